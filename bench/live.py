#!/usr/bin/python3
"""The live system beside cyclictest: wake-ups of the device loop, age of the force, allocations, drops and CPU.

`bench/live.py [--minutes 10] [--slice 60] [--load busy|idle|both] [--out FILE.json]`, with a built release preset, cyclictest and the
privilege for SCHED_FIFO. Runs graphs/bunny/refit.yaml live, in slices that alternate with slices of cyclictest on the same core, until
each has had its minutes; once with every core busy with other work, once without. The histograms of the slices are put together
before a percentile is taken. Keep the machine free of anything else.
"""
import argparse
import collections
import contextlib
import csv
import datetime
import json
import os
import pathlib
import shutil
import signal
import statistics
import struct
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
TACTOR = ROOT / "build/release/bin/tactor"
GRAPH = ROOT / "graphs/bunny/refit.yaml"
PATH = ROOT / "graphs/trajectories/bunny.csv"
CORE = os.cpu_count() - 1  # where the device loop goes by default
LONGEST_TRACKED_US = 20000
PERIOD_US = 1000
LATE_US = 1000
QUANTILES = {"p50": 0.5, "p99": 0.99, "p99_9": 0.999, "p99_99": 0.9999}

GOAL_RATIO_P99 = 1.2
GOAL_AGE_BEYOND_PERIOD_US = 1500


def quantiles(counts, longest):
    """Nearest-rank quantiles of {us: count}; `longest` is the maximum, exactly."""
    total = sum(counts.values())
    result = {}
    for name, q in QUANTILES.items():
        seen = 0
        for us in sorted(counts):
            seen += counts[us]
            if seen >= q * total:
                result[name] = min(us, longest)
                break
    return result | {"max": longest, "count": total}


def merged(histograms):
    total = collections.Counter()
    for h in histograms:
        total.update(h)
    return total


