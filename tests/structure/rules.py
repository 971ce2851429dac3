# SPDX-License-Identifier: Apache-2.0
"""Rules about the tree that a compiler does not check. Each gives a list of "file:line: what is wrong"."""
import pathlib
import re
import subprocess

# STYLE: who may include whom. Names are top-level folders.
MAY_INCLUDE = {
    "dsp": {"dsp"},
    "proto": {"proto", "dsp"},
    "drivers": {"drivers", "dsp"},
    "firmware": {"firmware", "drivers", "dsp", "proto"},
    "host": {"host", "drivers", "dsp", "proto"},
}
FOLDERS = set(MAY_INCLUDE) | {"tests", "board", "toolchains"}
# dsp is pure: std without clocks, threads and I/O, plus Eigen and Highway.
DSP_LIBRARIES = re.compile(r"^(Eigen|hwy)/")
DSP_NOT_STD = {
    "chrono", "condition_variable", "cstdio", "ctime", "filesystem", "fstream", "future", "iostream", "mutex",
    "shared_mutex", "stop_token", "thread",
}
INCLUDE = re.compile(r'^\s*#\s*include\s*([<"])([^">]+)[">]')
SOURCES = {".c", ".cc", ".cpp", ".h", ".hpp"}
MOST_LINES = 500
EQUATION = re.compile(r"^    .*\S\s{2,}\((\d+[a-z]?)\)$")
LICENCE = "SPDX-License-Identifier: Apache-2.0"
# A folder of one person's machine, at the start of a path.
MACHINE_PATH = re.compile(r"(?<![\w.})\]*~-])/(?:home|root|work|Users)/")


def source_files(root):
    """Files under source control; without git (an unpacked archive) all files outside build folders."""
    root = pathlib.Path(root)
    listed = None
    if (root / ".git").exists():
        listed = subprocess.run(
            ["git", "-C", str(root), "-c", "safe.directory=*", "ls-files", "-z"], capture_output=True, check=False)
    if listed is not None and listed.returncode == 0:
        names = [name for name in listed.stdout.decode().split("\0") if name]
    else:
        names = [str(path.relative_to(root)) for path in root.rglob("*")]
        names = [name for name in names if not name.startswith(("build", ".git/"))]
    return sorted(name for name in names if (root / name).is_file())


def lines_of(root, name):
    text = (pathlib.Path(root) / name).read_bytes()
    return [] if b"\0" in text else text.decode("utf-8", "replace").splitlines()


def include_problem(folder, mark, target):
    if ".." in target.split("/"):
        return "includes by a relative path; name it from the top folder"
    first = target.split("/")[0]
    if "/" in target and first in FOLDERS:
        allowed = MAY_INCLUDE[folder]
        return None if first in allowed else f"{folder}/ may include {', '.join(sorted(allowed))}; not {first}/"
    if folder != "dsp" or DSP_LIBRARIES.match(target):
        return None
    if mark == "<" and "/" not in target and not target.endswith(".h") and target not in DSP_NOT_STD:
        return None
    return "dsp/ may include std (no clock, thread or I/O), Eigen and Highway only"


def include_problems(root):
    problems = []
    for name in source_files(root):
        folder = name.split("/")[0]
        if folder not in MAY_INCLUDE or pathlib.Path(name).suffix not in SOURCES:
            continue
        for number, line in enumerate(lines_of(root, name), 1):
            found = INCLUDE.match(line)
            what = found and include_problem(folder, *found.groups())
            if what:
                problems.append(f"{name}:{number}: {line.strip()}: {what}")
    return problems


def length_problems(root):
    problems = []
    for name in source_files(root):
        length = len(lines_of(root, name)) if pathlib.Path(name).suffix in SOURCES else 0
        if length > MOST_LINES:
            problems.append(f"{name}:{length}: {length} lines; at most {MOST_LINES}, look for the seam")
    return problems


