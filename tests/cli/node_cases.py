# SPDX-License-Identifier: Apache-2.0
"""What can be wrong in what a technician gives to srd-node: name, builder, arguments, exit code, words of the message."""

from bench import NODE

USAGE, INPUT, DEVICE, NETWORK = 2, 3, 4, 5
CHECK = ("srd-node", "--config", "flume.toml", "--check-config")
RUN = ("srd-node", "--config", "flume.toml")


def config(old, new):
    return lambda bench: bench.node(old, new)


def with_key(node, mode):
    def build(bench):
        bench.node('id = "bench"', 'id = "bench"\nkey = "node.key"')
        bench.write("node.key", f"flume-srd-key-1 {node} {'0' * 64}\n")
        bench.path("node.key").chmod(mode)
    return build


def spoilt(name, old, new):
    def build(bench):
        bench.node()
        bench.spoil(name, old, new)
    return build


def written(name, contents):
    def build(bench):
        bench.node()
        bench.write(name, contents)
    return build


def without(*names):
    def build(bench):
        bench.node()
        bench.remove(*names)
    return build


def only_unreadable_images(bench):
    bench.node()
    for frame in range(3):
        bench.write(f"rec/frame_{frame:06}.png", "no image")




def blank_images(bench):
    bench.recording()
    listing = bench.path("rec/frames.csv").read_text()
    bench.write("rec/frames.csv", listing.replace(".png", ".pgm"))
    for frame in range(3):
        bench.blank_image(f"rec/frame_{frame:06}.pgm")
    bench.write("flume.toml", NODE)


IDENTITY = "1.9758591461345072e-02"
LINE = "".join(f"{20 * i} 0 0\n" for i in range(20))
# On a grid to 5 % of a square, but for one.
CROOKED = "0 0 0\n20 0 0\n0 20 0\n28 23 0\n"

