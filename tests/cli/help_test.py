# SPDX-License-Identifier: Apache-2.0
"""What --help prints, of srd-node and of each subcommand of srd: one form for all."""

import os
import re
import subprocess
import unittest

TEXT_AT = 30  # the column of descriptions
CHOICES = {
    "reconstruct": {"--metric": "reprojection|disparity|collinearity", "--loss": "none|huber|tukey",
                    "--model": "1|3|5|8|12|plane|level-normal"},
    "calibrate": {"--coefficients": "4|5|8|12|14", "--surface": "flat|bent|free", "--radius": "5|10"},
    "pose": {"--origin-square": "dark|bright|unknown", "--radius": "5|10"},
    "rig-check": {"--origin-square": "dark|bright|unknown", "--radius": "5|10"},
}

REQUIRED = {"reconstruct": ("x", "--out", "y"), "calibrate": ("x", "--out", "y"),
            "pose": ("x", "--calibration", "c", "--out", "y"), "rig-check": ("x", "z", "--calibration", "c")}


def said(*command, code=0):
    done = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=20, check=False)
    assert done.returncode == code, f"{command}: {done.returncode}\n{done.stderr}"
    return done.stdout + done.stderr


def entries(text):
    """Name and description of each option, positional and subcommand. Names that fill their column have the description below."""
    found, lines = [], text.splitlines() + [""]
    for line, after in zip(lines, lines[1:]):
        if not re.match(r"  \S", line):
            continue
        below = after.startswith(" " * TEXT_AT)
        found.append((line.strip(), after.strip()) if below else (line[:TEXT_AT].strip(), line[TEXT_AT:].strip()))
    return found


class Help(unittest.TestCase):
    def setUp(self):
        self.node, self.srd = os.environ["SRD_NODE_PROGRAM"], os.environ["SRD_PROGRAM"]
        listed = said(self.srd, "--help").split("Subcommands:")[1]
        self.subcommands = re.findall(r"^  ([a-z-]+)", listed, re.MULTILINE)
        self.assertGreater(len(self.subcommands), 7)

    def pages(self):
        yield "srd-node", said(self.node, "--help")
        yield "srd", said(self.srd, "--help")
        for name in self.subcommands:
            yield f"srd {name}", said(self.srd, name, "--help")

    def test_descriptions_begin_with_a_capital(self):
        for page, text in self.pages():
            found = entries(text)
            self.assertGreater(len(found), 2, page)
            for name, words in found:
                with self.subTest(f"{page} {name}"):
                    self.assertRegex(words, r"^[A-Z]")
            with self.subTest(page):
                self.assertRegex(text.splitlines()[0], r"^[A-Z]")

    def test_choices_are_plain_names(self):
        for page, text in self.pages():
            with self.subTest(page):
                self.assertEqual(re.findall(r".*(?:ENUM|->|\{).*", text), [])
        for command, options in CHOICES.items():
            listed = [name for name, _ in entries(said(self.srd, command, "--help"))]
            for option, names in options.items():
                with self.subTest(f"{command} {option}"):
                    self.assertTrue(any(re.match(rf"{option} {re.escape(names)}(=|$| )", name) for name in listed), listed)

    def test_a_wrong_choice_is_answered_with_the_names(self):
        for command, options in CHOICES.items():
            for option, names in options.items():
                with self.subTest(f"{command} {option}"):
                    answer = said(self.srd, command, *REQUIRED[command], option, "nothing", code=2)
                    self.assertIn(f"'nothing' is none of {names.replace('|', ', ')}", answer)


if __name__ == "__main__":
    unittest.main()
