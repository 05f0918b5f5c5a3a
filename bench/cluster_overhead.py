#!/usr/bin/python3
"""What a study on a cluster costs beside its runs: for each task, for each run, for the plan and for the merge.

`bench/cluster_overhead.py [--rows N] [--manifest N] [--slurm S]`, with a built release preset (or TACTOR). The tasks run as
processes of this machine, one at a time. What a scheduler takes for a task is --slurm, as measured with a Slurm of its own
(scripts/cluster_faults prints it).
"""
import argparse
import heapq
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from run_time import table  # noqa: E402

TACTOR = os.environ.get("TACTOR", ROOT / "build/release/bin/tactor")
CHUNK_S = 120  # the default of --chunk
# A cluster that takes every job and runs none.
IDLE = """submit: [echo, "1", "{script}"]
status: ["true"]
cancel: ["true"]
index: INDEX
states: {waiting: [Q], running: [R]}
"""


def write_study(folder, name, methods=("hold",), **keys):
    file = folder / f"{name}.yaml"
    file.write_text(json.dumps({"graphs": [str(ROOT / "graphs/wall/scene.yaml")],
                                "methods": [str(ROOT / f"graphs/methods/{m}.yaml") for m in methods],
                                "reference": "none", "judge": "whole", **keys}))
    return file


