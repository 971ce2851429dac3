#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""srd calibrate beside mrcal (Debian: python3-mrcal) on the same corners with the same weights: optimum and uncertainty.

usage: mrcal_test.py   with SRD_PROGRAM; SRD_DATA has the published images. Skips without mrcal or images."""
import csv
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

SYSTEM_PYTHON = "/usr/bin/python3"  # the one that Debian's packages are for
try:
    import mrcal
    import numpy as np
except ImportError:
    mrcal = None
    if os.path.exists(SYSTEM_PYTHON) and not os.environ.get("SRD_SYSTEM_PYTHON"):
        os.environ["SRD_SYSTEM_PYTHON"] = "tried"
        os.execv(SYSTEM_PYTHON, [SYSTEM_PYTHON, "-B", *sys.argv])

DATA = pathlib.Path(os.environ.get("SRD_DATA", pathlib.Path(__file__).parents[3] / "shared/data")) / "opensrd-2017"
LENSES = {4: "LENSMODEL_OPENCV4", 5: "LENSMODEL_OPENCV5"}


def report(file):
    """The few keys that are needed here, of a file that srd calibrate wrote."""
    values, views, section = {}, [], ""
    for line in file.read_text().splitlines():
        if line.startswith("["):
            section = line.split("#")[0].strip().strip("[]")
            if section == "views":
                views.append({})
        elif " = [" in line and line.endswith("]"):
            key, text = line.split(" = ")
            (views[-1] if section == "views" else values)[f"{section}.{key}" if section != "views" else key] = \
                [float(x) for x in text.strip("[]").split(", ")]
        elif " = " in line:
            key, text = line.split(" = ", 1)
            if section == "":
                values[key] = text.split("#")[0].strip()
    return values, views


@unittest.skipIf(mrcal is None, "no mrcal: install python3-mrcal")
@unittest.skipUnless((DATA / "Settings_calib_CAM1.xml").exists(), "no opensrd-2017 in SRD_DATA")
class Mrcal(unittest.TestCase):
    def test_same_optimum_and_same_uncertainty(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        out = pathlib.Path(folder.name) / "out"
        subprocess.run([os.environ["SRD_PROGRAM"], "calibrate", DATA / "Settings_calib_CAM1.xml", "--out", out], check=True,
                       capture_output=True)
        values, views = report(out / "report.toml")
        added, spacing, rows, columns = float(values["added_px"]), 9.75, 7, 17
        names = {}
        board = np.full((len(views), rows, columns, 3), -1.0)
        for row in csv.DictReader((out / "corners.csv").read_text().splitlines()):
            view = names.setdefault(row["image"], len(names))
            weight = 1 / np.hypot(float(row["sigma"]), added) if row["used"] == "1" else -1
            board[view, int(row["row"]), int(row["column"])] = float(row["u"]), float(row["v"]), weight
        # Our board runs X along rows and Z towards the camera, mrcal's X along columns and Z away from it.
        swap = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1.0]])
        frames = np.array([[*mrcal.r_from_R(mrcal.R_from_r(np.array(view["turn_rad"])) @ swap), *view["translation_mm"]] for view in views])
        lens = np.array([[values[f"parameters.{name}"][0] for name in "fx fy cx cy k1 k2 p1 p2 k3".split()]])
        start = lens.copy()
        start[0, :4] += 15, -12, 20, -20
        inputs = dict(
            intrinsics=start, extrinsics_rt_fromref=np.zeros((0, 6)), frames_rt_toref=frames.copy(), points=None,
            observations_board=board, indices_frame_camintrinsics_camextrinsics=np.array([[i, 0, -1] for i in range(len(views))], dtype=np.int32),
            observations_point=None, indices_point_camintrinsics_camextrinsics=None, lensmodel=LENSES[5],
            imagersizes=np.array([[int(values["image_width"]), int(values["image_height"])]], dtype=np.int32),
            calobject_warp=np.zeros(2), calibration_object_spacing=spacing, do_optimize_intrinsics_core=True,
            do_optimize_intrinsics_distortions=True, do_optimize_extrinsics=True, do_optimize_frames=True,
            do_optimize_calobject_warp=True, do_apply_outlier_rejection=False, do_apply_regularization=False, verbose=False)
        for _ in range(10):
            mrcal.optimize(**inputs)
        found = inputs["intrinsics"][0]
        print("fx, cx:", lens[0, 0], lens[0, 2], "mrcal:", found[0], found[2], "bend:", inputs["calobject_warp"])
        for i, most in ((0, 0.1), (1, 0.1), (2, 0.3), (3, 0.3)):
            self.assertLess(abs(found[i] - lens[0, i]), most, i)
        bend = [values["board.bend_along_rows_mm"][0], values["board.bend_along_columns_mm"][0]]
        np.testing.assert_allclose(-inputs["calobject_warp"][::-1], bend, atol=1e-3)

        model = mrcal.cameramodel(optimization_inputs=inputs, icam_intrinsics=0)
        widened = np.sqrt(float(values["view_factor"])) if values["views_contradict"] == "true" else 1
        ratios = []
        for row in list(csv.DictReader((out / "uncertainty.csv").read_text().splitlines()))[::37]:
            pixel = np.array([float(row["u"]), float(row["v"])])
            point = mrcal.unproject(pixel, LENSES[5], found, normalize=True) * float(row["distance_mm"])
            theirs = mrcal.projection_uncertainty(point, model, what="worstdirection-stdev")
            ratios.append(float(row["deviation_px"]) / widened / theirs)
        print("uncertainty, ours by theirs:", min(ratios), "to", max(ratios), "over", len(ratios), "places")
        self.assertGreater(min(ratios), 0.9)
        self.assertLess(max(ratios), 1.1)


if __name__ == "__main__":
    unittest.main()
