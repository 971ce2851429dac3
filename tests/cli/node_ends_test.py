# SPDX-License-Identifier: Apache-2.0
"""How srd-node ends, and what the next start knows of it."""

import os
import signal
import subprocess
import tempfile
import time
import unittest

import bench

LONGEST_S = 20


class NodeEnds(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.bench = bench.Bench(folder.name)
        self.bench.node()

    def start(self, *arguments, camera="simulator", **more):
        process = subprocess.Popen(
            [os.environ["SRD_NODE_PROGRAM"], "--config", "flume.toml", "--camera", camera, "--rate", "camera",
             "--state", "state", *arguments], cwd=self.bench.folder, stderr=subprocess.PIPE, text=True,
            **{"stdout": subprocess.DEVNULL, **more})
        self.addCleanup(process.stderr.close)
        self.addCleanup(process.kill)
        return process

    def wait_for_frames(self, process):
        """Its summary ends with the surface; the state is written before."""
        line = ""
        while not line.startswith("surface"):
            line = process.stderr.readline()
            self.assertTrue(line, "it ended before it measured")
        time.sleep(0.5)

    def end(self, process):
        said = process.communicate(timeout=LONGEST_S)[1]
        return process.returncode, said

    def test_in_order(self):
        for asked in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP, signal.SIGQUIT):
            with self.subTest(asked.name):
                process = self.start()
                self.wait_for_frames(process)
                self.assertTrue(self.bench.path("state/last_end").exists())
                process.send_signal(asked)
                code, said = self.end(process)
                self.assertEqual(code, 0, said)
                self.assertIn("captured", said)
                self.assertFalse(self.bench.path("state/last_end").exists())

    def test_goes_on_without_its_terminal_under_nohup(self):
        process = self.start(preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_IGN))
        self.wait_for_frames(process)
        process.send_signal(signal.SIGHUP)
        time.sleep(0.5)
        self.assertIsNone(process.poll())
        process.send_signal(signal.SIGTERM)
        self.assertEqual(self.end(process)[0], 0)

    def examining(self):
        """The doctor, when it has the camera and the strobe."""
        process = self.start("--doctor", stdout=subprocess.PIPE)
        self.addCleanup(process.stdout.close)
        line = ""
        while "camera" not in line:
            line = process.stdout.readline()
            self.assertTrue(line, "it ended before it had the camera")
        return process

    def test_an_examination_in_order(self):
        for asked in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT):
            with self.subTest(asked.name):
                process = self.examining()
                process.send_signal(asked)
                found, said = process.communicate(timeout=LONGEST_S)
                self.assertEqual(process.returncode, 128 + asked, said)
                self.assertIn("not everything", said)
                self.assertEqual(found, "")

    def test_an_examination_that_nobody_reads(self):
        process = self.examining()
        process.stdout.close()
        said = process.stderr.read()
        self.assertEqual(process.wait(LONGEST_S), 128 + signal.SIGPIPE, said)
        self.assertIn("not everything", said)

    def test_at_once_when_interrupted_again(self):
        with bench.TakenPort() as port:
            process = self.start("--host", f"127.0.0.1:{port}")
            self.wait_for_frames(process)
            process.send_signal(signal.SIGINT)
            time.sleep(0.3)
            self.assertIsNone(process.poll(), "it waits for the host's last acknowledgement")
            process.send_signal(signal.SIGINT)
            code, said = self.end(process)
        self.assertEqual(code, 128 + signal.SIGINT, said)
        self.assertNotIn("captured", said)
        self.assertFalse(self.bench.path("state/last_end").exists())

    def test_a_killed_node_is_known_at_the_next_start(self):
        for restart in (0, 1, 2):
            process = self.start()
            self.wait_for_frames(process)
            process.kill()
            process.wait(LONGEST_S)
            self.assertEqual(self.bench.path("state/last_end").read_text().split("\n")[0], str(restart))
        code, said = self.end(self.start("--frames", "1"))
        self.assertEqual(code, 0, said)
        self.assertIn("restart   3, after: ended without a word: killed", said)
        self.assertNotIn("restart", self.end(self.start("--frames", "1"))[1])

    def test_a_problem_is_kept(self):
        code, _ = self.end(self.start("--frames", "1", camera="recording:nowhere"))
        self.assertEqual(code, 3)
        self.assertIn("no such folder: nowhere", self.end(self.start("--frames", "1"))[1])


if __name__ == "__main__":
    unittest.main(verbosity=1)
