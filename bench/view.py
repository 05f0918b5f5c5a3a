#!/usr/bin/python3
"""What the view costs and how late it is, into a file for scripts/view_results.

    bench/view.py --out FILE [--seconds 20] [--pairs 20] [--without-browser]

Needs a built release preset, python3-h5py, and for the page itself chromium, chromium-driver and python3-selenium. Takes about fifteen
minutes on a machine with nothing else to do. Each client is a raw socket; it takes what comes and acknowledges it, unless it is to be one that does not read.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time

import h5py
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tests/command"))
sys.path.insert(0, str(ROOT / "bench"))
import page  # noqa: E402
from browser import MISSING, open_browser  # noqa: E402
from view_client import Closed, Page, View  # noqa: E402

BUILD = ROOT / "build/release"
TACTOR = str(BUILD / "bin/tactor")
TOUCH = str(ROOT / "graphs/bunny/touch.yaml")
METHODS = ("first", "second", "third", "fourth")


def quantiles(values):
    """The median, the 99th percentile and the largest."""
    return {"count": len(values), "p50": float(np.percentile(values, 50)), "p99": float(np.percentile(values, 99)), "max": float(max(values))}


def cpu_of(process, name):
    """CPU seconds of the threads of that name."""
    ticks = 0
    for task in pathlib.Path(f"/proc/{process}/task").iterdir():
        fields = (task / "stat").read_text().rsplit(")", 1)
        if fields[0].split("(", 1)[1] == name:
            ticks += sum(int(x) for x in fields[1].split()[11:13])
    return ticks / os.sysconf("SC_CLK_TCK")


class Taker(threading.Thread):
    """A client that takes and acknowledges until it is told to end."""

    def __init__(self, client):
        super().__init__(daemon=True)
        self.client, self.ending = client, False
        self.start()

    def run(self):
        while not self.ending:
            try:
                self.client.take_for(0.2)
            except (Closed, OSError):
                return
            # What was drawn is not needed any more.
            self.client.samples.clear()

    def end(self):
        self.ending = True
        self.join()
        self.client.close()


def press(client):
    """Leads the tool into contact; where the handle is then."""
    start = client.hello["device"]["start"][:3]
    for step in range(400):
        p = [start[0], start[1], start[2] - 0.0005 * step]
        client.cursor(p, step > 0)
        client.take_for(0.02)
        if client.stream("commanded") and client.stream("commanded")[-1][1][2] > 1:
            return p
    raise AssertionError("the tool met nothing")


def server(seconds):
    """The share of a core that the server's thread takes, by clients, and what one client is sent."""
    rows = []
    for clients in (0, 1, 4, 8):
        with View(TACTOR, TOUCH) as view:
            takers = [Taker(view.page()) for _ in range(clients)]
            time.sleep(2)
            before, sent = cpu_of(view.process.pid, "view"), sum(t.client.binary_bytes for t in takers)
            time.sleep(seconds)
            row = {"clients": clients, "share": (cpu_of(view.process.pid, "view") - before) / seconds}
            if clients:
                row["bytes_per_s"] = (sum(t.client.binary_bytes for t in takers) - sent) / seconds / clients
            for taker in takers:
                taker.end()
            rows.append(row)
    return rows


