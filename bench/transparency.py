#!/usr/bin/python3
"""The impedance that a hand meets beside the one that was asked for, by method: a Markdown table and a picture.

`bench/transparency.py [--rate HZ] [--picture FILE.svg]`, with a built release preset. The handle is led up and down inside a flat wall by a
sum of sinusoids, so that the tool never leaves the wall and what is asked for is linear. At each frequency the force that the motors hold
from tick to tick is divided by the true position of the handle. Two motions: one to 36 Hz, as a hand makes it, and one to 100 Hz, which
tells of vibration.
"""
import argparse
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
sys.path.insert(0, str(BUILD / "python"))
from run_time import table  # noqa: E402

METHODS = ("hold", "lowpass", "linear", "linear_position", "fixed", "paper", "refit", "burg", "rls", "kalman", "multirate", "hermite_cubic",
           "catmull_rom", "blend", "local_anchors", "local", "local, midpoint", "floor")
MIDPOINT = {"dynamics.integrator": "midpoint"}
SETTINGS = {"midpoint": MIDPOINT, "midpoint, 2 kHz": MIDPOINT | {"rate": 2000}, "midpoint, 4 kHz": MIDPOINT | {"rate": 4000},
            "midpoint, no encoder steps": MIDPOINT | {"device.encoder_step": 0}}  # by what stands behind a method's comma
TICK = 1e-3  # s
PERIOD = 20  # s, after which the motion repeats
SETTLE = 4  # s, before the first period that counts
MASS, SPRING, ZETA = 0.05, 500.0, 1.0  # kg, N/m, 1: tool and coupling
WALL, TOOL, CONTACT_DAMPING = 2000.0, 20000.0, 2.0  # N/m, N/m, N s/m
TOUCHES = 4e-3  # m, the handle's height where the tool touches
DEPTH = 5e-3  # m, the mean, of the handle
SMALL, WIDE = 0.7, 0.35  # by which power of the frequency the way falls above 1 Hz: 14 and 46 um at 29 Hz
CAUSES = ("local", "local, midpoint", "local, midpoint, 2 kHz", "local, midpoint, 4 kHz", "local, midpoint, no encoder steps", "floor", "floor, midpoint")
BANDS = {10: 36, 30: 36, 100: 101}  # Hz, up to which the worst is told, and up to which the handle moves then
SCENE = {"nodes": {"coupling": {"type": "coupling.dynamic", "k_t": SPRING, "zeta": ZETA}}}


def lines(most=101):
    """Harmonics of 1 / PERIOD, odd and about evenly spread by the logarithm, from 0.1 to `most` Hz."""
    wanted = np.geomspace(0.1 * PERIOD, 100 * PERIOD, 40)
    harmonics = np.unique(2 * np.round((wanted - 1) / 2).astype(int) + 1)
    return harmonics[harmonics <= most * PERIOD]


def motion(t, most, fall=SMALL, seed=1):
    """m, the way of the handle about its mean: a sum of sinusoids up to `most` Hz with random phases, 0.15 mm each, less above 1 Hz."""
    hz = lines(most) / PERIOD
    phases = np.random.default_rng(seed).uniform(0, 2 * np.pi, len(hz))
    amplitude = 1.5e-4 / np.maximum(1, hz) ** fall
    return (amplitude * np.cos(2 * np.pi * np.outer(t, hz) + phases)).sum(axis=1)


def target(hz):
    """N/m, the complex stiffness that was asked for: the coupling's spring and damper, the tool's mass and the wall's, in continuous time."""
    s = 2j * np.pi * np.asarray(hz)
    coupling = SPRING + 2 * ZETA * np.sqrt(SPRING * MASS) * s
    contact = 1 / (1 / WALL + 1 / TOOL) + CONTACT_DAMPING * s
    return coupling * (MASS * s**2 + contact) / (MASS * s**2 + contact + coupling)


def spectrum(values, harmonics, periods=1):
    """The complex amplitudes of samples that span so many whole periods."""
    n = len(values)
    return 2 / n * np.exp(-2j * np.pi * np.outer(harmonics, np.arange(n)) * periods / n) @ values


def rendered(force, position, harmonics, periods=1, tick=TICK):
    """N/m, complex: the force that is held over each tick, for the position at its begin. The force that is asked for is -stiffness * way."""
    w = 2 * np.pi * harmonics / PERIOD
    hold = (1 - np.exp(-1j * w * tick)) / (1j * w * tick)
    return -spectrum(force, harmonics, periods) * hold / spectrum(position, harmonics, periods)


def measure(name, hz_of_physics, path, most, periods=2):
    """The rendered stiffness at each line (N/m, complex), and the share of the force's RMS that no line explains."""
    import tactor
    method, _, setting = name.partition(", ")
    settings = {"trajectory.points": None, "trajectory.file": str(path), "trajectory.interpolation": "cubic", "trajectory.tremor_amplitude": 0,
                "trajectory.repeat_after": 0, "duration": SETTLE + periods * PERIOD} | SETTINGS.get(setting, {})
    if not method.startswith("floor"):  # which has a rate of its own
        settings["collision.cost"] = {"constant": f"{1000 / hz_of_physics:.6g} ms", "min": "0 ms", "max": "1 s"}
    with tactor.Session("wall/scene", over=[method, SCENE], set=settings) as session:
        force, truth = session.tap("device.commanded"), session.tap("device.truth")
        session.run()
        f, x = force.take()["force"][:, 2], truth.take()["p_WD"][:, 2]
    tick = 1 / settings.get("rate", 1 / TICK)
    n = round(periods * PERIOD / tick)
    f, x = f[-n:], x[-n:]
    explained = 0.5 * np.sum(np.abs(spectrum(f, lines(most), periods))**2)
    return rendered(f, x, lines(most), periods, tick), np.sqrt(max(0.0, np.var(f) - explained) / np.var(f))


