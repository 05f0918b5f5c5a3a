#!/usr/bin/python3
"""What a run costs from Python beside the same run by the command, and a tap at 1 kHz: Markdown tables.

`bench/python_overhead.py [--rounds N] [--live S]`, with a built release preset (scripts/build). Each round makes every run once, one
after the other, in an order that changes, so that a machine that slows down does so for all alike; tables have medians of the
rounds, and of each round's ratio to the command. Takes about four minutes.
"""
import argparse
import json
import os
import pathlib
import resource
import statistics
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
sys.path.insert(0, str(BUILD / "python"))
from run_time import table  # noqa: E402

TACTOR = BUILD / "bin/tactor"
# A light graph, of which Python's share would be large, and a heavy one; with seconds of the run for a measurement.
GRAPHS = {"wall/refit": 60, "bunny/refit": 13}
TAPPED = "device.commanded"
RUNS = ("command", "run", "session")
NAMES = {"command": "`tactor run`", "run": "`tactor.run`", "session": "`Session.run`, a tap at 1 kHz"}
HEAD = ["graph", "", "wall ms a second", "CPU ms a second", "wall / command", "CPU / command"]


def seconds_of(kind, graph, duration, folder):
    """(wall s, CPU s) of the run alone, without loading and without its reference run."""
    import tactor
    if kind == "command":
        out = pathlib.Path(folder) / "command"
        subprocess.run([TACTOR, "run", graph, "--duration", f"{duration} s", "--out", out, "--overwrite"], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        summary = json.loads((out / "summary.json").read_text())
        return summary["wall_s"], summary["cpu_s"]
    if kind == "run":
        summary = tactor.run(graph, duration=duration, out=pathlib.Path(folder) / "run", overwrite=True).summary
        return summary["wall_s"], summary["cpu_s"]
    with tactor.Session(graph, duration=duration) as session:
        tap = session.tap(TAPPED)
        session.start()
        wall, cpu = time.perf_counter(), time.thread_time()
        session.run()
        messages = tap.take()
        found = time.perf_counter() - wall, time.thread_time() - cpu
    # The run's end belongs to it: a message at each whole ms before it.
    if len(messages) != round(1000 * duration):
        raise RuntimeError(f"{graph}: expected {round(1000 * duration)} messages, found {len(messages)}")
    return found


def overhead(rounds, graphs=None):
    """{graph: {kind: [(wall, CPU) s a second of the run, by round]}}; a round before the first does not count."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for graph, duration in (graphs or GRAPHS).items():
            found[graph] = {kind: [] for kind in RUNS}
            for i in range(rounds + 1):
                for k in range(len(RUNS)):
                    kind = RUNS[(i + k) % len(RUNS)]
                    wall, cpu = seconds_of(kind, graph, duration, folder)
                    if i > 0:
                        found[graph][kind].append((wall / duration, cpu / duration))
    return found


def overhead_rows(found):
    """A row a graph and kind of run."""
    for graph, kinds in found.items():
        for kind, values in kinds.items():
            ratios = [statistics.median(value[i] / base[i] for value, base in zip(values, kinds["command"])) for i in (0, 1)]
            milliseconds = [1000 * statistics.median(value[i] for value in values) for i in (0, 1)]
            yield [graph, NAMES[kind], *milliseconds, *(f"{ratio:.3f}" for ratio in ratios)]


def cpu_seconds():
    """Of this process and of those that it has waited for."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


def taken(work):
    """(wall s, CPU s) of `work()`."""
    wall, cpu = time.perf_counter(), cpu_seconds()
    work()
    return time.perf_counter() - wall, cpu_seconds() - cpu


def calls(rounds, graph="wall/refit", duration=1):
    """{what: [(wall s, CPU s), by round]}: a whole call for a run of so many seconds, with its files; and an import."""
    import tactor
    found = {"command": [], "run": [], "import": []}
    environment = dict(os.environ, PYTHONPATH=str(BUILD / "python"))
    with tempfile.TemporaryDirectory() as folder:
        work = {"command": lambda: seconds_of("command", graph, duration, folder),
                "run": lambda: tactor.run(graph, duration=duration, out=pathlib.Path(folder) / "run", overwrite=True),
                "import": lambda: subprocess.run([sys.executable, "-c", "import tactor"], check=True, env=environment)}
        for i in range(rounds + 1):
            for name in sorted(work, reverse=i % 2 == 0):
                one = taken(work[name])
                if i > 0:
                    found[name].append(one)
    return found


def call_rows(found):
    names = {"command": "`tactor run`, the whole command", "run": "`tactor.run`, the call alone",
             "import": "a Python that imports tactor, numpy included"}
    for name, label in names.items():
        yield [label, *(1000 * statistics.median(one[i] for one in found[name]) for i in (0, 1))]


CALL_HEAD = ["1 s of wall/refit", "wall ms", "CPU ms, with gnuplot's"]


def tap(seconds, clock):
    """What arrives of an output at 1 kHz in so many seconds of a clock, taken at the end as one array."""
    import numpy
    import tactor
    # A busy machine may stall a thread of the pool for long, which is not what is measured.
    changes = {"clock": clock, "live": {"on_missing_privilege": "warn", "stall_timeout": "20 s"}}
    with tactor.Session("wall/refit", changes, duration=seconds) as session:
        tapped = session.tap(TAPPED)
        begin = time.perf_counter()
        session.start()
        while session.running:
            session.advance(1)
        wall = time.perf_counter() - begin
        session.finish()
        begin = time.perf_counter()
        messages = tapped.take()
        took = time.perf_counter() - begin
        lost = int(numpy.diff(messages["sequence"]).sum()) + 1 - len(messages)
        return {"clock": clock, "seconds": seconds, "wall": wall, "messages": len(messages), "lost": lost,
                "dropped": tapped.dropped + session.dropped, "take_ms": 1000 * took}


def tap_rows(found):
    for one in found:
        yield [one["clock"], one["seconds"], one["messages"], one["lost"], one["dropped"], one["wall"], one["take_ms"]]


TAP_HEAD = ["clock", "s of the run", "messages", "gaps in the sequence", "dropped", "wall s", "`take`, ms"]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--live", type=float, default=60, help="seconds of the live tap; 0: none")
    arguments = parser.parse_args()
    print(table(HEAD, overhead_rows(overhead(arguments.rounds))))
    print(table(CALL_HEAD, call_rows(calls(arguments.rounds))))
    clocks = ["virtual"] + (["real"] if arguments.live > 0 else [])
    print(table(TAP_HEAD, tap_rows([tap(arguments.live or 60, clock) for clock in clocks])), end="")


if __name__ == "__main__":
    main()