CONFIGURATION = [
    ("config is not given", lambda b: None, ("srd-node",), USAGE, ["--config", "expected", "found"]),
    ("config is missing", lambda b: None, RUN, USAGE, ["flume.toml", "cannot be read", "check the path"]),
    ("config is a folder", lambda b: b.path("flume.toml").mkdir(), CHECK, USAGE, ["flume.toml", "cannot be read"]),
    ("config is not TOML", config('id = "bench"', "id = = 4"), CHECK, USAGE, ["flume.toml:2", "expected"]),
    ("config is binary", written("flume.toml", bytes(range(256))), CHECK, USAGE, ["flume.toml:1"]),
    ("spill without a folder", config("[water]", '[transmit]\nspill = ""\n[water]'), CHECK, USAGE,
     ["flume.toml:9", "'transmit.spill'", "a folder"]),
    ("key file missing", config('id = "bench"', 'id = "bench"\nkey = "node.key"'), CHECK, USAGE,
     ["node.key", "No such file", "srd keygen"]),
    ("key of another node", with_key("cam-1", 0o600), CHECK, USAGE, ["node.key", "a key of bench", "one of cam-1"]),
    ("key that others can read", with_key("bench", 0o640), CHECK, USAGE, ["node.key", "mode 640", "chmod 600 node.key"]),
    ("key that others can read, without a check", with_key("bench", 0o604), RUN, USAGE, ["mode 604", "chmod 600 node.key"]),
    ("unknown key", config("refractive_index", "refractiv_index"), CHECK, USAGE,
     ["flume.toml:9", "unknown key 'water.refractiv_index'", "one of: ", "refractive_index"]),
    ("unknown table", config("[water]", "[watr]"), CHECK, USAGE, ["flume.toml:8", "unknown key 'watr'", "water"]),
    ("wrong type", config("parameters = 5", 'parameters = "5"'), CHECK, USAGE,
     ["flume.toml:11", "'surface.parameters'", "a whole number", "found"]),
    ("out of range", config("1.333", "13.33"), CHECK, USAGE,
     ["flume.toml:9", "'water.refractive_index'", "expected a number from 1.0001 to 2", "found 13.33"]),
    ("not a number", config("240.0", "nan"), CHECK, USAGE, ["flume.toml:12", "'surface.lx_mm'", "found nan"]),
    ("infinite", config("440.0", "inf"), CHECK, USAGE, ["flume.toml:13", "'surface.ly_mm'", "found inf"]),
    ("length scale missing", config("lx_mm = 240.0", ""), CHECK, USAGE, ["flume.toml", "'surface.lx_mm' is missing"]),
    ("parameters that no model has", config("parameters = 5", "parameters = 4"), CHECK, USAGE,
     ["flume.toml:11", "'surface.parameters'", "1, 3, 5, 8 or 12", "found 4"]),
    ("bad name of a mode", config("parameters = 5", 'modes = ["A00", "Q7"]'), CHECK, USAGE,
     ["flume.toml:11", "'surface.modes'", '"Q7"']),
    ("a mode twice", config("parameters = 5", 'modes = ["A00", "B", "B"]'), CHECK, USAGE,
     ["flume.toml:11", "'surface.modes'", "different modes"]),
    ("guess is too long", config("[80.0]", "[80.0, 0, 0, 0, 0, 0]"), CHECK, USAGE,
     ["flume.toml:14", "'surface.guess_mm'", "expected", "found"]),
    ("not a number in the guess", config("[80.0]", "[nan]"), CHECK, USAGE, ["flume.toml:14", "'surface.guess_mm'", "nan"]),
    ("bounds that exclude everything",
     config("[80.0]", "[80.0]\nlower_mm = [90, -9, -9, -9, -9]\nupper_mm = [70, 9, 9, 9, 9]"), CHECK, USAGE,
     ["flume.toml:15", "'surface.lower_mm'", "upper_mm", "90"]),
    ("bounds of another length", config("[80.0]", "[80.0]\nlower_mm = [60, -9]"), CHECK, USAGE,
     ["flume.toml:15", "'surface.lower_mm'", "a list of 5"]),
    ("node id that reads as a number", config('"bench"', '"1e5"'), CHECK, USAGE, ["flume.toml:2", "'node.id'", '"1e5"', "flume-1e5"]),
    ("bad node id", config('"bench"', '"a node"'), CHECK, USAGE, ["flume.toml:2", "'node.id'", '"a node"']),
    ("index and temperature", config("1.333", "1.333\nwater_temperature_c = 20.0"), CHECK, USAGE,
     ["flume.toml:9", "refractive_index", "temperature", "both"]),
    ("a grid without its size", config('first_square = "dark"', "rows = 11"), CHECK, USAGE,
     ["flume.toml", "'pattern.columns' is missing", "'pattern.square_mm' is missing"]),
    ("region without area", config("min_distance_px = 8", "region_px = [300, 0, 200, 100]"), CHECK, USAGE,
     ["flume.toml:16", "'detector.region_px'", "u0 < u1"]),
    ("region outside the image", config("min_distance_px = 8", "region_px = [0, 0, 641, 320]"), CHECK, USAGE,
     ["flume.toml", "'detector.region_px'", "640 x 320", "641"]),
    ("priority beyond the system's", config("[80.0]", "[80.0]\n[realtime]\nprocess_priority = 100"), CHECK, USAGE,
     ["flume.toml:16", "'realtime.process_priority'", "from 0 to 99", "100"]),
    ("recording without a folder's name", config("[80.0]", '[80.0]\n[record]\nfolder = ""'), CHECK, USAGE,
     ["flume.toml:16", "'record.folder'", "a folder"]),
    ("recording with a queue of none", config("[80.0]", "[80.0]\n[record]\nqueue_frames = 0"), CHECK, USAGE,
     ["flume.toml:16", "'record.queue_frames'", "from 2"]),
    ("half a CPU", config("[80.0]", "[80.0]\n[realtime]\ncapture_cpus = [0.5]"), CHECK, USAGE,
     ["flume.toml:16", "'realtime.capture_cpus'", "whole numbers"]),
    ("unknown key of the real-time start-up", config("[80.0]", "[80.0]\n[realtime]\npriority = 50"), CHECK, USAGE,
     ["flume.toml:16", "unknown key 'realtime.priority'", "process_priority"]),
    ("strobe without a line", lambda b: b.node(text=NODE + '[strobe]\nmode = "follow"\n'), CHECK, USAGE,
     ["flume.toml:", "'strobe.line' is missing", "number or a name"]),
    ("strobe without a known exposure", lambda b: b.node(text=NODE + '[strobe]\nmode = "follow"\nline = 17\n'), CHECK, USAGE,
     ["flume.toml:", "'strobe.mode'", "camera.exposure_us", "none"]),
    ("strobe beyond what the LEDs bear",
     lambda b: b.node(text=NODE + '[strobe]\nmode = "follow"\nline = "LED"\npulse_us = 1500\nmax_pulse_us = 1000\nmax_duty = 0.05\n'),
     CHECK, USAGE, ["'strobe.pulse_us'", "max_pulse_us, 1000 us", "found 1500 us", "max_duty, 0.0500", "a duty of 0.0750"]),
    ("strobe in an exposure that is too short for a rolling shutter",
     lambda b: b.node(text=NODE.replace("[pattern]", 'exposure_us = 6000\nshutter = "rolling"\nreadout_us = 5500\n[pattern]') +
                      '[strobe]\nmode = "follow"\nline = 17\n'), CHECK, USAGE,
     ["'strobe.pulse_us'", "5500 + 500 + 200 = 6200 us", "all rows of a rolling shutter", "found 6000 us"]),
    ("strobe with letters that no pattern has", lambda b: b.node(text=NODE + '[strobe]\npattern = "LUX"\n'), CHECK, USAGE,
     ["'strobe.pattern'", "L (lit) and D (dark)", '"LUX"']),
    ("trigger for a camera that has no input",
     lambda b: b.node(text=NODE + '[strobe]\nmode = "trigger"\ntrigger_line = 4\n'), CHECK, USAGE,
     ["'strobe.mode'", "camera.trigger_input = true"]),
    ("no camera", config('source = "recording:rec"', ""), CHECK, USAGE, ["flume.toml", "no camera", "camera.source"]),
    ("unknown kind of camera in the file", config("recording:rec", "webcam:0"), CHECK, USAGE,
     ["flume.toml:4", "'camera.source'", "recording:FOLDER", "webcam:0"]),
]

