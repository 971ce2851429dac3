# SPDX-License-Identifier: Apache-2.0
"""Whether the light went on in step with the frames: check_strobe.py KERNEL_TRACE FRAMES.csv [LEAST]

The kernel's trace of the line (event gpio_value, clock mono) against the frames of a recording: the time of a frame that is
labelled lit must lie within a pulse that the kernel saw, and no pulse may serve two frames. One frame in fifty may lie
outside: an emulated processor stalls for milliseconds between switching the line and reading the clock.
"""
import bisect
import csv
import re
import sys

EDGE = re.compile(r"\s(\d+)\.(\d{6}): gpio_value: \d+ set (\d)")


def pulses(trace):
    """(on, off) in ns; the trace rounds down to a microsecond."""
    found, on = [], None
    for line in trace:
        edge = EDGE.search(line)
        if not edge:
            continue
        time_ns = int(edge[1]) * 1_000_000_000 + int(edge[2]) * 1000
        if edge[3] == "1":
            on = time_ns if on is None else on
        elif on is not None:
            found.append((on, time_ns + 1000))
            on = None
    return found


def main(trace, frames, least="50"):
    with open(trace, encoding="ascii", errors="replace") as file:
        seen = pulses(file)
    starts = [on for on, _ in seen]
    with open(frames, newline="", encoding="ascii") as file:
        rows = list(csv.DictReader(file))
    lit = [int(row["time_ns"]) for row in rows if row["strobe"] in ("lit", "1")]
    used, outside = set(), 0
    for time_ns in lit:
        i = bisect.bisect_right(starts, time_ns) - 1
        if i < 0 or time_ns > seen[i][1] or i in used:
            outside += 1
        else:
            used.add(i)
    print(f"strobe: {len(seen)} pulses in the kernel's trace; {len(lit)} of {len(rows)} recorded frames are labelled lit, "
          f"{outside} of them outside a pulse")
    return 0 if len(lit) >= int(least) and 50 * outside <= len(lit) else 1


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
