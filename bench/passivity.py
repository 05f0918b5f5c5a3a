#!/usr/bin/python3
"""What the stages of graphs/passivity do and cost, as Markdown tables: the net energy of the port in every cell of the closed-loop maps,
by the true motion of the handle, the force error that they add where a run is passive anyway, and microseconds a tick.

`bench/passivity.py [--jobs N]`, with a built release preset, h5py and numpy. Some minutes on two cores. The energy is summed up here, from
what was recorded: force commanded at a tick by the way of the handle until the next.
"""
import argparse
import collections
import concurrent.futures
import itertools
import json
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "bench"))
from run_time import table  # noqa: E402

TACTOR = pathlib.Path(os.environ.get("TACTOR", ROOT / "build/release/bin/tactor"))
GRAPHS = ROOT / "graphs"
STAGES = (None, "controller", "energy_bound")
METHODS = ("hold", "lowpass", "fixed", "paper", "blend", "local", "floor")
STIFFNESSES = tuple(50 * 2 ** step for step in range(8))  # N/m, as in graphs/studies/closed_loop_stiffness.yaml
SEEDS, ZETAS = (1001, 1002), (1, 0.25)
STEP = 1e-5  # m, of the scenes' encoder
STUDIED = ("device.hand_mass=0.15 kg",), ("device.hand_mass=0.55 kg",)
# Hands that no default was chosen by. The handle weighs 0.1 kg besides.
HANDS = {
    "the study's two": STUDIED,
    "an undamped hand, 0.3 kg on 135 N/m, friction 0": (("device.hand_mass=0.3 kg", "device.hand_damping=0", "device.friction=0",
                                                         "device.damping=0.05 N s/m"),),
    "a light finger, 0.05 kg and 0.2 N s/m on 20 N/m, friction 0": (("device.hand_mass=0.05 kg", "device.hand_damping=0.2 N s/m",
                                                                     "device.hand_stiffness=20 N/m", "device.friction=0"),),
}
LIVE_STIFFNESSES = (100, 400, 1600, 6400)  # N/m
OTHER_METHODS = ("hold", "blend", "local")
SCENES = ("duck", "wall", "bunny", "block_pushed", "peg_in_hole")
Cell = collections.namedtuple("Cell", "hand method stiffness of_hand seed zeta stage")


def run(graph, over, settings):
    """With these files of graphs/ over it: the summary, and of each tick that shows a handle the force and torque commanded (N, N m) and the
    true position (m). A live device commands for some ticks before it shows a handle, so rows go together by their times and not by their place."""
    import h5py
    import numpy

    with tempfile.TemporaryDirectory() as out:
        command = [TACTOR, "run", graph, "--overwrite", "--out", out]
        for file in over:
            command += ["--over", GRAPHS / file]
        for setting in ("record=[device.truth, device.commanded]", "metrics=~", *settings):
            command += ["--set", setting]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        summary = json.loads((pathlib.Path(out) / "summary.json").read_text())
        with h5py.File(pathlib.Path(out) / "recording.h5") as file:
            commanded, truth = (file[f"streams/device.{name}/data"][:] for name in ("commanded", "truth"))
    _, of_commanded, of_truth = numpy.intersect1d(commanded["valid_ns"], truth["valid_ns"], return_indices=True)
    return summary, commanded["force"][of_commanded], commanded["torque"][of_commanded], truth["p_WD"][of_truth]


def energy(force, p, weight=0.0):
    """J: the most net energy given at a time, and what one tick and one step of the encoder may bring. What a displayed weight (N, along z) gives
    while there is a force is not counted."""
    import numpy

    given = (force[:-1] * numpy.diff(p, axis=0)).sum(axis=1)
    of_weight = weight * numpy.diff(p[:, 2]) * force[:-1].any(axis=1)
    return max(0.0, numpy.cumsum(given - of_weight).max()), numpy.linalg.norm(force, axis=1).max() * STEP + numpy.abs(given).max()


