# SPDX-License-Identifier: Apache-2.0
"""What can be wrong in what a person gives to srd: name, builder, arguments, exit code, words of the message."""

from bench import COEFFICIENTS, DATA, SCENE, TRUTH

USAGE, INPUT, NETWORK = 2, 3, 5
SIMULATE = ("srd", "simulate", "scene.toml", "--out", "new")
SETTINGS = ("srd", "reconstruct", "settings.xml", "--out", "new")
RECORDING = ("srd", "reconstruct", "rec", "--out", "new", "--lx", "240", "--ly", "440", "--guess", "80")
LISTEN = ("srd", "listen", "--for", "1", "--bind", "127.0.0.1:0")
PLOT = ("srd", "plot", "run.csv", "--out", "new")
CALIBRATE = ("srd", "calibrate", "view.png", "--out", "new", "--board", "21x11", "--square-mm", "20")
CALIBRATE_SETTINGS = ("srd", "calibrate", "settings.xml", "--out", "new")
COMPARE = ("srd", "compare", "run.csv", "truth.csv")
OF_REC = ("--calibration", "rec/calibration.yml", "--pattern", "rec/points.txt")
POSE = ("srd", "pose", "rec/reference.png", *OF_REC, "--out", "new", "--position", "1")
RIG_CHECK = ("srd", "rig-check", "rec/reference.png", "rec/reference.png", *OF_REC, "--position", "1")


def scene(more, old=None, new=None):
    def build(bench):
        bench.write("scene.toml", SCENE + more)
        if old is not None:
            bench.spoil("scene.toml", old, new)
    return build


def settings(leave_out=(), **changed):
    return lambda bench: bench.settings(leave_out, **changed)


def recording(bench):
    bench.recording()


def spoilt(make, name, old, new):
    def build(bench):
        make(bench)
        bench.spoil(name, old, new)
    return build


def written(make, name, contents):
    def build(bench):
        make(bench)
        bench.write(name, contents)
    return build


def tables(bench):
    bench.tables()


def exists(name, contents):
    return lambda bench: bench.write(name, contents)


def folder_without_images(bench):
    bench.settings()
    bench.remove("frames/0.png", "frames/1.png")


def pose_from_image(**changed):
    return settings(**{"TypeCameraPose": "1", "InputReference1": '"reference.png"', "InputInitial1": '"rec/points.txt"',
                       "RefPatternSize_Width": "11", "RefPatternSize_Height": "21", **changed})


def blank_reference(bench):
    pose_from_image(InputReference1='"blank.pgm"')(bench)
    bench.blank_image("blank.pgm")


def small_reference(bench):
    pose_from_image(InputReference1='"blank.pgm"')(bench)
    bench.blank_image("blank.pgm", 64, 64)


def unreadable_reference(bench):
    pose_from_image(InputReference1='"broken.png"')(bench)
    bench.write("broken.png", "no image")


def points_in_one_line(bench):
    pose_from_image(InputReference1='"rec/reference.png"', InputInitial1='"line.txt"')(bench)
    bench.write("line.txt", "".join(f"{20 * i} 0 0\n" for i in range(231)))


def no_image_is_readable(bench):
    bench.settings()
    for frame in range(2):
        bench.write(f"frames/{frame}.png", "no image")


def of_2017(bench):
    bench.settings(gridSize="10", min_u="0", max_u="75", min_v="0", max_v="53", minThreshold="90", maxThreshold="140",
                   OutputFileCenters='"centres.txt"')


