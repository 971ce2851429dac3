#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The water surface at a point, from the file that `srd listen` or `srd reconstruct` wrote. Standard library and numpy.

usage: surface_at.py RUN.csv X_MM Y_MM   prints sequence, time in s, and height in mm above the pattern, a line each frame

Beside RUN.csv stands RUN.csv.model.toml with the lengths and the origin of the modes.
"""

import csv
import re
import sys
import tomllib

import numpy

HEIGHT = re.compile(r"B|C|A\d\d")


def mode_value(name, x, y):
    """One mode at X/Lx, Y/Ly: dsp/OPTICS.md, equation (5)."""
    if name in ("B", "C"):
        return x if name == "B" else y
    return numpy.cos(int(name[1]) * numpy.pi * x) * numpy.cos(int(name[2]) * numpy.pi * y)


def heights(path, x_mm, y_mm):
    """Sequences, times (s) and heights (mm) of the frames of one node that have a surface which the node itself trusts."""
    with open(path + ".model.toml", "rb") as file:
        model = tomllib.load(file)["node"][0]
    with open(path, newline="", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["node"] == model["name"] and row["status"] == "ok"]
    if not rows:
        raise SystemExit(f"{path}: no row of node {model['name']} has status ok")
    modes = [column for column in rows[0] if HEIGHT.fullmatch(column)]
    coefficients = numpy.array([[float(row[mode]) for mode in modes] for row in rows])
    x, y = (x_mm - model["x0"]) / model["lx"], (y_mm - model["y0"]) / model["ly"]
    surface = coefficients @ numpy.array([mode_value(mode, x, y) for mode in modes])
    return [int(row["sequence"]) for row in rows], [int(row["time_ns"]) / 1e9 for row in rows], surface


def main(arguments):
    if len(arguments) != 3:
        raise SystemExit(__doc__.strip())
    for sequence, time_s, height in zip(*heights(arguments[0], float(arguments[1]), float(arguments[2]))):
        print(f"{sequence} {time_s:.6f} {height:.4f}")


if __name__ == "__main__":
    main(sys.argv[1:])