def stalled(seconds, pairs):
    """The device loop's wake-ups beside three clients that do not read, between two runs without clients."""
    graph = str(ROOT / "graphs/bunny/live.yaml")
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(pairs):
            row = []
            for clients in (0, 3, 0):
                out = pathlib.Path(folder) / f"out_{len(found)}_{len(row)}"
                process = subprocess.Popen([TACTOR, "run", graph, "--duration", f"{seconds} s", "--view", "--no-open", "--out", out,
                                            "--set", "nodes.metrics=~", "--set", "record=[device.commanded]"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
                url = process.stdout.readline()
                port, token = int(url.split(":")[2].split("/")[0]), url.strip().split("#")[1]
                held = [Page(port, token, receive_buffer=4096) for _ in range(clients)]
                said = process.communicate()[1]
                if process.returncode != 0:
                    sys.exit(f"bench/view.py: a run failed: {said}")
                for client in held:
                    client.close()
                device = json.loads((out / "summary.json").read_text())["device"]
                row.append({"p99_us": device["wakeup_us"]["p99"], "missed": device["missed"], "page_faults": device["page_faults"],
                            "allocations": device.get("allocations", 0)})
            found.append(row)
    return found


def latency(seconds):
    """From a cursor that a client sends to the device's state and to the commanded force, by method."""
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        for method in METHODS:
            graph = pathlib.Path(folder) / "graph.yaml"
            graph.write_text(f"extends: {TOUCH}\nrecord: [device.state, device.commanded]\nnodes: {{select: {{use: {method}}}}}\n")
            recording = pathlib.Path(folder) / "run.h5"
            sent = []
            with View(TACTOR, str(graph), "--record", str(recording)) as view:
                client = view.page()
                p = press(client)
                end = time.monotonic() + seconds
                side = 1
                at = p
                while time.monotonic() < end:
                    # Still held: the force comes to rest.
                    for _ in range(6):
                        client.cursor(at, True)
                        client.take_for(0.05)
                    # Not in step with the ticks, nor with the server's frames.
                    client.take_for(0.05 * np.random.random())
                    side = -side
                    at = [p[0] + side * 2e-4, p[1], p[2]]
                    sent.append(time.monotonic())
                    client.cursor(at, True)
                label = next(c["label"] for c in client.hello["methods"]["choices"] if c["value"] == method)
                zero = client.last("status")["monotonic"] - client.last("status")["now"]
                client.say(type="stop")
                try:
                    client.take_for(5)
                except Closed:
                    pass
            with h5py.File(recording) as file:
                streams = {name: file[f"streams/{name}/data"][()] for name in ("device.state", "device.commanded")}
            rows.append({"method": label, **latencies(streams, [t - zero for t in sent])})
    return rows


def latencies(streams, sent):
    """By the recording: ticks at which the handle begins to move, and at which the commanded force begins to follow."""
    ticks = {name: rows["valid_ns"] * 1e-9 for name, rows in streams.items()}
    speed = np.abs(streams["device.state"]["v_WD"][:, 0])
    force = streams["device.commanded"]["force"]
    to_state, to_force = [], []
    for t in sent:
        first = np.searchsorted(ticks["device.state"], t, side="right")
        moved = np.flatnonzero(speed[first:first + 40] > 1e-3 + speed[max(first - 1, 0)])
        if not len(moved):
            continue
        to_state.append(1e3 * (ticks["device.state"][first + moved[0]] - t))
        # The force has come to rest since the jump before. It follows where it leaves what it did in the 30 ms before by five times.
        first = np.searchsorted(ticks["device.commanded"], t, side="right")
        rest = force[first - 30:first]
        away = np.linalg.norm(force[first:first + 150] - rest.mean(axis=0), axis=1)
        at_rest = np.linalg.norm(rest - rest.mean(axis=0), axis=1).max()
        follows = np.flatnonzero(away > max(5 * at_rest, 2e-3))
        if len(follows):
            to_force.append(1e3 * (ticks["device.commanded"][first + follows[0]] - t))
    return {"to_state_ms": quantiles(to_state), "to_force_ms": quantiles(to_force)}


def page_figures(seconds):
    """The page in a browser that draws in software."""
    found = {}
    with tempfile.TemporaryDirectory() as folder, View(TACTOR, TOUCH) as view:
        browser = open_browser(pathlib.Path(folder) / "profile", flags=("--window-size=1100,1120",))
        try:
            looker = view.page()
            looker.close()
            begun = time.monotonic()
            browser.get(view.url)
            while not browser.execute_script("return window.tactor?.counters.frames_drawn > 0 && window.tactor.latest('device.state') !== null"):
                time.sleep(0.01)
            found["first_frame_s"] = time.monotonic() - begun
            time.sleep(3)
            canvas = "document.getElementById('scene-canvas')"
            found["canvas"] = browser.execute_script(f"const c = {canvas}; return [c.clientWidth, c.clientHeight];")
            found["triangles"] = sum(t for _, _, t in view.page().meshes)
            before = browser.execute_script("return [performance.now(), window.tactor.counters.frames_drawn]")
            time.sleep(seconds)
            after = browser.execute_script("return [performance.now(), window.tactor.counters.frames_drawn]")
            found["frames_per_s"] = 1e3 * (after[1] - before[1]) / (after[0] - before[0])
            found["pixel_ratio"] = browser.execute_script("return window.tactor.counters.pixel_ratio")
            found["chart_ms"] = browser.execute_script("return window.tactor.counters.chart_ms")
            dropped = browser.execute_script("return [window.tactor.status.dropped, window.tactor.status.lost]")
            found["dropped"], found["lost"] = dropped
            browser.set_script_timeout(60)
            found["lag_ms"] = browser.execute_async_script("""
                const done = arguments[0];
                const end = performance.now() + 8000;
                while (performance.now() < end);
                setTimeout(() => done(1000 * window.tactor.lag_s), 500);""")
        finally:
            browser.quit()
    with View(TACTOR, TOUCH) as view:
        import gzip
        import socket
        total = 0
        for path in ("/", "/view.js", "/view.css"):
            connection = socket.create_connection(("127.0.0.1", view.port))
            connection.sendall(f"GET {path} HTTP/1.1\r\nHost: 127.0.0.1:{view.port}\r\nConnection: close\r\n\r\n".encode())
            data = b""
            while more := connection.recv(65536):
                data += more
            gzip.decompress(data.split(b"\r\n\r\n", 1)[1])
            total += len(data)
        found["program_bytes"] = total
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--pairs", type=int, default=20)
    parser.add_argument("--without-browser", action="store_true")
    options = parser.parse_args()
    found = {"measured_on": page.measured_on(), "seconds": options.seconds}
    print("the server's thread", flush=True)
    found["server"] = server(options.seconds)
    print("latency of the mouse", flush=True)
    found["latency"] = latency(options.seconds)
    if not options.without_browser:
        if MISSING:
            sys.exit(f"bench/view.py: missing are {', '.join(MISSING)}; --without-browser does without")
        print("the page", flush=True)
        found["page"] = page_figures(options.seconds)
    print("wake-ups beside clients that do not read", flush=True)
    found["stalled"] = stalled(5, options.pairs)
    options.out.write_text(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