SIMULATING = [
    ("scene missing", lambda b: None, SIMULATE, USAGE, ["scene.toml", "no such file"]),
    ("scene is not TOML", scene("[surface\n"), SIMULATE, USAGE, ["scene.toml:10"]),
    ("scene with an unknown key", scene("", "fx =", "focal ="), SIMULATE, USAGE,
     ["scene.toml:6", "unknown key 'camera.focal'", "fx"]),
    ("scene with text for a number", scene("", "640", '"640"'), SIMULATE, USAGE, ["scene.toml:4", "'camera.width'", "expected"]),
    ("scene without an image", scene("", "height = 320", "height = 0"), SIMULATE, USAGE,
     ["scene.toml:5", "'camera.height'", "expected", "found 0"]),
    ("scene with a mode that does not exist", scene('[[surface.mode]]\nname = "Q1"\n'), SIMULATE, USAGE,
     ["scene.toml:11", "name", "A00, B, C", '"Q1"']),
    ("scene with water below the pattern", scene('[[surface.mode]]\nname = "A00"\nmean_mm = -5.0\n'), SIMULATE, USAGE,
     ["scene.toml", "above the pattern"]),
    ("scene with a rotation that is none",
     scene("[pose]\nrotation = [1, 0, 0, 0, 1, 0, 0, 0, 0.5]\ntranslation_mm = [0, 0, 900]\n"), SIMULATE, USAGE,
     ["scene.toml:11", "rotation", "orthonormal"]),
    ("no output folder", scene(""), ("srd", "simulate", "scene.toml"), USAGE, ["--out"]),
    ("recording is there already", lambda b: (scene("")(b), b.write("new/truth.csv", "mine")), SIMULATE, USAGE,
     ["new/truth.csv", "is there already", "--force"]),
    ("output is a file", lambda b: (scene("")(b), b.write("new", "mine")), SIMULATE, INPUT, ["new", "expected"]),
    ("no frames to simulate", scene(""), (*SIMULATE, "--frames", "0"), USAGE, ["--frames", "0"]),
]

RECONSTRUCTING = [
    ("settings missing", lambda b: None, SETTINGS, INPUT, ["settings.xml", "no such file"]),
    ("settings not XML", exists("settings.xml", "Lx = 240\n"), SETTINGS, USAGE, ["settings.xml", "not an OpenSRD settings file"]),
    ("settings cut short", exists("settings.xml", "<?xml version=\"1.0\"?>\n<opencv_storage>\n<Settings>\n<Lx>2"), SETTINGS,
     USAGE, ["settings.xml", "not an OpenSRD settings file", "found"]),
    ("settings of a calibration", settings(["OutputFileName"], Write_outputFileName='"c.yml"'), SETTINGS, USAGE,
     ["settings.xml", "calibration", "Write_outputFileName"]),
    ("settings without a key", settings(["Lx"]), SETTINGS, USAGE, ["settings.xml", "'Lx' is missing", "expected"]),
    ("settings without several keys", settings(["Lx", "InitialGuess", "OutputFileName"]), SETTINGS, USAGE,
     ["3 problems", "'Lx' is missing", "'InitialGuess' is missing", "'OutputFileName' is missing"]),
    ("settings with text for a number", settings(Ly="wide"), SETTINGS, USAGE, ["settings.xml:10", "'Ly'", "a number", "'wide'"]),
    ("settings with four cameras", settings(NumberOfCameras="4"), SETTINGS, USAGE,
     ["settings.xml:4", "'NumberOfCameras'", "'4'"]),
    ("settings with parameters that no model has", settings(SurfaceModelParameters="4"), SETTINGS, USAGE,
     ["settings.xml:11", "'SurfaceModelParameters'", "1, 3, 5, 8 or 12", "'4'"]),
    ("settings with a guess too long", settings(InitialGuess='"[80,0,0,0,0,0]"'), SETTINGS, USAGE,
     ["settings.xml:12", "'InitialGuess'", "at most 5", "6 numbers"]),
    ("settings with words in the guess", settings(InitialGuess='"[deep]"'), SETTINGS, USAGE,
     ["settings.xml:12", "'InitialGuess'", "list of numbers", "[deep]"]),
    ("settings with not a number in the guess", settings(InitialGuess='"[nan,0,0,0,0]"'), SETTINGS, USAGE,
     ["settings.xml:12", "'InitialGuess'", "nan"]),
    ("settings with an unknown metric", settings(ErrorMetric="3"), SETTINGS, USAGE, ["settings.xml:14", "'ErrorMetric'", "'3'"]),
    ("settings of 2017", of_2017, SETTINGS, USAGE, ["settings.xml", "pattern metric", "TypeCameraPose 1"]),
    ("wrong number of points", settings(FeaturePatternSize_Width="12"), SETTINGS, INPUT,
     ["points.txt", "252", "12 rows of 21", "231"]),
    ("calibration missing", settings(CalibrationFile1='"lens.yml"'), SETTINGS, INPUT, ["lens.yml", "no such file"]),
    ("image folder missing", settings(InputDirectory1='"nowhere"'), SETTINGS, INPUT, ["nowhere", "no such folder"]),
    ("image folder without images", folder_without_images, SETTINGS, INPUT, ["frames", "holds no frames", "images"]),
    ("unreadable images", no_image_is_readable, SETTINGS, INPUT, ["frames/0.png", "expected"]),
    ("no board in the reference image", blank_reference, SETTINGS, INPUT, ["blank.pgm", "shows no board", "11", "21", "found"]),
    ("reference image of another size", small_reference, SETTINGS, INPUT, ["blank.pgm", "640 x 320", "64 x 64"]),
    ("reference image unreadable", unreadable_reference, SETTINGS, INPUT, ["broken.png", "expected"]),
    ("points in one line", points_in_one_line, SETTINGS, INPUT, ["cannot give a pose", "in one line"]),
    ("settings with a recording's options", settings(), (*SETTINGS, "--guess", "80"), USAGE, ["--guess", "settings.xml"]),
    ("results are there already", lambda b: (b.settings(), b.write("new/coefficients.txt", "mine")), SETTINGS, USAGE,
     ["new/coefficients.txt", "is there already", "--force"]),
    ("recording without its lengths", recording, RECORDING[:5] + ("--guess", "80"), USAGE, ["--lx and --ly are missing"]),
    ("recording without a guess", recording, RECORDING[:-2], USAGE, ["--guess", "1 to 5 numbers"]),
    ("recording with an unknown mode", recording, (*RECORDING, "--modes", "A00,Q1"), USAGE, ["--modes", "A00,Q1", "expected"]),
    ("not a number for a length", recording, (*RECORDING[:5], "--lx", "nan", *RECORDING[7:]), USAGE, ["--lx", "nan"]),
    ("recording with a damaged pose", spoilt(recording, "rec/pose.yml", "1.9758591461345072e-02", "1.5"), RECORDING, INPUT,
     ["pose.yml", "'Rotationmatrix'", "orthonormal"]),
    ("recording with its points in one line",
     written(recording, "rec/points.txt", "".join(f"{20 * i} 0 0\n" for i in range(20))), RECORDING, INPUT, ["points"]),
    ("recording with points not on a board", written(recording, "rec/points.txt", "0 0 0\n20 0 0\n0 20 0\n28 23 0\n"),
     RECORDING, INPUT, ["points.txt", "checkerboard", "square"]),
]