def was_late(summary):
    """Whether a live run was later than `energy_bound` foresees; None where no stage tells."""
    of_stage = summary.get("passivity", {})
    return of_stage["ahead_most"] > 3 or of_stage["held_most"] > 2 if "held_most" in of_stage else None


def late_text(found):
    """How many of these were late, or None where no stage tells."""
    return None if None in found else f"{sum(found)} of {len(found)}"


def overlays(method, stage):
    """The files of a method, and of a stage where there is one."""
    return (f"methods/{method}.yaml", *((f"passivity/{stage}.yaml",) if stage else ()))


def measure(cell, *more):
    """(cell, J given, J allowed, N RMS of the force, N RMS of what the stage changed, whether the run was late)"""
    import numpy

    settings = [f"coupling.k_t={cell.stiffness} N/m", "scene.bodies.wall.material.stiffness=100 N/mm",
                "scene.bodies.tool.material.stiffness=100 N/mm", f"coupling.zeta={cell.zeta}", f"seed={cell.seed}",
                *HANDS[cell.hand][cell.of_hand], *more]
    summary, force, _, p = run(GRAPHS / "wall/closed_loop.yaml", overlays(cell.method, cell.stage), settings)
    rms = float(numpy.sqrt((force ** 2).sum(axis=1).mean()))
    return cell, *energy(force, p), rms, summary.get("passivity", {}).get("change_rms_N", 0.0), was_late(summary)


def cells():
    for hand, settings in HANDS.items():
        studied = settings is STUDIED
        seeds = itertools.product(SEEDS, ZETAS) if studied else ((SEEDS[0], zeta) for zeta in ZETAS)
        for (seed, zeta), method, stiffness, of_hand, stage in itertools.product(
                list(seeds), METHODS if studied else OTHER_METHODS, STIFFNESSES, range(len(settings)), STAGES):
            yield Cell(hand, method, stiffness, of_hand, seed, zeta, stage)


def named(stage):
    return f"`{stage}`" if stage else "none"


def energy_rows(found):
    """A row a hand and stage: of how many cells, how many keep the bound, and the worst."""
    for hand in HANDS:
        for stage in STAGES:
            of = [f for f in found if f[0].hand == hand and f[0].stage == stage]
            worst = max(of, key=lambda f: f[1] / f[2])
            yield [hand, named(stage), f"{sum(f[1] <= f[2] for f in of)} of {len(of)}", 1e3 * max(f[1] for f in of), worst[1] / worst[2],
                   f"{worst[0].method}, {worst[0].stiffness} N/m, damping ratio {worst[0].zeta}"]


def method_rows(found):
    """A row a method, over the study's hands: energy over what is allowed, the worst cell, without and with each stage."""
    for method in METHODS:
        yield [method, *(max(f[1] / f[2] for f in found if f[0].hand == "the study's two" and f[0].method == method and f[0].stage == stage)
                         for stage in STAGES)]


def changed_rows(found):
    """What the stages change in closed loop where the run without them is passive: in the strict sense, and within the bound."""
    without = {f[0]: f for f in found if f[0].stage is None}
    for stage in STAGES[1:]:
        for name, limit in (("gives nothing", lambda f: 1e-6), ("is within the bound", lambda f: f[2])):
            errors = []
            for f in found:
                bare = without[f[0]._replace(stage=None)]
                if f[0].stage == stage and f[0].hand == "the study's two" and bare[1] <= limit(bare):
                    errors.append((100 * f[4] / bare[3], f[0]))
            errors.sort(key=lambda e: e[0])
            worst = errors[-1]
            yield [named(stage), name, len(errors), sum(e[0] < 1 for e in errors), worst[0],
                   f"{worst[1].method}, {worst[1].stiffness} N/m, damping ratio {worst[1].zeta}"]


def live_rows():
    """A row a method and stage: the same scene in real time, one run after the other, by each coupling."""
    for method in OTHER_METHODS:
        for stage in STAGES:
            of = [measure(Cell("the study's two", method, stiffness, 0, SEEDS[0], 1, stage), "clock=real") for stiffness in LIVE_STIFFNESSES]
            worst = max(of, key=lambda f: f[1] / f[2])
            yield [method, named(stage), f"{sum(f[1] <= f[2] for f in of)} of {len(of)}", 1e3 * max(f[1] for f in of), worst[1] / worst[2],
                   f"{worst[0].stiffness} N/m", late_text([f[5] for f in of])]


