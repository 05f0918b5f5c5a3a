#!/usr/bin/python3
"""What each method bears in closed loop, as Markdown tables: the stiffest coupling that stays quiet in a hand, by rate of physics and
grip, and the energy that comes out of the device's port.

`bench/closed_loop.py [--jobs N]`, with a built release preset. A cell runs graphs/wall/closed_loop.yaml: a hand comes down onto a
wall ten times as stiff as the coupling, pushes once and lets its target rest inside, 2 mm or 5 mm deep. The ladder of stiffnesses is
climbed until the handle comes to no rest at one depth or the other; the limit is the step before, so all below it are quiet.
"""
import argparse
import concurrent.futures
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from run_time import table  # noqa: E402

sys.path.insert(0, str(ROOT / "graphs"))
from shipped import graph_file  # noqa: E402

TACTOR = ROOT / "build/release/bin/tactor"
GRAPHS = ROOT / "graphs"
METHODS = ("hold", "lowpass", "fixed", "paper", "blend", "local", "floor")
RATES = (50, 100, 150)  # Hz; the floor is physics at 1 kHz and has none of these
GRIPS = {"firm": (0.55, 6.5, 135), "light": (0.15, 2, 40)}  # kg, N s/m, N/m
LADDER = tuple(50 * 2 ** (step / 4) for step in range(31))  # N/m, to 9,051
WALL = 10  # times as stiff as the coupling
DEPTHS = (2e-3, 5e-3)  # m, of the hand's target inside the wall; 5 mm is the graph's
# In place of the flat wall: a mesh of the transfer scenes, and where the handle touches it (m). An edge of stairs, waves of 0.3 mm.
SURFACES = {"edge": ("transfer/stairs_stairs.off", (-7.98e-3, 0, 0)), "texture": ("transfer/waves_plate.off", (0, 0, 1.8e-4))}
SPEED = 2e-3  # m/s; a handle at rest is slower
REFERENCE = "floor_exact"  # physics at 1 kHz, an encoder without steps
STIFF = [f"coupling.{name}=4 N/mm" for name in ("k_0", "k_device")] + ["coupling.a=0"]
DEVICES = {name: GRAPHS / f"devices/{name}.yaml" for name in ("ideal", "phantom_premium_1_5", "touch", "omega_3")}
TEN_SECONDS = "duration=10 s"
SCENES = {"duck": ("duck", []), "duck, coupling of 4 N/mm": ("duck", STIFF), "wall": ("wall", []),
          "wall, coupling of 4 N/mm": ("wall", STIFF)}  # with a tremor in the hand's target


