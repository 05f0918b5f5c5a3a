#!/usr/bin/python3
"""Physics of a program's own, in Python: a ball against fixed obstacles, at 60 and 100 results a second, by method.

`bench/own_loop.py [--seeds N] [--jobs N]`, with a built release preset. The ball is pushed by springs and dampers with Coulomb friction,
in steps of 0.25 ms. A result tells either the contacts with this law, and `local` goes on with them in each tick, or the force alone. The
truth is the same physics in steps of 0.1 ms on a device at 10 kHz without encoder steps.
"""
import argparse
import concurrent.futures
import math
import os
import pathlib
import statistics
import sys
import time
import warnings

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
sys.path.insert(0, str(BUILD / "python"))
from run_time import table  # noqa: E402

EXAMPLE = ROOT / "examples/physics"
RATES = (60, 100)  # results a second
MASS, RADIUS = 0.05, 4e-3  # kg, m: as in the example's graph
STIFFNESS, DAMPING, FRICTION = 2000.0, 2.0, 0.1  # N/m, N s/m, Coulomb coefficient
SUBSTEP, TRUE_RATE = 2.5e-4, 10000  # s, Hz
CREEP = 1e-3  # m/s, below which friction grows with the slip
NEAR = 0.02  # m, from which on a contact is told
DURATION, WARM = 8.0, 4.0  # s, of a run, and from when on it is judged: forecasts have learnt the motion by then
METHODS = {"hold": "hold, coupling by Tactor", "local": "`local` with the declared law", "local_unfitted": "the same, the law not fitted",
           "force_hold": "force alone, held", "force_linear": "force alone, `linear`", "force_blend": "force alone, `blend`"}
FORCE_ALONE = {"edges": ["physics.force -> prediction.force"]}


def plane(p, normal, through=(0, 0, 0)):
    """Of a point and a plane: the distance in m, the normal, and the curvature of the distance in 1/m."""
    return float(np.dot(p - np.asarray(through), normal)), np.asarray(normal, float), 0.0


def sphere(p, centre, radius):
    """The same of a ball."""
    away = p - np.asarray(centre)
    length = float(np.linalg.norm(away))
    return length - radius, away / length, 1 / length


# Fixed obstacles by scene. The hand of the example goes over the plane z = 0, up to 30 mm along x and 20 mm along y.
SCENES = {"plane": lambda p: [plane(p, (0, 0, 1))],
          "groove": lambda p: [plane(p, (0, math.sin(a), math.cos(a)), (0, 0.01, -2e-3)) for a in (0.5, -0.5)],
          "ball on a plane": lambda p: [plane(p, (0, 0, 1)), sphere(p, (0.015, 0.004, -0.02), 0.024)]}


def law(p, v, obstacles):
    """N, the force of the obstacles on the ball."""
    force = np.zeros(3)
    for distance, normal, _ in obstacles(p):
        speed = float(v @ normal)
        push = max(0.0, STIFFNESS * (RADIUS - distance) - DAMPING * speed)
        if push > 0 and distance < RADIUS:
            slip = v - speed * normal
            force += push * (normal - FRICTION * slip / max(float(np.linalg.norm(slip)), CREEP))
    return force


def contacts(p, obstacles):
    """Those near the ball, told before they touch."""
    told = []
    for distance, normal, curvature in obstacles(p):
        if distance > NEAR:
            continue
        hessian = curvature * (np.eye(3) - np.outer(normal, normal))
        told.append({"p_WC": p - distance * normal, "n_W": normal, "distance": distance - RADIUS, "stiffness": STIFFNESS,
                     "damping": DAMPING, "friction": FRICTION, "H_W": hessian[np.triu_indices(3)]})
    return told


class Ball:
    """Semi-implicit Euler steps on the coupling's explicit force."""

    def __init__(self, obstacles):
        self.obstacles = obstacles
        self.p = self.v = self.contact = self.felt = np.zeros(3)  # m, m/s, N of the obstacles, N on the device
        self.begun = False

    def move(self, step):
        if not self.begun:
            self.p, self.begun = step.handle(step.begin).p_WD, True
        count = max(1, math.ceil(step.h / SUBSTEP - 1e-6))
        h = step.h / count
        for i in range(1, count + 1):
            pull, _ = step.wrench(self.p, None, self.v, None, MASS, None, h, time=step.begin + i * h)
            self.contact = law(self.p, self.v, self.obstacles)
            self.v = self.v + h / MASS * (pull + self.contact)
            self.p = self.p + h * self.v
        self.felt = -step.wrench(self.p, None, self.v, None, MASS, None, h)[0]


