# SPDX-License-Identifier: Apache-2.0
"""What packages carry is right before it is packed: profiles, unit file, helper scripts. run.sh installs the packages themselves."""

import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import xml.etree.ElementTree

import write_geometry

TREE = pathlib.Path(__file__).resolve().parents[2]
PACKAGING = TREE / "board/packaging"
PROFILES = sorted(TREE.glob("board/*/node.toml"))
WORST_EXPOSURE = 2.1  # 0.4 of it: adjtimex, which also reads whether the clock is synchronised


def run(*command, **environment):
    return subprocess.run([str(word) for word in command], env={**os.environ, **environment}, stdin=subprocess.DEVNULL,
                          capture_output=True, text=True, timeout=60)


class Packaging(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_every_profile_passes_check_config(self):
        self.assertGreaterEqual(len(PROFILES), 5)
        for profile in PROFILES:
            with self.subTest(profile.parent.name):
                there = self.folder / profile.parent.name
                there.mkdir()
                shutil.copy(profile, there)
                write_geometry.write(profile, there)
                done = run(os.environ["SRD_NODE_PROGRAM"], "--config", there / "node.toml", "--check-config")
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertNotIn("warning", done.stderr)

    def test_profiles_are_told_of_and_drawn(self):
        table = (TREE / "board/README.md").read_text()
        for profile in PROFILES:
            with self.subTest(profile.parent.name):
                self.assertIn(f"{profile.parent.name}/", table)
                for picture in profile.parent.glob("*.svg"):
                    xml.etree.ElementTree.parse(picture)
                    self.assertIn(picture.name, (profile.parent / "README.md").read_text())

    def unit(self, old="", new=""):
        """The unit with programs that are there on any machine: systemd looks for them."""
        text = (PACKAGING / "flume-srd-node.service").read_text()
        self.assertIn(old, text)
        unit = self.folder / "flume-srd-node.service"
        unit.write_text(re.sub(r"/usr/(bin|lib/flume-srd)/[a-z-]+", "/bin/true", text.replace(old, new)))
        return unit

    @unittest.skipUnless(shutil.which("systemd-analyze"), "no systemd-analyze here")
    def test_unit_verifies(self):
        self.assertEqual(run("systemd-analyze", "--man=no", "verify", self.unit()).stderr, "")
        wrong = run("systemd-analyze", "--man=no", "verify", self.unit("WatchdogSec=", "WatchdogSecs="))
        self.assertIn("WatchdogSecs", wrong.stderr)

    @unittest.skipUnless(shutil.which("systemd-analyze"), "no systemd-analyze here")
    def test_unit_is_exposed_little(self):
        security = ("systemd-analyze", "security", "--offline=true", f"--threshold={round(10 * WORST_EXPOSURE)}")
        done = run(*security, self.unit())
        print(done.stdout.strip().splitlines()[-1])
        self.assertEqual(done.returncode, 0, done.stdout)
        open_unit = self.unit()
        open_unit.write_text(re.sub(r"(?m)^(Protect|Restrict|SystemCall|Capability).*\n", "", open_unit.read_text()))
        self.assertNotEqual(run(*security, open_unit).returncode, 0)

    def test_service_waits_for_an_edited_profile(self):
        profiles, config = self.folder / "profiles", self.folder / "node.toml"
        for board in ("raspberrypi-4", "raspberrypi-5", "generic-v4l2"):
            with self.subTest(board):
                shutil.copytree(TREE / "board" / board, profiles / board)
                text = (TREE / "board" / board / "node.toml").read_text()
                config.write_text(text)
                waits = run(PACKAGING / "configured.sh", config, SRD_PROFILES=str(profiles))
                self.assertEqual(waits.returncode, 1)
                self.assertEqual(len(waits.stderr.splitlines()), 1)
                self.assertIn("edit node.id and node.host", waits.stderr)
                config.write_text(text.replace('"node-1"', '"north-wall"'))
                self.assertEqual(run(PACKAGING / "configured.sh", config, SRD_PROFILES=str(profiles)).returncode, 0)
        gone = run(PACKAGING / "configured.sh", self.folder / "gone.toml", SRD_PROFILES=str(profiles))
        self.assertEqual(gone.returncode, 1)
        self.assertIn("copy a profile from", gone.stderr)

    def test_the_doctor_is_named_with_the_services_user_and_limits(self):
        unit = dict(re.findall(r"(?m)^(User|Group|LimitRTPRIO|LimitMEMLOCK)=(.*)$",
                               (PACKAGING / "flume-srd-node.service").read_text()))
        memory = unit["LimitMEMLOCK"].replace("infinity", "unlimited")
        command = (f"prlimit --rtprio={unit['LimitRTPRIO']} --memlock={memory} setpriv --reuid={unit['User']} "
                   f"--regid={unit['Group']} --init-groups srd-node --config ")
        for path in ("README.md", "board/README.md", "board/packaging/configured.sh", "board/packaging/man/srd-node.1"):
            with self.subTest(path):
                text = (TREE / path).read_text().replace("\\-", "-")
                text = re.sub(r"\s*\\e?\n\s*", " ", text)
                named = re.findall(r"(.*)(?:/etc/flume-srd/node\.toml|\$config) --doctor", text)
                self.assertEqual(len(named), 1)
                self.assertTrue(named[0].endswith(command), named[0])

    def test_board_is_detected_by_its_model(self):
        model = self.folder / "model"
        for text, board in (("Raspberry Pi 4 Model B Rev 1.5\0", "raspberrypi-4"),
                            ("Raspberry Pi Compute Module 4 Rev 1.0\0", "raspberrypi-4"),
                            ("Raspberry Pi 5 Model B Rev 1.0\0", "raspberrypi-5"),
                            ("Raspberry Pi 3 Model B\0", "generic-v4l2"), ("", "generic-v4l2")):
            model.write_text(text)
            self.assertEqual(run(PACKAGING / "detect_board.sh", SRD_MODEL_FILE=str(model)).stdout.strip(), board)
        no_device_tree = run(PACKAGING / "detect_board.sh", SRD_MODEL_FILE=str(self.folder / "none"))
        self.assertEqual((no_device_tree.stdout, no_device_tree.stderr), ("generic-v4l2\n", ""))

    def purge(self):
        """The package's own script, on folders of the test and with nothing of the system but what removes."""
        programs = self.folder / "bin"
        programs.mkdir(exist_ok=True)
        for name in ("rm", "rmdir"):
            if not (programs / name).exists():
                (programs / name).symlink_to(shutil.which(name))
        script = self.folder / "postrm"
        script.write_text(re.sub(r"/(etc|var|run)/", rf"{self.folder}/\1/", (PACKAGING / "debian/postrm").read_text()))
        return run("/bin/sh", script, "purge", PATH=str(programs))

    def test_purge_takes_empty_folders_only(self):
        state, settings, disk = self.folder / "var/lib/flume-srd", self.folder / "etc/flume-srd", self.folder / "disk"
        for folder in (state, settings, disk):
            folder.mkdir(parents=True)
        (settings / "node.toml").write_text("")
        (state / "frames.csv").write_text("")
        self.assertEqual(self.purge().returncode, 0)
        self.assertFalse(settings.exists())
        self.assertTrue((state / "frames.csv").exists())
        (state / "frames.csv").unlink()
        self.assertEqual(self.purge().returncode, 0)
        self.assertFalse(state.exists())
        state.symlink_to(disk)
        done = self.purge()
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertTrue(state.is_symlink())


if __name__ == "__main__":
    unittest.main(verbosity=1)
