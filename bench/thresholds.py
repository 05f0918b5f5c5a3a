#!/usr/bin/python3
"""What a hand notices, by the curves of the metrics: their tables, their pictures, and the spectra of errors of methods.

A library for `scripts/thresholds` and its test. Levels of bands are computed anew here, by scipy, from the curves of a report.
"""
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from scipy import signal

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
sys.path.insert(0, str(BUILD / "python"))

EXACT = "local_exact"  # `local` on an encoder without steps
COLOURS = ("black", "#d62728", "#1f77b4", "#2ca02c", "#ff7f0e", "#9467bd", "#8c564b", "#17becf")

# Others' thresholds of vibration, peak displacement in um by Hz. All as quoted in row HAP-27 and HAP-28 of the ledger
# docs/research/ledger/HAP_guidance_impedance.csv of the repository adambickerdike/Stabilisation_Pen, commit bbcf1c79.
PEN_HOLD_UM = {10: 26.0, 20: 8.5, 160: 26.0 * 10 ** (-13 * 4 / 20), 320: 0.06}  # Israr, Choi, Tan 2006; -13 dB an octave from 10 to 160 Hz
GRASPED_CYLINDER_UM = {150: 0.03}  # Brisben, Hsiao, Johnson 1999
THENAR_UM = {300: 0.13}  # Bolanowski et al. 1988: the palm, pressed by a probe with a surround
# Fu, Cavusoglu 2012: kg of the hand, N/m and N s/m of the grasp, N/m and N s/m of the arm; nominal, Table II, by direction. HAP-26 there.
STYLUS_HANDS = {"X": (0.218, 379.5, 1.839, 78.75, 4.645), "Y": (0.269, 552.4, 3.609, 105.3, 6.430), "Z": (0.204, 769.9, 0.776, 271.7, 18.06)}
SIMULATED_HAND = (0.55, 6.5, 135.0)  # kg, N s/m, N/m: that of device.simulated, bolted to its handle


def reachable(found):
    """The scenes of a study in which no vibration of EXACT is felt, and the others: an encoder without steps shows what a filter could reach."""
    levels = {row["graph"]: row["metrics"].get("delivered.force.vibration_above_threshold_dB", {}).get("mean") for row in found["rows"]
              if row["method"] == EXACT}
    met = [scene for scene, level in levels.items() if level is not None and level < 0]
    return met, [scene for scene in levels if scene not in met]


def curves():
    """What bench/threshold_curves prints."""
    program = next(p for p in BUILD.rglob("threshold_curves") if p.is_file())
    return json.loads(subprocess.run([program], check=True, capture_output=True, text=True).stdout)


def band_mean_squares(error, centre, rate):
    """The squares of the part of an error (samples by axes) in a third of an octave, over time; by scipy."""
    half = 10 ** 0.05
    sections = signal.butter(3, [centre / half, centre * half], "bandpass", fs=rate, output="sos")
    pad = min(len(error) - 1, int(np.ceil(2 * rate / (centre * half - centre / half))))
    whole = np.concatenate([2 * error[0] - error[pad:0:-1], error])
    return (signal.sosfilt(sections, whole - whole[0], axis=0)[pad:] ** 2).sum(axis=1)


def bands_of(error, rate, bands):
    """(nominal Hz, N of its threshold, squares over time) of each band of an error (samples by axes) that the rate can show; `bands` as curves()
    has them."""
    for nominal, centre, threshold in bands:
        if centre * 10 ** 0.05 >= 0.45 * rate:
            break
        yield nominal, threshold, band_mean_squares(error, centre, rate)


