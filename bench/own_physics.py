#!/usr/bin/python3
"""How near each method comes to physics that is MuJoCo, under the virtual clock and live, as Markdown tables.

`bench/own_physics.py [--seeds N] [--jobs N] [--live SECONDS]`, with a built release preset that has the plugin tactor_mujoco. The scenes are
those of graphs/own_physics, each at every rate of physics. The truth is each graph's reference run: the same model in steps of 50 us, with
the device at 10 kHz and no encoder steps.
"""
import argparse
import json
import math
import os
import pathlib
import re
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import page  # noqa: E402
from run_time import table  # noqa: E402

BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
TACTOR = BUILD / "bin/tactor"
FOLDER = ROOT / "graphs/own_physics"
OUT = ROOT / "out/own_physics"
RATES = {60: "60hz.yaml", 100: None, 200: "200hz.yaml"}  # results a second, and what is laid over a scene for it
OWN = ("rollout", "rollout_kept", "each_tick")  # overlays beside the scenes
METHODS = ("hold", "local", "blend", *OWN, "floor")
LIVE = ("hold", "rollout", "each_tick")  # the first is the control
FIRST_SEED = 1001  # seeds that nothing was tuned on
RMS, WORST, DELAY = (f"delivered.force.{name}" for name in ("rms_error_N", "max_error_N", "delay_ms"))


def scenes():
    """The graphs that are a scene, by name."""
    return {file.stem: file for file in sorted(FOLDER.glob("*.yaml")) if re.search(r"^extends: common\.yaml$", file.read_text(), re.MULTILINE)}


def method_file(method):
    return (FOLDER if method in OWN else ROOT / "graphs/methods") / f"{method}.yaml"


