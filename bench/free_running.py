#!/usr/bin/python3
"""How far a method takes a hand from where the ideal rendering would have it: a Markdown table.

`bench/free_running.py`, with a built release preset. In closed loop the reference of a run follows the path of that run, so it tells of the
force alone. Here the same hand is simulated twice and goes free both times: with a method and physics at 60 Hz, and with physics at every
tick of a 4 kHz loop, on an encoder without steps. Then the two paths and the two forces are compared at each millisecond.
"""
import os
import pathlib
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
sys.path.insert(0, str(BUILD / "python"))
from run_time import table  # noqa: E402

METHODS = ("hold", "lowpass", "fixed", "paper", "blend", "local_anchors", "local", "floor")
SCENES = ("wall/closed_loop", "duck/scene", "peg_in_hole/scene", "bunny/scene")
HANDS = {"firm": (0.55, 6.5, 135), "light": (0.15, 2, 40)}  # kg, N s/m, N/m
IDEAL, IDEAL_KHZ = "floor_exact", 4
PHYSICS = {"collision.cost": {"constant": "16.667 ms", "min": "0 ms", "max": "1 s"}}
SECONDS, SETTLED = 4, 0.8  # the first result of slow physics is late, and a heavy tool hangs on the hand from then on


def path_and_force(scene, method, hand, khz=1):
    """Of each millisecond from SETTLED on: where the handle is, m, and the force on it, N."""
    import tactor
    hand = dict(zip(("device.hand_mass", "device.hand_damping", "device.hand_stiffness"), hand))
    settings = hand | {"device.loop": "closed", "rate": f"{khz} kHz", "duration": SECONDS}
    if not method.startswith("floor"):
        settings |= PHYSICS
    with tactor.Session(scene, over=[method], set=settings) as session:
        truth, force = session.tap("device.truth"), session.tap("device.commanded")
        session.run()
        first = round(1000 * SETTLED)
        return truth.take()["p_WD"][::khz][first:], force.take()["force"][::khz][first:]


def apart(a, b):
    """RMS and largest distance of two tracks, sample by sample."""
    distance = np.linalg.norm(a - b, axis=1)
    return np.sqrt(np.mean(distance**2)), distance.max()


HEAD = ["scene", "hand", "method", "path, mm RMS", "mm, worst", "force, N RMS", "N, worst"]


def rows(scenes=SCENES, hands=HANDS, methods=METHODS):
    """One row a scene, hand and method, and first the ideal rendering at half its rate, which tells how ideal it is."""
    for scene in scenes:
        for name, hand in hands.items():
            ideal = path_and_force(scene, IDEAL, hand, IDEAL_KHZ)
            others = {f"ideal, {IDEAL_KHZ // 2} kHz": (IDEAL, IDEAL_KHZ // 2)} | {m: (m, 1) for m in methods}
            for label, (method, khz) in others.items():
                found = path_and_force(scene, method, hand, khz)
                (path, path_worst), (force, force_worst) = (apart(*pair) for pair in zip(found, ideal))
                yield [scene, name, label, 1e3 * path, 1e3 * path_worst, force, force_worst]


if __name__ == "__main__":
    print(table(HEAD, rows()), end="")