def live(text, geometry=True):
    """A live camera instead of the recording, with the recording's calibration, pose and points."""
    rig = '[geometry]\ncalibration = "rec/calibration.yml"\npose = "rec/pose.yml"\npoints = "rec/points.txt"\n'
    return lambda b: b.node(text=NODE.replace('source = "recording:rec"', text) + (rig if geometry else ""))


V4L2 = 'source = "v4l2:/dev/no-such-camera"'

CAMERA = [
    ("v4l2 without a path", config("recording:rec", "v4l2:video0"), CHECK, USAGE,
     ["flume.toml:4", "'camera.source'", "v4l2:/dev/videoN", "v4l2:video0"]),
    ("libcamera with an empty id", config("recording:rec", "libcamera:"), CHECK, USAGE,
     ["flume.toml:4", "'camera.source'", "libcamera:ID", "--list-cameras"]),
    ("unknown pixel format", live(V4L2 + '\nformat = "RGB3"'), CHECK, USAGE,
     ["flume.toml:5", "'camera.format'", "GREY", '"RGB3"']),
    ("samples of 7 bits", live(V4L2 + "\nbits = 7"), CHECK, USAGE, ["flume.toml:5", "'camera.bits'", "from 8 to 16"]),
    ("exposure of a minute", live(V4L2 + "\nexposure_us = 60000000"), CHECK, USAGE,
     ["flume.toml:5", "'camera.exposure_us'", "from 1 to 1e+06", "us"]),
    ("exposure longer than a frame", live(V4L2 + "\nframe_rate_hz = 50\nexposure_us = 25000"), CHECK, USAGE,
     ["flume.toml:6", "'camera.exposure_us'", "20000 us at 50 Hz", "25000"]),
    ("one buffer", live(V4L2 + "\nbuffers = 1"), CHECK, USAGE, ["flume.toml:5", "'camera.buffers'", "from 3 to 32"]),
    ("gain below nothing", live(V4L2 + "\ngain = -1.0"), CHECK, USAGE, ["flume.toml:5", "'camera.gain'", "found -1"]),
    ("rolling shutter without its readout", live(V4L2 + '\nshutter = "rolling"'), CHECK, USAGE,
     ["flume.toml", "'camera.readout_us' is missing", "rolling"]),
    ("unknown shutter", live(V4L2 + '\nshutter = "leaf"'), CHECK, USAGE, ["flume.toml:5", "'camera.shutter'", "rolling", "leaf"]),
    ("unknown stamp", live(V4L2 + '\nstamp = "middle"'), CHECK, USAGE,
     ["flume.toml:5", "'camera.stamp'", "frame-start", "exposure-start", "middle"]),
    ("trigger input with a word", live(V4L2 + '\ntrigger_input = "yes"'), CHECK, USAGE,
     ["flume.toml:5", "'camera.trigger_input'", "true or false"]),
    ("live camera of another size than the calibration", live(V4L2 + "\nwidth_px = 1280\nheight_px = 720"), CHECK, USAGE,
     ["flume.toml", "camera.width_px", "640 x 320", "1280 x 720", "calibrate"]),
    ("live camera without a calibration", live(V4L2, geometry=False), CHECK, USAGE,
     ["flume.toml", "no calibration", "geometry.calibration", "live camera"]),
    ("live camera that is not there", live(V4L2), RUN, DEVICE,
     ["/dev/no-such-camera", "no such camera", "a video capture device", "--list-cameras"]),
    ("live camera that is no video device", live('source = "v4l2:/dev/null"'), RUN, DEVICE,
     ["/dev/null", "not a video device", "--list-cameras"]),
    ("v4l2 on the command line without a path", config(None, None), (*RUN, "--camera", "v4l2:0"), USAGE,
     ["--camera", "v4l2:/dev/videoN", '"v4l2:0"']),
    ("libcamera without a camera", live('source = "libcamera:nobody"'), RUN, DEVICE, ["libcamera:nobody", "expected"]),
]

