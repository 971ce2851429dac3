# SPDX-License-Identifier: Apache-2.0
"""srd-node --stills as a technician uses it: Enter through a pipe, a signal, by itself without a terminal."""

import os
import signal
import subprocess
import tempfile
import time
import unittest

import bench

LONGEST_S = 30
# A still pool, ten small frames a second: as fast as they are rendered.
SCENE = """\
[camera]
width = 640
height = 320
fx = 1075.0
fy = 1075.0
cx = 323.4
cy = 157.7
rate_hz = 10.0
[[surface.mode]]
name = "A00"
mean_mm = 80.0
"""
NODE = """\
[camera]
source = "simulator"
scene = "scene.toml"
[surface]
guess_mm = [80.0]
"""


class Stills(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.bench = bench.Bench(folder.name)
        self.bench.write("scene.toml", SCENE)
        self.bench.write("node.toml", NODE)

    def start(self, *arguments, stdin=subprocess.PIPE):
        process = subprocess.Popen([os.environ["SRD_NODE_PROGRAM"], "--config", "node.toml", "--stills", "out", *arguments],
                                   cwd=self.bench.folder, stdin=stdin, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                   text=True)
        for pipe in (process.stdin, process.stderr):
            if pipe is not None:
                self.addCleanup(pipe.close)
        self.addCleanup(process.kill)
        line = process.stderr.readline()
        self.assertIn("Enter takes one", line)
        return process

    def wait_for(self, process, words):
        line = process.stderr.readline()
        self.assertIn(words, line)

    def files(self):
        return sorted(os.listdir(self.bench.path("out")))

    def test_enter_and_a_signal_take_one_each_and_calibrate_reads_them(self):
        process = self.start("--count", "3")
        process.stdin.write("\n")
        process.stdin.flush()
        self.wait_for(process, "still_001.png: 21 x 11 corners")
        process.send_signal(signal.SIGUSR1)
        self.wait_for(process, "still_002.png")
        process.stdin.close()  # the connection is gone: the signal still counts
        time.sleep(0.3)
        process.send_signal(signal.SIGUSR1)
        self.wait_for(process, "still_003.png")
        self.assertEqual(process.wait(LONGEST_S), 0)
        self.assertEqual(self.files(), ["still_001.png", "still_002.png", "still_003.png"])
        done = subprocess.run([os.environ["SRD_PROGRAM"], "calibrate", "out", "--board", "21x11", "--square-mm", "20", "--out", "c"],
                              cwd=self.bench.folder, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=LONGEST_S)
        self.assertEqual(done.returncode, 3)
        self.assertIn("too few views of the whole board", done.stderr)
        self.assertIn("found: 3", done.stderr)

    def test_by_itself_without_a_terminal_until_it_is_told_to_end(self):
        process = self.start("--every", "0.5", stdin=subprocess.DEVNULL)
        self.wait_for(process, "still_001.png")
        self.wait_for(process, "not taken the board is where it was in still_001.png")
        process.send_signal(signal.SIGTERM)
        said = process.communicate(timeout=LONGEST_S)[1]
        self.assertEqual(process.returncode, 0)
        self.assertIn("1 taken", said)
        self.assertEqual(self.files(), ["still_001.png"])

    def test_a_live_camera_without_a_size_is_told_which_keys(self):
        self.bench.write("node.toml", NODE.replace('"simulator"', '"v4l2:/dev/video99"').replace('scene = "scene.toml"\n', ""))
        done = self.bench.run(("srd-node", "--config", "node.toml", "--stills", "out"))
        self.assertEqual(done.returncode, 2)
        self.assertIn("camera.width_px and camera.height_px", done.stderr)
        self.assertIn("--list-cameras", done.stderr)

    def test_options_that_measure_do_not_go_with_it(self):
        for other in (["--record", "x"], ["--frames", "3"], ["--doctor"], ["--check-config"]):
            done = self.bench.run(("srd-node", "--config", "node.toml", "--stills", "out", *other))
            self.assertEqual(done.returncode, 2, other)
            self.assertIn("--stills", done.stderr)
        done = self.bench.run(("srd-node", "--config", "node.toml", "--every", "3"))
        self.assertEqual(done.returncode, 2)


if __name__ == "__main__":
    unittest.main()
