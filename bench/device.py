#!/usr/bin/env python3
"""The device loop with a device of hardware in the graph beside the same loop with the simulated device, in alternating slices.

    bench/device.py [--seconds 20] [--rounds 3] [--load] [--out device.json]

Each slice is a live run without physics: a Modbus motor over TCP, a Polhem on the USB, both emulated, and the simulated
device. Medians over the rounds; `--load` keeps every core busy with stress-ng beside it.
"""
import argparse
import contextlib
import json
import os
import pathlib
import shutil
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
BIN = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release")) / "bin"
GRAPH = """clock: real
duration: {seconds} s
scene: {{bodies: {{}}}}
live: {{on_stall: recover, on_missing_privilege: warn}}
nodes:
  device: {device}
{rest}record: [device.safety]
"""
SIMULATED_REST = """  trajectory: {type: source.trajectory, points: [{t: 0 s, x: 0 mm}, {t: 1 s, x: 10 mm}]}
edges:
  - trajectory.target -> device.target
"""
# The emulators share a machine that is loaded on purpose: what is measured is the loop, so their lines may be late.
PATIENT = "link_timeout: 1 s, failure_timeout: 30 s, stuck_after: 0"
FIGURES = [("wakeup_us", "p50"), ("wakeup_us", "p99"), ("wakeup_us", "p99_9"), ("body_us", "p50"), ("body_us", "p99")]
COUNTS = ["ticks", "missed", "allocations", "page_faults"]


def run(folder, device, rest, seconds, before=()):
    """The metrics of the device loop in one live run; `before` is put in front of the command."""
    graph = folder / "device.yaml"
    graph.write_text(GRAPH.format(seconds=seconds, device=device, rest=rest))
    done = subprocess.run([*before, BIN / "tactor", "run", graph, "--no-dead-man", "--overwrite", "--out", folder / "out"], capture_output=True, text=True,
                          check=False)
    if done.returncode != 0:
        raise RuntimeError(done.stderr)
    found = json.loads((folder / "out/summary.json").read_text())["device"]
    metrics = {f"{name}.{part}": found[name][part] for name, part in FIGURES}
    return metrics | {name: found.get(name) for name in COUNTS}


def simulated(folder, seconds):
    return run(folder, "{type: device.simulated}", SIMULATED_REST, seconds)


def modbus(folder, seconds):
    emulator = subprocess.Popen([BIN / "tactor", "emulate", "modbus", "iris_orca", "--tcp", "0"], stdin=subprocess.PIPE,
                                stdout=subprocess.PIPE, text=True)
    try:
        connect = emulator.stdout.readline().split()[1]
        device = f'{{type: modbus.actuator, profile: modbus/iris_orca.yaml, connect: "{connect}", link_rate: 1000 Hz, {PATIENT}}}'
        return run(folder, device, "", seconds)
    finally:
        emulator.kill()
        emulator.communicate()


def usb(folder, seconds):
    return run(folder, f"{{type: usb.device, profile: polhem, {PATIENT}}}", "", seconds,
               before=[BIN / "tactor", "emulate", "usb", "polhem", "--"])


DEVICES = {"device.simulated": simulated, "modbus.actuator": modbus, "usb.device": usb}


@contextlib.contextmanager
def busy_cores(load):
    """Every core busy beside what is in the block, where `load`."""
    if load and shutil.which("stress-ng") is None:
        sys.exit("a loaded machine needs stress-ng (Debian package stress-ng)")
    stress = subprocess.Popen(["stress-ng", "--cpu", "0", "--quiet"]) if load else None
    try:
        yield
    finally:
        if stress is not None:
            stress.terminate()
            stress.wait()


def measure(seconds, rounds, load):
    """{device: metrics}: of times the median over the rounds, of counts the sum."""
    found = {name: [] for name in DEVICES}
    with busy_cores(load), tempfile.TemporaryDirectory() as folder:
        for _ in range(rounds):
            for name, one in DEVICES.items():
                found[name].append(one(pathlib.Path(folder), seconds))
    result = {}
    for name, slices in found.items():
        result[name] = {metric: statistics.median(s[metric] for s in slices) for metric in slices[0] if metric not in COUNTS}
        for count in COUNTS:
            values = [s[count] for s in slices]
            result[name][count] = None if None in values else sum(values)
    return result


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=int, default=20)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--load", action="store_true", help="every core busy beside it")
    parser.add_argument("--out", type=pathlib.Path)
    options = parser.parse_args()
    result = measure(options.seconds, options.rounds, options.load)
    for name, metrics in result.items():
        print(name, *(f"{metric}={value}" for metric, value in metrics.items()))
    if options.out:
        options.out.write_text(json.dumps(result, indent=1) + "\n")


if __name__ == "__main__":
    main()