def open_loop(scene, seconds=10):
    """Rows of a scene whose handle is led, by `local` and `hold`: RMS of the difference of the force (torque) to that without the stage."""
    import numpy

    rows = []
    for method in ("local", "hold"):
        plain = None
        for stage in STAGES:
            _, force, torque, _ = run(GRAPHS / f"{scene}/scene.yaml", overlays(method, stage), [f"duration={seconds} s"])
            if stage is None:
                plain = force, torque
                continue
            error = [100 * numpy.sqrt(((a - b) ** 2).sum() / (b ** 2).sum()) if b.any() else None
                     for a, b in zip((force, torque), plain)]
            rows.append([scene, method, named(stage), *(e if e is None else float(e) for e in error)])
    return rows


def cost_rows(repeats=5):
    """Of each stage, in one run with the rest: us a step, and its time over that of the device and over that of the interpolation."""
    for scene in ("wall", "bunny"):
        for stage in STAGES[1:]:
            runs = [run(GRAPHS / f"{scene}/scene.yaml", overlays("local", stage), ["duration=10 s"])[0]["cost_us"] for _ in range(repeats)]
            best = min(runs, key=lambda cost: cost["passivity"]["total_s"])
            of = {name: 1e6 * best[name]["total_s"] / best[name]["steps"] for name in ("passivity", "device", "rollout")}
            yield [scene, named(stage), best["passivity"]["median"], best["passivity"]["p99"], of["passivity"], of["passivity"] / of["device"],
                   of["passivity"] / of["rollout"]]


def live_tables():
    """The generated section on live runs. They need most of a processor each, so they come one after the other."""
    return "\n".join([
        f"### Energy, live\n\nWith the light one of the study's hands, at couplings of {', '.join(map(str, LIVE_STIFFNESSES))} N/m. The stage and "
        "the device step in one real-time loop, the method in the pool. A run is late where `passivity.ahead_most` is above 3 or "
        "`passivity.held_most` above 2.\n",
        table(["method", "stage", "cells within the bound", "largest energy, mJ", "largest share", "in which cell", "late runs"], live_rows())])


def tables(jobs):
    """The generated section of docs/explanation/passivity.md."""
    costs = list(cost_rows())
    with concurrent.futures.ProcessPoolExecutor(jobs) as pool:
        found = list(pool.map(measure, cells(), chunksize=8))
        errors = [row for rows in pool.map(open_loop, SCENES) for row in rows]
    return "\n".join([
        "### Energy, in a hand\n\n*Energy* is the largest net energy that the motors had given at any time. "
        "*Share* is this energy divided by max |F| D + max |F . dx|.\n",
        table(["hand", "stage", "cells within the bound", "largest energy, mJ", "largest share", "in which cell"], energy_rows(found)),
        "The largest share of each method, over all cells of the study's two hands:\n",
        table(["method", *(f"{named(s)}" for s in STAGES)], method_rows(found)),
        "### Force that is changed, in a hand\n\nThe RMS of the change by the stage, divided by the RMS of the force. Only the cells "
        "of the study's two hands count that are passive without a stage: the port gives nothing, or stays within the bound.\n",
        table(["stage", "without the stage, the port", "cells", "of these below 1 %", "largest change, %", "in which cell"], changed_rows(found)),
        "### Force that is changed, handle led\n\n10 s of each scene. Only scenes whose tool rotates have a torque.\n",
        table(["scene", "method", "stage", "force, %", "torque, %"], errors),
        "### Cost\n\nThe time of the stage's steps in a run of `local` under the virtual clock, and its ratio to the steps of the device and of "
        "the interpolation in the same run. The fastest of five runs counts.\n",
        table(["scene", "stage", "median, us", "p99, us", "mean, us", "of the device's step", "of `local`'s tick"], costs)])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    print(tables(parser.parse_args().jobs), end="")
