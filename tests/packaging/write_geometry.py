# SPDX-License-Identifier: Apache-2.0
"""write_geometry.py PROFILE.toml FOLDER: a calibration and a pose that fit a profile: its image size, its pattern in view.

They are no camera's; they let a profile be checked as a technician's own files do.
"""

import pathlib
import sys
import tomllib

# The oblique camera of tests/data/flume-small, 1 m above an 11 x 21 board of 20 mm.
FOCAL_OF_WIDTH = 1075 / 640
POSE = """\
%YAML:1.0
---
Rotationmatrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1.9758591461345072e-02, 9.9909522970671183e-01, -3.7660590021348306e-02,
       9.4966250606576574e-01, -6.9751138396383083e-03, 3.1319717808405206e-01,
       3.1265111967871317e-01, -4.1953185388197929e-02, -9.4894109806638183e-01 ]
TranslationVector: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ -2.1004452861412804e+02, -1.0586103950678674e+02, 9.7451256344585488e+02 ]
"""
CALIBRATION = """\
%YAML:1.0
---
image_width: {width}
image_height: {height}
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ {focal}, 0., {u}, 0., {focal}, {v}, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 5
   cols: 1
   dt: d
   data: [ 0., 0., 0., 0., 0. ]
"""


def write(profile, folder):
    camera = tomllib.loads(pathlib.Path(profile).read_text())["camera"]
    width, height = camera.get("width_px", 1280), camera.get("height_px", 800)
    folder = pathlib.Path(folder)
    folder.joinpath("pose.yml").write_text(POSE)
    folder.joinpath("calibration.yml").write_text(
        CALIBRATION.format(width=width, height=height, focal=FOCAL_OF_WIDTH * width, u=width / 2, v=height / 2))


if __name__ == "__main__":
    write(*sys.argv[1:])
