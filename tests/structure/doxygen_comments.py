#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Headers with their plain comments marked as Doxygen wants them, every line where it was (tests/structure/api_pages.sh).

Comments right above a declaration and behind one are its description; those that begin the file are the file's. What Doxygen
would take for a command, a tag or a list is escaped: comments are text.

usage: doxygen_comments.py FOLDER HEADER...   writes FOLDER/HEADER for each
"""
import pathlib
import re
import sys

ALONE = re.compile(r"^(\s*)//(?!/)(.*)$")
BEHIND = re.compile(r"^([^/]*(?:/[^/]+)*)(?<=\S)\s+//(?!/)(.*)$")
# Ends of blocks, labels and pieces of the preprocessor have nothing to be described.
NOT_DECLARED = re.compile(r"^\s*(}|#|public:|private:|protected:|$)")
NOT_SAID = re.compile(r"^\s*(NOLINT|namespace\b|clang-format)|^\s*$")


def escaped(text):
    """Text between backticks is code already."""
    parts = text.split("`")
    if len(parts) % 2 == 0:
        parts = [text.replace("`", "\\`")]
    parts[::2] = [re.sub(r"([\\@<>&#%*_~|]|::)", r"\\\1", part) for part in parts[::2]]
    return re.sub(r"^( *)([-+]|\d+\.)(?= )", r"\1\\\2", "`".join(parts))


def marked(lines):
    behind = None  # the column of a comment behind the line before
    file_said = False
    for number, line in enumerate(lines):
        alone = ALONE.match(line)
        if alone:
            indent, text = alone.groups()
            if "SPDX-License-Identifier" in text:
                yield "/// @file"
                continue
            if not file_said:
                yield "///" + escaped(text)
                continue
            if behind == len(indent) and behind > 0:
                yield indent + "///<" + escaped(text)
                continue
            after = next((later for later in lines[number + 1:] if not ALONE.match(later)), "")
            yield line if NOT_DECLARED.match(after) else indent + "///" + escaped(text)
            continue
        file_said = True
        found = BEHIND.match(line)
        behind = None
        if found and not NOT_DECLARED.match(line) and not NOT_SAID.match(found.group(2)) and found.group(1)[-1] not in "{(":
            yield f"{found.group(1)} ///<{escaped(found.group(2))}"
            behind = line.index("//", len(found.group(1)))
        else:
            yield line


if __name__ == "__main__":
    for name in sys.argv[2:]:
        copy = pathlib.Path(sys.argv[1]) / name
        copy.parent.mkdir(parents=True, exist_ok=True)
        text = pathlib.Path(name).read_text(encoding="utf-8")
        copy.write_text("\n".join(marked(text.splitlines())) + "\n", encoding="utf-8")
