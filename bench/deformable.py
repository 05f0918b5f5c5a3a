#!/usr/bin/python3
"""What each method delivers on bodies that deform, beside what it costs, as Markdown tables.

`bench/deformable.py [--seeds N] [--fine-seeds N] [--keep FOLDER]`, with a built release preset. Each cell is a run of 3 s at 60 Hz
physics, beside a reference of physics at 1 kHz on an exact encoder. Keep the machine free of anything else. What runs delivered is kept
in FOLDER, so that a table that was stopped goes on; delete it when the program has changed.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from run_time import table  # noqa: E402

TACTOR = ROOT / "build/release/bin/tactor"
METHODS = ("hold", "lowpass", "paper", "refit", "blend", "local", "floor")
SCENES = {"gel_cube": "gel", "liver": "liver", "bunny_soft": "bunny"}  # and the body that deforms
#           name                          kPa  N/m   tetrahedra
CASES = (("20 kPa, 1,000 N/m", 20, 1000, 1000), ("20 kPa, 4,000 N/m", 20, 4000, 1000), ("5 kPa, 1,000 N/m", 5, 1000, 1000),
         ("20 kPa, 1,000 N/m, 3,000 tetrahedra", 20, 1000, 3000))
SECONDS = 3
FIRST_SEED = 1001
KEEP = ROOT / "build/deformable_results"


def settings(scene, young, stiffness, tetrahedra):
    body = SCENES[scene]
    said = {f"scene.bodies.{body}.young": f"{young} kPa", f"scene.bodies.{body}.tetrahedra": tetrahedra, "coupling.a": 0,
            "coupling.k_0": f"{stiffness} N/m", "coupling.k_device": f"{stiffness} N/m"}
    return [word for key, value in said.items() for word in ("--set", f"{key}={value}")]


def run(scene, method, seed, words, graph="scene"):
    """summary.json of a run."""
    with tempfile.TemporaryDirectory() as out:
        subprocess.run([TACTOR, "run", ROOT / f"graphs/{scene}/{graph}.yaml", "--over", ROOT / f"graphs/methods/{method}.yaml", "--seed",
                        str(seed), "--duration", f"{SECONDS} s", *words, "--overwrite", "--out", out], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        return json.loads((pathlib.Path(out) / "summary.json").read_text())


def figures(summary):
    """What a run delivered, and medians of what it took."""
    force = summary["delivered"]["force"]

    def median(kind):
        return sum(n["median"] for n in summary["cost_us"].values() if n["type"].startswith(kind) and n["steps"])
    return {"error": force["rms_error_N"], "most": force["max_error_N"], "delay": force.get("delay_ms"),
            "vibration": force.get("vibration_above_threshold_dB"), "weber": force.get("share_beyond_weber"),
            "result": median("prediction."), "tick": median("interpolation.")}


def kept(keep, scene, case, method, seed):
    """figures() of a run, from the folder `keep` where it was made before."""
    file = keep / f"{scene}-{'-'.join(map(str, case[1:]))}-{method}-{seed}.json"
    if not file.exists():
        keep.mkdir(parents=True, exist_ok=True)
        found = json.dumps(figures(run(scene, method, seed, settings(scene, *case[1:]))))
        part = file.with_suffix(".part")
        part.write_text(found)
        part.rename(file)
    return json.loads(file.read_text())


HEAD = ["scene", "method", "error, N", "error / hold", "worst seed", "error / floor", "worst seed", "most, N", "delay, ms", "noticed, %",
        "a result, us", "a tick, us"]  # medians


def rows(scene, case, seeds, keep):
    """The rows of a scene in a case."""
    found = {method: [kept(keep, scene, case, method, seed) for seed in seeds] for method in METHODS}

    def mean(method, name):
        known = [f[name] for f in found[method] if f[name] is not None]
        return statistics.fmean(known) if known else None
    body = []
    for method in METHODS:
        ratios = [f["error"] / hold["error"] for f, hold in zip(found[method], found["hold"])]
        noticed = mean(method, "weber")
        delay = [f["delay"] for f in found[method] if f["delay"] is not None]
        body.append([f"`{scene}`", f"`{method}`", f"{mean(method, 'error'):.4f}", f"{statistics.fmean(ratios):.3f}", f"{max(ratios):.3f}",
                     f"{mean(method, 'error') / mean('floor', 'error'):.2f}",
                     f"{max(f['error'] / floor['error'] for f, floor in zip(found[method], found['floor'])):.2f}", f"{max(f['most'] for f in found[method]):.3f}",
                     f"{statistics.median(delay):.2f}" if delay else "", "" if noticed is None else f"{100 * noticed:.0f}",
                     f"{mean(method, 'result'):.0f}", f"{mean(method, 'tick'):.1f}"])
        print(case[0], *body[-1], flush=True)
    return body


def seeds_of(case, seeds, fine_seeds):
    return range(FIRST_SEED, FIRST_SEED + (fine_seeds if case[3] > 1000 else seeds))


def worst_of(method, seeds, fine_seeds, keep, scenes):
    """What the method delivers in the worst scene, case and seed, in words."""
    worst = []
    for case in CASES:
        for scene in scenes:
            for seed in seeds_of(case, seeds, fine_seeds):
                error, hold = (kept(keep, scene, case, one, seed)["error"] for one in (method, "hold"))
                worst.append((error / hold, f"`{scene}`, {case[0]}, seed {seed}"))
    ratio, where = max(worst)
    return f"`{method}`: {ratio:.2f} ({where})"


def accuracy(seeds, fine_seeds, keep, scenes=tuple(SCENES)):
    """A Markdown text: the worst runs, and a table a case."""
    said = "\n".join(f"- {worst_of(method, seeds, fine_seeds, keep, scenes)}" for method in METHODS if method != "hold")
    parts = [f"The worst single run of each method, by the ratio of its error to the hold's:\n\n{said}"]
    for case in CASES:
        own = seeds_of(case, seeds, fine_seeds)
        body = [row for scene in scenes for row in rows(scene, case, own, keep)]
        parts.append(f"### {case[0]}\n\n{len(own)} seeds.\n\n{table(HEAD, body)}")
    return "\n\n".join(parts)


SPEED_HEAD = ["scene", "tetrahedra", "solver", "rate, Hz", "a result, ms", "p99, ms", "share of the period, %", "steps a result",
              "factors a step", "iterations a step", "error, N", "the predictor, ms", "a tick, us", "p99, us"]
#         scene, tetrahedra, solver, Hz
SPEEDS = (("liver", 1000, "eigen", 60), ("liver", 1000, "supernodal", 60), ("liver", 3000, "simplicial", 60), ("liver", 3000, "supernodal", 60),
          ("liver", 10000, "supernodal", 20), ("gel_cube", 3000, "supernodal", 60), ("bunny_soft", 3000, "supernodal", 60))


def speed():
    """A Markdown table: the time of results and ticks by scene, tetrahedra and solver."""
    body = []
    for scene, tetrahedra, solver, rate in SPEEDS:
        words = [*settings(scene, 20, 1000, tetrahedra), "--set", f"dynamics.solver={solver}", "--set",
                 f"dynamics.cost={{constant: {1000 / rate:.4g} ms}}"]
        summary = run(scene, "local", FIRST_SEED, words)
        of = {node["type"]: node for node in summary["cost_us"].values()}
        result, predictor, tick = of["dynamics.deformable"], of["prediction.local"], of["interpolation.rollout"]
        body.append([f"`{scene}`", tetrahedra, solver, rate, result["median"] / 1e3, result["p99"] / 1e3, result["median"] * rate / 1e4,
                     summary["dynamics_steps"] / result["steps"], summary["deformable"]["factors"], summary["deformable"]["iterations"],
                     summary["delivered"]["force"]["rms_error_N"], predictor["median"] / 1e3, tick["median"], tick["p99"]])
        print(*body[-1], flush=True)
    return table(SPEED_HEAD, body)


def convergence():
    """A Markdown table: what physics at 10 kHz changes in the reference."""
    body = []
    for scene in SCENES:
        words = settings(scene, *CASES[0][1:])
        hold = run(scene, "hold", FIRST_SEED, words)["delivered"]["force"]["rms_error_N"]
        fine = run(scene, "hold", FIRST_SEED, [*words, "--set", "device.encoder_step=0", "--set", "dynamics.cost=none", "--set",
                                               "rate=10 kHz"])["physics"]["force"]["rms_error_N"]
        body.append([f"`{scene}`", hold, fine, fine / hold])
    return table(["scene", "error of hold, N", "change by 10 kHz, N", "change / hold"], body)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--fine-seeds", type=int, default=5)
    parser.add_argument("--scenes", default=",".join(SCENES))
    parser.add_argument("--keep", type=pathlib.Path, default=KEEP)
    options = parser.parse_args()
    print(accuracy(options.seeds, options.fine_seeds, options.keep, options.scenes.split(",")))


if __name__ == "__main__":
    main()
