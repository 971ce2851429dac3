# SPDX-License-Identifier: Apache-2.0
"""The examples do what they say: each is run as a stranger would, and what it prints is held against the truth of tests/data.

Run by ctest with the programs' places in the environment: SRD_PROGRAM, SRD_NODE_PROGRAM, SRD_ONE_FRAME, SRD_PROTOC, SRD_CMAKE, SRD_PYTHON.
"""

import csv
import math
import os
import pathlib
import socket
import subprocess
import tempfile
import unittest

HERE = pathlib.Path(__file__).parent
ROOT = HERE.parents[1]
FLUME = ROOT / "tests/data/flume-small"
MODES = ["A00", "B", "C", "A10", "A01"]
LX_MM, LY_MM = 240, 440
FRAMES = 12
# The board's reach in the water, mm. Half the demo's resolution, whose worst frame is 0.0105 mm off: README, Accuracy.
PLACES = [(x, y) for x in (0, 100, 200) for y in (0, 200, 400)]
MOST_RMS_MM = 0.03
LONGEST_S = 60


def true_surfaces():
    with open(FLUME / "truth.csv", newline="", encoding="utf-8") as file:
        return [{mode: float(row[mode]) for mode in MODES} for row in csv.DictReader(file)]


def height(surface, x_mm, y_mm):
    x, y = x_mm / LX_MM, y_mm / LY_MM
    return (surface["A00"] + surface["B"] * x + surface["C"] * y + surface["A10"] * math.cos(math.pi * x)
            + surface["A01"] * math.cos(math.pi * y))


def rms(values):
    return math.sqrt(sum(value * value for value in values) / len(values))


class Examples(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def ran(self, *command, **more):
        done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False, timeout=LONGEST_S,
                              stdin=subprocess.DEVNULL, **more)
        self.assertEqual(done.returncode, 0, f"{command}\n{done.stdout}{done.stderr}")
        return done.stdout

    def node(self, **more):
        """srd-node on the recording: the simulator's profile, with the host and the options given."""
        profile = (ROOT / "board/simulator/node.toml").read_text(encoding="utf-8")
        (self.folder / "node.toml").write_text(profile.replace("host = ", "# host = "), encoding="utf-8")
        options = [word for name, value in more.items() for word in (f"--{name}", value)]
        return subprocess.Popen([os.environ["SRD_NODE_PROGRAM"], "--config", self.folder / "node.toml", "--camera",
                                 f"recording:{FLUME}", "--rate", "max", *options], stdin=subprocess.DEVNULL,
                                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)

    def test_surface_at_gives_the_true_height(self):
        self.ran(os.environ["SRD_PROGRAM"], "reconstruct", FLUME, "--guess", "80", "--out", self.folder / "run")
        file, = (self.folder / "run").glob("*.csv")
        true = true_surfaces()
        for x, y in PLACES:
            rows = [line.split() for line in self.ran(os.environ["SRD_PYTHON"], "-B", HERE / "surface_at.py", file, x, y).splitlines()]
            self.assertEqual([int(row[0]) for row in rows], list(range(FRAMES)))
            self.assertEqual([float(row[1]) for row in rows], [n * 0.02 for n in range(FRAMES)])
            self.assertLess(rms([float(row[2]) - height(surface, x, y) for row, surface in zip(rows, true)]), MOST_RMS_MM)

    def test_datagrams_are_decoded_to_the_true_surfaces(self):
        self.ran(os.environ["SRD_PROTOC"], f"--proto_path={ROOT / 'proto'}", f"--python_out={self.folder}", ROOT / "proto/srd.proto")
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
            probe.bind(("127.0.0.1", 0))
            port = probe.getsockname()[1]
        node = self.node(host=f"127.0.0.1:{port}")
        try:
            said = self.ran(os.environ["SRD_PYTHON"], "-B", HERE / "datagrams.py", "127.0.0.1", port, FRAMES,
                            env={**os.environ, "PYTHONPATH": str(self.folder)})
        finally:
            node.kill()  # it would wait for its frames to be acknowledged
            node.communicate()
        rows = {}
        for line in said.splitlines():
            name, sequence, *modes = line.split()
            self.assertEqual(name, "simulated")
            rows[int(sequence)] = {mode: float(mm) for mode, mm in (each.split("=") for each in modes)}
        self.assertEqual(sorted(rows), list(range(FRAMES)))
        for sequence, surface in enumerate(true_surfaces()):
            self.assertEqual(list(rows[sequence]), MODES)
            self.assertLess(rms([height(rows[sequence], *at) - height(surface, *at) for at in PLACES]), MOST_RMS_MM)

    def test_damaged_datagrams_are_none(self):
        self.ran(os.environ["SRD_PROTOC"], f"--proto_path={ROOT / 'proto'}", f"--python_out={self.folder}", ROOT / "proto/srd.proto")
        # The check of RFC 3720's "123456789"; and a message whose check is that of the host's direction, not the node's.
        said = self.ran(os.environ["SRD_PYTHON"], "-B", "-c", """
import datagrams
assert datagrams.crc32c(b"123456789") == 0xE3069283
message = datagrams.srd_pb2.NodeDatagram(version=1, node=b"a").SerializeToString()
def sealed(letter, message):
    return message + bytes([15 << 3 | 5]) + datagrams.crc32c(letter + message).to_bytes(4, "little")
assert datagrams.decode(sealed(b"N", message)).node == b"a"
assert datagrams.decode(sealed(b"H", message)) is None
assert datagrams.decode(sealed(b"N", message)[:-1]) is None
assert datagrams.decode(b"") is None
""", env={**os.environ, "PYTHONPATH": f"{self.folder}{os.pathsep}{HERE}"})
        self.assertEqual(said, "")

    def test_one_frame_finds_the_true_surface_of_each_frame(self):
        # The node keeps what it saw as PGM.
        node = self.node(record=self.folder / "seen")
        self.assertEqual(node.wait(timeout=LONGEST_S), 0, node.communicate()[1])
        images = sorted((self.folder / "seen").glob("*.pgm"))
        self.assertEqual(len(images), FRAMES)
        for image, true in zip(images, true_surfaces()):
            corners, *modes = self.ran(os.environ["SRD_ONE_FRAME"], image).splitlines()
            self.assertEqual(corners.split(",")[0], "corners 231")
            found = {name: float(mm) for name, mm, _ in map(str.split, modes)}
            self.assertEqual(list(found), MODES)
            self.assertLess(rms([height(found, *at) - height(true, *at) for at in PLACES]), MOST_RMS_MM)
            for name, mm, deviation in map(str.split, modes):
                self.assertLess(abs(float(mm) - true[name]), 5 * float(deviation), f"{image.name}: {name}")

    def test_one_frame_says_what_is_no_image(self):
        done = subprocess.run([os.environ["SRD_ONE_FRAME"], __file__], capture_output=True, text=True, check=False)
        self.assertEqual((done.returncode, done.stdout), (3, ""))
        self.assertIn("PGM", done.stderr)

    def test_one_frame_is_a_project_of_its_own(self):
        said = self.ran(os.environ["SRD_CMAKE"], "-S", HERE / "one_frame", "-B", self.folder / "alone", "-G", "Ninja")
        self.assertNotIn("protoc", said)
        self.ran(os.environ["SRD_CMAKE"], "--build", self.folder / "alone", "--target", "CMakeFiles/one_frame.dir/one_frame.cpp.o")


if __name__ == "__main__":
    unittest.main()
