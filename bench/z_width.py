#!/usr/bin/python3
"""How stiff and how damped a virtual wall may be, by device and rate, with theory beside: SVG by gnuplot, and Markdown tables.

`bench/z_width.py [--jobs N] [--out FOLDER]`, with a built release preset, gnuplot and Debian's python3-scipy and python3-yaml. A run is
graphs/virtual_wall/scene.yaml with a device of graphs/devices: a hand comes down onto a one-sided wall, pushes once and rests inside.
For each damping the stiffness climbs a ladder until the handle keeps moving; the limit is the step before. The gate's slew limit is
lifted, because the theory knows of none. Methods likewise, by the coupling's stiffness and damping ratio at the wall of
bench/closed_loop.py, with physics at 100 Hz.
"""
import argparse
import concurrent.futures
import itertools
import json
import math
import os
import pathlib
import subprocess
import sys

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
if "TACTOR_BUILD" not in os.environ:
    sys.path.insert(0, str(ROOT / "build/release/python"))
import closed_loop  # noqa: E402
import sampled_loop  # noqa: E402
import worst_hand  # noqa: E402
from run_time import table  # noqa: E402

DEVICES = tuple(closed_loop.DEVICES)
RATES = (1000, 2000, 4000)  # Hz, of the device
METHOD_RATES = (1000, 4000)
DAMPINGS = (0.125, 0.5, 2, 4, 8, 16, 32)  # N s/m
LADDER = tuple(50 * 2 ** (step / 2) for step in range(22))  # N/m, to 72,408
HANDS = ("firm", "finger")
ZETAS = (0.125, 0.25, 0.5, 1, 2)  # damping ratios of a method's coupling


def values_of(device, hand, rate):
    """The parameters of the graph's device with an overlay of graphs/devices and a hand, SI units."""
    import tactor
    import yaml

    graph = tactor.load("virtual_wall/scene", over=[str(closed_loop.DEVICES[device])],
                        set={f"device.{name}": value for name, value in vars(worst_hand.KNOWN[hand]).items()} | {"rate": rate})
    return yaml.safe_load(graph.to_yaml())["nodes"]["device"]


def bears(device, hand, rate, stiffness, damping):
    import tactor

    found = tactor.run("virtual_wall/scene", over=[str(closed_loop.DEVICES[device])], taps=["device.truth"], without_reference=True,
                       set={f"device.{name}": value for name, value in vars(worst_hand.KNOWN[hand]).items()} |
                       {"rate": rate, "wall.stiffness": stiffness, "wall.damping": damping, "device.force_slew": 1e9})
    speeds = numpy.linalg.norm(found.taps["device.truth"]["v_WD"], axis=1)
    return numpy.isfinite(speeds).all() and not found.metrics["device.faults"] and not worst_hand.keeps_moving(speeds)


def measured(key):
    """N/m: the highest step up to which all are borne, 0 where the first is not."""
    device, hand, rate, damping = key
    return closed_loop.climb(lambda stiffness: bears(device, hand, rate, stiffness, damping), LADDER)


def method_limit(key):
    """The same of a method's coupling, in the firm hand."""
    rate, device, method, zeta = key

    def quiet(stiffness):
        import tactor

        physics = None if method == "floor" else worst_hand.RATE
        for depth in closed_loop.DEPTHS:
            # The device's own friction stays.
            values = worst_hand.settings(stiffness, physics, worst_hand.KNOWN["firm"], depth, None) | {"coupling.zeta": zeta, "rate": rate}
            found = tactor.run("wall/closed_loop", over=[str(closed_loop.DEVICES[device]), method], taps=["device.truth"],
                               without_reference=True, set=values)
            speeds = numpy.linalg.norm(found.taps["device.truth"]["v_WD"], axis=1)
            if not numpy.isfinite(speeds).all() or found.metrics["device.faults"] or worst_hand.keeps_moving(speeds):
                return False
        return True

    return closed_loop.climb(quiet, worst_hand.KNOWN_LADDER)


GRID = tuple(0.01 * 3200 ** (i / 30) for i in range(31))  # N s/m, of the theory's lines


