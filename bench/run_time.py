#!/usr/bin/python3
"""Run time, memory and error of whole runs, as a Markdown table: median of some repeats, and the spread of the CPU time.

`bench/run_time.py [--repeats N]`, with a built release preset. Reference runs are not counted; they come from the cache.
"""
import argparse
import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "graphs"))
from shipped import graph_file  # noqa: E402

TACTOR = ROOT / "build/release/bin/tactor"
GRAPHS = ("duck_1_refit", "peg_free_refit", "peg_in_hole_refit", "bunny_off", "bunny_refit")


def summary(graph, out):
    subprocess.run([TACTOR, "run", graph_file(graph), "--overwrite", "--out", out], check=True,
                   stdout=subprocess.DEVNULL)
    return json.loads((pathlib.Path(out) / "summary.json").read_text())


def rows(repeats):
    """One row a graph. The first run warms up and makes the reference."""
    for graph in GRAPHS:
        with tempfile.TemporaryDirectory() as out:
            summary(graph, out)
            runs = [summary(graph, out) for _ in range(repeats)]
        cpu = sorted(r["cpu_s"] for r in runs)
        wall = statistics.median(r["wall_s"] for r in runs)
        last = runs[-1]
        yield [graph, last["duration_s"], statistics.median(cpu), f"{cpu[0]:.3g} to {cpu[-1]:.3g}",
               last["duration_s"] / wall, last["peak_memory_MB"], last["contacts"]["median"],
               last["physics"]["rate_hz_median"], last["delivered"]["force"]["rms_error_N"]]


HEAD = ["graph", "virtual time, s", "CPU, s", "spread", "times real time", "peak memory, MB", "contacts", "physics, Hz",
        "RMS error, N"]


def table(head, body):
    def cell(value):
        return value if isinstance(value, str) else str(value) if isinstance(value, int) else f"{value:.3g}"

    lines = ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)]
    lines += ["| " + " | ".join("-" if c is None else cell(c) for c in row) + " |" for row in body]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repeats", type=int, default=5)
    print(table(HEAD, rows(parser.parse_args().repeats)), end="")