RIG = [
    ("calibration missing", without("rec/calibration.yml"), CHECK, USAGE,
     ["flume.toml", "no calibration", "calibration.yml", "expected"]),
    ("pose missing", without("rec/pose.yml"), CHECK, USAGE, ["flume.toml", "no pose", "pose.yml", "expected"]),
    ("points missing", without("rec/points.txt"), CHECK, USAGE, ["flume.toml", "no points", "points.txt", "expected"]),
    ("named calibration missing", lambda b: b.node(text=NODE + '[geometry]\ncalibration = "lens.yml"\n'), CHECK, INPUT,
     ["lens.yml", "no such file", "expected"]),
    ("calibration with another key", spoilt("rec/calibration.yml", "camera_matrix", "cameramatrix"), CHECK, INPUT,
     ["calibration.yml", "'camera_matrix'", "no such key"]),
    ("calibration matrix of another size", spoilt("rec/calibration.yml", "rows: 3", "rows: 2"), CHECK, INPUT,
     ["calibration.yml", "'camera_matrix'", "3 x 3", "2 x 3 with 9 numbers"]),
    ("not a number in the calibration", spoilt("rec/calibration.yml", "data: [ 1075.", "data: [ .Nan"), CHECK, INPUT,
     ["calibration.yml", "'camera_matrix'", "not a finite number"]),
    ("distortion of six numbers",
     spoilt("rec/calibration.yml", "rows: 5\n   cols: 1\n   dt: d\n   data: [", "rows: 6\n   cols: 1\n   dt: d\n   data: [ 0.,"),
     CHECK, INPUT, ["calibration.yml", "'distortion_coefficients'", "4, 5, 8, 12 or 14 numbers", "6 x 1"]),
    ("calibration without the image's size", spoilt("rec/calibration.yml", "image_width: 640\n", ""), CHECK, INPUT,
     ["image_width", "expected", "found"]),
    ("calibration is text", written("rec/calibration.yml", "f = 1075\n"), CHECK, INPUT,
     ["calibration.yml", "camera calibration", "FileStorage"]),
    ("calibration is empty", written("rec/calibration.yml", ""), CHECK, INPUT, ["calibration.yml", "expected"]),
    ("pose is not a rotation", spoilt("rec/pose.yml", IDENTITY, "1.5"), CHECK, INPUT,
     ["pose.yml", "'Rotationmatrix'", "orthonormal", "found"]),
    ("points not on a board", written("rec/points.txt", CROOKED), CHECK, INPUT, ["no checkerboard", "square", "points"]),
    ("points in one line", written("rec/points.txt", LINE), CHECK, INPUT, ["points"]),
    ("points with two columns", written("rec/points.txt", "0 0 0\n0 20\n"), CHECK, INPUT,
     ["points.txt:2", "x y z", "'0 20'"]),
    ("text among the points", written("rec/points.txt", "0 0 0\n0 twenty 0\n"), CHECK, INPUT,
     ["points.txt:2", "x y z", "'0 twenty 0'"]),
    ("not a number among the points", written("rec/points.txt", "0 0 0\n0 nan 0\n"), CHECK, INPUT,
     ["points.txt:2", "'0 nan 0'"]),
    ("a point twice", written("rec/points.txt", "0 0 0\n0 20 0\n0 0 0\n"), CHECK, INPUT,
     ["points.txt:3", "repeats a point", "line 1"]),
    ("no points in the file", written("rec/points.txt", ""), CHECK, INPUT, ["points.txt", "holds no points", "x y z"]),
]

