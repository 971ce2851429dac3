# SPDX-License-Identifier: Apache-2.0
"""Commands that the pages tell a reader to type, taken from the pages' own text.

srd and srd-node run where a page shows a whole command, with files for its placeholders; elsewhere their options must be in
their help. cmake's presets, scripts with their options, filters of tests must be there. What else a page calls (apt,
systemctl), a script of the project must call too.
"""

import json
import os
import pathlib
import re
import shlex
import shutil
import subprocess
import tempfile
import unittest

import bench

ROOT = pathlib.Path(__file__).parents[2]
BUILD = pathlib.Path(os.environ["SRD_PROGRAM"]).parents[1]
PAGES = ["README.md", "CONTRIBUTING.md", "board/README.md", "tests/bench/README.md",
         *sorted(str(page.relative_to(ROOT)) for page in ROOT.glob("board/*/README.md"))]
COMMAND = re.compile(r"(srd|srd-node|cmake|cpack|ctest|srd_\w+_tests|((tests|toolchains|board)/\S+\.sh)|build/\S+)(\s|$)")
CONFIGURATION = re.compile(r"\s*(\[|#|\w+ = )")
PLACEHOLDERS = {"SETTINGS.xml": "settings.xml", "SCENE.toml": "scene.toml", "EST.csv": "run.csv", "TRUTH.csv": "truth.csv",
                "FILE.csv": "run.csv", "FILE": "flume.toml", "DIR": "out", "IMAGES..": "views", "REFERENCE.png": "rec/reference.png",
                "LATER.png": "rec/reference.png", "CALIBRATION.yml": "rec/calibration.yml", "POINTS.txt": "rec/points.txt"}
# The doctor ends with 4 where it finds something amiss, as the recording of make_place() lets it.
# The water of the recording moves, so no still is taken of it.
CODES = {"--doctor": (0, 4), "--stills": (3,)}
LONGEST_S = 60


def commands(page):
    """Line, command and whether the page shows it whole: in a block, or as the first thing of a row of a table."""
    joined = ""
    for number, line in enumerate((ROOT / page).read_text(encoding="utf-8").splitlines(), 1):
        layout = re.match(r"    [a-z]+/  ", line)  # a line of the map, no command
        if (line.startswith("    ") and not layout) or joined:
            joined += re.split(r"\s#\s", line)[0].rstrip()
            if joined.endswith("\\"):
                joined = joined[:-1]
                continue
            if joined.strip() and not CONFIGURATION.match(joined):
                yield from ((number, command.strip(), True) for command in joined.split("&&"))
            joined = ""
            continue
        for n, span in enumerate(re.findall(r"`([^`]+)`", line)):
            whole = n == 0 and line.startswith("| `srd")
            yield from ((number, command.strip(), whole) for command in span.split("&&") if COMMAND.match(command.strip()))