def key(name, mode, digits="0" * 64):
    def build(bench):
        bench.write(name, f"flume-srd-key-1 cam-1 {digits}\n")
        bench.path(name).chmod(mode)
    return build


LISTENING = [
    ("address without a port", lambda b: None, ("srd", "listen", "--for", "1", "--bind", "localhost"), USAGE,
     ["--bind", "no port", "'localhost'"]),
    ("address of another computer", lambda b: None, ("srd", "listen", "--for", "1", "--bind", "192.0.2.1:47810"), NETWORK,
     ["192.0.2.1:47810", "address of this computer"]),
    ("port is taken", lambda b: None, ("srd", "listen", "--for", "1", "--bind", "127.0.0.1:{taken_port}"), NETWORK,
     ["127.0.0.1:", "another port"]),
    ("record is there already", exists("run.csv", COEFFICIENTS), (*LISTEN, "--csv", "run.csv"), USAGE,
     ["run.csv", "--append", "--force"]),
    ("append to a file of another kind", exists("run.csv", TRUTH), (*LISTEN, "--csv", "run.csv", "--append"), INPUT,
     ["run.csv:1", "not a record of srd listen", "node,boot,sequence"]),
    ("append to a damaged record", exists("run.csv", COEFFICIENTS.replace("07,1,", "07,x,")),
     (*LISTEN, "--csv", "run.csv", "--append"), INPUT, ["run.csv:3", "node,boot,sequence", "07,x"]),
    ("append and force", exists("run.csv", COEFFICIENTS), (*LISTEN, "--csv", "run.csv", "--append", "--force"), USAGE,
     ["--append", "--force"]),
    ("record in a folder that is not there", lambda b: None, (*LISTEN, "--csv", "nowhere/run.csv"), 4, ["nowhere/run.csv"]),
    ("keys in a folder that is not there", lambda b: None, (*LISTEN, "--keys", "keys"), USAGE, ["keys", "srd keygen NODE"]),
    ("a key that others can read", key("keys/cam-1.key", 0o644), (*LISTEN, "--keys", "keys"), USAGE,
     ["keys/cam-1.key", "mode 644", "chmod 600 keys/cam-1.key"]),
    ("a key with a slip", key("keys/cam-1.key", 0o600, "0" * 63 + "x"), (*LISTEN, "--keys", "keys"), USAGE,
     ["keys/cam-1.key:1", "not a key file", "srd keygen"]),
    ("a node that has a key", key("keys/cam-1.key", 0o600), ("srd", "keygen", "cam-1", "--out", "keys"), USAGE,
     ["keys/cam-1.key", "has a key already", "--change"]),
    ("change of a key that is not there", lambda b: None, ("srd", "keygen", "cam-1", "--out", "keys", "--change"), USAGE,
     ["keys/cam-1.key", "No such file", "srd keygen"]),
    ("a key for no node", lambda b: None, ("srd", "keygen", "cam 1", "--out", "keys"), USAGE, ["1 to 31", "'cam 1'"]),
    ("change and end of it", lambda b: None, ("srd", "keygen", "cam-1", "--out", "keys", "--change", "--end-change"), USAGE,
     ["--change"]),
    ("file of boards is missing", lambda b: None, (*LISTEN, "--boards", "no-boards.toml"), USAGE, ["no-boards.toml"]),
    ("one board is no fusion", exists("one.toml", '[[board]]\nnode = "a"\n'),
     (*LISTEN, "--boards", "one.toml"), USAGE, ["one.toml", "at least two boards of one surface"]),
    ("record with a segment that is none", exists("rec/000001.mcap", COEFFICIENTS), (*LISTEN, "--record", "rec"), INPUT,
     ["rec/000001.mcap", "MCAP"]),
    ("record where a file is", exists("rec", COEFFICIENTS), (*LISTEN, "--record", "rec"), 4, ["rec", "cannot make the record"]),
    ("no seconds", lambda b: None, ("srd", "listen", "--for", "0"), USAGE, ["--for", "0"]),
]


