#!/usr/bin/env python3
"""The line to an emulated USB device at 1 kHz: what its thread takes of a core, and how old samples are.

    bench/usb.py [polhem | falcon] [--seconds 30] [--load] [--out usb.json]

The emulated device is a thread of the same process and is not counted; without hardware there is no interrupt of a host
controller to count either. `--load` keeps every core busy with stress-ng beside it.
"""
import argparse
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
BIN = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release")) / "bin"
MOST_OF_A_CORE = 0.05
OPTIONS = {"polhem": [], "falcon": ["--firmware"]}  # of the emulator


def line_thread(parent):
    """The schedstat file of the thread `link-device` of a program started by `parent`, once it is there."""
    children = pathlib.Path(f"/proc/{parent}/task/{parent}/children").read_text().split()
    for child in children:
        for task in pathlib.Path(f"/proc/{child}/task").iterdir():
            try:
                if (task / "comm").read_text().strip() == "link-device":
                    return task / "schedstat"
            except OSError:
                pass
    return None


def cpu_seconds(stat):
    """Counted by the scheduler in ns: `stat` counts clock ticks, in step with which a thread of 1 kHz may run or not."""
    return 1e-9 * int(stat.read_text().split()[0])


def measure(device, seconds, out):
    process = subprocess.Popen([BIN / "tactor-emulate-usb", device, *OPTIONS[device], "--", BIN / "tactor", "run",
                                ROOT / f"graphs/duck/{device}.yaml", "--duration", str(seconds + 4), "--set",
                                "live.on_stall=recover", "--set", "device.failure_timeout=10 s", "--overwrite", "--out", out],
                               stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    stat = None
    while stat is None and process.poll() is None:
        time.sleep(0.05)
        stat = line_thread(process.pid)
    if stat is None:
        sys.exit(f"the run has not begun: {process.stderr.read()}")
    time.sleep(1)
    begin, cpu = time.monotonic(), cpu_seconds(stat)
    time.sleep(seconds)
    share = (cpu_seconds(stat) - cpu) / (time.monotonic() - begin)
    if process.wait() != 0:
        sys.exit(process.stderr.read())
    link = json.loads((pathlib.Path(out) / "summary.json").read_text())["device"]["link"]
    # A cycle is due every millisecond while the line is open.
    return {"share_of_a_core": share, "cycles_per_s": 1000 * link["cycles"] / (link["cycles"] + link["skipped"]),
            "skipped": link["skipped"], "timeouts": link["errors"]["timeout"],
            **{f"{name}_us.{part}": value for name in ("age", "cycle") for part, value in link[f"{name}_us"].items()}}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("device", nargs="?", choices=OPTIONS, default="polhem")
    parser.add_argument("--seconds", type=float, default=30)
    parser.add_argument("--load", action="store_true", help="every core busy beside it")
    parser.add_argument("--out", type=pathlib.Path)
    options = parser.parse_args()
    load = None
    if options.load:
        if shutil.which("stress-ng") is None:
            sys.exit("--load needs stress-ng (Debian package stress-ng)")
        load = subprocess.Popen(["stress-ng", "--cpu", "0", "--quiet"])
    try:
        with tempfile.TemporaryDirectory() as folder:
            result = measure(options.device, options.seconds, folder)
    finally:
        if load is not None:
            load.terminate()
            load.wait()
    for name, value in result.items():
        print(f"{name:20} {value:10.4g}")
    if options.out:
        options.out.write_text(json.dumps(result, indent=1) + "\n")
    good = result["share_of_a_core"] < MOST_OF_A_CORE
    print(f"the line's thread takes {100 * result['share_of_a_core']:.2f} % of a core, the goal is below 5 %: "
          f"{'kept' if good else 'MISSED'}")
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
