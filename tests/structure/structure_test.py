#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""The tree keeps its rules, and each rule catches a small tree that breaks it. Run by ctest, one case at a time."""
import pathlib
import tempfile
import unittest

import picture
import rules

ROOT = pathlib.Path(__file__).resolve().parents[2]


class Structure(unittest.TestCase):
    def assert_clean(self, problems):
        self.assertEqual([], problems, "\n" + "\n".join(problems))

    def tree(self, files):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        for name, text in files.items():
            path = pathlib.Path(folder.name) / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        return folder.name

    def test_includes_follow_the_folders(self):
        self.assertGreater(len(rules.source_files(ROOT)), 20)
        self.assert_clean(rules.include_problems(ROOT))

    def test_sources_are_short(self):
        self.assert_clean(rules.length_problems(ROOT))

    def test_no_path_of_one_machine(self):
        self.assert_clean(rules.machine_path_problems(ROOT))

    def test_folders_do_not_include_each_other(self):
        self.assertGreater(len(rules.folder_edges(ROOT)), 20)
        self.assert_clean(rules.cycle_problems(ROOT))

    def test_circles_of_folders_are_found(self):
        includes = {"dsp/a/x.hpp": "dsp/b/x.hpp", "dsp/b/x.hpp": "dsp/c/x.hpp", "dsp/c/x.hpp": "dsp/a/x.hpp",
                    "dsp/d/x.hpp": "dsp/a/x.hpp", "dsp/a/y.hpp": "dsp/a/x.hpp"}
        root = self.tree({name: f'#include "{other}"\n' for name, other in includes.items()})
        self.assertEqual(["dsp/a/x.hpp:1", "dsp/b/x.hpp:1", "dsp/c/x.hpp:1"],
                         [problem.split(": ")[0] for problem in rules.cycle_problems(root)])

    def test_equations_have_a_file_each(self):
        self.assert_clean(rules.equation_problems(ROOT))

    def test_equations_without_their_file_are_found(self):
        page = "    a = b      (1)\n    c = d      (2)\n    e = f      (3)\n    g = h      (4)\n\n" \
               "| (1) (9) | dsp/a.hpp |\n| (2) | dsp/b.hpp |\n| (4) | dsp/a.hpp |\n"
        root = self.tree({"dsp/OPTICS.md": page, "dsp/a.hpp": "// optics (1), (9)\nint b(4);\n"})
        found = rules.equation_problems(root)
        self.assertEqual(["dsp/OPTICS.md: (2): no file dsp/b.hpp", "dsp/OPTICS.md: a row of (9), which is no equation",
                          "dsp/OPTICS.md: equation (3) has no row", "dsp/a.hpp: does not cite (4)"], sorted(found))

    def test_what_is_looked_for_has_its_file(self):
        self.assertGreater(len(rules.lines_of(ROOT, "CONTRIBUTING.md")), 20)
        self.assert_clean(rules.where_problems(ROOT))

    def test_files_that_moved_from_where_they_were_are_found(self):
        page = "| a | `gone.md` |\n## Where is\n\n| looked for | file |\n|---|---|\n| a | `x/a.hpp`, `x/b.hpp` |\n" \
               "| b | somewhere |\n\n## Other\n\n| c | `x/c.hpp` |\n"
        root = self.tree({"CONTRIBUTING.md": page, "x/a.hpp": ""})
        self.assertEqual(["CONTRIBUTING.md:6: no file x/b.hpp", "CONTRIBUTING.md:7: names no file"],
                         rules.where_problems(root))

    def test_picture_shows_what_the_sources_have(self):
        self.assert_clean(picture.problems(ROOT))

    def test_pictures_that_show_something_else_are_found(self):
        drawn = (ROOT / picture.PICTURE).read_text(encoding="utf-8")
        # What a later change of the sources would leave behind, and what is wrong with the picture then.
        changes = {
            (">SurfaceTracker<", ">SurfaceFollower<"): "box SurfaceFollower: no such class in dsp/pipeline",
            (">drivers/net<", ">drivers/network<"): "box UdpSocket: no sources in drivers/network",
            ('data-from="dsp/pipeline" data-to="dsp/frontend"', 'data-from="dsp/pipeline" data-to="dsp/estimate"'):
                "arrow M850 332 V350 H720 V368: expected an end at a box of dsp/estimate, found ['dsp/frontend']",
            ("M455 675 V632", "M455 675 V640"):
                "arrow M455 675 V640: expected an end at a box of firmware/transmit, found no box",
            (">SpscRing queue_ of firmware/recording<", ">SpscRing line_ of firmware/recording<"): "ring line_ of firmware/recording: drawn",
            (">SpscRing ring_ of firmware/loop<", ">a ring<"): "ring ring_ of firmware/loop: not drawn",
            (">recorder<", ">writer<"): "thread recorder: not drawn",
            ("NodeDatagram to", "NodePacket to"): "message NodePacket: not in proto/srd.proto",
        }
        for (old, new), expected in changes.items():
            with self.subTest(new):
                self.assertIn(old, drawn)
                found = picture.problems(ROOT, drawn.replace(old, new))
                self.assertTrue(any(problem.startswith(expected) for problem in found), found)

    def test_arrows_between_strangers_are_found(self):
        drawn = (ROOT / picture.PICTURE).read_text(encoding="utf-8")
        root = self.tree({"dsp/frontend/board_finder.hpp": "class BoardFinder {\n", "dsp/pipeline/surface_tracker.hpp": "class SurfaceTracker {\n",
                          "proto/srd.proto": "message NodeDatagram {\n", picture.PICTURE: drawn})
        self.assertIn("arrow M850 332 V350 H720 V368: neither of dsp/pipeline and dsp/frontend includes the other", picture.problems(root))

    def test_sources_name_their_licence(self):
        self.assert_clean(rules.licence_problems(ROOT))

    def test_sources_without_licence_are_found(self):
        licence = "SPDX-License-Identifier: Apache-2.0\n"
        root = self.tree({"dsp/a.cpp": f"// {licence}", "dsp/b.cpp": "int a;\n", "tests/c": "#!/bin/sh\ntrue\n",
                          "tests/d.sh": f"#!/bin/sh\n# {licence}", "README.md": "a\n", "CMakeLists.txt": "\n\n\n# " + licence})
        self.assertEqual(["CMakeLists.txt:1", "dsp/b.cpp:1", "tests/c:1"],
                         sorted(problem.split(": ")[0] for problem in rules.licence_problems(root)))

    def test_wrong_includes_are_found(self):
        wrong = {
            "dsp/a.cpp": '#include <opencv2/core.hpp>',
            "dsp/b.hpp": '#include "drivers/camera/camera.hpp"',
            "dsp/c.cpp": '#include <chrono>',
            "dsp/d.cpp": '#include <sys/mman.h>',
            "proto/a.cpp": '#include "drivers/support/problem.hpp"',
            "drivers/a.cpp": '  #  include "proto/codec.hpp"',
            "drivers/b.cpp": '#include "../host/table/csv_table.hpp"',
            "firmware/a.cpp": '#include "host/plot/command.hpp"',
            "host/a.cpp": '#include "firmware/state.hpp"',
            "host/b.cpp": '#include "tests/fakes/clock.hpp"',
        }
        right = {
            "dsp/e.cpp": '#include <Eigen/Core>\n#include <hwy/highway.h>\n#include <cmath>\n#include "dsp/core/result.hpp"',
            "proto/b.cpp": '#include <pb_encode.h>\n#include "srd.pb.h"\n#include "dsp/core/result.hpp"',
            "host/c.cpp": '#include <cairo.h>\n#include "proto/codec.hpp"\n#include "drivers/camera/camera.hpp"',
            "tests/t.cpp": '#include "host/plot/command.hpp"\n#include "firmware/state.hpp"',
        }
        root = self.tree({name: "// line 1\n" + text + "\n" for name, text in {**wrong, **right}.items()})
        found = [problem.split(": ")[0] for problem in rules.include_problems(root)]
        self.assertEqual(sorted(f"{name}:2" for name in wrong), sorted(found))

    def test_long_sources_are_found(self):
        root = self.tree({"dsp/long.cpp": "\n" * 501, "dsp/fits.cpp": "\n" * 500, "host/long.txt": "\n" * 900})
        self.assertEqual(["dsp/long.cpp:501"], [problem.split(": ")[0] for problem in rules.length_problems(root)])

    def test_paths_of_one_machine_are_found(self):
        # Put together here, or this file would hold what it looks for.
        home, root_folder, work = (f"/{name}/" for name in ("home", "root", "work"))
        root = self.tree({
            "a.txt": f"first\nlook in {home}ann/flume", "b.txt": f"build{work}x and <a{root_folder}b>\n",
        })
        self.assertEqual(["a.txt:2"], [problem.split(": ")[0] for problem in rules.machine_path_problems(root)])


if __name__ == "__main__":
    unittest.main()