def of_table(command, verb):
    return [
        (f"{verb} a missing file", lambda b: b.write("truth.csv", TRUTH), command, INPUT, ["run.csv", "cannot read"]),
        (f"{verb} an empty file", written(tables, "run.csv", ""), command, INPUT, ["run.csv", "header"]),
        (f"{verb} a header alone", written(tables, "run.csv", COEFFICIENTS.splitlines()[0] + "\n"), command, INPUT,
         ["run.csv", "no frames", "expected"]),
        (f"{verb} without a column", spoilt(tables, "run.csv", ",clock,", ",clck,"), command, INPUT,
         ["run.csv:1", "no column 'clock'", "expected"]),
        (f"{verb} text in a number", spoilt(tables, "run.csv", ",80.5,", ",deep,"), command, INPUT,
         ["run.csv:3", "'A00'", "a finite number", "'deep'"]),
        (f"{verb} a short row", spoilt(tables, "run.csv", "80.5,1,0.01,0.01", "80.5,1"), command, INPUT,
         ["run.csv:3", "21 cells", "found: 19"]),
        (f"{verb} a node that is not there", tables, (*command, "--node", "other"), USAGE, ["run.csv", "'other'", "bench"]),
    ]


TABLES = of_table(PLOT, "plot") + of_table(COMPARE, "compare") + [
    ("plot a frame that is not there", tables, (*PLOT, "--frame", "99"), USAGE, ["run.csv", "no such frame", "99"]),
    ("plot with a damaged truth", spoilt(tables, "truth.csv", ",80.5,", ",deep,"), (*PLOT, "--truth", "truth.csv"), INPUT,
     ["truth.csv:3", "deep"]),
    ("compare without the truth", exists("run.csv", COEFFICIENTS), COMPARE, INPUT, ["truth.csv", "no such file"]),
    ("compare with an empty truth", written(tables, "truth.csv", ""), COMPARE, INPUT, ["truth.csv:1", "frame,time_ns"]),
    ("compare with a truth of another kind", written(tables, "truth.csv", COEFFICIENTS), COMPARE, INPUT,
     ["truth.csv:1", "header", "frame,time_ns"]),
    ("compare with text in the truth", spoilt(tables, "truth.csv", ",80.5,", ",deep,"), COMPARE, INPUT,
     ["truth.csv:3", "expected", "deep"]),
    ("compare with a truth of other times", written(tables, "truth.csv", TRUTH.replace("0,0,", "0,5,").replace(",20000000,", ",7,")),
     COMPARE, INPUT, ["truth.csv", "time"]),
    ("no such loss", recording, (*RECORDING, "--loss", "cauchy"), USAGE, ["--loss", "'cauchy' is none of none, huber, tukey"]),
    ("no such metric", recording, (*RECORDING, "--metric", "px"), USAGE,
     ["--metric", "'px' is none of reprojection, disparity, collinearity"]),
    ("compare beyond a limit without a model", tables, (*COMPARE, "--max-rms", "1"), USAGE, ["--max-rms", "--model"]),
    ("study: no folder to write to", lambda b: None, ("srd", "study", "--quick"), USAGE, ["--out DIR"]),
    ("study: a table is there", lambda b: b.write("out/corners.csv", "mine"), ("srd", "study", "--quick", "--out", "out"),
     USAGE, ["corners.csv", "--force"]),
    ("study: a file in the folder's place", lambda b: b.write("out", "mine"), ("srd", "study", "--quick", "--out", "out"),
     INPUT, ["out", "folder"]),
    ("no subcommand", lambda b: None, ("srd",), USAGE, ["subcommand"]),
    ("unknown subcommand", lambda b: None, ("srd", "measure"), USAGE, ["measure"]),
]

