#!/usr/bin/python3
"""Runs the Modbus actuator against its emulator and prints what its line delivers: TCP at 1 kHz with both cores loaded, and a
serial line at 95 % of what it can carry.

    bench/modbus_rates.py [--tactor build/release/bin/tactor] [--seconds 10]

Needs stress-ng. The serial line is a pseudo-terminal with the time that its characters would take."""
import argparse
import json
import os
import pathlib
import re
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parents[1]
TACTOR = ROOT / "build/release/bin/tactor"
GRAPH = """clock: real
duration: {seconds} s
scene: {{bodies: {{}}}}
nodes:
  device: {{type: modbus.actuator, profile: "{profile}", connect: "{connect}", stuck_after: 0, baud: {baud}, link_rate: {rate} Hz,
           link_timeout: 1 s}}
record: [device.safety]
"""

CASES = [("TCP, loopback", ["--tcp", "0"], 115200, lambda most: min(1000, most), False),
         ("TCP, loopback", ["--tcp", "0"], 115200, lambda most: min(1000, most), True),
         ("RTU 115200 8E1", ["--pty", "--baud", "115200"], 115200, lambda most: 0.95 * most, False),
         ("RTU 115200 8E1", ["--pty", "--baud", "115200"], 115200, lambda most: 0.95 * most, True)]


def limit(tactor, folder, profile, connect, baud):
    """The rate that the line carries, as the refusal of a higher one tells it."""
    graph = folder / "limit.yaml"
    graph.write_text(GRAPH.format(seconds=1, profile=profile, connect=connect, baud=baud, rate=9999))
    text = subprocess.run([tactor, "check", graph], capture_output=True, text=True, check=False).stderr
    return float(re.search(r"at most ([\d.]+) Hz", text).group(1))


def measure(tactor, folder, line, baud, rate, seconds, load):
    profile = folder / "orca.yaml"
    # The emulator shares the loaded machine; what is measured is how old samples are, not whether it keeps its time-out.
    profile.write_text((ROOT / "devices/modbus/profiles/iris_orca.yaml").read_text()
                       .replace("response_timeout: 25 ms", "response_timeout: 200 ms").replace("time: 150 ms", "time: 5 s"))
    emulator = subprocess.Popen([tactor, "emulate", "modbus", profile, *line], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                                text=True)
    stress = None
    try:
        connect = emulator.stdout.readline().split()[1]
        rate = rate(limit(tactor, folder, profile, connect, baud))
        graph = folder / "run.yaml"
        graph.write_text(GRAPH.format(seconds=seconds, profile=profile, connect=connect, baud=baud, rate=rate))
        if load:
            stress = subprocess.Popen(["stress-ng", "--cpu", str(os.cpu_count()), "--timeout", f"{seconds + 10}s"],
                                      stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        run = subprocess.run([tactor, "run", graph, "--no-dead-man", "--overwrite", "--out", folder / "out"], capture_output=True, text=True, check=False)
        summary = json.loads((folder / "out/summary.json").read_text())
        if run.returncode != 0:
            print(run.stderr)
        return rate, summary["device"]["link"]
    finally:
        if stress is not None:
            stress.terminate()
            stress.wait()
        emulator.kill()
        emulator.communicate()


def kept(link):
    """The share of the cycles asked for that the line delivered while it was open: opening it is no cycle, and a fault that
    the device reports of itself is a good one."""
    failed = sum(link["errors"][kind] for kind in ("timeout", "crc", "exception", "protocol", "reset"))
    return link["cycles"] / (link["cycles"] + link["skipped"] + failed)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--tactor", default=str(TACTOR))
    parser.add_argument("--seconds", type=int, default=10)
    arguments = parser.parse_args()
    print("| line | load | asked Hz | kept % | age of a sample p50 / p99 / max ms | cycle p50 / p99 / max ms | errors |")
    print("|---|---|---|---|---|---|---|")
    for name, line, baud, rate, load in CASES:
        with tempfile.TemporaryDirectory() as folder:
            asked, link = measure(arguments.tactor, pathlib.Path(folder), line, baud, rate, arguments.seconds, load)
        age, cycle = link["age_us"], link["cycle_us"]
        print(f"| {name} | {'both cores' if load else 'none'} | {asked:.1f} | {100 * kept(link):.2f} | "
              f"{age['p50'] / 1e3:.2f} / {age['p99'] / 1e3:.2f} / {age['max'] / 1e3:.2f} | "
              f"{cycle['p50'] / 1e3:.2f} / {cycle['p99'] / 1e3:.2f} / {cycle['max'] / 1e3:.2f} | {sum(link['errors'].values()):.0f} |", flush=True)


if __name__ == "__main__":
    main()
