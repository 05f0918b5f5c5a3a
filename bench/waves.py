#!/usr/bin/python3
"""What a line of wave variables does where physics is far away, beside a held force without and with an energy bound, as Markdown tables:
the net energy of the port by the true motion of the handle, the stiffness at rest, the error against the ideal wall, and microseconds a tick.

`bench/waves.py [--jobs N]`, with a built release preset, h5py and numpy. Some minutes on two cores. All is computed here, from what was recorded.
"""
import argparse
import collections
import concurrent.futures
import itertools
import os
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "bench"))
from passivity import GRAPHS, HANDS, LIVE_STIFFNESSES, STIFFNESSES, energy, late_text, run, was_late  # noqa: E402
from run_time import table  # noqa: E402

STAGES = ("none", "energy_bound", "waves")
OVER = {"none": ("methods/hold.yaml",), "energy_bound": ("methods/hold.yaml", "passivity/energy_bound.yaml"), "waves": ("passivity/waves.yaml",)}
DELAYS = (0, 10, 50, 100)  # ms each way, as in graphs/passivity/delay_*.yaml
LIVE_DELAYS = (10, 50)
UNEVEN = ((1001, "10 %"), (1002, "30 %"))  # seed, and jitter of collision's cost
WALL = GRAPHS / "wall/closed_loop.yaml"
TOUCH, MATERIAL = 4e-3, 1e5  # m, where the sphere touches; N/m, of wall and of tool
PERIOD, TICK = 11.7e-3, 1e-3  # s, of the scene's physics in contact, and of the device
IMPEDANCE_MOST = 25  # N s/m, a quarter of the handle's 0.1 kg by 1 kHz
FIRM = next(iter(HANDS)), 1
GRAMS, HEAVY_STIFFNESSES = (50, 200, 500), (200, 3200)  # g of the tool, N/m
SHOWN = (50, 200, 800, 3200, 6400)  # N/m
Cell = collections.namedtuple("Cell", "hand of_hand stiffness delay jitter seed stage")
Found = collections.namedtuple("Found", "cell given allowed stiffness ripple error late")


def half_loop(delay):
    """s: half the time from the handle to physics and back. A wave is half a period old in its result, whose query goes on while samples are still
    under way, and it is played half a period and a tick and a half later. `delay` in ms each way."""
    away = 1e-3 * delay
    return 0.5 * (PERIOD + max(PERIOD, away) + away + 1.5 * TICK)


def impedance(stiffness, delay):
    """N s/m: the line is as stiff at rest as the coupling would be, where the handle bears it."""
    return min(IMPEDANCE_MOST, stiffness * half_loop(delay))


def overlays(stage, delay):
    return (*OVER[stage], *((f"passivity/delay_{delay}ms.yaml",) if delay else ()))


def ideal(stiffness, p):
    """N along z: coupling and contact in series at the true place of the handle."""
    import numpy

    return numpy.maximum(0, TOUCH - p[:, 2]) / (1 / stiffness + 2 / MATERIAL)


def measure(cell, *more, weight=0.0):
    import numpy

    settings = [f"scene.bodies.{body}.material.stiffness={MATERIAL} N/m" for body in ("wall", "tool")]
    settings += [f"collision.cost.jitter={cell.jitter}", f"seed={cell.seed}", *HANDS[cell.hand][cell.of_hand], *more]
    # The coupling's k_t, or the line that is as stiff.
    settings.append(f"coupling.impedance={impedance(cell.stiffness, cell.delay)} N s/m" if cell.stage == "waves" else
                    f"coupling.k_t={cell.stiffness} N/m")
    summary, force, _, p = run(WALL, overlays(cell.stage, cell.delay), settings)
    given, allowed = energy(force, p, weight)
    rest, pressed = force[-1000:, 2], TOUCH - p[-1000:, 2].mean()
    wanted = ideal(cell.stiffness, p)
    error = numpy.sqrt(((force[:, 2] - wanted) ** 2).sum() / (wanted ** 2).sum())
    rests = pressed > 1e-4 and rest.std() < 0.5 * rest.mean()
    return Found(cell, given, allowed, float(rest.mean() / pressed) if rests else None, float(rest.std()), float(100 * error),
                 was_late(summary))


def all_hands():
    return [(hand, i) for hand, settings in HANDS.items() for i in range(len(settings))]


def cells():
    for (hand, i), stiffness, delay, (seed, jitter), stage in itertools.product(all_hands(), STIFFNESSES, DELAYS, UNEVEN, STAGES):
        yield Cell(hand, i, stiffness, delay, jitter, seed, stage)


def named(stage):
    return {"none": "`hold`", "energy_bound": "`hold`, `energy_bound`", "waves": "`waves`"}[stage]


def energy_row(first, of):
    """Of how many cells, how many keep the bound, and the worst."""
    worst = max(of, key=lambda f: f.given / f.allowed)
    return [*first, f"{sum(f.given <= f.allowed for f in of)} of {len(of)}", 1e3 * max(f.given for f in of), worst.given / worst.allowed,
            f"{worst.cell.hand}, {worst.cell.stiffness} N/m" if worst.given > 0 else None]


def energy_rows(found):
    """A row a delay and stage."""
    for delay, stage in itertools.product(DELAYS, STAGES):
        yield energy_row([delay, named(stage)], [f for f in found if f.cell.delay == delay and f.cell.stage == stage])