def call(folder, *words):
    """Seconds, and the largest memory of a process in MB, of a command."""
    environment = dict(os.environ, TACTOR_CACHE=str(folder / "cache"))
    begin = time.monotonic()
    process = subprocess.Popen([TACTOR, *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
    _, status, used = os.wait4(process.pid, 0)
    if os.waitstatus_to_exitcode(status) != 0:
        raise RuntimeError(f"tactor {' '.join(map(str, words))} ended with {os.waitstatus_to_exitcode(status)}")
    return time.monotonic() - begin, used.ru_maxrss / 1024


def runner(out):
    return json.loads((out / "study.json").read_text())["runner"]


def task_costs(folder, duration, seeds):
    """CPU seconds that a task takes beside its runs: for itself and for each run, by the same runs in two cuts."""
    study = write_study(folder, f"tasks_{duration}", seeds=seeds, duration=f"{duration} s")
    found = {}
    for name, chunk in (("many", "0.5 s"), ("few", "1000 s")):
        out = folder / f"out_{duration}_{name}"
        call(folder, "study", study, "--out", out, "--cluster", "local", "--jobs", "1", "--chunk", chunk, "--wait")
        found[name] = runner(out)
    # By CPU time, since other programs may have the cores meanwhile.
    beside = {name: 3600 * one["cpu_hours"] - one["run_cpu_s"] for name, one in found.items()}
    a_task = (beside["many"] - beside["few"]) / (found["many"]["tasks"] - found["few"]["tasks"])
    a_run = (beside["few"] - found["few"]["tasks"] * a_task) / seeds
    return {"run_s": found["few"]["run_cpu_s"] / seeds, "a_task_s": a_task, "a_run_s": a_run, "tasks": found["many"]["tasks"]}


def share_at_chunk(costs, scheduler_s=0.0):
    """The share of the core time of a chunk that is not spent in runs."""
    runs = CHUNK_S / costs["run_s"]
    beside = scheduler_s + costs["a_task_s"] + runs * costs["a_run_s"]
    return beside / (beside + CHUNK_S)


def simulated(runs, slots, run_s, a_task_s, scheduler_s):
    """The core time of an array on so many slots, each of which takes the next task when it is free."""
    a_chunk = max(1, int(CHUNK_S / run_s))
    chunks = [min(a_chunk, runs - begin) for begin in range(0, runs, a_chunk)]
    free = [0.0] * slots
    heapq.heapify(free)
    busy = end = 0.0
    for chunk in chunks:
        taken = scheduler_s + a_task_s + chunk * run_s
        done = heapq.heappop(free) + taken
        busy += taken
        end = max(end, done)
        heapq.heappush(free, done)
    return {"tasks": len(chunks), "share": 1 - runs * run_s / busy, "hours": end / 3600}


def merge_cost(folder, rows):
    """Seconds of the merge of so many real runs, with its report, and the size of the table."""
    study = write_study(folder, "merge", ("hold", "lowpass"), seeds=rows // 10, duration="0.05 s",
                        vary={"coupling.k_0": {"from": "200 N/m", "to": "1000 N/m", "count": 5}})
    out = folder / "out_merge"
    call(folder, "study", study, "--out", out, "--cluster", "local", "--chunk", "5 s", "--wait")
    jobs = sorted((out / "cluster/jobs").glob("*.json"))
    merge = next(int(job.stem) for job in reversed(jobs) if json.loads(job.read_text())["stage"] == "merge")
    seconds, memory = call(folder, "task", out, merge, 0)
    shards = [file.stat().st_size for file in (out / "cluster/runs").glob("*.shard")]
    return {"rows": rows, "seconds": seconds, "memory_MB": memory, "shards": len(shards), "shards_MB": sum(shards) / 1e6,
            "table_MB": (out / "study.sqlite").stat().st_size / 1e6}


def plan_cost(folder, runs, cases):
    """Seconds and memory of the command that plans, measures a few runs and submits."""
    idle = folder / "idle.yaml"
    idle.write_text(IDLE)
    study = write_study(folder, f"plan_{cases}", ("hold", "lowpass"), seeds=runs // cases, duration="5 s",
                        vary={"coupling.k_0": {"from": "200 N/m", "to": "1000 N/m", "count": cases // 2}})
    out = folder / f"out_plan_{cases}"
    seconds, memory = call(folder, "study", study, "--out", out, "--cluster", idle)
    files = sum((out / "cluster" / name).stat().st_size for name in ("plan.bin", "manifest.json"))
    return {"runs": runs, "cases": cases, "seconds": seconds, "memory_MB": memory, "files_MB": files / 1e6}


def measure(rows, manifest, scheduler_s):
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        tasks = [task_costs(folder, duration, seeds) for duration, seeds in ((5, 200), (50, 40))]
        plans = [plan_cost(folder, manifest, cases) for cases in (100, 1000)]
        merge = merge_cost(folder, rows)
    typical = tasks[-1]
    arrays = [simulated(100_000, slots, run_s, typical["a_task_s"] + CHUNK_S / run_s * typical["a_run_s"], scheduler_s)
              | {"slots": slots, "run_s": run_s} for slots in (100, 1000) for run_s in (0.1, 1.0, 10.0)]
    return {"scheduler_s": scheduler_s, "tasks": tasks, "plans": plans, "merge": merge, "arrays": arrays}


def task_table(found):
    return table(["a run takes, s", "a task beside its runs, s", "each run beside itself, ms", "of a chunk, %", "with the scheduler, %"],
                 [[t["run_s"], t["a_task_s"], 1000 * t["a_run_s"], 100 * share_at_chunk(t),
                   100 * share_at_chunk(t, found["scheduler_s"])] for t in found["tasks"]])


def array_table(found):
    return table(["cores", "a run takes, s", "tasks", "hours", "core time not in runs, %"],
                 [[a["slots"], a["run_s"], a["tasks"], a["hours"], 100 * a["share"]] for a in found["arrays"]])


def plan_table(found):
    return table(["runs", "cases", "s", "MB of memory", "MB of files"],
                 [[p["runs"], p["cases"], p["seconds"], p["memory_MB"], p["files_MB"]] for p in found["plans"]])


def merge_table(found):
    m = found["merge"]
    return table(["runs", "shards", "s, report included", "MB of memory", "MB of shards", "MB of the table"],
                 [[m["rows"], m["shards"], m["seconds"], m["memory_MB"], m["shards_MB"], m["table_MB"]]])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rows", type=int, default=100_000, help="runs of the table that is merged")
    parser.add_argument("--manifest", type=int, default=1_000_000, help="runs of the study that is planned")
    parser.add_argument("--slurm", type=float, default=0.5, help="seconds that the scheduler takes for a task")
    arguments = parser.parse_args()
    measured = measure(arguments.rows, arguments.manifest, arguments.slurm)
    for part in (task_table, array_table, plan_table, merge_table):
        print(part(measured))