def errors(found):
    """dB and degrees at each line, of the rendered stiffness against the target; positive degrees lead."""
    ratio = found / target(lines()[:len(found)] / PERIOD)
    return 20 * np.log10(np.abs(ratio)), np.degrees(np.angle(ratio))


HEAD = ["method", *[f"to {band} Hz: {unit}" for band in BANDS for unit in ("dB", "degrees")], "unexplained to 36 Hz, %", "to 100 Hz, %"]


def row(name, found):
    """A row of the table: of each band the error that is farthest from zero, with its sign. `found`: by the end of the motion, Hz."""
    worst = []
    for band, motion_to in BANDS.items():
        inside = lines(motion_to) / PERIOD <= 1.002 * band
        worst += [values[inside][np.argmax(np.abs(values[inside]))] for values in errors(found[motion_to][0])]
    return [name, *worst, *(100 * unexplained for _, unexplained in found.values())]


def write_path(folder, most, fall=SMALL):
    t = np.arange(0, SETTLE + 3 * PERIOD, TICK)
    file = pathlib.Path(folder) / f"path_{most}_{fall}.csv"
    down = np.minimum(t, 1)  # it comes from outside within a second
    z = TOUCHES + 2e-3 + (3 * down**2 - 2 * down**3) * (motion(t, most, fall) - DEPTH - 2e-3)
    np.savetxt(file, np.column_stack([t, np.zeros((len(t), 2)), z]), fmt="%.9g", delimiter=",", header="t [s],x [m],y [m],z [m]", comments="")
    return file


def measure_all(hz, methods=METHODS):
    """{method: {end of the motion, Hz: what measure gives}}"""
    with tempfile.TemporaryDirectory() as folder:
        paths = {most: write_path(folder, most) for most in dict.fromkeys(BANDS.values())}
        return {method: {most: measure(method, hz, path, most) for most, path in paths.items()} for method in methods}


CAUSE_HEAD = ["method", *(f"{way} motion: {unit}" for way in ("small", "wider") for unit in ("dB", "degrees"))]


def causes(hz, names=CAUSES):
    """Rows of what the error to 30 Hz is made of: by two motions, the error farthest from zero, with its sign."""
    with tempfile.TemporaryDirectory() as folder:
        paths = [write_path(folder, BANDS[30], fall) for fall in (SMALL, WIDE)]
        for name in names:
            cells = []
            for path in paths:
                found = errors(measure(name, hz, path, BANDS[30])[0])
                inside = lines(BANDS[30]) / PERIOD <= 1.002 * 30
                cells += [values[inside][np.argmax(np.abs(values[inside]))] for values in found]
            yield [name, *cells]


def draw(found, file, methods=("hold", "lowpass", "paper", "blend", "local")):
    """Magnitude and phase against the frequency, the target in black."""
    hz = lines() / PERIOD
    shown = {"asked for": target(hz)} | {m: found[m][max(BANDS.values())][0] for m in methods}
    data = "\n\n\n".join("\n".join(f"{f:.6g} {20 * np.log10(abs(k)):.6g} {p:.6g}" for f, k, p in
                                   zip(hz, stiffness, np.degrees(np.unwrap(np.angle(stiffness))))) for stiffness in shown.values())
    colours = ("black", "#888888", "#2ca02c", "#1f77b4", "#ff7f0e", "#d62728")
    with tempfile.NamedTemporaryFile("w", suffix=".dat") as points:
        points.write(data)
        points.flush()
        curves = ", ".join(f"'{points.name}' index {i} using 1:COLUMN with lines lw {3 if i == 0 else 1.5} "
                           f"lc rgb '{colours[i]}' title '{name.replace('_', ' ')}'" for i, name in enumerate(shown))
        script = f"""set terminal svg size 900,640 font 'sans,13' background 'white'
set output '{file}'
set logscale x
set grid
set multiplot layout 2,1
set xrange [0.1:100]
set ylabel 'stiffness, dB re 1 N/m'
set key left bottom
plot {curves.replace('COLUMN', '2')}
set ylabel 'phase, degrees'
set xlabel 'Hz'
set yrange [-180:180]
set ytics 45
unset key
plot {curves.replace('COLUMN', '3')}
"""
        subprocess.run(["gnuplot"], input=script, text=True, check=True)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rate", type=float, default=60, help="Hz, of physics")
    parser.add_argument("--picture", type=pathlib.Path)
    arguments = parser.parse_args()
    all_found = measure_all(arguments.rate)
    print(table(HEAD, [row(name, found) for name, found in all_found.items()]), end="")
    if arguments.picture:
        draw(all_found, arguments.picture)
