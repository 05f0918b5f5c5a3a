#!/usr/bin/python3
"""Whether the lump of graphs/liver can be felt: the force of a finger that presses along a line over it, as a Markdown table.

`bench/palpation.py [--depth MM]`, with a built release preset. At each place the handle goes down from where the finger touches to the
depth in 0.4 s and rests 0.4 s. Each way of computing the force is run with the lump, and with a lump as soft as the rest, so that one and the
same shape and mesh is compared. A difference counts by the smallest one that is noticed at the force without the lump (thresholds.md).
"""
import argparse
import math
import pathlib
import subprocess
import sys
import tempfile

import h5py
import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from run_time import table  # noqa: E402

TACTOR = ROOT / "build/release/bin/tactor"
SCENE = ROOT / "graphs/liver/scene.yaml"
MESH = ROOT / "build/release/meshes/liver.off"
RADIUS, LINE_Y, LUMP_X, CLEAR = 7e-3, 10e-3, -27e-3, 5e-3  # m
PLACES = [1e-3 * x for x in (-51, -45, -39, -33, -27, -21, -15, -9, -3)]  # m
DOWN, REST, UP, ASIDE = 0.4, 0.4, 0.3, 0.4  # s
WAYS = {"fine": ["--over", ROOT / "graphs/methods/floor.yaml", "--set", "device.encoder_step=0"],
        "local": ["--over", ROOT / "graphs/methods/local.yaml"]}
SOFT_LUMP = ["--set", "scene.bodies.liver.inclusions.lump.young=20 kPa"]
WEBER = ((0.04, 0.04), (2.5, 0.175), (10, 0.7))  # N: a steady force, and the smallest difference that is noticed


def noticed(force):
    """The smallest difference that is noticed at this force, N: straight in logarithms between the points of WEBER."""
    if force <= WEBER[0][0]:
        return WEBER[0][1]
    for (x0, y0), (x1, y1) in zip(WEBER, WEBER[1:]):
        if force <= x1:
            return y0 * (force / x0) ** (math.log(y1 / y0) / math.log(x1 / x0))
    return force * WEBER[-1][1] / WEBER[-1][0]


def surface(file):
    """Points on the triangles of a file, a tenth of a side apart."""
    lines = [line.split("#")[0].split() for line in file.read_text().splitlines()]
    words = [line for line in lines if line][1:]
    vertices, faces = int(words[0][0]), int(words[0][1])
    p = numpy.array(words[1:1 + vertices], dtype=float)
    corners = numpy.array([face[1:4] for face in words[1 + vertices:1 + vertices + faces]], dtype=int)
    steps = numpy.array([(i, j) for i in range(11) for j in range(11 - i)]) / 10
    a, b, c = (p[corners[:, k]] for k in range(3))
    return numpy.concatenate([a + u * (b - a) + v * (c - a) for u, v in steps])


def touches_at(points, x, y):
    """z of the finger's centre where it touches the surface from above."""
    aside = numpy.hypot(points[:, 0] - x, points[:, 1] - y)
    near = aside < RADIUS
    return float((points[near, 2] + numpy.sqrt(RADIUS ** 2 - aside[near] ** 2)).max())


def trajectory(depth):
    """(points of the hand, (begin, end) of each press) over all places."""
    points, presses, t = [], [], 0.0
    shape = surface(MESH)
    for x in PLACES:
        z = touches_at(shape, x, LINE_Y)
        for wait, height in ((ASIDE if points else 0, z + CLEAR), (UP, z), (DOWN, z - depth), (REST, z - depth), (UP, z + CLEAR)):
            t += wait
            points.append((t, x, LINE_Y, height))
        presses.append((t - UP - REST - DOWN, t - UP))
    return points, presses


def forces(words, depth, folder):
    """The largest force at each place, N."""
    points, presses = trajectory(depth)
    hand = folder / "hand.yaml"
    way = ", ".join(f"{{t: {t:.3f} s, x: {x:.6f} m, y: {y:.6f} m, z: {z:.6f} m}}" for t, x, y, z in points)
    # Nothing is judged, so no reference run is made.
    hand.write_text(f"format: 2\nnodes:\n  metrics: ~\n  trajectory: {{tremor_amplitude: 0, repeat_after: 1000 s, points: [{way}]}}\n")
    subprocess.run([TACTOR, "run", SCENE, *words, "--over", hand, "--set", "record=[device.commanded]", "--duration", f"{points[-1][0]} s",
                    "--overwrite", "--out", folder / "run"], check=True, stdout=subprocess.DEVNULL)
    with h5py.File(folder / "run/recording.h5") as file:
        data = file["streams/device.commanded/data"][...]
    t, force = data["valid_ns"] * 1e-9, numpy.linalg.norm(data["force"], axis=1)
    return [float(force[(t >= begin) & (t <= end)].max()) for begin, end in presses]


HEAD = ["place, mm", *(f"{what}, {way}" for way in WAYS for what in ("lump, N", "none, N", "lump / none", "difference / noticed"))]


def measured(depth=6e-3):
    """A Markdown table: the largest force at each place along the line, with the lump and without."""
    body = [[f"{1e3 * (x - LUMP_X):+.0f}"] for x in PLACES]
    with tempfile.TemporaryDirectory() as name:
        for words in WAYS.values():
            with_lump, without = (forces([*words, *more], depth, pathlib.Path(name)) for more in ((), SOFT_LUMP))
            for row, lump, none in zip(body, with_lump, without):
                row += [lump, none, lump / none, (lump - none) / noticed(none)]
                print(*row, file=sys.stderr, flush=True)
    return table(HEAD, body)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--depth", type=float, default=6, help="how deep the handle goes, mm")
    options = parser.parse_args()
    if not TACTOR.exists():
        sys.exit("build first: scripts/build")
    print(measured(1e-3 * options.depth))


if __name__ == "__main__":
    main()
