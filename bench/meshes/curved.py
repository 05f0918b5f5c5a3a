"""How far the force of a curved mesh depends on how finely it is divided: a tool slides over balls of triangles, against the finest."""
import json
import math
import pathlib
import subprocess
import sys

import h5py
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "graphs/transfer"))
from shapes import write_off  # noqa: E402

RADIUS = 0.04  # m
FINEST = 6  # divisions of an icosahedron, each into four triangles
TOOLS = {"ball of 10 mm": "sphere: {radius: 5 mm}", "box of 10 mm": "box: {size: [10 mm, 10 mm, 10 mm]}", "mesh of 10 mm": "mesh: tool.off"}

GRAPH = """format: 2
title: {title}
clock: virtual
duration: 2 s
scene:
  gravity: [0, 0, 0]
  bodies:
    ball:
      mesh: {mesh}
      material: {{stiffness: 2 N/mm, damping: 2 N s/m, friction: 0}}
    tool: {{{tool}, motion: translation, mass: 50 g, pose: {{p: [0 mm, 0 mm, 47 mm]}}}}
nodes:
  trajectory: {{type: source.trajectory, points: [{points}]}}
  device: {{type: device.simulated, encoder_step: 0}}
  collision: {{type: collision.auto, cost: {{constant: 1 ms}}}}
  dynamics: {{type: dynamics.auto}}
  coupling: {{type: coupling.adaptive}}
  prediction: {{type: prediction.hold}}
  interpolation: {{type: interpolation.none}}
edges: [trajectory.target -> device.target, device.state -> collision.device, device.state -> dynamics.device,
        collision.contacts -> dynamics.contacts, dynamics.state -> collision.state, coupling.parameters -> dynamics.coupling,
        dynamics.state -> coupling.state, coupling.force -> prediction.force, prediction.forecast -> interpolation.forecast,
        interpolation.segment -> device.segment]
record: [coupling.force]
"""


def icosphere(radius, divisions):
    """Vertices in m and faces of an icosahedron on the ball, each triangle divided into four so many times."""
    g = (1 + math.sqrt(5)) / 2
    vertices = [numpy.array(v) / math.hypot(1, g) for v in
                [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g), (0, -1, -g), (0, 1, -g),
                 (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2), (10, 7, 6), (7, 1, 8),
             (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    for _ in range(divisions):
        middles, finer = {}, []

        def middle(a, b):
            key = (min(a, b), max(a, b))
            if key not in middles:
                middles[key] = len(vertices)
                m = vertices[a] + vertices[b]
                vertices.append(m / numpy.linalg.norm(m))
            return middles[key]
        for a, b, c in faces:
            ab, bc, ca = middle(a, b), middle(b, c), middle(c, a)
            finer += [(a, ab, ca), (b, bc, ab), (c, ca, bc), (ab, bc, ca)]
        faces = finer
    return [radius * v for v in vertices], faces


def path():
    """Onto the ball and around it, 2 mm deep where a hand presses, half a radian to each side."""
    at = [(0, 0, 0.008)] + [(0.3 + 0.034 * i, 0.5 * math.sin(0.13 * i), -0.002) for i in range(50)]
    reach = RADIUS + 0.005
    return ", ".join(f"{{t: {t:.3f} s, x: {1e3 * (reach + up) * math.sin(a):.5f} mm, y: {2 * a:.5f} mm, "
                     f"z: {1e3 * (reach + up) * math.cos(a):.5f} mm}}" for t, a, up in at)


def run(tactor, folder, name, tool, divisions):
    """The force on the device in N, by sample, and the median time of a query in us."""
    graph = folder / f"{name}_{divisions}.yaml"
    graph.write_text(GRAPH.format(title=name, mesh=f"ball_{divisions}.off", tool=tool, points=path()))
    out = folder / f"{name}_{divisions}"
    subprocess.run([tactor, "run", graph, "--overwrite", "--out", out], check=True, capture_output=True, text=True)
    with h5py.File(out / "recording.h5") as file:
        force = file["streams/coupling.force/data"][...]["force"]
    return force, json.loads((out / "summary.json").read_text())["cost_us"]["collision"]["median"]


def rows(tactor, folder):
    """Of each tool and ball: faces, how deep a triangle lies below the ball in mm, error in parts of the force, us a query."""
    folder.mkdir(parents=True, exist_ok=True)
    balls = {}
    for divisions in range(1, FINEST + 1):
        vertices, faces = icosphere(RADIUS, divisions)
        write_off((vertices, faces), folder / f"ball_{divisions}.off")
        middle = min(numpy.linalg.norm(sum(vertices[i] for i in face) / 3) for face in faces)
        balls[divisions] = {"faces": len(faces), "below_mm": 1e3 * (RADIUS - middle)}
    write_off(icosphere(0.005, 3), folder / "tool.off")
    found = []
    for name, tool in TOOLS.items():
        runs = {n: run(tactor, folder, name.replace(" ", "_"), tool, n) for n in balls}
        finest, _ = runs[FINEST]
        size = math.sqrt(numpy.mean(numpy.sum(finest ** 2, axis=1)))
        for divisions, (force, cost) in runs.items():
            count = min(len(force), len(finest))
            error = math.sqrt(numpy.mean(numpy.sum((force[:count] - finest[:count]) ** 2, axis=1))) / size
            found.append({"tool": name, **balls[divisions], "error": error, "query_us": cost})
    return found
