#!/usr/bin/python3
"""Makes the meshes of a list. `bench/meshes/make.py LIST FOLDER [--build BUILD]`; README.md beside this file tells what the names mean."""
import argparse
import math
import os
import pathlib
import random
import struct
import sys
import tarfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[1]
sys.path[:0] = [str(HERE), str(ROOT / "graphs/transfer")]
import broken  # noqa: E402
from shapes import ball, blob, box, cylinder, gear, height_field, joined, knot, moved, revolved, ring, stairs, star, write_off  # noqa: E402

ARCHIVES = (pathlib.Path("/usr/share/doc/libcgal-dev/data.tar.gz"), ROOT / "build/cgal-data/data.tar.gz")


def names(file):
    """The names of a list, in its order."""
    return [line.split()[0] for line in pathlib.Path(file).read_text().splitlines() if line.strip() and not line.startswith("#")]


def archive():
    found = next((a for a in ARCHIVES if a.exists()), None)
    if found is None:
        sys.exit("bench/meshes: data.tar.gz of Debian's libcgal-demo is missing; run scripts/install")
    return tarfile.open(found)


def scaled(mesh, by):
    return [tuple(by * c for c in v) for v in mesh[0]], mesh[1]


def inside_out(mesh):
    return mesh[0], [f[::-1] for f in mesh[1]]


def bowl():
    outer = [(0.0, 0.0), *((0.05 * math.sin(a), 0.05 - 0.05 * math.cos(a)) for a in (0.05 * math.pi * k for k in range(1, 11)))]
    inner = [*((0.046 * math.sin(a), 0.05 - 0.046 * math.cos(a)) for a in (0.05 * math.pi * k for k in range(10, 0, -1))), (0.0, 0.004)]
    return revolved(outer + inner, 48)


SOUND = {
    "ball_in_mm": lambda: scaled(ball(1), 40.0),
    "ball_of_a_hair": lambda: ball(4e-5),
    "block_of_a_house": lambda: broken.block(12.0, 9.0, 20.0),
    "box": lambda: box(0.1, 0.06, 0.04),
    "needle": lambda: cylinder(0.001, 0.12, 24),
    "disc": lambda: cylinder(0.05, 0.001, 48),
    "gear": lambda: gear(14, 0.03, 0.04, 0.01),
    "star": lambda: star(7, 0.015, 0.05, 0.008),
    "stairs": lambda: stairs(5, 0.02, 0.01, 0.06),
    "knot": lambda: knot(2, 3, 0.05, 0.008),
    "ring": lambda: ring(0.02, 0.03, 0.01, 48),
    "bowl": bowl,
    "far_from_the_origin": lambda: moved(ball(0.05), (3.0, -2.0, 5.0)),
    "two_bodies": lambda: joined(ball(0.03), moved(box(0.04, 0.04, 0.04), (0.1, 0.0, 0.0))),
    "cavity": lambda: joined(ball(0.05), inside_out(ball(0.03))),
    "inside_out": lambda: inside_out(broken.torus(0.06, 0.02)),
    "waves": lambda: height_field(0.12, 60, 0.01, lambda x, y: 0.004 * math.sin(120 * x) * math.cos(90 * y)),
    "fine_blob": lambda: blob(0.05, ((0.1, (1, 0.3, -0.4), 6, 0.3), (0.03, (0.2, 1, 0.5), 20, 0.9)), 240),
    "pebbles": lambda: joined(*(moved(ball(0.008, 12), (0.02 * (k % 5), 0.02 * (k // 5), 0.003 * (k % 3))) for k in range(25))),
    "tetrahedron": lambda: ([(0.0, 0.0, 0.0), (0.05, 0.0, 0.0), (0.0, 0.05, 0.0), (0.0, 0.0, 0.05)], [(0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3)]),
}


def fuzzed(name, source):
    """The file with some bytes gone or others in their place; which, the name decides."""
    dice, data = random.Random(name), bytearray(source)
    kind = name.rsplit("_", 1)[1]
    if kind == "cut":
        return bytes(data[:dice.randrange(len(data) // 4, len(data))])
    for _ in range(3):
        at = dice.randrange(len(data))
        if kind == "digits":  # a digit becomes another
            at = next(i for i in range(at, len(data)) if data[i:i + 1].isdigit())
            data[at] = ord(str(dice.randrange(10)))
        else:
            data[at] = dice.randrange(256)
    return bytes(data)


def off_bytes(mesh, folder):
    file = folder / "source.tmp"
    write_off(mesh, file)
    text = file.read_bytes()
    file.unlink()
    return text


def stl_bytes(mesh):
    """Binary STL, whose numbers are floats."""
    out = bytearray(80) + struct.pack("<I", len(mesh[1]))
    for f in mesh[1]:
        out += struct.pack("<12fH", 0, 0, 0, *(c for i in f for c in mesh[0][i]), 0)
    return bytes(out)


def content(name, folder, build, data):
    kind, file = name.split("/")
    stem = file.rsplit(".", 1)[0]
    if kind == "archive":
        return data.extractfile(f"data/meshes/{file}").read()
    if kind == "own":
        return (build / "meshes" / file).read_bytes()
    if kind == "broken":
        mesh = broken.broken(*stem.split("_", 1))
    elif kind == "sound":
        mesh = SOUND[stem]()
    elif kind == "fuzzed":
        return fuzzed(stem, off_bytes(broken.SOURCES[stem.split("_")[0]](), folder))
    else:
        raise ValueError(f"{name}: no such kind of mesh")
    return stl_bytes(mesh) if file.endswith(".stl") else off_bytes(mesh, folder)


def make(list_file, folder, build, only=None):
    """Makes the meshes of a list in a folder; {name: file}. `only`: some of its names."""
    made = {}
    with archive() as data:
        for name in names(list_file):
            if only is not None and name not in only:
                continue
            made[name] = folder / name
            made[name].parent.mkdir(parents=True, exist_ok=True)
            made[name].write_bytes(content(name, folder, build, data))
    return made


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("list", type=pathlib.Path)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--build", type=pathlib.Path, default=pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release")))
    arguments = parser.parse_args()
    arguments.folder.mkdir(parents=True, exist_ok=True)
    print(len(make(arguments.list, arguments.folder, arguments.build)), "meshes")
