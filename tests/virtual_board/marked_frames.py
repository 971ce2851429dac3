# SPDX-License-Identifier: Apache-2.0
"""Frames that carry their number, so that an image which went through a camera can be told from all others: a row of
squares along the image's upper edge, white, black, then eight bits and their parity.

marked_frames.py play RECORDING OUT.raw     the recording's PGM images with their marks, one after the other
marked_frames.py truth RECORDED TRUTH OUT   the true surface of every recorded frame, by its mark, at its time
"""
import csv
import pathlib
import sys

SIDE = 12  # px
BITS = 8


def read_pgm(path):
    data = path.read_bytes()
    magic, width, height, maximum = data.split(maxsplit=4)[:4]
    if magic != b"P5" or maximum != b"255":
        raise ValueError(f"{path}: not a PGM of 8 bits")
    width, height = int(width), int(height)
    return width, height, bytearray(data[-width * height:])


def marks(number):
    bits = [(number >> i) & 1 for i in range(BITS)]
    return [1, 0] + bits + [sum(bits) % 2]


def mark(pixels, width, number):
    for i, white in enumerate(marks(number)):
        for row in range(SIDE):
            begin = row * width + i * SIDE
            pixels[begin:begin + SIDE] = bytes([255 if white else 0]) * SIDE


def number_of(pixels, width):
    """None: no mark, as in an image that no player wrote."""
    seen = []
    for i in range(BITS + 3):
        inner = [pixels[row * width + column] for row in range(3, SIDE - 3)
                 for column in range(i * SIDE + 3, (i + 1) * SIDE - 3)]
        if min(inner) > 200:
            seen.append(1)
        elif max(inner) < 60:
            seen.append(0)
        else:
            return None
    number = sum(bit << i for i, bit in enumerate(seen[2:2 + BITS]))
    return number if seen == marks(number) else None


def play(recording, out):
    recording = pathlib.Path(recording)
    with open(recording / "frames.csv", newline="", encoding="ascii") as table, open(out, "wb") as raw:
        for number, row in enumerate(csv.DictReader(table)):
            width, _, pixels = read_pgm(recording / row["file"])
            mark(pixels, width, number)
            raw.write(pixels)


def truth(recorded, truth_file, out):
    recorded = pathlib.Path(recorded)
    with open(truth_file, newline="", encoding="ascii") as table:
        surfaces = list(csv.DictReader(table))
    known = unknown = 0
    with open(recorded / "frames.csv", newline="", encoding="ascii") as table, \
            open(out, "w", newline="", encoding="ascii") as to:
        writer = csv.DictWriter(to, surfaces[0].keys(), lineterminator="\n")
        writer.writeheader()
        for row in csv.DictReader(table):
            width, _, pixels = read_pgm(recorded / row["file"])
            number = number_of(pixels, width)
            if number is None or number >= len(surfaces):
                unknown += 1
                continue
            writer.writerow(surfaces[number] | {"frame": known, "time_ns": row["time_ns"]})
            known += 1
    print(f"{known} recorded frames with a mark, {unknown} without")
    return 0 if known else 1


if __name__ == "__main__":
    sys.exit({"play": play, "truth": truth}[sys.argv[1]](*sys.argv[2:]))
