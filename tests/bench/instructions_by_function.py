#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Which functions a frame's instructions are in: PROGRAM, the counts of N and of 2N frames, N. Called by
count_instructions.sh --by-function. What the compiler put inline counts for the function that it is in."""
import bisect
import collections
import subprocess
import sys


def functions(program):
    listing = subprocess.run(["aarch64-linux-gnu-nm", "-C", "-n", program], capture_output=True, check=True, text=True)
    found = []
    for line in listing.stdout.splitlines():
        address, kind, name = line.split(" ", 2) if line[0] != " " else ("", "", "")
        if kind in ("t", "T", "w", "W", "i"):
            found.append((int(address, 16), name))
    return found


def counts(file, table):
    starts = [address for address, _ in table]
    total = collections.Counter()
    with open(file, encoding="ascii") as lines:
        next(lines)
        for line in lines:
            address, executed = line.split()
            address = int(address, 16)
            at = bisect.bisect_right(starts, address) - 1
            inside = at >= 0 and address < starts[-1] + (1 << 20)
            total[table[at][1] if inside else "(libraries)"] += int(executed)
    return total


def main():
    program, once, twice, frames = sys.argv[1], sys.argv[2], sys.argv[3], int(sys.argv[4])
    table = functions(program)
    once, twice = counts(once, table), counts(twice, table)
    for name, executed in (twice - once).most_common(25):
        print(f"{executed // frames:>10}  {name[:110]}")


if __name__ == "__main__":
    main()
