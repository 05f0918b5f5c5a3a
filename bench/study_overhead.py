#!/usr/bin/python3
"""What a study costs beside its runs: the share of its CPU time that is spent inside them, and how many cores are busy.

`bench/study_overhead.py [--runs N] [--duration S] [--jobs N]`, with a built release preset (or TACTOR). Runs a study of the wall with
so many seeds and prints a table. Inside a run: making its nodes, stepping them, judging them, and reference runs. Beside: planning,
the table on disk, the fixed computation that shows the machine's noise, reports.
"""
import argparse
import json
import os
import pathlib
import resource
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from run_time import table  # noqa: E402

TACTOR = os.environ.get("TACTOR", ROOT / "build/release/bin/tactor")


def measure(runs, duration, jobs):
    """The metrics of one study, from its engine and from the operating system."""
    with tempfile.TemporaryDirectory() as folder:
        study = pathlib.Path(folder) / "overhead.yaml"
        methods = [str(ROOT / f"graphs/methods/{m}.yaml") for m in ("hold", "kalman")]
        study.write_text(json.dumps({"graphs": [str(ROOT / "graphs/wall/scene.yaml")], "methods": methods, "seeds": runs // len(methods),
                                     "duration": f"{duration} s"}))
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        begin = time.monotonic()
        subprocess.run([TACTOR, "study", study, "--jobs", str(jobs), "--out", pathlib.Path(folder) / "out"], check=True,
                       stdout=subprocess.DEVNULL, env=dict(os.environ, TACTOR_CACHE=str(pathlib.Path(folder) / "cache")))
        wall = time.monotonic() - begin
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        engine = json.loads((pathlib.Path(folder) / "out" / "study.json").read_text())["runner"]
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return engine | {"process_cpu_s": cpu, "process_wall_s": wall}


def shares(found):
    """Shares of the engine's CPU time that are spent inside runs: with reference runs, and of what is left without them."""
    inside = found["run_cpu_s"] + found["reference_cpu_s"]
    return inside / found["total_cpu_s"], found["run_cpu_s"] / (found["total_cpu_s"] - found["reference_cpu_s"])


def rows(found):
    inside = found["run_cpu_s"] + found["reference_cpu_s"]
    share, share_without = shares(found)
    yield ["runs", found["runs"]]
    yield ["CPU s inside runs", found["run_cpu_s"]]
    yield ["CPU s inside reference runs", found["reference_cpu_s"]]
    yield ["CPU s of the engine", found["total_cpu_s"]]
    yield ["CPU s of the process, reports included", found["process_cpu_s"]]
    yield ["share of the engine's CPU inside runs, %", 100 * share]
    yield ["the same without reference runs, %", 100 * share_without]
    yield ["share of the process' CPU inside runs, %", 100 * inside / found["process_cpu_s"]]
    yield ["cores busy while running", found["total_cpu_s"] / found["wall_s"]]
    yield ["cores busy or asked for, which other programs had", (found["total_cpu_s"] + found["waited_for_core_s"]) / found["wall_s"]]


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--duration", type=float, default=2.0, help="simulated seconds of a run")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    arguments = parser.parse_args()
    print(table(["", ""], rows(measure(arguments.runs, arguments.duration, arguments.jobs))), end="")