def machine_path_problems(root):
    return [
        f"{name}:{number}: the path of one machine: {line.strip()}"
        for name in source_files(root)
        for number, line in enumerate(lines_of(root, name), 1)
        if MACHINE_PATH.search(line)
    ]


def licence_problems(root):
    """Sources and scripts say their licence in one of their first lines, as SPDX has it."""
    problems = []
    for name in source_files(root):
        path, lines = pathlib.Path(name), lines_of(root, name)
        script = bool(lines) and lines[0].startswith("#!")
        if path.suffix in SOURCES | {".sh", ".py", ".cmake", ".proto"} or path.name == "CMakeLists.txt" or script:
            if not any(line.endswith(LICENCE) for line in lines[:3]):
                problems.append(f"{name}:1: expected a comment: {LICENCE}")
    return problems


def equation_problems(root, page="dsp/OPTICS.md"):
    """Each numbered equation of the page has a row in its table, and each file that is named there cites it."""
    lines = lines_of(root, page)
    numbers = {found.group(1) for line in lines if (found := EQUATION.search(line))}
    rows = [re.match(r"\| ((?:\(\d+[a-z]?\) ?)+)\| (.+) \|$", line) for line in lines]
    places = {number: row.group(2) for row in rows if row for number in re.findall(r"\((\w+)\)", row.group(1))}
    problems = [f"{page}: equation ({number}) has no row" for number in sorted(numbers - places.keys())]
    problems += [f"{page}: a row of ({number}), which is no equation" for number in sorted(places.keys() - numbers)]
    for number, place in places.items():
        if place.startswith("not computed"):
            continue
        path = pathlib.Path(root) / place
        if not path.is_file():
            problems.append(f"{page}: ({number}): no file {place}")
        elif not re.search(rf"\({number}\)", "\n".join(line for line in lines_of(root, place) if "//" in line)) and not any(
                int(low) <= int(number.rstrip("abc")) <= int(high)
                for low, high in re.findall(r"\((\d+)\)-\((\d+)\)", path.read_text(encoding="utf-8"))):
            problems.append(f"{place}: does not cite ({number})")
    return problems


def where_problems(root, page="CONTRIBUTING.md"):
    """Each file that the page's table "Where is" names is there, and each row names one."""
    problems, in_table = [], False
    for number, line in enumerate(lines_of(root, page), 1):
        if line.startswith("## "):
            in_table = line == "## Where is"
        if not in_table or not line.startswith("| ") or line.startswith("| looked for |"):
            continue
        files = re.findall(r"`([\w./-]+)`", line.split("|")[2])
        problems += [f"{page}:{number}: no file {name}" for name in files if not (pathlib.Path(root) / name).is_file()]
        if not files:
            problems.append(f"{page}:{number}: names no file")
    return problems


def folder_edges(root):
    """Folder two levels deep -> the folders that its sources include, each with one such line."""
    edges = {}
    for name in source_files(root):
        if name.split("/")[0] not in FOLDERS - {"tests"} or pathlib.Path(name).suffix not in SOURCES:
            continue
        folder = "/".join(name.split("/")[:-1][:2])
        for number, line in enumerate(lines_of(root, name), 1):
            found = INCLUDE.match(line)
            other = "/".join(found.group(2).split("/")[:-1][:2]) if found else ""
            if other and other != folder and other.split("/")[0] in FOLDERS:
                edges.setdefault(folder, {}).setdefault(other, f"{name}:{number}")
    return edges


def cycle_problems(root):
    """Folders that include each other, whichever way round, with the lines that close the circle."""
    edges = folder_edges(root)

    def reached(start):
        seen, ahead = set(), [start]
        while ahead:
            for other in edges.get(ahead.pop(), {}):
                if other not in seen:
                    seen.add(other)
                    ahead.append(other)
        return seen

    reach = {folder: reached(folder) for folder in edges}
    return [f"{where}: {folder} includes {other}, which includes it in turn"
            for folder in sorted(edges) for other, where in sorted(edges[folder].items()) if folder in reach.get(other, ())]