def refusal(scene, method):
    """Why a method cannot be laid over a scene; empty where it can."""
    probe = subprocess.run([TACTOR, "run", scene, "--over", method_file(method), "--duration", "0.02 s", "--overwrite", "--out", OUT / "probe"],
                           stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if probe.returncode not in (0, 2):
        raise RuntimeError(f"{scene.name} over {method} ended with {probe.returncode}: {probe.stderr}")
    return "" if probe.returncode == 0 else probe.stderr.strip().splitlines()[0].replace(f"{ROOT}/", "")


def refusals(names):
    """{(scene, method): why} of those that are refused."""
    found = {(scene, method): refusal(file, method) for scene, file in names.items() for method in METHODS}
    return {key: why for key, why in found.items() if why}


def write_graphs(names):
    """{(scene, rate): a graph of that scene at that rate}"""
    graphs = {}
    for scene, file in names.items():
        for rate, over in RATES.items():
            graph = OUT / f"{scene}_{rate}hz.yaml"
            graph.write_text(f"format: 2\nextends: {json.dumps([str(file), *([str(FOLDER / over)] if over else [])])}\n")
            graphs[scene, rate] = graph
    return graphs


def groups(names, refused):
    """{methods: scenes}: scenes over which the same methods can be laid."""
    found = {}
    for scene in names:
        methods = tuple(method for method in METHODS if (scene, method) not in refused)
        found.setdefault(methods, []).append(scene)
    return found


def study(names, refused, seeds, jobs, timed):
    """{(scene, rate): {method: its row of the study}}"""
    graphs, found = write_graphs(names), {}
    for number, (methods, of) in enumerate(groups(names, refused).items()):
        file = OUT / f"{'timed' if timed else 'study'}_{number}.yaml"
        listed = {graph.stem: key for key, graph in graphs.items() if key[0] in of}
        file.write_text(page.study_text("own physics", [graphs[key] for key in listed.values()], [method_file(method) for method in methods], seeds,
                                        FIRST_SEED))
        for row in page.study(TACTOR, file, file.with_suffix(""), "--jobs", str(jobs), "--overwrite")["rows"]:
            found.setdefault(listed[row["graph"]], {})[row["method"]] = row
    return found


def measured(seeds, jobs, names=None):
    """What there is of each scene, rate and method, and why the rest is missing. Run times are those of one run at a time."""
    OUT.mkdir(parents=True, exist_ok=True)
    names = names or scenes()
    refused = refusals(names)
    found = study(names, refused, seeds, jobs, timed=False)
    for key, methods in study(names, refused, 1, 1, timed=True).items():
        for method, row in methods.items():
            kept = found[key][method]["metrics"]
            kept |= {name: value for name, value in row["metrics"].items() if page.is_run_time(name)}
    return found, refused


def by_seed(row, name):
    """A metric of each seed; those without it are left out."""
    return [value for value in row["metrics"].get(name, {}).get("by_seed", []) if value is not None]


def ratios(row, other, name):
    """A metric of each seed as a multiple of that of another method with the same seed."""
    return [a / b for a, b in zip(by_seed(row, name), by_seed(other, name), strict=True)]


def quantile(values, share):
    """The nearest-rank quantile."""
    return sorted(values)[max(0, math.ceil(share * len(values)) - 1)]


class Rate:
    """One rate of physics: {scene: {method: row}}."""

    def __init__(self, found, rate):
        self.rows = {scene: methods for (scene, of), methods in found.items() if of == rate}

    def of(self, method):
        """The scenes that the method has."""
        return {scene: methods for scene, methods in self.rows.items() if method in methods}

    def against(self, method, other, name):
        """{scene: the mean over the seeds of a ratio}"""
        return {scene: statistics.fmean(ratios(m[method], m[other], name)) for scene, m in self.of(method).items() if other in m}

    def runs(self, method, other, name):
        """That ratio of all runs."""
        return [ratio for methods in self.of(method).values() for ratio in ratios(methods[method], methods[other], name)]

    def mean_and_worst(self, method, other, name):
        """The mean over the scenes, and the worst scene with its name."""
        of = self.against(method, other, name)
        if not of:
            return [None, None]
        worst = max(of, key=of.get)
        return [statistics.fmean(of.values()), f"{of[worst]:.3g} ({worst})"]

    def values(self, method, name):
        """{scene: the mean over the seeds of a metric}, of the scenes that have it."""
        found = {scene: by_seed(methods[method], name) for scene, methods in self.of(method).items()}
        return {scene: statistics.fmean(values) for scene, values in found.items() if values}

    def delays(self, method):
        found = self.values(method, DELAY).values()
        return [statistics.median(found), f"{min(found):.3g} to {max(found):.3g}"] if found else [None, None]

    def times(self, method, name):
        """The mean over the scenes, and the largest."""
        found = self.values(method, name).values()
        return [statistics.fmean(found), max(found)] if found else [None, None]

    def methods(self):
        return [method for method in METHODS if self.of(method)]


SUMMARY = ["method", "scenes", "RMS error / hold's", "worst scene", "95 % of the runs below", "worst run", "worst error / hold's worst", "worst scene",
           "delay, ms", "by scene, ms", "method, us a tick", "worst scene"]
COSTS = ["method", "RMS error / floor's", "worst scene", "physics, us a result", "worst scene", "whole run, CPU ms a s", "worst scene"]


def summary(found, rate):
    """A row for each method at one rate of physics: errors beside run times, means beside the worst."""
    of = Rate(found, rate)
    for method in of.methods():
        runs = of.runs(method, "hold", RMS)
        yield [f"`{method}`", len(of.of(method)), *of.mean_and_worst(method, "hold", RMS), quantile(runs, 0.95), max(runs),
               *of.mean_and_worst(method, "hold", WORST), *of.delays(method), *of.times(method, "method_us_per_tick")]


def costs(found, rate):
    """The same beside physics at 1 kHz, with what physics and the whole run take."""
    of = Rate(found, rate)
    for method in of.methods():
        yield [f"`{method}`", *of.mean_and_worst(method, "floor", RMS), *of.times(method, "cost_us.physics.median"), *of.times(method, "cpu_ms_per_s")]


def by_scene(found, rate, name):
    """The hold in N, and each method as a multiple of it: the mean over the seeds, and the worst seed."""
    of = Rate(found, rate)
    yield ["`hold`, N", *(statistics.fmean(by_seed(methods["hold"], name)) for methods in of.rows.values())]
    for method in of.methods()[1:]:
        cells = []
        for methods in of.rows.values():
            all_ = ratios(methods[method], methods["hold"], name) if method in methods else None
            cells.append(f"{statistics.fmean(all_):.3g}; {max(all_):.3g}" if all_ else None)
        yield [f"`{method}`", *cells]


def virtual_tables(found):
    """The section of each rate."""
    parts = []
    for rate in RATES:
        of = Rate(found, rate)
        parts += [f"### {rate} results a second\n", table(SUMMARY, summary(found, rate)), table(COSTS, costs(found, rate))]
        for name, title in ((RMS, "RMS error"), (WORST, "Worst error")):
            parts += [f"{title} by scene, as a multiple of that of `hold`: mean of the seeds; worst seed.\n",
                      table(["method", *of.rows], by_scene(found, rate, name))]
    return "\n".join(parts)


def answer(found):
    """The main numbers as sentences."""
    lines = []
    for method, what in (("rollout", "With MuJoCo itself as the rollout (`rollout`)"), ("each_tick", "With MuJoCo in each tick (`each_tick`)"),
                         ("local", "With `local`")):
        of = {rate: Rate(found, rate) for rate in RATES}
        of = {rate: one for rate, one in of.items() if one.of(method)}
        if not of:
            continue
        means = " / ".join(f"{one.mean_and_worst(method, 'hold', RMS)[0]:.2f}" for one in of.values())
        worst = " / ".join(one.mean_and_worst(method, "hold", RMS)[1] for one in of.values())
        floor = " / ".join(f"{one.mean_and_worst(method, 'floor', RMS)[0]:.2f}" for one in of.values())
        us = " / ".join(f"{one.times(method, 'method_us_per_tick')[0]:.3g}" for one in of.values())
        lines.append(page.wrapped(f"- {what} the RMS error is {means} of that of a held force at {' / '.join(map(str, of))} results a "
                                  f"second, in the mean of the scenes. The worst scene has {worst}. That is {floor} times the error of `floor`, in the mean. The "
                                  f"method takes {us} us a tick.", "  "))
    return "\n".join(lines)


def refused_list(refused):
    """The methods that cannot be laid over a scene, with the reason, as a list."""
    if not refused:
        return "Every method can be laid over every scene."
    return "\n".join(page.wrapped(f"- `{method}` over `{scene}`: {why}", "  ") for (scene, method), why in refused.items())


def live_run(scene, method, seed):
    """summary.json of a live run of a scene's duration; a result of physics takes at least as long as the graph says."""
    out = OUT / "live"
    subprocess.run([TACTOR, "run", scene, "--over", method_file(method), "--set", "clock=real", "--set", "live.impose_cost=true", "--seed", str(seed),
                    "--overwrite", "--out", out], check=True, stdout=subprocess.DEVNULL)
    return json.loads((out / "summary.json").read_text())


def live(seconds, refused, names=None):
    """{scene: {method: [summaries]}}. Runs of the methods take turns with those of the control."""
    found = {}
    for scene, file in (names or scenes()).items():
        methods = [method for method in LIVE if (scene, method) not in refused]
        found[scene] = {method: [] for method in methods}
        while sum(run["duration_s"] for run in found[scene]["hold"]) < seconds - 1e-3:
            for method in methods:
                found[scene][method].append(live_run(file, method, FIRST_SEED + len(found[scene][method])))
    return found


LIVE_HEAD = ["scene", "method", "s", "ticks", "missed", "control missed", "allocations in the loop", "a tick of the device, p99, us", "worst run",
             "re-simulation, p50, us", "p99, worst run", "p99 / period of physics", "RMS error, N", "worst run", "physics, Hz"]


def total(runs, name):
    """The sum over the runs of a number of the device; nothing where none tells it."""
    told = [run["device"][name] for run in runs if name in run["device"]]
    return sum(told) if told else None


def mean_and_max(values):
    values = [value for value in values if value is not None]
    return [statistics.fmean(values), max(values)] if values else [None, None]


def live_rows(found):
    for scene, methods in found.items():
        for method, runs in methods.items():
            rate = statistics.median(run["physics"]["rate_hz_median"] for run in runs)
            again = [run["cost_us"]["resimulation"] for run in runs if "resimulation" in run["cost_us"]]
            p50, p99 = (statistics.median(one["median"] for one in again), max(one["p99"] for one in again)) if again else (None, None)
            yield [scene, f"`{method}`", sum(run["duration_s"] for run in runs), total(runs, "ticks"), total(runs, "missed"),
                   total(methods["hold"], "missed"), total(runs, "allocations"), *mean_and_max(run["device"]["body_us"]["p99"] for run in runs),
                   p50, p99, None if p99 is None else 1e-6 * p99 * rate,
                   *mean_and_max(run.get("delivered", {}).get("force", {}).get("rms_error_N") for run in runs), rate]


COUPLING_HEAD = ["tool", "degrees of freedom", "step, ms", "h² k/m + 2 h b/m", "rows: RMS error, N", "worst, N", "a step, p50, us", "p99, us",
                 "held force: RMS error, N", "worst, N", "a step, p50, us", "p99, us", "MuJoCo reset the scene", "held force"]


def behaviour(one, force_rms):
    """Whether a run stayed near the truth."""
    error_ = one["rms_error_N"]
    if one["resets"] or error_ is None:
        return "unstable: reset"
    return "stable" if error_ < force_rms else "unstable: the error exceeds the force"


def coupling_rows(cases):
    """Of what coupling_bench tells."""
    for case in cases:
        for step in case["steps"]:
            rows, held = step["rows"], step["held"]
            yield [f"{case['scene']}, {1e3 * case['mass_kg']:g} g", case["degrees"], 1e3 * step["step_s"], step["bound"],
                   *(rows[name] for name in ("rms_error_N", "max_error_N", "step_p50_us", "step_p99_us")),
                   *(held[name] for name in ("rms_error_N", "max_error_N", "step_p50_us", "step_p99_us")), held["resets"],
                   behaviour(held, case["truth_rms_N"])]


def coupling_truth(cases):
    """How far the two couplings are apart at the step of the truth, and how the rows behave, as a list."""
    lines = []
    for case in cases:
        rms = case["truth_rms_N"]
        is_stable = all(behaviour(step["rows"], rms) == "stable" for step in case["steps"])
        lines.append(page.wrapped(f"- {case['scene']}: {case['rows_at_truth_step']['rms_error_N']:.2g} N RMS apart, of a force of {rms:.3g} N. The rows are "
                                  f"{'stable' if is_stable else '**not** stable'} at every step tried.", "  "))
    return "\n".join(lines)


def program_json(name, *options):
    """What a benchmark of ours prints."""
    program = next(path for path in BUILD.rglob(name) if path.is_file())
    return json.loads(subprocess.run([program, *options], check=True, stdout=subprocess.PIPE, text=True).stdout)


BRIDGE_HEAD = ["from a result of physics to the force segment", "results", "p50, us", "p99, us", "worst, us"]


def bridge_rows(found):
    for row in found:
        yield [row["row"], row["count"], row["p50_us"], row["p99_us"], row["max_us"]]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--live", type=float, default=0, help="s of each scene and method")
    arguments = parser.parse_args()
    found, refused = measured(arguments.seeds, arguments.jobs)
    print(virtual_tables(found), refused_list(refused), sep="\n")
    if arguments.live > 0:
        print(table(LIVE_HEAD, live_rows(live(arguments.live, refused))), end="")


if __name__ == "__main__":
    main()