VIEW = (DATA / "flume-small" / "reference.png").read_bytes()


def view(bench):
    bench.write("view.png", VIEW)


def calibration_settings(leave_out=(), **changed):
    keys = {"BoardSize_Width": "11", "BoardSize_Height": "21", "Square_Size": "20", "nframes": "20",
            "Write_outputFileName": '"lens.yml"', "InputDirectory": '"views"', **changed}

    def build(bench):
        bench.write("views/1.png", VIEW)
        lines = ['<?xml version="1.0"?>', "<opencv_storage>", "<Settings>"]
        lines += [f"<{key}>{value}</{key}>" for key, value in keys.items() if key not in leave_out]
        bench.write("settings.xml", "\n".join(lines + ["</Settings>", "</opencv_storage>", ""]))
    return build


def calibrate(*, board="21x11", square="20", sources=("view.png",), more=()):
    words = ["srd", "calibrate", *sources, "--out", "new", *more]
    words += ["--board", board] if board else []
    return tuple(words + (["--square-mm", square] if square else []))


CALIBRATING = [
    ("image missing", lambda b: None, CALIBRATE, INPUT, ["view.png", "no such file or folder"]),
    ("folder without images", exists("pictures/notes.txt", "none"), calibrate(sources=["pictures"]), INPUT,
     ["pictures", "holds no image"]),
    ("no image but text", exists("view.png", "no image"), CALIBRATE, INPUT, ["view.png", "is not a readable image"]),
    ("image without a board", lambda b: b.blank_image("view.png"), CALIBRATE, INPUT,
     ["view.png", "shows no such board", "21 x 11", "0 corners"]),
    ("board larger than said", view, calibrate(board="15x9"), INPUT, ["view.png", "shows a larger board", "231 corners"]),
    ("board smaller than said", view, calibrate(board="31x21"), INPUT, ["no image shows the whole board", "21 x 11", "31 x 21"]),
    ("a single view", view, CALIBRATE, INPUT, ["too few views of the whole board", "at least 4", "tilted by 20 to 45 degrees"]),
    ("image twice", view, calibrate(sources=["view.png", "./view.png"]), USAGE, ["is given twice", "view.png"]),
    ("image alone and in its folder", exists("views/1.png", VIEW), calibrate(sources=["views", "views/1.png"]), USAGE,
     ["is given twice", "views/1.png"]),
    ("square missing", view, calibrate(square=None), USAGE, ["the side of a square is missing", "--square-mm"]),
    ("square of nothing", view, calibrate(square="0"), USAGE, ["--square-mm", "'0' is not a number above 0, mm"]),
    ("square that is no number", view, calibrate(square="nan"), USAGE, ["--square-mm", "'nan' is not a number above 0, mm"]),
    ("board missing", view, calibrate(board=None), USAGE, ["the board's size is missing", "--board"]),
    ("board without a cross", view, calibrate(board="21by11"), USAGE, ["is no size of a board", "'21by11'"]),
    ("board of one cell", view, calibrate(board="2x2"), USAGE, ["is no size of a board", "'2x2'", "from 4 to 200"]),
    ("coefficients of no model", view, calibrate(more=["--coefficients", "6"]), USAGE, ["'6' is none of 4, 5, 8, 12, 14"]),
    ("surface of no kind", view, calibrate(more=["--surface", "round"]), USAGE, ["'round' is none of flat, bent, free"]),
    ("radius of no kind", view, calibrate(more=["--radius", "7"]), USAGE, ["'7' is none of 5, 10"]),
    ("out is a file", lambda b: (view(b), b.write("new", "mine")), CALIBRATE, USAGE, ["new", "cannot be made"]),
    ("results there already", lambda b: (view(b), b.write("new/calibration.yml", "mine")), CALIBRATE, USAGE,
     ["new/calibration.yml", "is there already", "--force"]),
    ("settings that are no XML", exists("settings.xml", "board = 7"), CALIBRATE_SETTINGS, USAGE,
     ["settings.xml", "is not an OpenSRD settings file"]),
    ("settings of a reconstruction", settings(), CALIBRATE_SETTINGS, USAGE,
     ["are settings of a reconstruction", "srd reconstruct reads them"]),
    ("settings without a square", calibration_settings(["Square_Size"]), CALIBRATE_SETTINGS, USAGE,
     ["key 'Square_Size' is missing", "side of a square, mm"]),
    ("settings with a square of nothing", calibration_settings(Square_Size="0"), CALIBRATE_SETTINGS, USAGE,
     ["settings.xml:6", "'Square_Size'", "found: '0'"]),
    ("settings of a folder that is not there", calibration_settings(InputDirectory='"elsewhere"'), CALIBRATE_SETTINGS, INPUT,
     ["settings.xml:9", "no such folder", "elsewhere"]),
    ("settings and images together", lambda b: (calibration_settings()(b), view(b)),
     calibrate(sources=["settings.xml", "view.png"]), USAGE, ["a settings file stands alone"]),
    ("settings of a single view", calibration_settings(), CALIBRATE_SETTINGS, INPUT, ["too few views of the whole board"]),
]

