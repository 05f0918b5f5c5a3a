#!/usr/bin/python3
"""How still each method keeps a hand that rests inside soft tissue, as a Markdown table.

`bench/soft_loop.py [--jobs N]`, with a built release preset. A cell runs graphs/gel_cube/closed_loop.yaml: a hand comes down onto a block
of gel with a ball, pushes once and lets its target rest inside. Physics takes 16.7 ms, but for the floor.
"""
import argparse
import concurrent.futures
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from closed_loop import GRIPS as WALL_GRIPS  # noqa: E402
from run_time import table  # noqa: E402

TACTOR = ROOT / "build/release/bin/tactor"
METHODS = ("hold", "paper", "blend", "local", "floor")
GRIPS = {"light": (0.15, 3, 300), "firm": WALL_GRIPS["firm"]}  # kg, N s/m, N/m
STIFFNESSES = (300, 1000, 2000, 4000)  # N/m
YOUNGS = (20, 500)  # kPa
REST = 1.0  # s, at the end of the run
STILL = 1e-2  # mm, the encoder's step


def settings(grip, stiffness, young):
    mass, damping, spring = GRIPS[grip]
    return [f"device.hand_mass={mass} kg", f"device.hand_damping={damping} N s/m", f"device.hand_stiffness={spring} N/m",
            f"coupling.k_t={stiffness} N/m", f"scene.bodies.gel.young={young} kPa"]


def amplitude(points):
    """Half of how far the points reach along the axis where that is most, in their unit."""
    return max(max(axis) - min(axis) for axis in zip(*points)) / 2


def at_rest(times, points, rest=REST):
    """The points of the last `rest` seconds. Raises ValueError where the run is shorter."""
    if times[-1] - times[0] < rest:
        raise ValueError(f"a run of {times[-1] - times[0]:g} s has no last {rest:g} s")
    return [p for t, p in zip(times, points) if t > times[-1] - rest]


def run(method, settings_of_run):
    """By how much the handle and the tool swing at rest, mm."""
    import h5py  # the functions above are tested without it

    with tempfile.TemporaryDirectory() as out:
        command = [TACTOR, "run", ROOT / "graphs/gel_cube/closed_loop.yaml", "--over", ROOT / f"graphs/methods/{method}.yaml", "--overwrite",
                   "--out", out]
        for setting in ("record=[device.truth, dynamics.state]", *settings_of_run):
            command += ["--set", setting]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with h5py.File(pathlib.Path(out) / "recording.h5") as file:
            handle, tool = file["streams/device.truth"], file["streams/dynamics.state"]
            return tuple(1e3 * amplitude(at_rest(rows["data"]["valid_ns"] / 1e9, rows["data"][place].tolist()))
                         for rows, place in ((handle, "p_WD"), (tool, "p_WT")))


def swings(jobs, methods=METHODS):
    """{(grip, young, stiffness): {method: (handle, tool)}}, mm."""
    keys = [(g, y, k) for g in GRIPS for y in YOUNGS for k in STIFFNESSES]
    found = {key: {} for key in keys}
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        runs = {(key, m): pool.submit(run, m, settings(key[0], key[2], key[1])) for key in keys for m in methods}
        for (key, method), future in runs.items():
            found[key][method] = future.result()
            print(*key, method, *found[key][method], flush=True)
    return found


def swing_table(found):
    """A row a grip, stiffness of the material and of the coupling; a column a method, mm, the larger of handle and tool."""
    methods = dict.fromkeys(method for cells in found.values() for method in cells)
    return table(["grip", "gel, kPa", "coupling, N/m", *(f"`{method}`, mm" for method in methods)],
                 [[grip, young, stiffness, *(f"{max(cells[method]):.2g}" for method in methods)]
                  for (grip, young, stiffness), cells in found.items()])


def restless(found, method, still=STILL):
    """How many cells of a method swing by more than `still` mm, and the most that any does, mm."""
    worst = [max(cells[method]) for cells in found.values()]
    return sum(swing > still for swing in worst), max(worst)


def verdicts(found):
    """A line a method: in how many cells its amplitude at rest is above an encoder's step."""
    methods = dict.fromkeys(method for cells in found.values() for method in cells)
    said = ((method, *restless(found, method)) for method in methods)
    return (f"Cells in which the amplitude is above {STILL:g} mm, of {len(found)}, and the largest amplitude:\n\n" +
            "\n".join(f"- `{method}`: {count} cells, {most:.2g} mm at most" for method, count, most in said))


def closed_loop(jobs=1):
    """The table and, below it, how many cells of each method are restless."""
    found = swings(jobs)
    return f"{swing_table(found)}\n{verdicts(found)}\n"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=1)
    print(closed_loop(parser.parse_args().jobs), end="")