def overlays(method):
    """What is laid over the example's graph."""
    if method == "local":
        return [EXAMPLE / "local.yaml"]
    if method == "local_unfitted":
        return [EXAMPLE / "local.yaml", {"nodes": {"local": {"fit": False}}}]
    kind, _, of_forces = method.partition("_")
    return [of_forces, FORCE_ALONE] if kind == "force" else [method]


def run(method, rate, scene, seed, true=False):
    """A displayed force and that of physics, each as times (s) and forces (N, rows of 3), and the us that the graph takes a tick.

    `true`: the reference of that scene and seed.
    """
    import tactor
    values = {"physics.rate": rate, "seed": seed, "duration": DURATION}
    if true:
        values |= {"physics.rate": TRUE_RATE, "rate": TRUE_RATE, "device.encoder_step": 0}
    graph = tactor.load(EXAMPLE / "graph.yaml", over=overlays(method), set=values)
    ball, alone = Ball(SCENES[scene]), method.startswith("force_")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", tactor.InputWarning)  # defaults that count, since the graph has no dynamics of ours
        session = tactor.Session(graph)
    with session:
        displayed, felt = session.tap("device.commanded"), session.tap("physics.force" if alone else "coupling.force")
        loop, own, begin = session.physics(), 0.0, time.thread_time()
        for step in loop:
            before = time.thread_time()
            ball.move(step)
            told = {"felt": ball.felt} if alone else {}
            if method.startswith("local"):
                told = {"contact": ball.contact, "contacts": contacts(ball.p, ball.obstacles)}
            own += time.thread_time() - before
            loop.result(step, tool={"p_WT": ball.p, "v_WT": ball.v}, **told)
        took = time.thread_time() - begin - own
    streams = [(messages.time, messages["force"]) for messages in (displayed.take(), felt.take())]
    return *streams, 1e6 * took / len(streams[0][0])


def error(displayed, truth):
    """(RMS, worst) of the displayed force in N, while runs are judged. The truth is interpolated to the times of the display."""
    times, force = displayed
    judged = (times >= WARM) & (times <= truth[0][-1])
    expected = np.stack([np.interp(times[judged], truth[0], truth[1][:, axis]) for axis in range(3)], axis=1)
    apart = np.linalg.norm(force[judged] - expected, axis=1)
    return float(np.sqrt((apart**2).mean())), float(apart.max())


def measure(case):
    """{(rate, method): (RMS in N, worst in N, us a tick)} of a (scene, seed)."""
    scene, seed = case
    _, truth, _ = run("hold", RATES[0], scene, seed, true=True)
    found = {}
    for rate in RATES:
        for method in METHODS:
            displayed, _, us = run(method, rate, scene, seed)
            found[rate, method] = (*error(displayed, truth), us)
    return found


def measure_all(seeds, jobs, scenes=tuple(SCENES)):
    """{scene: [what `measure` gives, by seed]}"""
    cases = [(scene, seed) for scene in scenes for seed in seeds]
    with concurrent.futures.ProcessPoolExecutor(jobs) as pool:
        found = list(pool.map(measure, cases))
    return {scene: [one for (name, _), one in zip(cases, found) if name == scene] for scene in scenes}


HEAD = ["results a second", "scene", "method", "RMS error, N", "worst, N", "RMS / hold's", "at the worst seed", "worst / hold's",
        "the graph, us a tick"]


def rows(found):
    """Means over the seeds beside the worst seed."""
    for rate in RATES:
        for scene, seeds in found.items():
            for method, name in METHODS.items():
                errors, worst, us = zip(*(one[rate, method] for one in seeds))
                hold = [one[rate, "hold"] for one in seeds]
                ratios = [e / h[0] for e, h in zip(errors, hold)]
                yield [rate, scene, name, statistics.fmean(errors), max(worst), statistics.fmean(ratios), max(ratios),
                       max(w / h[1] for w, h in zip(worst, hold)), statistics.median(us)]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    print(table(HEAD, rows(measure_all(range(1001, 1001 + arguments.seeds), arguments.jobs))), end="")


if __name__ == "__main__":
    main()