def without(command, option):
    at = command.index(option)
    return command[:at] + command[at + 2:]


def with_images(**images):
    """A recording with blank images beside it: name=(width, height)."""
    def build(bench):
        recording(bench)
        for name, size in images.items():
            bench.blank_image(f"{name}.pgm", *size)
    return build


WHOLE = with_images(blank=(640, 320), small=(64, 64))
BY_SIZE = without(POSE, "--pattern")

POSING = [
    ("no calibration", recording, without(POSE, "--calibration"), USAGE, ["--calibration"]),
    ("no folder to write to", recording, without(POSE, "--out"), USAGE, ["--out"]),
    ("no pattern", recording, BY_SIZE, USAGE, ["no pattern", "--pattern", "--square-mm"]),
    ("a board without its squares", recording, (*BY_SIZE, "--board", "11x21"), USAGE, ["no pattern", "no --square-mm"]),
    ("a board that is no size", recording, (*BY_SIZE, "--board", "11by21", "--square-mm", "20"), USAGE,
     ["--board", "ROWSxCOLUMNS", "'11by21'"]),
    ("a board of one row", recording, (*BY_SIZE, "--board", "1x21", "--square-mm", "20"), USAGE, ["--board", "2 to 500", "'1x21'"]),
    ("not a number for a square", recording, (*BY_SIZE, "--board", "11x21", "--square-mm", "nan"), USAGE, ["--square-mm", "nan"]),
    ("points and the size of a square", recording, (*POSE, "--square-mm", "20"), USAGE, ["--square-mm", "exclude", "both"]),
    ("points of another board than the one named", recording, (*POSE, "--board", "12x21"), INPUT,
     ["rec/points.txt", "12 rows of 21", "11 rows of 21"]),
    ("points that are no board", written(recording, "rec/points.txt", "0 0 0\n20 0 0\n0 20 0\n"), POSE, INPUT,
     ["rec/points.txt", "row by row", "3 points"]),
    ("a fifth position", recording, (*POSE[:-1], "5"), USAGE, ["--position", "5"]),
    ("a position and a corner", recording, (*POSE, "--first-corner", "90,40"), USAGE, ["--first-corner", "--position", "both"]),
    ("a corner of one number", recording, (*POSE[:-2], "--first-corner", "90"), USAGE, ["--first-corner", "U,V", "'90'"]),
    ("a corner in the middle", recording, (*POSE[:-2], "--first-corner", "310,142"), INPUT,
     ["reference.png", "near two", "310.0,142.0"]),
    ("a board that looks alike from both ends", recording, POSE[:-2], INPUT,
     ["reference.png", "alike", "--first-corner", "--position"]),
    ("a position that the colours contradict", recording, (*POSE, "--origin-square", "bright"), INPUT,
     ["reference.png", "--position 1", "contradicts", "a dark one"]),
    ("a colour that is none", recording, (*POSE, "--origin-square", "red"), USAGE, ["--origin-square", "'red' is none of dark, bright, unknown"]),
    ("reference missing", recording, ("srd", "pose", "nowhere.png", *POSE[3:]), INPUT, ["nowhere.png", "no such file"]),
    ("reference without a board", WHOLE, ("srd", "pose", "blank.pgm", *POSE[3:]), INPUT, ["blank.pgm", "no board"]),
    ("reference of another size", WHOLE, ("srd", "pose", "small.pgm", *POSE[3:]), INPUT, ["small.pgm", "640 x 320", "64 x 64"]),
    ("folder without images", lambda b: (recording(b), b.write("empty/notes.txt", "none")),
     ("srd", "pose", "empty", *POSE[3:]), INPUT, ["empty", "no images"]),
    ("images of a moving pattern", recording, ("srd", "pose", "rec/reference.png", "rec/frame_000003.png", *POSE[3:]), INPUT,
     ["another place", "px from the mean"]),
    ("a level without its deviation", recording, (*POSE, "--water-level", "80"), USAGE, ["--water-level", "--level-deviation"]),
    ("a deviation without its level", recording, (*POSE, "--level-deviation", "0.1"), USAGE, ["--level-deviation", "--water-level"]),
    ("a level in the plates", recording, (*POSE, "--water-level", "8", "--level-deviation", "0.1", "--plate", "10,1.49"), USAGE,
     ["--water-level", "plates", "10 mm"]),
    ("one further view", recording, (*POSE, "--view", "rec/reference.png"), USAGE, ["--view", "at least 2"]),
    ("views through water", recording, (*POSE, "--water-level", "80", "--level-deviation", "0.1", "--view", "rec/reference.png"),
     USAGE, ["--view", "--water-level", "dry"]),
    ("a mode of the surface that does not exist", recording, (*POSE, "--modes", "A00,Q1"), USAGE, ["--modes", "A00,Q1"]),
    ("a depth above the camera", recording, (*POSE, "--depth", "2000"), INPUT, ["--depth 2000", "below the camera"]),
    ("pose is there already", lambda b: (recording(b), b.write("new/pose.yml", "mine")), POSE, USAGE,
     ["new/pose.yml", "is there already", "--force"]),
    ("later image missing", recording, (*RIG_CHECK[:3], "nowhere.png", *RIG_CHECK[4:]), INPUT, ["nowhere.png", "no such file"]),
    ("later image without a board", WHOLE, (*RIG_CHECK[:3], "blank.pgm", *RIG_CHECK[4:]), INPUT, ["blank.pgm", "no board"]),
    ("half of a level", recording, (*RIG_CHECK, "--later-level", "80"), USAGE, ["--later-level-deviation", "belong together"]),
    ("a false alarm rate of nothing", recording, (*RIG_CHECK, "--false-alarm", "0"), USAGE, ["--false-alarm", "0"]),
    ("report is there already", lambda b: (recording(b), b.write("rig.toml", "mine")), (*RIG_CHECK, "--report", "rig.toml"), USAGE,
     ["rig.toml", "is there already", "--force"]),
]

CASES = SIMULATING + CALIBRATING + RECONSTRUCTING + LISTENING + TABLES + POSING