def skipped(counts):
    """How many deadlines wake-ups of these latencies run past."""
    return sum(n * int(us // PERIOD_US) for us, n in counts.items() if us >= LATE_US)


def parse_cyclictest(text):
    """One slice of cyclictest: its histogram by the middle of each microsecond, and the longest latency."""
    counts, longest, beyond = {}, 0.0, 0
    for line in text.splitlines():
        words = line.split()
        if line.startswith("# Max Latencies:"):
            longest = float(words[-1])
        elif line.startswith("# Histogram Overflows:"):
            beyond = int(words[-1])
        elif len(words) == 2 and line[0].isdigit() and int(words[1]) > 0:
            counts[int(words[0]) + 0.5] = int(words[1])
    if not counts:
        raise ValueError("expected the histogram of cyclictest, found:\n" + text)
    if beyond:
        counts[max(longest, LONGEST_TRACKED_US)] = beyond
    return counts, longest


def cyclictest(seconds):
    said = subprocess.run(["cyclictest", "-m", "-p", "80", "-t", "1", "-a", str(CORE), "-i", str(PERIOD_US), "-l",
                           str(int(seconds * 1e6 / PERIOD_US)), "-q", "-h", str(LONGEST_TRACKED_US)],
                          check=True, capture_output=True, text=True)
    return parse_cyclictest(said.stdout)


def write_path(file, seconds, path=PATH):
    """The hand's path back and forth for as long as the slice."""
    with open(path, newline="") as source:
        head, *rows = list(csv.reader(source))
    rows = [[float(cell) for cell in row] for row in rows]
    end = rows[-1][0]
    with open(file, "w", newline="") as out:
        writer = csv.writer(out)
        writer.writerow(head)
        begin, there = 0.0, True
        while begin < seconds + 1:
            leg = rows if there else [[end - row[0], *row[1:]] for row in reversed(rows)]
            writer.writerows([begin + row[0], *row[1:]] for row in (leg if begin == 0 else leg[1:]))
            begin, there = begin + end, not there


def live_run(arguments, seconds, folder):
    """A slice of a live run: its summary, its histograms by name, and the share of the cores that was in use meanwhile."""
    out = folder / "run"
    # Longer than the slice and then asked to end: a run that ended by itself would be compared with a reference run.
    process = subprocess.Popen([TACTOR, "run", *arguments, "--duration", str(seconds + 3600), "--overwrite", "--out", out],
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    # The meshes are loaded before the loop begins, so the slice begins when the thread of the device is there.
    while process.poll() is None and not has_thread(process.pid, "device"):
        time.sleep(0.01)

    def slice_or_end(seconds):
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(seconds)
    busy = busy_share(seconds, slice_or_end)
    process.send_signal(signal.SIGINT)
    error = process.communicate(timeout=60)[1]
    if process.returncode != 0:
        raise RuntimeError(f"tactor ended with {process.returncode}: {error}")
    histograms = collections.defaultdict(dict)
    with open(out / "latencies.csv", newline="") as file:
        for row in csv.DictReader(file):
            histograms[row["latency"]][float(row["us"])] = int(row["count"])
    return json.loads((out / "summary.json").read_text()), histograms, busy


def live_slice(seconds, folder):
    """One slice of the live run: its summary and its histograms by name."""
    path = folder / "path.csv"
    write_path(path, seconds)
    summary, histograms, _ = live_run([GRAPH, "--set", "clock=real", "--set", f"trajectory.file={path}"], seconds, folder)
    return summary, histograms


def has_thread(pid, name):
    with contextlib.suppress(OSError):
        return any((task / "comm").read_text().strip() == name for task in pathlib.Path(f"/proc/{pid}/task").iterdir())
    return False


@contextlib.contextmanager
def other_work(busy):
    """Every core busy with computing, or nothing."""
    if not busy:
        yield
        return
    cores = os.cpu_count()
    if shutil.which("stress-ng"):
        commands = [["stress-ng", "--cpu", str(cores), "--quiet"]]
    else:
        commands = [[sys.executable, "-c", "while True: pass"]] * cores
    workers = [subprocess.Popen(c, start_new_session=True) for c in commands]
    time.sleep(0.5)
    try:
        yield
        if any(w.poll() is not None for w in workers):
            raise RuntimeError("the other work ended before the measurement did")
    finally:
        for w in workers:
            with contextlib.suppress(ProcessLookupError):
                os.killpg(w.pid, signal.SIGTERM)
            w.wait()


def cpu_times():
    """(all, idle) of the cores together since the machine began, in ticks."""
    with open("/proc/stat") as file:
        times = [int(word) for word in file.readline().split()[1:9]]
    return sum(times), times[3] + times[4]


def busy_share(seconds, wait=time.sleep):
    """The share of the cores that is in use, in the next seconds; or until `wait(seconds)` returns."""
    everything, idle = cpu_times()
    wait(seconds)
    later, idle_later = cpu_times()
    return 1 - (idle_later - idle) / max(1, later - everything)


@contextlib.contextmanager
def no_deep_sleep():
    """Keeps the cores out of deep idle states for both: cyclictest asks for it by itself, the live system does not."""
    try:
        with open("/dev/cpu_dma_latency", "wb", buffering=0) as file:
            file.write(struct.pack("i", 0))
            yield True
    except OSError:
        yield False


def machine():
    """Where and when this is measured."""
    model = next((line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")), "?")
    virtual = subprocess.run(["systemd-detect-virt"], capture_output=True, text=True).stdout.strip() \
        if shutil.which("systemd-detect-virt") else ""
    if not virtual and "hypervisor" in pathlib.Path("/proc/cpuinfo").read_text():
        virtual = "hypervisor"
    kernel = os.uname()
    return {"model": model, "cores": os.cpu_count(), "kernel": kernel.release,
            "realtime_kernel": "PREEMPT_RT" in kernel.version, "virtual": virtual not in ("", "none"),
            "date": datetime.date.today().isoformat()}


def measure(busy, seconds, slice_s):
    """One condition: alternating slices, then the metrics."""
    reference, ours = [], []
    with tempfile.TemporaryDirectory() as folder, other_work(busy):
        for n in range(max(1, round(seconds / slice_s))):
            reference.append(cyclictest(slice_s))
            ours.append(live_slice(slice_s, pathlib.Path(folder)))
            print(f"  slice {n + 1}: cyclictest p99 {quantiles(*reference[-1])['p99']:.0f} us, tactor p99 "
                  f"{ours[-1][0]['device']['wakeup_us']['p99']:.0f} us, missed {ours[-1][0]['device']['missed']}",
                  file=sys.stderr, flush=True)
    return metrics(reference, ours)


def metrics(reference, ours):
    summaries = [s for s, _ in ours]
    missing = {text for s in summaries for text in s.get("missing_privileges", [])}
    if missing:
        print("not comparable, a privilege is missing: " + "; ".join(sorted(missing)), file=sys.stderr)

    def together(name, longest):
        return quantiles(merged(h[name] for _, h in ours), longest)

    def total(name):
        return sum(s["device"][name] for s in summaries) if all(name in s["device"] for s in summaries) else None

    edge = "interpolation.segment -> device.segment"
    wake = together("device.wakeup", max(s["device"]["wakeup_us"]["max"] for s in summaries))
    theirs = quantiles(merged(h for h, _ in reference), max(longest for _, longest in reference))
    # What the host did to cyclictest in the slices around it, it is taken to have done to ours.
    missed = [s["device"]["missed"] for s in summaries]
    around = [statistics.mean(skipped(reference[i][0]) for i in (n, n + 1) if i < len(reference))
              for n in range(len(ours))]
    period_us = 1e6 / statistics.median(s["physics"]["rate_hz_median"] for s in summaries)
    age = together(edge, max(s["edges"][edge]["age_us"]["max"] for s in summaries))
    duration = sum(s["duration_s"] for s in summaries)
    return {
        "slices": len(ours),
        "duration_s": duration,
        "missing_privileges": sorted(missing),
        "ticks": total("ticks"),
        "missed": sum(missed),
        "missed_as_cyclictest": sum(min(a, b) for a, b in zip(missed, around)),
        "cyclictest_late": skipped(merged(h for h, _ in reference)),
        "wakeup_us": wake,
        "cyclictest_us": theirs,
        "ratio_p99": wake["p99"] / theirs["p99"],
        "slices_p99_us": {"tactor": [s["device"]["wakeup_us"]["p99"] for s in summaries],
                          "cyclictest": [quantiles(*r)["p99"] for r in reference]},
        "body_us": together("device.body", max(s["device"]["body_us"]["max"] for s in summaries)),
        "allocations": total("allocations"),
        "page_faults": total("page_faults"),
        "dropped": total("dropped"),
        "force_age_us": age,
        "physics_period_us": period_us,
        "force_age_goal_us": period_us + GOAL_AGE_BEYOND_PERIOD_US,
        "end_to_end_us": together("device.end_to_end", max(s["end_to_end_us"]["max"] for s in summaries)),
        "edge_drops": {name: sum(s["edges"][name]["drops"] for s in summaries) for name in summaries[0]["edges"]},
        "cpu_ms_per_s": 1e3 * sum(s["cpu_s"] for s in summaries) / duration,
    }


def lines(f):
    """The metrics as rows of a table: what, tactor, cyclictest, remark."""
    def verdict(good):
        return "met" if good else "NOT MET"

    yield ["ticks", f["ticks"], f["cyclictest_us"]["count"], ""]
    yield ["missed ticks", f["missed"], f["cyclictest_late"],
           f"{f['missed_as_cyclictest']:g} of {f['missed']} as cyclictest around"]
    for q in (*QUANTILES, "max"):
        yield [f"wake-up {q.replace('_', '.')}, us", f["wakeup_us"][q], f["cyclictest_us"][q],
               f"ratio {f['ratio_p99']:.2f}, goal {GOAL_RATIO_P99}: {verdict(f['ratio_p99'] <= GOAL_RATIO_P99)}"
               if q == "p99" else ""]
    for q in ("p50", "p99", "max"):
        yield [f"tick {q}, us", f["body_us"][q], "", ""]
    for name in ("allocations", "page_faults"):
        yield [f"{name.replace('_', ' ')} in the loop", "-" if f[name] is None else f[name], "",
               f"goal 0: {verdict(f[name] == 0)}"]
    for q in ("p50", "p99", "max"):
        yield [f"age of the force {q}, ms", f["force_age_us"][q] / 1e3, "",
               f"goal {f['force_age_goal_us'] / 1e3:.2f}, a physics period + 1.5: "
               f"{verdict(f['force_age_us']['p99'] < f['force_age_goal_us'])}" if q == "p99" else ""]
    for q in ("p50", "p99", "max"):
        yield [f"sample to force {q}, ms", f["end_to_end_us"][q] / 1e3, "", ""]
    yield ["messages dropped on edges", sum(f["edge_drops"].values()), "",
           ", ".join(f"{n}: {d}" for n, d in f["edge_drops"].items() if d)]
    yield ["messages dropped out of the loop", f["dropped"], "", ""]
    yield ["CPU, ms a s", f["cpu_ms_per_s"], "", ""]


def table(f):
    def cell(value):
        return f"{value:.2f}" if isinstance(value, float) else str(value)
    rows = [["", "tactor", "cyclictest", ""], *([cell(c) for c in row] for row in lines(f))]
    return "\n".join(f"  {a:<34}{b:>12}{c:>12}  {d}".rstrip() for a, b, c, d in rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--minutes", type=float, default=10, help="of each of the two, in each condition")
    parser.add_argument("--slice", type=float, default=60, help="length of a slice, s")
    parser.add_argument("--load", choices=("busy", "idle", "both"), default="both")
    parser.add_argument("--out", type=pathlib.Path)
    options = parser.parse_args()
    seconds = 60 * options.minutes
    if not 2 <= min(options.slice, seconds):
        parser.error("slices of 2 s at least, and minutes for one of them")
    if not TACTOR.exists():
        sys.exit("build first: scripts/build")
    if not shutil.which("cyclictest"):
        sys.exit("cyclictest is not installed: apt install rt-tests")
    result = {"graph": GRAPH.stem, "machine": machine(), "core": CORE, "slice_s": min(options.slice, seconds), "conditions": {}}
    result["busy_before"] = busy_share(3)
    if result["busy_before"] > 0.05:
        print(f"{100 * result['busy_before']:.0f} % of the cores are in use by something else: these metrics will tell of it too",
              file=sys.stderr, flush=True)
    with no_deep_sleep() as held:
        result["deep_sleep_off"] = held
        for condition in ("busy", "idle") if options.load == "both" else (options.load,):
            print(f"{condition}: {options.minutes:g} minutes of each", file=sys.stderr, flush=True)
            result["conditions"][condition] = measure(condition == "busy", seconds, min(options.slice, seconds))
            print(f"\n{condition}\n{table(result['conditions'][condition])}\n", flush=True)
    if options.out:
        options.out.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