def is_quiet(speeds, faults=0):
    """True where the handle is at rest over the second half of its speeds (m/s) and the device was never without its force."""
    if faults:
        return False
    half = speeds[len(speeds) // 2:]
    if not len(half):
        raise ValueError("a verdict needs speeds")
    # A comparison with NaN is false.
    return all(speed < SPEED for speed in half)


def climb(quiet, ladder=LADDER):
    """The highest step below which, and at which, all are quiet; 0 where the first is not. Nothing above the first restless one
    is tried."""
    limit = 0.0
    for stiffness in ladder:
        if not quiet(stiffness):
            break
        limit = stiffness
    return limit


def settings(stiffness, rate, grip, depth, surface=None):
    """What a run at the wall sets; `rate` None leaves the method its own. Materials of the wall and the tool act in series."""
    mass, damping, spring = GRIPS[grip]
    x, y, z = SURFACES[surface][1] if surface else (0, 0, 0)
    return [f"coupling.k_t={stiffness:.6g}", f"scene.bodies.wall.material.stiffness={2 * WALL * stiffness:.6g}",
            f"scene.bodies.tool.material.stiffness={2 * WALL * stiffness:.6g}",
            f"scene.bodies.wall.pose.p=[{-1e3 * x:.6g} mm, {-1e3 * y:.6g} mm, {1e3 * (depth - DEPTHS[-1] - z):.6g} mm]", f"device.hand_mass={mass}",
            f"device.hand_damping={damping}", f"device.hand_stiffness={spring}",
            *([] if rate is None else [f"collision.cost={{constant: {1000 / rate:.6g} ms}}"])]


def run(graph, method, settings_of_run, device=None, surface=None):
    """The handle's speeds (m/s, one a tick), and the run's summary. No reference run is made. `device`: an overlay; none: the graph's.
    `surface`: one of SURFACES in place of the body `wall`."""
    import h5py  # the tables of scripts/results are tested without it

    with tempfile.TemporaryDirectory() as out:
        command = [TACTOR, "run", graph_file(graph)]
        if device:
            command += ["--over", device]
        if surface:
            over = pathlib.Path(out) / "surface.yaml"
            over.write_text(f"format: 2\nscene: {{bodies: {{wall: {{plane: ~, mesh: {SURFACES[surface][0]}}}}}}}\n")
            command += ["--over", over]
        # The method comes last: floor_exact takes the encoder's steps away from any device.
        command += ["--over", GRAPHS / f"methods/{method}.yaml", "--overwrite", "--out", out]
        for setting in ("record=[device.truth]", "metrics=~", *settings_of_run):
            command += ["--set", setting]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        summary = json.loads((pathlib.Path(out) / "summary.json").read_text())
        with h5py.File(pathlib.Path(out) / "recording.h5") as file:
            rows = file["streams/device.truth/data"][:]
    return [math.sqrt(sum(c * c for c in row)) for row in rows["v_WD"].tolist()], summary


def generated(summary):
    """The most energy, in mJ, that the motors had given to hand and handle, net, at any time."""
    return 1e3 * summary["device"]["energy_generated_J"]


def cell(method, rate, grip, more=(), device=None, surface=None):
    """The limit in N/m, and the most energy in mJ that the device's port generated there."""
    energies = {}

    def quiet(stiffness):
        for depth in DEPTHS:
            speeds, summary = run("wall_closed_loop", method, [*settings(stiffness, rate, grip, depth, surface), *more], device, surface)
            energies.setdefault(stiffness, []).append(generated(summary))
            if not is_quiet(speeds, summary["device"]["faults"]):
                return False
        return True

    limit = climb(quiet)
    return limit, max(energies[limit]) if limit else None


def limits(jobs, methods=METHODS, more=(), device=None, surface=None):
    """{(method, rate, grip): (limit, energy)}."""
    keys = [(m, r, g) for m in methods for r in ((None,) if m.startswith("floor") else RATES) for g in GRIPS]
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        return dict(zip(keys, pool.map(lambda key: cell(*key, more, device, surface), keys)))


def energies(jobs, methods=(*METHODS, REFERENCE), more=(), device=None):
    """{(method, scene): mJ generated at the device's port} in closed loop over SCENES."""
    keys = [(m, s) for m in methods for s in SCENES]

    def one(key):
        graph, values = SCENES[key[1]]
        return generated(run(graph, key[0], ["device.loop=closed", TEN_SECONDS, *values, *more], device)[1])

    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        return dict(zip(keys, pool.map(one, keys)))


def energy_table(found):
    """A row a method, a column a scene."""
    methods = dict.fromkeys(method for method, _ in found)
    return table(["method", *(f"{scene}, mJ" for scene in SCENES)],
                 [[m, *(f"{found[m, scene]:.2g}" if found[m, scene] < 0.01 else f"{found[m, scene]:.2f}" for scene in SCENES)]
                  for m in methods])


def limit_table(found):
    """A row a method: limits by grip and rate, the largest energy at a limit."""
    def limit(method, rate, grip):
        value = (found.get((method, rate, grip)) or found[method, None, grip])[0]
        return f"{value:.0f}" if 0 < value < LADDER[-1] else "none" if value == 0 else f"{value:.0f} or more"

    methods = dict.fromkeys(method for method, _, _ in found)
    return table(["method", *(f"{grip}, {rate} Hz" for grip in GRIPS for rate in RATES), "energy at the limit, mJ"],
                 [[m, *(limit(m, rate, grip) for grip in GRIPS for rate in RATES),
                   max((e for (name, _, _), (_, e) in found.items() if name == m and e is not None), default=None)]
                  for m in methods])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--method", action="append", help="one of graphs/methods; may be repeated")
    parser.add_argument("--device", choices=DEVICES, help="one of graphs/devices; none: the graph's own")
    parser.add_argument("--surface", choices=SURFACES, help="in place of the flat wall, for the limits")
    parser.add_argument("--set", action="append", default=[], help="as of tactor run, for every run")
    arguments = parser.parse_args()
    methods = tuple(arguments.method or METHODS)
    of = DEVICES.get(arguments.device)
    print(limit_table(limits(arguments.jobs, methods, arguments.set, of, arguments.surface)))
    print(energy_table(energies(arguments.jobs, (*methods, REFERENCE), arguments.set, of)), end="")
