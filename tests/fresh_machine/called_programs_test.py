#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""What is found in scripts, and what is not. Run on the fresh system, which has shfmt."""
import pathlib
import subprocess
import tempfile
import unittest

import called_programs


class CalledPrograms(unittest.TestCase):
    def found(self, **files):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        for name, text in files.items():
            (pathlib.Path(folder.name) / name.replace("_", ".")).write_text(text, encoding="utf-8")
        for command in (["init", "-q"], ["add", "-A"]):
            subprocess.run(["git", "-C", folder.name, *command], check=True)
        return {name: sorted(places) for name, places in called_programs.called_programs(folder.name).items()}

    def test_commands_of_bash_are_found_wherever_they_stand(self):
        text = """#!/usr/bin/env bash
if alpha; then (beta | gamma -x) & fi
value="$(delta)" && [ -e x ] || { epsilon; }
while read -r line; do zeta "$line"; done < <(eta)
"""
        self.assertEqual({"alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta"}, set(self.found(a_sh=text)))

    def test_programs_behind_other_programs_are_found(self):
        text = """#!/bin/bash
exec env A=1 alpha
timeout -k 3 20 beta
find . | xargs -n 1 gamma
unshare --mount sh -c 'delta && epsilon "$1"' sh x
command -v zeta
"""
        self.assertLessEqual({"alpha", "beta", "gamma", "delta", "epsilon", "zeta"}, set(self.found(a_sh=text)))

    def test_a_variable_stands_for_what_its_script_assigns(self):
        one = "#!/bin/bash\ncase $1 in a) tool=alpha ;; b) tool=beta ;; esac\n\"$tool\" x\nroot=()\n\"${root[@]}\" gamma\n"
        other = "#!/bin/bash\ntool=delta\n"
        self.assertEqual({"alpha", "beta", "gamma"}, set(self.found(a_sh=one, b_sh=other)))

    def test_functions_builtins_own_paths_and_other_systems_are_none(self):
        own = "#!/bin/bash\nmine() { cd /; }\nmine\ntests/run.sh\n/sbin/alpha\n. b.sh\nshared\n"
        shared = "# shellcheck shell=bash\nshared() { :; }\n"
        board = "#!/bin/sh\nmodprobe vivid\n"
        self.assertEqual({"/sbin/alpha"}, set(self.found(a_sh=own, b_sh=shared, c_sh=board)))

    def test_python_calls_are_found_with_their_file(self):
        text = "import subprocess, shutil\nsubprocess.run(['alpha', 'x'])\nshutil.which('beta')\nsubprocess.run([program])\n"
        self.assertEqual({"alpha": ["a.py"], "beta": ["a.py"]}, self.found(a_py=text))

    def test_methods_of_the_same_name_are_no_calls_of_programs(self):
        text = "from subprocess import run as start\nstart(['alpha'])\nself.call('beta')\nrun('gamma')\ntest.run('delta')\n"
        self.assertEqual({"alpha": ["a.py"]}, self.found(a_py=text))


if __name__ == "__main__":
    unittest.main()