def theory(device, rate):
    """What is drawn beside, N/m: by line at each of GRID, as said by `exact` and `closed`; and "ticks" from a sample to its force."""
    v = values_of(device, "firm", rate)
    ticks = 1 + round(v["delay_in"] * rate) + round(v["delay_out"] * rate)
    names = ("mass", "damping", "mode_frequency", "mode_damping", "motor_share")
    bare = sampled_loop.Device(**{name: v[name] for name in names})
    firm = sampled_loop.Device(**{name: v[name] for name in (*names, "hand_mass", "hand_damping", "hand_stiffness")})

    def at(b):
        return {"firm hand, linear loop": sampled_loop.limit(firm, 1 / rate, ticks, b, steps=150),
                "no hand, linear loop": sampled_loop.limit(bare, 1 / rate, ticks, b, steps=150),
                "(b + B)/(T/2 + t_d)": (v["damping"] + b) * rate / (0.5 + ticks),
                "passive, linear": sampled_loop.passive_limit(v["damping"], 1 / rate, ticks, b),
                "passive without delay, 2(b - B)/T": 2 * (v["damping"] - b) * rate,
                "2 f_c/step": 2 * v["friction"] / v["encoder_step"]}

    rows = [at(b) for b in GRID]
    return {"ticks": ticks, "undamped": at(0.0), "lines": {name: [row[name] for row in rows] for name in rows[0]}}


MEASURED = {"firm": "with linespoints lc rgb '#1f6fb4' lw 2 pt 7 ps 0.5", "finger": "with linespoints lc rgb '#d06020' lw 2 pt 5 ps 0.5"}
LINES = {"firm hand, linear loop": "lc rgb '#1f6fb4' dt 2", "no hand, linear loop": "lc rgb '#505050' dt 2", "(b + B)/(T/2 + t_d)": "lc rgb '#40a040' dt 3",
         "passive, linear": "lc rgb '#a03080' lw 2", "passive without delay, 2(b - B)/T": "lc rgb '#a03080' dt 4", "2 f_c/step": "lc rgb '#909090' dt 5"}


def block_of(name, columns):
    """A table of gnuplot's; what is no number above zero is left out."""
    rows = (" ".join(f"{c:.6g}" if 0 < c < math.inf else "nan" for c in row) for row in zip(*columns))
    return [f"{name} << EOD", *rows, "EOD"]


def figure_script(device, found, theories, file):
    """What gnuplot draws: a panel a rate; damping to the right, stiffness upwards."""
    lines = [f"set terminal svg size {480 * len(RATES)},460 font 'sans,11' background rgb 'white'", f"set output '{file}'",
             f"set multiplot layout 1,{len(RATES)}", "set logscale xy", f"set xrange [{GRID[0]}:{GRID[-1]}]", "set yrange [10:100000]",
             "set xlabel 'damping of the wall, N s/m'", "set format y '10^{%L}'", "unset key"]
    for i, rate in enumerate(RATES):
        said = theories[rate]["lines"]
        if i + 1 == len(RATES):
            lines.append("set key noenhanced at graph 0.99,0.02 bottom right font ',8' samplen 2")
        lines += [*block_of(f"$m{i}", [DAMPINGS, *(found[rate][hand] for hand in MEASURED)]), *block_of(f"$t{i}", [GRID, *(said[name] for name in LINES)]),
                  f"set title '{device.replace('_', ' ')}, {rate} Hz'", "set ylabel 'stiffness of the wall, N/m'" if i == 0 else "unset ylabel",
                  "plot " + ", ".join([*(f"$m{i} using 1:{n + 2} {style} title '{hand}, measured'" for n, (hand, style) in enumerate(MEASURED.items())),
                                       *(f"$t{i} using 1:{n + 2} with lines {style} title '{name}'" for n, (name, style) in enumerate(LINES.items()))])]
    return "\n".join([*lines, "unset multiplot", ""])


COLOURS = ("#1f6fb4", "#d06020", "#40a040", "#a03080", "#707070", "#c02020", "#c0c0c0")


def method_script(found, rate, file):
    """What gnuplot draws of one rate: a panel a device; damping ratio to the right, stiffness upwards, a line a method. What is under the ladder is
    drawn at 35 N/m."""
    lines = ["set terminal svg size 1000,640 font 'sans,11' background rgb 'white'", f"set output '{file}'",
             "set multiplot layout 2,2", "set logscale xy", f"set xrange [{ZETAS[0]}:{ZETAS[-1]}]", "set yrange [30:12000]",
             "set xlabel 'damping ratio of the coupling'", "set ylabel 'stiffness of the coupling, N/m'", "set xtics (" + ", ".join(f"{z:g}" for z in ZETAS) + ")",
             "set key bottom left font ',8' samplen 2"]
    for i, (device, by_method) in enumerate(found.items()):
        lines += [f"$d{i} << EOD",
                  *(" ".join([f"{z:g}", *(f"{max(by_method[m][n], 35):.6g}" for m in by_method)]) for n, z in enumerate(ZETAS)), "EOD",
                  f"set title '{device.replace('_', ' ')}, {rate} Hz'",
                  "plot " + ", ".join(f"$d{i} using 1:{n + 2} with linespoints lc rgb '{COLOURS[n]}' lw {5 if m == 'floor' else 2} pt 7 ps 0.4 title '{m}'"
                                      for n, m in sorted(enumerate(by_method), key=lambda one: one[1] != "floor")), "unset key"]
    return "\n".join([*lines, "unset multiplot", ""])


