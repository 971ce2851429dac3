#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""clang-tidy with the checks of .clang-tidy over what build/host compiles of the folders that run unattended on a board: a unity
source at a time, so that a header is read once for eight of them. Sources compiled alone (vector kernels, the solver's templates)
are left to the compilers.

What was found clean is kept by the contents of all that went into it (the source, the project's files that it includes, its command,
.clang-tidy) for 30 days, so that a second run looks at what has changed. SRD_KEPT names another folder than ~/.cache/flume-srd.

usage: tidy.py [PATTERN]   only sources whose target has PATTERN in its path
"""
import concurrent.futures
import hashlib
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ("drivers/", "dsp/", "firmware/")
BUILD = ROOT / "build/host"
KEPT = pathlib.Path(os.environ.get("SRD_KEPT") or pathlib.Path(os.environ.get("XDG_CACHE_HOME") or pathlib.Path.home() / ".cache")
                    / "flume-srd") / "tidy"
KEPT_DAYS = 30
# GCC's warnings are the compilers' business.
ARGUMENTS = ["--quiet", "--extra-arg=-w", "--extra-arg=-Wno-unknown-warning-option"]


def included(build):
    """Object -> the project's files that it was made from, as the build has noted."""
    said = subprocess.run(["ninja", "-C", build, "-t", "deps"], capture_output=True, text=True, check=True).stdout
    found, files = {}, []
    for line in said.splitlines():
        if (head := re.match(r"(\S+): #deps", line)) is not None:
            files = found.setdefault(head.group(1), [])
        elif line.startswith("    "):
            path = pathlib.Path(os.path.normpath(build / line.strip()))
            if path.is_relative_to(ROOT):
                files.append(path)
    return found


def key(command, files, seed):
    """Folders of another clone do not count."""
    digest = hashlib.sha256(seed)
    digest.update(command.replace(str(ROOT), ".").encode())
    for path in sorted(set(files)):
        digest.update(f"{path.relative_to(ROOT)}\0".encode() + path.read_bytes().replace(str(ROOT).encode(), b"."))
    return digest.hexdigest()


def look(source):
    return subprocess.run(["clang-tidy", f"-p={BUILD}", *ARGUMENTS, source], capture_output=True, text=True, check=False, cwd=ROOT)


def main(arguments):
    if shutil.which("clang-tidy") is None:
        print("tidy: no clang-tidy (tests/install_packages.sh installs it)")
        return 1
    pattern = arguments[0] if arguments else ""
    commands = [{**entry, "output": re.search(r" -o (\S+)", entry["command"]).group(1)}
                for entry in json.loads((BUILD / "compile_commands.json").read_text())]
    commands = [entry for entry in commands
                if entry["output"].startswith(FOLDERS) and pattern in entry["output"] and "/Unity/" in entry["file"]]
    notes = included(BUILD)
    version = subprocess.run(["clang-tidy", "--version"], capture_output=True, check=True).stdout
    seed = version + (ROOT / ".clang-tidy").read_bytes() + " ".join(ARGUMENTS).encode()
    KEPT.mkdir(parents=True, exist_ok=True)
    for mark in KEPT.iterdir():
        if time.time() - mark.stat().st_mtime > KEPT_DAYS * 86400:
            mark.unlink(missing_ok=True)
    marks = {entry["file"]: KEPT / key(entry["command"], [pathlib.Path(entry["file"]), *notes.get(entry["output"], [])], seed)
             for entry in commands}
    ahead = [source for source, mark in marks.items() if not mark.exists()]
    failed = 0
    with concurrent.futures.ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        for source, done in zip(ahead, pool.map(look, ahead)):
            if done.returncode == 0:
                marks[source].touch()
            else:
                failed += 1
                print(done.stdout + done.stderr, end="", flush=True)
    print(f"tidy: {len(ahead)} of {len(marks)} sources looked at, {failed} with findings")
    return 1 if failed or not marks else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
