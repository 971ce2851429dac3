#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The programs that the project's scripts call, collected from the scripts, and which of them this machine has not.

usage: called_programs.py [--missing]   (in the project's folder; needs shfmt)

Shell scripts for bash and Python scripts run on the machine that builds. Scripts for sh run on a board or inside an emulated
system, which bring their own programs, and are not looked at. A command word that is a variable stands for every literal
that the script assigns to it.
"""
import ast
import json
import pathlib
import re
import shutil
import subprocess
import sys

BASH = re.compile(r"^#!.*\bbash\b|^# shellcheck shell=bash")
SH = re.compile(r"^#!.*\bsh\b|^# shellcheck shell=sh")
PYTHON_CALLS = {"subprocess": {"run", "Popen", "check_call", "check_output", "call"}, "shutil": {"which"}}
# Programs that run another program, with the options that take a word of their own.
RUNNERS = {"exec": "", "env": "u", "nice": "n", "timeout": "sk", "xargs": "nPIdaL", "unshare": "", "setpriv": "", "command": "", "trap": None}
BUILTINS = set("""! . : [ [[ alias bg break builtin caller case cd command continue declare dirs disown echo enable eval exec exit
    export false fg getopts hash help history jobs kill let local logout mapfile popd printf pushd pwd read readarray readonly
    return set shift shopt source test times trap true type typeset ulimit umask unalias unset wait""".split())
# Root needs none, and who is not root has it from the system's administrator: install_packages.sh says so when it is missing.
NOT_OURS = {"sudo"}


def scripts(root):
    listed = subprocess.run(["git", "-C", root, "-c", "safe.directory=*", "ls-files", "-z"], capture_output=True, check=True)
    for name in sorted(filter(None, listed.stdout.decode().split("\0"))):
        path = pathlib.Path(root) / name
        if not path.is_file() or path.is_symlink():
            continue
        with path.open("rb") as file:
            first = file.readline(200).decode("utf-8", "replace")
        if BASH.match(first):
            yield path, "bash"
        elif SH.match(first):
            yield path, "sh"
        elif path.suffix == ".py":
            yield path, "python"


def nodes(tree):
    if isinstance(tree, dict):
        yield tree
        for value in tree.values():
            yield from nodes(value)
    elif isinstance(tree, list):
        for value in tree:
            yield from nodes(value)


def parse_shell(text):
    done = subprocess.run(["shfmt", "--to-json", "--language-dialect=bash"], input=text, capture_output=True, text=True, check=False)
    if done.returncode:
        raise ValueError(done.stderr.strip())
    return json.loads(done.stdout)


def literal(word):
    """The text of a word that nothing is expanded in, else None."""
    text = ""
    for part in word.get("Parts", []):
        if part["Type"] in ("Lit", "SglQuoted"):
            text += part.get("Value", "")
        elif part["Type"] == "DblQuoted":
            inner = literal(part)
            if inner is None:
                return None
            text += inner
        else:
            return None
    return text


def variable(word):
    """The name of the variable that a word consists of, else None."""
    parts = word.get("Parts", [])
    if len(parts) == 1 and parts[0]["Type"] == "DblQuoted":
        parts = parts[0].get("Parts", [])
    return parts[0]["Param"]["Value"] if len(parts) == 1 and parts[0]["Type"] == "ParamExp" else None


class Shell:
    def __init__(self):
        self.values, self.may_be_empty, self.functions, self.found = {}, set(), set(), []

    def read_functions(self, tree):
        self.functions |= {node["Name"]["Value"] for node in nodes(tree) if node.get("Type") == "FuncDecl"}

    def read(self, tree, where):
        self.read_functions(tree)
        for node in nodes(tree):
            for assign in node.get("Assigns") or []:
                words = [assign["Value"]] if assign.get("Value") else []
                if assign.get("Array"):
                    words = [element["Value"] for element in assign["Array"].get("Elems", [])[:1] if element.get("Value")]
                    if not words:
                        self.may_be_empty.add((where, assign["Name"]["Value"]))
                for word in words:
                    if literal(word):
                        self.values.setdefault((where, assign["Name"]["Value"]), set()).add(literal(word).split()[0])
        self.found += [(node["Args"], where) for node in nodes(tree) if node.get("Type") == "CallExpr" and node.get("Args")]

    def programs(self):
        """Pairs of program and the file that calls it."""
        for words, where in self.found:
            for program in self.called(words, where):
                if program not in self.functions and program not in BUILTINS:
                    yield program, where

    def called(self, words, where):
        if not words:
            return
        name = variable(words[0])
        if name is not None:
            yield from self.values.get((where, name), ())
            if (where, name) in self.may_be_empty:
                yield from self.called(words[1:], where)
            return
        program = literal(words[0])
        if not program:
            return
        yield program
        if program in ("sh", "bash"):
            texts = [literal(words[i + 1]) for i, word in enumerate(words[:-1]) if literal(word) == "-c"]
            for text in filter(None, texts):
                inner = Shell()
                inner.read(parse_shell(text), where)
                inner.functions |= self.functions
                yield from (program for program, _ in inner.programs())
        elif RUNNERS.get(program) is not None:
            yield from self.called(self.after_options(words[1:], RUNNERS[program], program == "timeout"), where)

    @staticmethod
    def after_options(words, with_word, first_is_time):
        words = list(words)
        while words:
            text = literal(words[0]) or ""
            if text.startswith("-") or "=" in text:
                words = words[2 if len(text) == 2 and text[1] in with_word and text[0] == "-" else 1:]
            elif first_is_time:
                words, first_is_time = words[1:], False
            else:
                break
        return words


def python_programs(text):
    tree = ast.parse(text)
    # What a method of another class is called (a test's own "call") says nothing: only these modules' functions run programs.
    bare = {alias.asname or alias.name for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) for alias in node.names
            if alias.name in PYTHON_CALLS.get(node.module, ())}
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call) or not node.args:
            continue
        called = node.func
        if isinstance(called, ast.Attribute):
            runs = isinstance(called.value, ast.Name) and called.attr in PYTHON_CALLS.get(called.value.id, ())
        else:
            runs = isinstance(called, ast.Name) and called.id in bare
        if not runs:
            continue
        first = node.args[0]
        if isinstance(first, ast.List) and first.elts:
            first = first.elts[0]
        if isinstance(first, ast.Constant) and isinstance(first.value, str) and re.fullmatch(r"[\w.+-]+", first.value):
            yield first.value


def called_programs(root):
    """Program -> files that call it; those of the project itself, which are paths inside it, left out."""
    found, shell = {}, Shell()
    for path, kind in scripts(root):
        where = str(path.relative_to(root))
        text = path.read_text(encoding="utf-8")
        if kind == "bash":
            shell.read(parse_shell(text), where)
        elif kind == "sh":
            shell.read_functions(parse_shell(text))
        else:
            for program in python_programs(text):
                found.setdefault(program, set()).add(where)
    for program, where in shell.programs():
        if "/" not in program or program.startswith("/"):
            found.setdefault(program, set()).add(where)
    return {program: places for program, places in found.items() if program not in NOT_OURS}


def main(arguments):
    if arguments not in ([], ["--missing"]):
        print(__doc__.strip(), file=sys.stderr)
        return 2
    found = called_programs(".")
    missing = {program: places for program, places in found.items() if shutil.which(program) is None}
    if not arguments:
        print("\n".join(sorted(found)))
        return 0
    for program, places in sorted(missing.items()):
        print(f"{program}: called by {', '.join(sorted(places))}; no package of any packages.txt brings it")
    print(f"{len(found)} programs are called, {len(missing)} of them are missing")
    return 1 if missing or len(found) < 20 else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