def measure_methods(jobs, devices=DEVICES, methods=closed_loop.METHODS, rates=METHOD_RATES):
    """{rate as text: {device: {method: N/m at each of ZETAS}}}."""
    keys = list(itertools.product(rates, devices, methods, ZETAS))
    with concurrent.futures.ProcessPoolExecutor(jobs) as pool:
        limits = dict(zip(keys, pool.map(method_limit, keys)))
    return {str(rate): {device: {method: [limits[rate, device, method, z] for z in ZETAS] for method in methods} for device in devices} for rate in rates}


def method_table(found):
    """A row a rate, device and method."""
    lowest = worst_hand.KNOWN_LADDER[0]
    return table(["rate, Hz", "device", "method", *(f"ratio {z:g}" for z in ZETAS)],
                 [[rate, device, method, *(worst_hand.number(value, lowest) for value in values)]
                  for rate, by_device in found.items() for device, by_method in by_device.items() for method, values in by_method.items()])


def measure(jobs, devices=DEVICES, rates=RATES):
    """{device: {rate: {hand: N/m at each of DAMPINGS}}}."""
    keys = list(itertools.product(devices, HANDS, rates, DAMPINGS))
    with concurrent.futures.ProcessPoolExecutor(jobs) as pool:
        limits = dict(zip(keys, pool.map(measured, keys, chunksize=4)))
    return {device: {rate: {hand: [limits[device, hand, rate, b] for b in DAMPINGS] for hand in HANDS} for rate in rates} for device in devices}


def theories(devices=DEVICES, rates=RATES):
    """{device: {rate: `theory`}}."""
    return {device: {rate: theory(device, rate) for rate in rates} for device in devices}


def number(value):
    return "none" if value <= 0 else f"{value:.0f}" if value < LADDER[-1] else f"{LADDER[-1]:.0f} or more"


def best_table(found, said):
    """A row a device and rate: the stiffest wall without a damper and at its best damping, per hand; and what theory says without a
    damper. `said`: of `theories`."""
    rows = []
    for device, by_rate in found.items():
        for rate, limits in by_rate.items():
            cells = []
            for hand in HANDS:
                at = max(range(len(DAMPINGS)), key=limits[hand].__getitem__)
                cells += [number(limits[hand][0]), f"{number(limits[hand][at])} at {DAMPINGS[at]:g}" if limits[hand][at] > 0 else "none"]
            rows.append([device, str(rate), str(said[device][rate]["ticks"]), *cells,
                         *(number(said[device][rate]["undamped"][name]) for name in LINES)])
    return table(["device", "rate, Hz", "ticks late", *(f"{hand}, {what}" for hand in HANDS for what in (f"B = {DAMPINGS[0]:g}", "best")), *LINES], rows)


def draw(found, said, folder):
    for device, by_rate in found.items():
        subprocess.run(["gnuplot"], input=figure_script(device, by_rate, said[device], folder / f"z_width_{device}.svg"), text=True, check=True)


def draw_methods(found, folder):
    for rate, by_device in found.items():
        subprocess.run(["gnuplot"], input=method_script(by_device, rate, folder / f"z_width_methods_{rate}.svg"), text=True, check=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out/z_width")
    parser.add_argument("--device", action="append", choices=DEVICES, help="may be repeated; none: all")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    found = measure(arguments.jobs, tuple(arguments.device or DEVICES))
    (arguments.out / "found.json").write_text(json.dumps(found, indent=1))
    said = theories(tuple(found))
    draw(found, said, arguments.out)
    methods = measure_methods(arguments.jobs, tuple(arguments.device or DEVICES))
    (arguments.out / "methods.json").write_text(json.dumps(methods, indent=1))
    draw_methods(methods, arguments.out)
    print(best_table(found, said))
    print(method_table(methods), end="")
