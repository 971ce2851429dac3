# SPDX-License-Identifier: Apache-2.0
"""A folder of good input for srd-node and srd that a case spoils in one place, and the run that follows."""

import math
import os
import pathlib
import shutil
import socket
import subprocess

DATA = pathlib.Path(os.environ.get("SRD_TEST_DATA", pathlib.Path(__file__).parents[1] / "data"))
PROGRAMS = {"srd": "SRD_PROGRAM", "srd-node": "SRD_NODE_PROGRAM"}
LONGEST_S = 10

NODE = """\
[node]
id = "bench"
[camera]
source = "recording:rec"
rate = "max"
[pattern]
first_square = "dark"
[water]
refractive_index = 1.333
[surface]
parameters = 5
lx_mm = 240.0
ly_mm = 440.0
guess_mm = [80.0]
[detector]
min_distance_px = 8
"""

SCENE = """\
name = "bench"
frames = 2
[camera]
width = 640
height = 320
fx = 1075.0
fy = 1075.0
cx = 323.4
cy = 157.7
"""

# The 2016 dialect with a pose file and images; a key a line, the first in line 4.
SETTINGS = {
    "NumberOfCameras": "1", "TypeCameraPose": "0", "TypeFeatureInput": "1", "FeaturePatternSize_Width": "11",
    "FeaturePatternSize_Height": "21", "Lx": "240", "Ly": "440", "SurfaceModelParameters": "5",
    "InitialGuess": '"[80,0,0,0,0]"', "Scaling": '"[1,1,1,1,1]"', "ErrorMetric": "2", "Epsg": "0.000001",
    "ResponseRadius": "5", "ResponseThreshold": "350", "MinDistance": "8", "CalibrationFile1": '"rec/calibration.yml"',
    "InputReference1": '"rec/pose.yml"', "InputFeatures1": '"rec/points.txt"', "InputDirectory1": '"frames"',
    "OutputCameraPose1": '"pose.txt"', "OutputDirectory1": '"features"', "OutputFileName": '"coefficients.txt"',
    "OutputFileNameErrors": '"errors.txt"',
}

COEFFICIENTS = """\
node,boot,sequence,time_ns,clock,status,n_expected,n_found,n_used,mean_error,metric,height_mm,A00,B,sd_A00,sd_B,wall_time_ns,wall_uncertainty_ns,sys_A00,sys_B,sys_height_mm
bench,b0000000000000007,0,0,recording,ok,231,231,231,0.1,reprojection,80,80,1,0.01,0.01,,,,,
bench,b0000000000000007,1,20000000,recording,ok,231,231,231,0.1,reprojection,80,80.5,1,0.01,0.01,,,,,
"""

TRUTH = """\
frame,time_ns,A00,B
0,0,80,1
1,20000000,80.5,1
"""


class Bench:
    """The current folder of one case."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)

    def path(self, name):
        return self.folder / name

    def write(self, name, text):
        self.path(name).parent.mkdir(parents=True, exist_ok=True)
        self.path(name).write_bytes(text if isinstance(text, bytes) else text.encode())

    def spoil(self, name, old, new):
        text = self.path(name).read_text()
        assert text.count(old) == 1, f"{name} has {text.count(old)} of {old!r}"
        self.path(name).write_text(text.replace(old, new))

    def remove(self, *names):
        for name in names:
            self.path(name).unlink()

    def recording(self, frames=3):
        # As another program writes it: without what the light went through and the lengths of the modes.
        shutil.copytree(DATA / "flume-small", self.path("rec"), ignore=shutil.ignore_patterns("optics.toml"))
        listing = self.path("rec/frames.csv").read_text().splitlines(keepends=True)
        self.write("rec/frames.csv", "".join(listing[: frames + 1]))

    def node(self, old=None, new=None, text=NODE):
        self.recording()
        self.write("flume.toml", text)
        if old is not None:
            self.spoil("flume.toml", old, new)

    def settings(self, leave_out=(), **changed):
        self.recording()
        for frame in range(2):
            self.write(f"frames/{frame}.png", self.path(f"rec/frame_{frame:06}.png").read_bytes())
        keys = {key: value for key, value in {**SETTINGS, **changed}.items() if key not in leave_out}
        lines = ["<?xml version=\"1.0\"?>", "<opencv_storage>", "<Settings>"]
        lines += [f"<{key}>{value}</{key}>" for key, value in keys.items()]
        self.write("settings.xml", "\n".join(lines + ["</Settings>", "</opencv_storage>", ""]))

    def tables(self):
        self.write("run.csv", COEFFICIENTS)
        self.write("truth.csv", TRUTH)

    def views(self, folder="views", count=8):
        """A checkerboard of 17 x 7 corners, 9.75 mm apart, from all sides, rendered."""
        for view in range(count):
            around, tilt = 2 * math.pi * view / count, math.radians(20 + 10 * (view % 3))
            to = [29 + 12 * math.cos(3 * around), 78 + 30 * math.sin(2 * around)]
            away = [math.sin(tilt) * math.cos(around), math.sin(tilt) * math.sin(around), math.cos(tilt)]
            centre = [to[0] + 460 * away[0], to[1] + 460 * away[1], 460 * away[2]]
            scene = SCENE.replace("frames = 2", "frames = 1") + "[pattern]\nrows = 7\ncolumns = 17\nsquare_mm = 9.75\n"
            scene += f"[pose]\ncentre_mm = {centre}\ntarget_mm = {[*to, 0.0]}\n"
            self.write("view.toml", scene)
            done = self.run(("srd", "simulate", "view.toml", "--out", f"rendered{view}"))
            assert done.returncode == 0, done.stderr
            self.write(f"{folder}/{view}.png", self.path(f"rendered{view}/reference.png").read_bytes())

    def blank_image(self, name, width=640, height=320):
        self.write(name, b"P5\n%d %d\n255\n" % (width, height) + b"\x80" * (width * height))

    def files(self):
        return {str(file.relative_to(self.folder)): file.read_bytes()
                for file in sorted(self.folder.rglob("*")) if file.is_file()}

    def run(self, arguments):
        program, *rest = arguments
        return subprocess.run([os.environ[PROGRAMS[program]], *rest], cwd=self.folder, stdin=subprocess.DEVNULL,
                              capture_output=True, timeout=LONGEST_S, text=True, errors="replace")


class TakenPort:
    """A UDP port of this computer that nobody else can have and that answers nothing."""

    def __enter__(self):
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(("127.0.0.1", 0))
        return self._socket.getsockname()[1]

    def __exit__(self, *_):
        self._socket.close()