RECORDING = [
    ("recording folder missing", config("recording:rec", "recording:nowhere"), CHECK, INPUT, ["nowhere"]),
    ("recording folder missing, with a rig",
     lambda b: b.node(text=NODE.replace("recording:rec", "recording:nowhere") + '[geometry]\ncalibration = '
                      '"rec/calibration.yml"\npose = "rec/pose.yml"\npoints = "rec/points.txt"\n'),
     RUN, INPUT, ["nowhere", "no such folder"]),
    ("recording folder empty",
     lambda b: (b.node(text=NODE.replace("recording:rec", "recording:empty") + '[geometry]\ncalibration = '
                       '"rec/calibration.yml"\npose = "rec/pose.yml"\npoints = "rec/points.txt"\n'),
                b.path("empty").mkdir()),
     RUN, INPUT, ["empty", "neither frames.csv nor images"]),
    ("images without a pattern", blank_images, RUN, INPUT,
     ["nothing was measured", "recording:rec", "3 searching", "little contrast", "--doctor"]),
    ("only unreadable images", only_unreadable_images, RUN, INPUT, ["frame_000000.png", "no image of this recording"]),
    ("listing with another header", spoilt("rec/frames.csv", "file,sequence", "name,sequence"), RUN, INPUT,
     ["frames.csv:1", "header", "file,sequence,time_ns,exposure_us,strobe"]),
    ("listing with text in a number", spoilt("rec/frames.csv", ",1,20000000,", ",one,20000000,"), RUN, INPUT,
     ["frames.csv:3", "is not a frame", "one,20000000"]),
    ("listing leaves the folder", spoilt("rec/frames.csv", "frame_000001.png", "../secret.png"), RUN, INPUT,
     ["frames.csv:3", "file inside the folder", "../secret.png"]),
    ("image of another size than the calibration", spoilt("rec/calibration.yml", "image_width: 640", "image_width: 656"),
     RUN, INPUT, ["another size", "656 x 320", "640 x 320"]),
]