def live_rows():
    """A row a delay and stage: the same scene in real time, one run after the other, by each coupling."""
    hand, (seed, jitter) = next(iter(HANDS)), UNEVEN[0]
    for delay, stage in itertools.product(LIVE_DELAYS, STAGES):
        of = [measure(Cell(hand, 0, stiffness, delay, jitter, seed, stage), "clock=real") for stiffness in LIVE_STIFFNESSES]
        yield energy_row([delay, named(stage)], of) + [late_text([f.late for f in of])]


def heavy_cells():
    for delay, grams, (hand, i), stiffness in itertools.product(DELAYS[1:], GRAMS, all_hands(), HEAVY_STIFFNESSES):
        yield grams, Cell(hand, i, stiffness, delay, UNEVEN[0][1], UNEVEN[0][0], "waves")


def measure_heavy(cell):
    grams, of = cell
    return grams, measure(of, "scene.gravity=[0, 0, -9.81]", f"scene.bodies.tool.mass={grams} g", weight=-9.81e-3 * grams)


def heavy_rows(found):
    """A row a delay and tool."""
    for delay, grams in itertools.product(DELAYS[1:], GRAMS):
        yield energy_row([delay, grams], [f for of_grams, f in found if of_grams == grams and f.cell.delay == delay])


def firm(found, delay, stiffness):
    """Of the study's firm hand, what each stage gives there."""
    return {f.cell.stage: f for f in found if (f.cell.hand, f.cell.of_hand) == FIRM and f.cell.seed == UNEVEN[0][0] and
            (f.cell.delay, f.cell.stiffness) == (delay, stiffness)}


def rest_rows(found):
    """A row a delay and coupling: stiffness and ripple at rest of each stage."""
    for delay, stiffness in itertools.product(DELAYS, SHOWN):
        of = firm(found, delay, stiffness)
        b = impedance(stiffness, delay)
        felt = (value for stage in STAGES for value in (of[stage].stiffness, of[stage].ripple))
        yield [delay, stiffness, b, 1 / (half_loop(delay) / b + 2 / MATERIAL), *felt]


def error_rows(found):
    """A row a delay: for each coupling the error of each stage."""
    for delay, stage in itertools.product(DELAYS, STAGES):
        yield [delay, named(stage), *(firm(found, delay, stiffness)[stage].error for stiffness in SHOWN)]


def cost_rows(repeats=5):
    """us a step of the line, of a coupling and of a bound, in runs of the wall; the quickest of some."""
    for stage, node in (("waves", "coupling"), ("energy_bound", "coupling"), ("energy_bound", "passivity")):
        runs = [run(GRAPHS / "wall/scene.yaml", OVER[stage], ["duration=10 s"])[0]["cost_us"] for _ in range(repeats)]
        best = min(runs, key=lambda cost: cost[node]["total_s"])[node]
        name = {"coupling": "`coupling.adaptive`", "passivity": "`energy_bound`"}[node] if stage != "waves" else "`waves`"
        yield [name, best["steps"] / 10, best["median"], best["p99"], 1e6 * best["total_s"] / 10]


def live_tables():
    """The generated section on live runs, one after the other."""
    return "\n".join([
        f"### Energy, live, with physics away\n\nWith the same hand, at couplings of {', '.join(map(str, LIVE_STIFFNESSES))} N/m.\n",
        table(["delay each way, ms", "stage", "cells within the bound", "largest energy, mJ", "largest share", "in which cell", "late runs"], live_rows())])


def tables(jobs):
    """The generated section on waves of docs/explanation/passivity.md."""
    costs = list(cost_rows())
    with concurrent.futures.ProcessPoolExecutor(jobs) as pool:
        found = list(pool.map(measure, cells(), chunksize=8))
        weighed = list(pool.map(measure_heavy, heavy_cells(), chunksize=8))
    headings = [f"{named(stage)}: {what}" for stage in STAGES for what in ("N/m", "ripple, N")]
    return "\n".join([
        "### Energy, with physics away\n\nAll hands of the tables above, couplings of 50 to 6400 N/m. The cost of collision varies by 10 % and by 30 %. "
        f"The impedance is the coupling's stiffness times half the time there and back, {IMPEDANCE_MOST} N s/m at most.\n",
        table(["delay each way, ms", "stage", "cells within the bound", "largest energy, mJ", "largest share", "in which cell"], energy_rows(found)),
        "### Energy of a heavy tool, with physics away\n\nThe line of waves with gravity, all hands, couplings of "
        f"{' and '.join(map(str, HEAVY_STIFFNESSES))} N/m. The energy that the tool's weight gives along the way of the handle is not counted.\n",
        table(["delay each way, ms", "tool, g", "cells within the bound", "largest energy, mJ", "largest share", "in which cell"], heavy_rows(weighed)),
        "### How stiff the wall is, with physics away\n\nThe firm hand of the study rests in the wall. Stiffness is the mean force divided by "
        "the mean depth of the last second. Ripple is the standard deviation of the force. Where no stiffness is given, the "
        "handle is pushed out or oscillates.\n",
        table(["delay each way, ms", "coupling, N/m", "b, N s/m", "b / D and contact, N/m", *headings], rest_rows(found)),
        "### Error, with physics away\n\nThe same runs as a whole. The true force is that of coupling and contact in series at the "
        "true position. The error is the RMS of the difference from it, in percent of its RMS, by the coupling's stiffness in N/m.\n",
        table(["delay each way, ms", "stage", *map(str, SHOWN)], error_rows(found)),
        "### Cost of the line\n\nUnder the virtual clock, in the fastest of five runs of `wall/scene`.\n",
        table(["node", "steps a second", "median, us", "p99, us", "us a second"], costs)])


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    print(tables(parser.parse_args().jobs), end="")
