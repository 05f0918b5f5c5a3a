#!/usr/bin/python3
"""What each method costs and gives where the device asks for a force 1,000, 2,000 and 4,000 times a second, as Markdown tables.

`bench/rates.py [--seconds S]`, with a built release preset. Every method runs over the same scenes and rates, once under the virtual
clock and once live. Runs are made one after another, the rates of a method next to each other, so that their times can be compared.
Keep the machine free of anything else.
"""
import argparse
import json
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from run_time import table  # noqa: E402

TACTOR = ROOT / "build/release/bin/tactor"
METHODS = ("hold", "lowpass", "linear", "linear_position", "fixed", "paper", "refit", "burg", "rls", "kalman", "multirate", "hermite_cubic",
           "hermite_quintic", "catmull_rom", "blend", "local_anchors", "local")
RATES = (1, 2, 4)  # kHz
SCENES = ("duck/scene", "wall/scene", "peg_in_hole/scene", "bunny/scene", "transfer/waves", "transfer/fast")
LIVE_SCENES = ("wall/scene", "bunny/scene")
RESULT, TICK = "prediction.", "interpolation."  # the nodes that step with each result of physics, and with each tick


def run(scene, method, rate, seconds, *settings):
    """summary.json of a run."""
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([TACTOR, "run", ROOT / f"graphs/{scene}.yaml", "--over", ROOT / f"graphs/methods/{method}.yaml", "--seed", "1001",
                        "--duration", f"{seconds} s", "--set", f"rate={rate} kHz", "--set", f"metrics.settle={seconds / 2} s", *settings,
                        "--overwrite", "--out", out], check=True, stdout=subprocess.DEVNULL)
        return json.loads((pathlib.Path(out) / "summary.json").read_text())


def step_us(summary, kind):
    """us, the mean of a step of the nodes of that kind, together: one step of each is a result, or a tick."""
    return sum(1e6 * node["total_s"] / node["steps"] for node in summary["cost_us"].values()
               if node["type"].startswith(kind) and node["steps"])


def geometric_mean(values):
    return math.exp(statistics.fmean(map(math.log, values)))


def figures(summary):
    """Error, delay and cost of a run."""
    force = summary["delivered"]["force"]
    return {"error": force["rms_error_N"], "delay": force.get("delay_ms"), "result": step_us(summary, RESULT),
            "tick": step_us(summary, TICK), "vibration": force.get("vibration_above_threshold_dB")}


def over(mean, figures_, name):
    """That mean of a figure over the runs that have it; None where none has."""
    known = [f[name] for f in figures_ if f[name] is not None]
    return mean(known) if known else None


HEAD = ["method", "kHz", "error / hold at 1 kHz", "worst scene", "delay, ms", "a result, us", "its cost / 1 kHz", "worst scene ",
        "a tick, us", "vibration above threshold, dB"]


def rows(found, hold):
    """The rows of a method. `found`: {rate: {scene: figures}}; `hold`: {scene: N, the error of a hold at 1 kHz}."""
    for rate, scenes in found.items():
        errors = [f["error"] / hold[scene] for scene, f in scenes.items()]
        cost = [f["result"] / found[RATES[0]][scene]["result"] for scene, f in scenes.items()]
        yield [rate, geometric_mean(errors), max(errors), over(statistics.median, scenes.values(), "delay"),
               over(statistics.fmean, scenes.values(), "result"), geometric_mean(cost), max(cost),
               over(statistics.fmean, scenes.values(), "tick"), over(statistics.fmean, scenes.values(), "vibration")]


def virtual(seconds, methods=METHODS, scenes=SCENES):
    hold = None
    for method in methods:
        found = {rate: {} for rate in RATES}
        for scene in scenes:
            for rate in RATES:
                found[rate][scene] = figures(run(scene, method, rate, seconds))
        hold = hold or {scene: f["error"] for scene, f in found[RATES[0]].items()}
        yield from ([method, *row] for row in rows(found, hold))


LIVE_HEAD = ["method", "scene", "kHz", "error, N", "delay, ms", "ticks missed, %", "a tick of the device, p99, us", "a result, us", "a tick, us"]


def live(seconds, methods=METHODS, scenes=LIVE_SCENES):
    for method in methods:
        for scene in scenes:
            for rate in RATES:
                summary = run(scene, method, rate, seconds, "--set", "clock=real")
                device, found = summary["device"], figures(summary)
                yield [method, scene, rate, found["error"], found["delay"], 100 * device["missed"] / device["ticks"],
                       device["body_us"]["p99"], found["result"], found["tick"]]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=10)
    seconds = parser.parse_args().seconds
    print(table(HEAD, virtual(seconds)))
    print(table(LIVE_HEAD, live(seconds)), end="")
