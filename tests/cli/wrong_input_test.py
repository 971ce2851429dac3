# SPDX-License-Identifier: Apache-2.0
"""Wrong input is explained: every case names the place, ends with its exit code and leaves nothing behind."""

import subprocess
import tempfile
import unittest

import bench
import host_cases
import node_cases

CASES = [("srd-node: " + case[0], *case[1:]) for case in node_cases.CASES]
CASES += [(f"srd {case[2][1] if len(case[2]) > 1 else ''}: {case[0]}", *case[1:]) for case in host_cases.CASES]

# The good input that the cases spoil: were it wrong itself, a case could pass for another reason than its own.
GOOD = [
    ("srd-node checks", lambda b: b.node(), node_cases.CHECK),
    ("srd-node examines", lambda b: b.node(), (*node_cases.RUN, "--doctor")),
    ("srd-node runs", lambda b: b.node(), node_cases.RUN),
    ("srd simulate", host_cases.scene(""), host_cases.SIMULATE),
    ("srd reconstruct settings", host_cases.settings(), host_cases.SETTINGS),
    ("srd reconstruct with a reference image",
     host_cases.pose_from_image(InputReference1='"rec/reference.png"'), host_cases.SETTINGS),
    ("srd reconstruct recording", host_cases.recording, host_cases.RECORDING),
    ("srd calibrate", lambda b: b.views(), host_cases.calibrate(board="17x7", square="9.75", sources=["views"])),
    ("srd listen", lambda b: None, (*host_cases.LISTEN, "--csv", "run.csv")),
    ("srd plot", host_cases.tables, host_cases.PLOT),
    ("srd compare", host_cases.tables, host_cases.COMPARE),
    ("srd pose", host_cases.recording, host_cases.POSE),
    ("srd rig-check", host_cases.recording, host_cases.RIG_CHECK),
]

# What is only noted: the words.
NOTED = [
    ("a host without an address is no fault of the configuration",
     node_cases.config('id = "bench"', 'id = "bench"\nhost = "flume..invalid:47810"'), node_cases.CHECK,
     ["note", "flume.toml", "cannot resolve 'flume..invalid'"]),
    ("a disk that is too full for the file's recordings does not stop the measurement",
     node_cases.config("[80.0]", '[80.0]\n[record]\nfolder = "new"\nmin_free_mib = 1000000000'), node_cases.RUN,
     ["note", "nothing is recorded to ", "1000000000 MiB free (record.min_free_mib)", "the measurement goes on", "3 records"]),
]


def faults(before, after, done, code, parts):
    """What a person would complain about."""
    found = []
    if done.returncode != code:
        found.append(f"exit code {done.returncode} in place of {code}")
    found += [f"stderr does not say {part!r}" for part in parts if part not in done.stderr]
    if "1 to 0" in done.stderr:
        found.append("a wrong line is told of two times, once with an impossible range")
    if "terminate called" in done.stderr or "Sanitizer" in done.stderr:
        found.append("the program broke down")
    if done.stdout:
        found.append(f"stdout says {done.stdout[:200]!r}")
    found += [f"{name} is changed or gone" for name in before if after.get(name) != before[name]]
    found += [f"{name} is left behind" for name in after if name not in before]
    return found


class WrongInput(unittest.TestCase):
    def test_is_explained(self):
        self.assertEqual(len({case[0] for case in CASES}), len(CASES), "two cases have one name")
        with bench.TakenPort() as taken_port:
            for name, build, arguments, code, parts in CASES:
                arguments = [argument.format(taken_port=taken_port) for argument in arguments]
                with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                    place = bench.Bench(folder)
                    build(place)
                    before = place.files()
                    try:
                        done = place.run(arguments)
                    except subprocess.TimeoutExpired:
                        self.fail(f"{' '.join(arguments)}\n  does not end within {bench.LONGEST_S} s")
                    found = faults(before, place.files(), done, code, parts)
                    if found:
                        self.fail("\n  ".join([" ".join(arguments), *found, "stderr:", done.stderr]))
        print(f"{len(CASES)} cases of wrong input run")

    def test_starts_from_good_input(self):
        for name, build, arguments in GOOD:
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                place = bench.Bench(folder)
                build(place)
                done = place.run(arguments)
                self.assertEqual(done.returncode, 0, done.stderr)

    def test_what_is_only_noted(self):
        for name, build, arguments, parts in NOTED:
            with self.subTest(name), tempfile.TemporaryDirectory() as folder:
                place = bench.Bench(folder)
                build(place)
                done = place.run(arguments)
                self.assertEqual(done.returncode, 0, done.stderr)
                for part in parts:
                    self.assertIn(part, done.stderr)


if __name__ == "__main__":
    unittest.main(verbosity=1)