COMMAND_LINE = [
    ("unknown option", config(None, None), (*RUN, "--configuration", "x"), USAGE, ["--configuration"]),
    ("no frames", config(None, None), (*RUN, "--frames", "0"), USAGE, ["--frames", "0"]),
    ("negative frames", config(None, None), (*RUN, "--frames", "-4"), USAGE, ["--frames", "-4"]),
    ("text for frames", config(None, None), (*RUN, "--frames", "ten"), USAGE, ["--frames", "ten"]),
    ("unknown rate", config(None, None), (*RUN, "--rate", "slow"), USAGE, ["--rate", "slow", "camera", "max"]),
    ("unknown kind of camera", config(None, None), (*RUN, "--camera", "webcam:0"), USAGE,
     ["--camera", "recording:FOLDER", '"webcam:0"']),
    ("recording without a folder", config(None, None), (*RUN, "--camera", "recording:"), USAGE,
     ["--camera", "recording:FOLDER", '"recording:"']),
    ("simulator with a word for a seed", config(None, None), (*RUN, "--camera", "simulator:x"), USAGE,
     ["--camera", "simulator:SEED", '"simulator:x"']),
    ("host without a port", config(None, None), (*RUN, "--host", "127.0.0.1"), USAGE,
     ["--host", "no port", "HOST:PORT", "'127.0.0.1'"]),
    ("host with a port too large", config(None, None), (*RUN, "--host", "127.0.0.1:70000"), USAGE,
     ["--host", "'70000' is not a port", "1..65535"]),
    ("host with port 0", config(None, None), (*RUN, "--host", "127.0.0.1:0"), USAGE, ["--host", "port", "1..65535"]),
    # Two dots in a row are no name: this needs no network to be refused.
    ("host that has no address", config(None, None), (*RUN, "--host", "flume..invalid:47810"), NETWORK,
     ["--host", "cannot resolve 'flume..invalid'"]),
    ("host that has no address, of a live camera that starts without it",
     lambda b: live(V4L2)(b) or b.spoil("flume.toml", 'id = "bench"', 'id = "bench"\nhost = "flume..invalid:47810"'),
     RUN, DEVICE, ["/dev/no-such-camera", "no such camera"]),
    ("bad host in the file", config('id = "bench"', 'id = "bench"\nhost = "127.0.0.1"'), CHECK, USAGE,
     ["flume.toml", "no port", "HOST:PORT"]),
    ("nobody listens", config(None, None), (*RUN, "--frames", "2", "--host", "127.0.0.1:{taken_port}"), NETWORK,
     ["127.0.0.1:", "not acknowledged", "srd listen"]),
    ("recording where one is", config(None, None), (*RUN, "--record", "rec"), USAGE, ["rec", "recorded over itself"]),
    ("recording over what is replayed", config(None, None), (*RUN, "--record", "./rec", "--force"), USAGE,
     ["rec", "recorded over itself"]),
    ("recording over another",
     lambda b: (b.node(), b.write("old/frames.csv", "file,sequence,time_ns,exposure_us,strobe\n")),
     (*RUN, "--record", "old"), USAGE, ["old/frames.csv", "a recording is there already", "--force"]),
    ("recording into a file", config(None, None), (*RUN, "--record", "flume.toml"), INPUT, ["flume.toml", "cannot be made"]),
    ("recording on a disk that is too full",
     config("[80.0]", '[80.0]\n[record]\nmin_free_mib = 1000000000'), (*RUN, "--record", "new"), INPUT,
     ["new", "too little room", "1000000000 MiB", "record.min_free_mib"]),
    ("state in a file", config(None, None), (*RUN, "--state", "flume.toml"), INPUT,
     ["flume.toml/last_end", "cannot keep how the node ended", "--state"]),
    ("lines to switch off that are not there",
     lambda b: b.node(text=NODE.replace('[camera]', '[camera]\nexposure_us = 2000') +
                      '[strobe]\nmode = "follow"\nchip = "no-such-chip"\nline = "LED"\n'),
     ("srd-node", "--config", "flume.toml", "--strobe-low"), DEVICE, ["no-such-chip", "GPIO chip"]),
    ("truth of a recording", config(None, None), (*RUN, "--truth", "t.csv"), USAGE, ["--truth", "simulator", "recording"]),
    ("truth in a folder that is not there", config(None, None),
     (*RUN, "--camera", "simulator", "--frames", "1", "--truth", "nowhere/t.csv"), INPUT,
     ["nowhere/t.csv", "cannot be written"]),
]

CASES = CONFIGURATION + CAMERA + RIG + RECORDING + COMMAND_LINE
