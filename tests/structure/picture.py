# SPDX-License-Identifier: Apache-2.0
"""The picture of a frame's way (firmware/frame_way.svg) against the sources. Gives a list of what does not hold.

A box names a class, or a file, of its folder. An arrow goes from one box to another, and one of their folders includes the other's.
A ring is an SpscRing member of its folder. Every ring and every thread that the node has is drawn.
"""
import functools
import pathlib
import re
import xml.etree.ElementTree as ElementTree

import rules

PICTURE = "firmware/frame_way.svg"
SVG = "{http://www.w3.org/2000/svg}"
RING = re.compile(r"SpscRing<[^;]*> (\w+_)(?:\{\w*\})?;")
ROLES = re.compile(r"case ThreadRole::\w+: return \"(\w+)\";")
OWN_THREAD = re.compile(r"^  std::thread thread_;", re.MULTILINE)
NEAR = 2  # px


def texts(group, kind):
    return [text.text for text in group.iter(f"{SVG}text") if kind in (text.get("class") or "").split()]


def of_class(picture, kind):
    return [element for element in picture.iter() if kind in (element.get("class") or "").split()]


def place(group):
    return tuple(float(number) for number in re.findall(r"[\d.]+", group.get("transform")))


def ends(path):
    """First and last point of a path of M, H, V and L with absolute coordinates."""
    x = y = 0.0
    points = []
    for letter, numbers in re.findall(r"([MHVL])([\d. ]+)", path):
        values = [float(number) for number in numbers.split()]
        x, y = (values[0] if letter != "V" else x), (values[-1] if letter != "H" else y)
        points.append((x, y))
    return points[0], points[-1]


# Of trees that stay as they are while they are looked at.
@functools.cache
def sources(root):
    return [name for name in rules.source_files(root) if pathlib.Path(name).suffix in rules.SOURCES]


@functools.cache
def text_of(root, name):
    return "\n".join(rules.lines_of(root, name))


@functools.cache
def edges_of(root):
    return rules.folder_edges(root)


def sources_in(root, folder):
    return [name for name in sources(root) if name.startswith(folder + "/")]


def box_problem(root, name, folder):
    names = sources_in(root, folder)
    if not names:
        return f"box {name}: no sources in {folder}"
    if name in {pathlib.Path(source).stem for source in names}:
        return None
    declared = re.compile(rf"^(?:class|struct) {re.escape(name)}\b[^;]*{{", re.MULTILINE)
    return None if any(declared.search(text_of(root, source)) for source in names) else f"box {name}: no such class in {folder}"


def arrow_problem(arrow, boxes, edges):
    path, folders = arrow.get("d"), (arrow.get("data-from"), arrow.get("data-to"))
    for (x, y), folder in zip(ends(path), folders):
        at = [each for each, (left, top, right, bottom) in boxes
              if left - NEAR <= x <= right + NEAR and top - NEAR <= y <= bottom + NEAR]
        # What comes from a thread of a library begins at no box.
        if at != [folder] and not (not at and folders[0] == folders[1]):
            return f"arrow {path}: expected an end at a box of {folder}, found {at or 'no box'}"
    a, b = folders
    return None if a == b or b in edges.get(a, {}) or a in edges.get(b, {}) else f"arrow {path}: neither of {a} and {b} includes the other"


def node_rings(root):
    return {(name, "/".join(source.split("/")[:2])) for folder in ("firmware", "drivers") for source in sources_in(root, folder)
            if source.endswith(".hpp") for name in RING.findall(text_of(root, source))}


def node_threads(root):
    """The roles of Realtime, and a thread for each class of the firmware that has one, named by its file's last word."""
    found = {role for source in sources_in(root, "firmware/realtime") for role in ROLES.findall(text_of(root, source))}
    owners = {pathlib.Path(source).stem.split("_")[-1] for source in sources_in(root, "firmware")
              if source.endswith(".hpp") and OWN_THREAD.search(text_of(root, source))}
    return found | owners | {"main"}


def problems(root, drawn_as=None):
    """drawn_as: the picture's text, instead of the file's."""
    picture = ElementTree.fromstring(drawn_as or (pathlib.Path(root) / PICTURE).read_text(encoding="utf-8"))
    found, boxes = [], []
    for group in of_class(picture, "box"):
        (name,), (folder,) = texts(group, "name"), texts(group, "folder")
        rectangle, (x, y) = group.find(f"{SVG}rect"), place(group)
        boxes.append((folder, (x, y, x + float(rectangle.get("width")), y + float(rectangle.get("height")))))
        found.append(box_problem(root, name, folder))
    edges = edges_of(root)
    found += [arrow_problem(arrow, boxes, edges) for arrow in of_class(picture, "flow")]
    drawn = {tuple(re.match(r"SpscRing (\w+) of (\S+)$", title.text).groups()) for title in picture.iter(f"{SVG}title")
             if title.text.startswith("SpscRing")}
    found += [f"ring {name} of {folder}: drawn, and not in the sources" for name, folder in sorted(drawn - node_rings(root))]
    found += [f"ring {name} of {folder}: not drawn" for name, folder in sorted(node_rings(root) - drawn)]
    threads = {name for lane in of_class(picture, "lane") if lane.get("class") == "lane" for name in texts(lane, "thread")}
    found += [f"thread {name}: drawn, and not in the sources" for name in sorted(threads - node_threads(root))]
    found += [f"thread {name}: not drawn" for name in sorted(node_threads(root) - threads)]
    messages = re.findall(r"^message (\w+)", text_of(root, "proto/srd.proto"), re.MULTILINE)
    said = re.findall(r"[A-Z]\w+", " ".join(texts(picture, "message")))
    found += [f"message {name}: not in proto/srd.proto" for name in said if name not in messages]
    return [problem for problem in found if problem] + ([] if boxes and drawn and said else ["nothing is drawn"])
