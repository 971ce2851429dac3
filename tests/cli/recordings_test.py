# SPDX-License-Identifier: Apache-2.0
"""What a recording says of itself, and what srd-node and srd make of it: floor plates, names of images, clocks."""

import os
import re
import shutil
import subprocess
import tempfile
import unittest

import bench

LONGEST_S = 60
FRAMES = 5
ACRYLIC = "[tank]\nrefractive_index = 1.333\n[[tank.plate]]\nthickness_mm = 12.0\nrefractive_index = 1.49\n"
AIR_GAP = ACRYLIC + "[[tank.plate]]\nthickness_mm = 3.0\nrefractive_index = 1.0\n"
RMS_MM = 0.02  # noise of 640 x 320 px images: 0.01 mm


class Recordings(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.bench = bench.Bench(folder.name)

    def call(self, *arguments, code=0):
        done = self.bench.run(arguments)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done.stdout + done.stderr

    def simulate(self, tank):
        scene = (bench.DATA / "flume-small/scene.toml").read_text()
        self.bench.write("scene.toml", re.sub(r"\[tank\]\n(?:[^\[]*\n)?(?=\[)", "", scene) + tank)
        self.call("srd", "simulate", "scene.toml", "--out", "rec", "--frames", str(FRAMES))

    def node(self, csv, *arguments, water="", camera="recording:rec"):
        """Measures into csv by way of srd listen; what srd-node said."""
        text = bench.NODE.replace("[water]\nrefractive_index = 1.333\n", water)
        self.bench.write("flume.toml", text)
        with bench.TakenPort() as port:
            pass
        listen = subprocess.Popen([os.environ["SRD_PROGRAM"], "listen", "--bind", f"127.0.0.1:{port}", "--csv", csv,
                                   "--count", str(FRAMES)], cwd=self.bench.folder, stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL)
        self.addCleanup(listen.wait)
        self.addCleanup(listen.kill)
        said = self.call("srd-node", "--config", "flume.toml", "--camera", camera, "--host", f"127.0.0.1:{port}",
                         *arguments)
        listen.wait(LONGEST_S)
        return said

    def reconstruct(self, folder, out, *arguments, code=0):
        return self.call("srd", "reconstruct", folder, "--out", out, "--guess", "80", "--threads", "1", *arguments,
                         code=code)

    def assert_true(self, csv):
        self.call("srd", "compare", csv, "rec/truth.csv", "--max-rms", str(RMS_MM))

    def test_lengths_and_origin_of_the_modes_are_the_recordings_where_nobody_says_others(self):
        self.simulate("")
        optics = self.bench.path("rec/optics.toml").read_text()
        self.assertIn("lx_mm = 240.0", optics)
        said = self.node("own.csv")
        self.assertIn("Lx 240 mm, Ly 440 mm", said)
        self.bench.write("rec/optics.toml", optics.replace("lx_mm = 240.0", "lx_mm = 120.0").replace("x0_mm = 0.0", "x0_mm = 7.0"))
        without = bench.NODE.replace("lx_mm = 240.0\nly_mm = 440.0\n", "")
        self.bench.write("flume.toml", without)
        said = self.call("srd-node", "--config", "flume.toml", "--record", "again")
        self.assertIn("Lx 120 mm, Ly 440 mm", said)
        again = self.bench.path("again/optics.toml").read_text()
        self.assertIn("lx_mm = 120.0", again)
        self.assertIn("x0_mm = 7.0", again)
        self.bench.remove("rec/optics.toml")
        said = self.call("srd-node", "--config", "flume.toml", "--check-config", code=2)
        self.assertIn("'surface.lx_mm' is missing", said)

    def test_a_loss_is_taken_and_said(self):
        self.simulate("")
        series = {}
        for loss in ("none", "huber", "tukey"):
            said = self.reconstruct("rec", loss, "--loss", loss)
            self.assert_true(f"{loss}/surface.csv")
            self.assertEqual(loss != "none", f"loss: {loss}" in said + self.bench.path(f"{loss}/summary.txt").read_text())
            series[loss] = self.bench.path(f"{loss}/surface.csv").read_text()
        self.assertEqual(len(set(series.values())), 3)

    def test_plates_go_with_the_frames_from_the_tank_to_the_surface(self):
        for tank, text in ((ACRYLIC, "floor plates 12 mm of index 1.49"),
                           (AIR_GAP, "floor plates 12 mm of index 1.49, 3 mm of index 1 ")):
            with self.subTest(text):
                self.setUp()
                self.simulate(tank)
                said = self.node("run.csv", "--record", "kept")
                self.assertIn(text, said)
                self.assertIn("optics.toml", said)
                self.assert_true("run.csv")
                self.assertEqual(self.bench.path("kept/optics.toml").read_text().count("[[water.plate]]"),
                                 tank.count("[[tank.plate]]"))
                for folder in ("rec", "kept"):
                    said = self.reconstruct(folder, "out-" + folder)
                    self.assertIn(text, said)
                    self.assertIn("from optics.toml of the recording", said)
                    self.assert_true(f"out-{folder}/surface.csv")
                    model = self.bench.path(f"out-{folder}/surface.csv.model.toml").read_text()
                    self.assertIn("[[node.plate]]\nthickness_mm = 12.0\nindex = 1.49\n", model)
                self.bench.remove("kept/optics.toml")
                lengths = ("--lx", "240", "--ly", "440")
                plates = [part for plate in re.findall(r"thickness_mm = (\S+)\nrefractive_index = (\S+)", tank)
                          for part in ("--plate", ",".join(plate))]
                said = self.reconstruct("kept", "by-hand", *lengths, *plates)
                self.assertIn("(from --plate)", said)
                self.assert_true("by-hand/surface.csv")
                # Without them the surface is millimetres off: the plates are seen to matter.
                self.reconstruct("kept", "without", *lengths)
                self.call("srd", "compare", "without/surface.csv", "rec/truth.csv", "--max-rms", "0.5", code=3)

    def test_contradictions_are_told_and_who_asks_goes_first(self):
        self.simulate(ACRYLIC)
        said = self.reconstruct("rec", "out", "--plate", "10,1.5", "--refractive-index", "1.34")
        self.assertIn("--plate says floor plates 10 mm of index 1.5", said)
        self.assertIn("12 mm of index 1.49", said)
        self.assertIn("--refractive-index says 1.34, optics.toml of the recording 1.333", said)
        said = self.reconstruct("rec", "same", "--plate", "12,1.49", "--refractive-index", "1.333")
        self.assertNotIn("says", said)
        said = self.node("run.csv", water="[water]\nrefractive_index = 1.34\n"
                         "[[water.plate]]\nthickness_mm = 10.0\nindex = 1.49\n")
        self.assertIn("the configuration says index 1.34, the recording's optics.toml 1.333", said)
        self.assertIn("the configuration says floor plates 10 mm of index 1.49", said)

    def test_wrong_plates_are_refused(self):
        self.simulate(ACRYLIC)
        for plate in ("12", "12,", "0,1.5", "-1,1.5", "12,0.9", "12,3.5", "nan,1.5", "12,1.5,2", "12 mm,1.5", ""):
            with self.subTest(plate):
                self.assertIn("--plate", self.reconstruct("rec", "out", "--plate", plate, code=2))
        self.assertIn("at most 4", self.reconstruct("rec", "out", *["--plate", "1,1.5"] * 5, code=2))
        self.assertIn("--guess lies in the floor plates", self.reconstruct("rec", "out", "--plate", "80,1.5", code=2))
        good = self.bench.path("rec/optics.toml").read_text()
        for old, new, word in (("index = 1.49", "index = 0.5", "index"), ("thickness_mm", "thickness", "thickness"),
                               ("refractive_index = 1.333\n", "", "refractive_index"), ('"B"', '"Q"', "modes")):
            with self.subTest(new):
                self.bench.write("rec/optics.toml", good.replace(old, new, 1))
                said = self.reconstruct("rec", "out", code=3)
                self.assertIn("optics.toml", said)
                self.assertIn(word, said)
        self.assertFalse(self.bench.path("out").exists())

    def test_images_come_in_the_order_that_their_names_mean(self):
        self.simulate(ACRYLIC)
        self.bench.remove("rec/frames.csv")
        shutil.copytree(self.bench.path("rec"), self.bench.path("plain"))
        for k, name in enumerate(("-10", "-2", "-1.5", "0", "3")):
            self.bench.path(f"rec/frame_{k:06}.png").rename(self.bench.path(f"rec/{name}.png"))
        self.bench.write("rec/._0.png", b"\x00\x05\x16\x07" + b"\x00" * 60)
        said = self.reconstruct("rec", "out", "--rate", "50")
        self.assertIn("first -10.png, last 3.png", said)
        self.reconstruct("plain", "right", "--rate", "50")
        self.assertEqual(self.bench.path("out/surface.csv").read_bytes(), self.bench.path("right/surface.csv").read_bytes())
        said = self.node("run.csv", "--rate", "50", "--rate", "max")
        self.assertIn("first -10.png, last 3.png", said)
        self.assertIn(f"{FRAMES} captured", said)
        self.assert_true("run.csv")

    def test_hidden_files_are_no_frames_of_settings(self):
        self.bench.settings()
        self.call("srd", "reconstruct", "settings.xml", "--out", "right")
        self.bench.write("frames/._0.png", b"\x00\x05\x16\x07" + b"\x00" * 60)
        self.call("srd", "reconstruct", "settings.xml", "--out", "out")
        self.assertEqual(self.bench.path("out/coefficients.txt").read_bytes(),
                         self.bench.path("right/coefficients.txt").read_bytes())

    def test_clock_that_was_set_back_is_passed_by_with_a_rate(self):
        self.simulate(ACRYLIC)
        listing = self.bench.path("rec/frames.csv").read_text()
        self.bench.write("rec/frames.csv", listing.replace(",3,60000000,", ",3,5,"))
        for said in (self.reconstruct("rec", "out", code=3),
                     self.call("srd-node", "--config", "flume.toml", "--camera", "recording:rec", code=3)
                     if self.bench.write("flume.toml", bench.NODE) is None else ""):
            self.assertIn("frames.csv:5", said)
            self.assertIn("--rate HZ", said)
        said = self.reconstruct("rec", "out", "--rate", "50")
        self.assertIn("times follow from the sequence at 50 Hz", said)
        said = self.node("run.csv", "--rate", "50", "--rate", "max")
        self.assertIn("times follow from the sequence at 50 Hz", said)
        for csv in ("out/surface.csv", "run.csv"):
            times = [line.split(",")[3] for line in self.bench.path(csv).read_text().splitlines()[1:]]
            self.assertEqual(times, ["0", "20000000", "40000000", "60000000", "80000000"], csv)
            self.assert_true(csv)
        for rate in ("0", "-5", "nan", "fast", "1e9"):
            self.call("srd-node", "--config", "flume.toml", "--rate", rate, code=2)
        self.call("srd-node", "--config", "flume.toml", "--camera", "simulator", "--rate", "50", code=2)

    def test_fisheye_calibration_is_refused_by_its_name(self):
        self.bench.node()
        calibration = self.bench.path("rec/calibration.yml").read_text()
        self.bench.write("rec/calibration.yml", calibration + "distortion_model: equidistant\n")
        for said in (self.call("srd-node", "--config", "flume.toml", "--check-config", code=3),
                     self.reconstruct("rec", "out", "--lx", "240", "--ly", "440", code=3)):
            self.assertIn("distortion_model", said)
            self.assertIn("'equidistant'", said)


if __name__ == "__main__":
    unittest.main()