def levels(result, bands):
    """{nominal Hz: (dB of the mean, dB of the worst half second)} of a result of tactor.run; `bands` as curves() has them."""
    axes = [[result.series[f"{name}.{axis}"]["value"] for axis in "xyz"] for name in ("commanded", "reference")]
    time = result.series["commanded.x"]["time"]
    judged = time >= result.metrics["judged.from_s"] - 1e-9
    time, error = time[judged], (np.array(axes[0]) - np.array(axes[1])).T[judged]
    rate = (len(time) - 1) / (time[-1] - time[0])
    found = {}
    for nominal, threshold, squares in bands_of(error, rate, bands):
        window = round(0.5 * rate)
        begins = [*range(0, len(squares) - window + 1, window // 2), len(squares) - window]
        worst = max(squares[b:b + window].mean() for b in begins)
        found[nominal] = tuple(10 * np.log10(s / threshold**2) for s in (squares.mean(), worst))
    return found


def rms_acceleration(um_by_hz):
    """m/s^2 RMS of sinusoids of a peak displacement in um."""
    return [(hz, (2 * np.pi * hz) ** 2 * um * 1e-6 / np.sqrt(2)) for hz, um in um_by_hz.items()]


def bolted_force(curve, handle_mass):
    """N: the force that makes handle and simulated hand, one body, vibrate at a curve of accelerations."""
    mass, damping, stiffness = SIMULATED_HAND
    w = [2 * np.pi * hz for hz, _ in curve]
    return [(hz, a * abs((handle_mass + mass) + damping / (1j * v) - stiffness / v**2)) for (hz, a), v in zip(curve, w)]


def stylus_force(curve, handle_mass, direction):
    """N: the same with a hand of STYLUS_HANDS behind its grasp, beside a handle."""
    mass, k_grasp, b_grasp, k_arm, b_arm = STYLUS_HANDS[direction]
    points = []
    for hz, a in curve:
        s = 2j * np.pi * hz
        grasp, behind = b_grasp + k_grasp / s, mass * s + b_arm + k_arm / s
        points.append((hz, a * abs((handle_mass * s + grasp * behind / (grasp + behind)) / s)))
    return points


def plot(file, xlabel, ylabel, lines, more="", size="820,420"):
    """`lines`: (title, points, gnuplot's style)."""
    with tempfile.TemporaryDirectory() as folder:
        parts = []
        for i, (title, points, style) in enumerate(lines):
            data = pathlib.Path(folder) / f"{i}.dat"
            data.write_text("\n".join(" ".join(f"{v:.6g}" for v in point) for point in points))
            parts.append(f"'{data}' using 1:2 with {style} title '{title}'")
        script = (f"set terminal svg size {size} font 'sans,13' background 'white'\nset output '{file}'\nset grid\nset logscale x\n"
                  f"set xlabel '{xlabel}'\nset ylabel '{ylabel}'\n{more}\nplot " + ", ".join(parts) + "\n")
        subprocess.run(["gnuplot"], input=script, text=True, check=True)


def draw(found, images):
    """The three pictures of curves."""
    line, dots = "lines lw {} lc rgb '{}' dt {}", "points pt 7 ps 0.8 lc rgb '{}'"
    weber = found["weber_curve"]
    plot(images / "thresholds_weber.svg", "steady force, N", "smallest difference noticed, N",
         [("max(0.04 N, 7 %), for share beyond jnd", [(f, max(0.04, 0.07 * f)) for f, _ in weber], line.format(1.5, "#888888", 2)),
          ("Weber curve, for share beyond weber", weber, line.format(2.5, "black", 1)),
          ("its rows", [p[:2] for p in found["weber"]], dots.format("black"))],
         "set logscale y\nset xrange [0.005:20]\nset yrange [0.02:2]\nset key left top")
    beyond = found["vibration"][-1][0]
    plot(images / "thresholds_vibration.svg", "Hz", "m/s^2, RMS",
         [("gripped handle (Morioka, Griffin 2006), used", [p for p in found["vibration_curve"] if p[0] <= beyond], line.format(2.5, "black", 1)),
          ("the same displacement above 315 Hz, used", [p for p in found["vibration_curve"] if p[0] >= beyond], line.format(2.5, "black", 3)),
          ("its rows", [p[:2] for p in found["vibration"]], dots.format("black")),
          ("pen hold (Israr et al. 2006)", rms_acceleration(PEN_HOLD_UM), "linespoints pt 5 ps 0.7 lw 1.5 lc rgb '#1f77b4'"),
          ("grasped cylinder (Brisben et al. 1999)", rms_acceleration(GRASPED_CYLINDER_UM), "points pt 9 ps 1.2 lc rgb '#2ca02c'"),
          ("palm, probe (Bolanowski et al. 1988)", rms_acceleration(THENAR_UM), "points pt 11 ps 1.2 lc rgb '#d62728'")],
         "set logscale y\nset xrange [8:500]\nset yrange [0.01:1]\nset key left top", "820,460")
    force = [("no handle, a pen hold" if m == "0" else f"handle of {1000 * float(m):.0f} g held like a pen" + (", used" if m == "0.1" else ""),
              [(hz, 1e3 * f) for hz, f in found["force_curves"][m]], line.format(2.5 if m == "0.1" else 1.5, colour, 1))
             for m, colour in (("0.2", "#ff7f0e"), ("0.1", "black"), ("0.045", "#1f77b4"), ("0", "#2ca02c"))]
    plot(images / "thresholds_force.svg", "Hz", "mN, RMS",
         [("100 g bolted to the simulated hand", [(hz, 1e3 * f) for hz, f in bolted_force(found["vibration_curve"], 0.1)], line.format(1.5, "#888888", 2)),
          *force,
          ("100 g, another model of the hand (Fu, Cavusoglu 2012)", [(hz, 1e3 * f) for hz, f in stylus_force(found["vibration_curve"], 0.1, "X")],
           line.format(1.2, "black", 2))],
         "set logscale y\nset xrange [8:500]\nset yrange [0.01:1000]\nset key below vertical maxrows 3", "820,560")


def draw_methods(spectra, file):
    """Spectra over the threshold, a step a band. `spectra`: {method: levels()}"""
    lines = [("threshold", [(10, 0), (400, 0)], "lines lw 1 lc rgb '#888888' dt 2")]
    for (name, found), colour in zip(spectra.items(), ("#888888", "#2ca02c", "#9467bd", "#1f77b4", "#ff7f0e", "black", "#8c564b")):
        lines.append((name.replace("_", " "), [(hz, mean) for hz, (mean, _) in found.items()], f"linespoints pt 7 ps 0.5 lw 1.8 lc rgb '{colour}'"))
    plot(file, "Hz, thirds of octaves", "dB above the threshold", lines,
         "set xrange [9:450]\nset xtics (10, 20, 40, 80, 160, 315)\nset key outside right top", "820,440")