class Pages(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        with bench.TakenPort() as port:
            self.port = port

    def make_place(self, name):
        place = bench.Bench(self.folder / name)
        place.tables()
        place.settings()
        place.write("flume.toml", bench.NODE)
        place.write("scene.toml", bench.SCENE)
        for link, there in (("board", ROOT / "board"), ("tests", ROOT / "tests"), ("build/host", BUILD)):
            place.path(link).parent.mkdir(exist_ok=True)
            place.path(link).symlink_to(there)
        return place

    def start(self, words, place):
        """The process of a command of srd or srd-node, on a port of this test and with an end."""
        there = f"127.0.0.1:{self.port}"
        arguments = [PLACEHOLDERS.get(word, word.replace("ADDR:47810", there)) for word in words[1:]]
        more = []
        if arguments[0] == "listen":
            place.remove("run.csv")
            arguments = ["run.csv" if word == "flume.toml" else word for word in arguments]
            more = ["--bind", there] if there not in arguments else []
            more += ["--for", "0.5"] if "--count" not in arguments else []
        elif arguments[0] == "calibrate":
            place.views()
        elif arguments[0] == "study":
            more = ["--help"]  # minutes: Study.* run it
        elif "--camera" in arguments:
            more = ["--host", there]
        return subprocess.Popen([os.environ[bench.PROGRAMS[pathlib.Path(words[0]).name]], *arguments, *more],
                                cwd=place.folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                stderr=subprocess.STDOUT, text=True, errors="replace")

    def assert_ends(self, process, words):
        try:
            said = process.communicate(timeout=LONGEST_S)[0]
        except subprocess.TimeoutExpired:
            process.kill()
            self.fail(f"{words} still runs after {LONGEST_S} s: {process.communicate()[0]}")
        codes = next((codes for option, codes in CODES.items() if option in words), (0,))
        self.assertIn(process.returncode, codes, f"{words}\n{said}")

    def help_of(self, *program):
        done = subprocess.run([*program, "--help"], cwd=ROOT, capture_output=True, text=True, check=False,
                              stdin=subprocess.DEVNULL)
        self.assertEqual(done.returncode, 0, f"{program}\n{done.stdout}{done.stderr}")
        return done.stdout

    def assert_in_help(self, options, *program):
        said = self.help_of(*program) if options else ""
        for option in options:
            self.assertRegex(said, rf"{re.escape(option)}(?![\w-])", program)

    def judge(self, command, whole, presets, scripts):
        words = shlex.split(command)
        program, options = words[0], [word.split("=")[0] for word in words if re.match(r"--\w", word)]
        name = pathlib.Path(program).name
        if name in bench.PROGRAMS:
            if whole:
                self.assert_ends(self.start(words, self.make_place("place")), words)
            else:
                subcommand = [word for word in words[1:2] if re.fullmatch("[a-z]+", word)]
                self.assert_in_help(options, os.environ[bench.PROGRAMS[name]], *subcommand)
        elif name.startswith("srd_") and name.endswith("_tests"):
            listed = subprocess.run([BUILD / "tests" / name, *words[1:], "--gtest_list_tests"], cwd=ROOT, check=True,
                                    capture_output=True, text=True).stdout
            self.assertIn("\n  ", listed, "no test has such a name")
        elif program.startswith("build/"):  # of another preset: a target of this name
            self.assertTrue(any(re.search(rf"add_executable\({name}\b", file.read_text()) for file in
                                (ROOT / "tests").rglob("CMakeLists.txt")), f"nothing builds {name}")
        elif program in ("cmake", "ctest"):
            for preset in (words[n + 1] for n, word in enumerate(words) if word == "--preset"):
                self.assertIn(preset, presets)
        elif program.endswith(".sh"):
            self.assertTrue(os.access(ROOT / program, os.X_OK), f"{program} is no program")
            self.assert_in_help(options, ROOT / program)
        elif "=" not in program:
            self.assertTrue(re.search(rf"\b{re.escape(program)}\b", scripts), f"no script of the project calls {program}")

    def test_every_command_is_one_that_works(self):
        listed = json.loads((ROOT / "CMakePresets.json").read_text())
        presets = {preset["name"] for kind, each in listed.items() if kind.endswith("Presets") for preset in each}
        scripts = "".join(path.read_text(encoding="utf-8") for folder in ("tests", "toolchains", "board")
                          for path in sorted((ROOT / folder).rglob("*.sh")))
        found = [(page, *command) for page in PAGES for command in commands(page)]
        self.assertGreater(len(found), 40)
        # These two need each other: the next test.
        found = [each for each in found if "recording:" not in each[2] and "--count" not in each[2]]
        for page, line, command, whole in found:
            with self.subTest(f"{page}:{line}: {command}"):
                try:
                    self.judge(command, whole, presets, scripts)
                finally:
                    shutil.rmtree(self.folder / "place", ignore_errors=True)

    def test_the_two_terminals_of_the_first_page_measure_a_recording(self):
        shown = [shlex.split(command) for _, command, whole in commands("README.md")
                 if whole and command.startswith("build/host/")]
        self.assertEqual([pathlib.Path(words[0]).name for words in shown], ["srd", "srd-node"])
        place = self.make_place("terminals")
        listen, node = (self.start(words, place) for words in shown)
        self.assert_ends(node, shown[1])
        self.assert_ends(listen, shown[0])
        rows = place.path("run.csv").read_text().splitlines()
        self.assertEqual(len(rows), 1 + int(shown[0][shown[0].index("--count") + 1]))
        self.assertTrue(all(",ok," in row for row in rows[1:]), rows)


if __name__ == "__main__":
    unittest.main()
