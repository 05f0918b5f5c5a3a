#!/usr/bin/python3
"""The device's loop in live runs whose physics deforms a liver, beside rigid physics with the same load and without, as a Markdown table.

`bench/soft_live.py [--minutes 3] [--slice 20]`, with a built release preset and the privilege for SCHED_FIFO. Runs graphs/liver/live.yaml
in slices that alternate with two of graphs/duck/live.yaml: one with nothing beside it, and one beside a program that multiplies matrices
for as much time as makes up for what the liver's run takes more. All have the same method, the local rollout in the loop. The histograms
of the slices are put together before a percentile is taken. Keep the machine free of anything else; the table tells what else ran.
"""
import argparse
import collections
import contextlib
import multiprocessing
import os
import pathlib
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import live  # noqa: E402
from run_time import table  # noqa: E402

LIVER = ROOT / "graphs/liver/live.yaml"
DUCK = ROOT / "graphs/duck/live.yaml"
PATH = ROOT / "graphs/trajectories/duck_1.csv"
METHOD = ROOT / "graphs/methods/local.yaml"
TITLES = {"idle": "rigid, nothing beside it", "loaded": "rigid, the same CPU time beside it", "soft": "deformable"}
TURN_S = 0.02  # in which the other program computes for its share, and then sleeps


def multiply_matrices(share):
    """Multiplies matrices for this share of a core until it is ended, as the factors of physics do mostly."""
    import numpy
    a = numpy.full((160, 160), 1.0 / 160)
    while True:
        begin, used = time.monotonic(), time.process_time()
        while time.process_time() - used < share * TURN_S:
            a = a @ a  # stays as it is
        time.sleep(max(0.0, begin + TURN_S - time.monotonic()))


@contextlib.contextmanager
def other_program(share):
    """A program of SCHED_OTHER on any core; more than a core is two programs."""
    os.environ["OPENBLAS_NUM_THREADS"] = "1"
    parts = [min(1.0, share - k) for k in range(int(share) + 1) if share - k > 0.01]
    programs = [multiprocessing.get_context("spawn").Process(target=multiply_matrices, args=(part,), daemon=True) for part in parts]
    for program in programs:
        program.start()
    time.sleep(1 if programs else 0)
    try:
        yield
        if any(not program.is_alive() for program in programs):
            raise RuntimeError("the other program ended before the measurement did")
    finally:
        for program in programs:
            program.terminate()
            program.join()


def run_slice(arguments, seconds, folder):
    """One live run: its summary, its histograms by name, and how many cores other programs used meanwhile."""
    summary, histograms, busy = live.live_run(arguments, seconds, folder)
    return summary, histograms, os.cpu_count() * busy - cpu_share(summary)


def cpu_share(summary):
    return summary["cpu_s"] / summary["duration_s"]


def row(title, slices, share):
    summaries = [s for s, _, _ in slices]
    wake = live.quantiles(live.merged(h["device.wakeup"] for _, h, _ in slices), max(s["device"]["wakeup_us"]["max"] for s in summaries))
    body = live.quantiles(live.merged(h["device.body"] for _, h, _ in slices), max(s["device"]["body_us"]["max"] for s in summaries))

    def total(name):
        return sum(s["device"].get(name, 0) for s in summaries)

    def mean(values):
        return sum(values) / len(slices)
    return [title, wake["p50"], wake["p99"], round(wake["max"]), f"{total('missed')} of {total('ticks')}", body["p50"], body["p99"],
            total("allocations"), total("page_faults"), mean(s["physics"]["rate_hz_median"] for s in summaries),
            mean(cpu_share(s) for s in summaries), share, mean(other for _, _, other in slices) - share]


HEAD = ["physics", "wake-up p50, us", "p99, us", "worst, us", "ticks missed", "tick p50, us", "p99, us", "allocations", "page faults",
        "results a second", "cores used by the run", "by the other program", "by anything else"]


def measured(minutes, slice_s):
    """A Markdown table with a row for each kind of run, each of that many minutes."""
    slices = collections.defaultdict(list)
    shares = []
    with tempfile.TemporaryDirectory() as name, live.no_deep_sleep():
        folder = pathlib.Path(name)
        path = folder / "path.csv"
        live.write_path(path, slice_s, PATH)
        said = ("rollout.lane=realtime", "rollout.priority=78", "local.cost=none", f"trajectory.file={path}")  # as the liver has it
        rigid = [DUCK, "--over", METHOD, *(word for text in said for word in ("--set", text))]
        for n in range(max(1, round(60 * minutes / slice_s))):
            slices["idle"].append(run_slice(rigid, slice_s, folder))
            slices["soft"].append(run_slice([LIVER], slice_s, folder))
            shares.append(max(0.0, cpu_share(slices["soft"][-1][0]) - cpu_share(slices["idle"][-1][0])))
            with other_program(shares[-1]):
                slices["loaded"].append(run_slice(rigid, slice_s, folder))
            print(f"slice {n + 1}: " + ", ".join(
                f"{kind} p99 {of[-1][0]['device']['wakeup_us']['p99']:.0f} us, missed {of[-1][0]['device']['missed']}"
                for kind, of in slices.items()), file=sys.stderr, flush=True)
    missing = {text for of in slices.values() for s, _, _ in of for text in s.get("missing_privileges", [])}
    if missing:
        print("not comparable, a privilege is missing: " + "; ".join(sorted(missing)), file=sys.stderr)
    share = {"loaded": sum(shares) / len(shares)}
    return table(HEAD, [row(title, slices[kind], share.get(kind, 0.0)) for kind, title in TITLES.items()])


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=3, help="of each kind of run")
    parser.add_argument("--slice", type=float, default=20, help="length of a slice, s")
    options = parser.parse_args()
    if not 2 <= min(options.slice, 60 * options.minutes):
        parser.error("slices of 2 s at least, and minutes for one of them")
    if not live.TACTOR.exists():
        sys.exit("build first: scripts/build")
    print(measured(options.minutes, options.slice))


if __name__ == "__main__":
    main()
