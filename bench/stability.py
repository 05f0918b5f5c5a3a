#!/usr/bin/python3
"""Maps of stability: what stability_bench found as tables and as a metric; `bench/stability.py FOUND.json` prints the tables.

scripts/stability_results runs the benchmark and writes docs/results/stability_results.md with these.
"""
import json
import pathlib
import statistics
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import page  # noqa: E402
from run_time import table  # noqa: E402

# The worst first. The colours grow darker from stable to the worst, so that they can be told apart without colour.
VERDICTS = {"not_finite": ("not finite", "#000000"), "energy": ("energy from nowhere", "#8c2d6b"),
            "pushed_through": ("pushed through", "#3f7fbf"), "limit_cycle": ("limit cycle", "#f0b040"),
            "stable": ("stable", "#eef3ea")}
CONTENDERS = {"tactor": "tactor", "tactor_as_made": "tactor, nothing taken", "ode": "ODE", "ode_quick": "ODE quick step",
              "ode_substeps": "ODE, sub-steps of 1 ms", "ode_explicit": "ODE, explicit spring"}
AXES = ("contact_stiffness", "mass", "rate", "coupling_stiffness")
UNITS = {"contact_stiffness": "N/m", "mass": "kg", "rate": "Hz", "coupling_stiffness": "N/m"}
FIGURES = ("verdict", "generated", "peak_to_peak_m", "rest_error_m", "step_s", "query_s", "simulated_s", "left_out", "damped_steps", "stopped_steps")
TIMED_RATE = 1000


def check_whole(found):
    """Raises ValueError where a cell lacks something, or the contenders of a scene did not run the same cells."""
    for scene in found["scenes"]:
        cells = {}
        for cell in scene["cells"]:
            missing = [key for key in ("contender", *AXES, *FIGURES) if key not in cell]
            if missing:
                raise ValueError(f"{scene['name']}: a cell without {', '.join(missing)}: {cell}")
            if cell["verdict"] not in VERDICTS:
                raise ValueError(f"{scene['name']}: expected one of {', '.join(VERDICTS)}, found {cell['verdict']!r}")
            seen = cells.setdefault(cell["contender"], set())
            if place(cell) in seen:
                raise ValueError(f"{scene['name']}: {cell['contender']} has two of the cell {place(cell)}")
            seen.add(place(cell))
        if len({frozenset(c) for c in cells.values()}) != 1:
            raise ValueError(f"{scene['name']}: expected the same cells of all, found {({n: len(c) for n, c in cells.items()})}")


def place(cell):
    return tuple(cell[axis] for axis in AXES)


def by_contender(scene):
    """{contender: {place: cell}}, in the order of CONTENDERS."""
    found = {name: {} for name in CONTENDERS}
    for cell in scene["cells"]:
        found[cell["contender"]][place(cell)] = cell
    return {name: cells for name, cells in found.items() if cells}


def timed(cells):
    """Milliseconds of the stepper for a simulated second at 1 kHz, over all cells."""
    chosen = [c for c in cells if c["rate"] == TIMED_RATE and c["simulated_s"] > 0]
    seconds = sum(c["simulated_s"] for c in chosen)
    return 1e3 * sum(c["step_s"] for c in chosen) / seconds if seconds else None


def counts(found):
    """A row for each scene and contender: how many cells of each verdict, the error at rest, the time."""
    rows = []
    for scene in found["scenes"]:
        for name, cells in by_contender(scene).items():
            cells = list(cells.values())
            errors = [c["rest_error_m"] for c in cells if c["verdict"] == "stable" and c["rest_error_m"] is not None]
            rows.append([scene["name"], CONTENDERS[name], len(cells),
                         *(sum(c["verdict"] == v for c in cells) for v in reversed(VERDICTS)),
                         1e6 * statistics.median(errors) if errors else None, 1e6 * max(errors) if errors else None,
                         timed(cells)])
    return table(["scene", "", "cells", *(VERDICTS[v][0] for v in reversed(VERDICTS)), "off balance, median, um",
                  "largest, um", "ms a simulated s at 1 kHz"], rows)


def against(found):
    """A row for each scene and way of ODE: where one is stable and the other is not."""
    rows = []
    for scene in found["scenes"]:
        cells = by_contender(scene)
        ours = {p for p, c in cells["tactor"].items() if c["verdict"] == "stable"}
        for name in cells:
            if name == "tactor":
                continue
            theirs = {p for p, c in cells[name].items() if c["verdict"] == "stable"}
            rows.append([scene["name"], CONTENDERS[name], len(ours & theirs), len(ours - theirs), len(theirs - ours),
                         len(cells["tactor"]) - len(ours | theirs)])
    return table(["scene", "tactor beside", "both stable", "only tactor", "only the other", "neither"], rows)


def failures(found):
    """Every cell in which ours is not stable."""
    rows = []
    for scene in found["scenes"]:
        for cell in by_contender(scene)["tactor"].values():
            if cell["verdict"] != "stable":
                swing = cell["peak_to_peak_m"]
                rows.append([scene["name"], *(f"{value:g}" for value in place(cell)), VERDICTS[cell["verdict"]][0],
                             None if cell["generated"] is None else f"{100 * cell['generated']:.3g}",
                             None if swing is None else f"{1e6 * swing:.3g}"])
    if not rows:
        return "None."
    return table(["scene", *(f"{axis.replace('_', ' ')}, {UNITS[axis]}" for axis in AXES), "verdict", "energy made, %",
                  "swing, um"], rows)


def without_balance(found):
    """How many cells of which scenes no balance of forces was held against."""
    parts = []
    for scene in found["scenes"]:
        cells = by_contender(scene)["tactor"].values()
        unknown = sum(c["rest_error_m"] is None for c in cells)
        if unknown:
            parts.append(f"{unknown} of the {len(cells)} cells of `{scene['name']}`")
    return ", ".join(parts) or "none"


def steps_of_ours(found):
    """How often our step needed its fallbacks."""
    rows = []
    for scene in found["scenes"]:
        cells = by_contender(scene)["tactor"].values()
        rows.append([scene["name"], sum(c["damped_steps"] for c in cells), sum(c["stopped_steps"] for c in cells),
                     f"{sum(max(c['rate'], TIMED_RATE) * c['simulated_s'] for c in cells):.3g}"])
    return table(["scene", "damped steps", "stopped steps", "of sub-steps"], rows)


def title_lines(found):
    return "\n".join(page.wrapped(f"- `{scene['name']}`: {scene['title']}.", "  ") for scene in found["scenes"])


def grams(kg):
    return f"{kg:g} kg" if kg >= 1 else f"{1e3 * kg:g} g"


def figure_script(scene, file):
    """What gnuplot draws into `file`: a row of panels for each contender, one panel a rate. In a panel masses go to the right,
    within each mass the coupling stiffnesses, and contact stiffnesses upwards."""
    cells = by_contender(scene)
    contact, masses, rates, couplings = (sorted({c[axis] for c in scene["cells"]}) for axis in AXES)
    terminal = {".svg": "svg font 'sans,11'", ".png": "pngcairo font 'sans,11'"}[pathlib.Path(file).suffix]
    width, height = 230 * len(rates) + 130, 150 * len(cells) + 110
    left, right, top, bottom = 0.115, 0.995, 0.9, 0.085
    lines = [f"set terminal {terminal} size {width},{height} background rgb 'white'", f"set output '{file}'",
             "set multiplot", "unset key", "set border lc rgb '#606060'", "set tics scale 0 font ',9'",
             f"set xrange [0:{len(masses)}]", f"set yrange [0:{len(contact)}]", "set style fill solid noborder"]
    step_x, step_y = (right - left) / len(rates), (top - bottom) / len(cells)
    label = 0
    for verdict, (text, colour) in reversed(VERDICTS.items()):
        x = left + 0.17 * label
        label += 1
        lines += [f"set object {label} rectangle from screen {x},0.952 to screen {x + 0.014},0.976 fc rgb '{colour}' fs solid "
                  f"border lc rgb '#606060'", f"set label {label} '{text}' at screen {x + 0.018},0.964 left"]
    caption = (f"to the right: mass of the tool, within each the coupling from {couplings[0]:g} to {couplings[-1]:g} N/m; "
               "upwards: stiffness of the contact, N/m")
    lines.append(f"set label 20 '{caption}' at screen {(left + right) / 2},0.02 center")
    for row, (name, found) in enumerate(cells.items()):
        y = top - (row + 1) * step_y
        lines.append(f"set label {30 + row} \"{CONTENDERS[name].replace(', ', chr(92) + 'n')}\" at screen 0.004,{y + 0.55 * step_y} left "
                     "font ',11'")
        for column, rate in enumerate(rates):
            x = left + column * step_x
            block = f"$c{row}_{column}"
            lines.append(f"{block} << EOD")
            for i, m in enumerate(masses):
                for j, k in enumerate(couplings):
                    for n, c in enumerate(contact):
                        x0, x1 = i + 0.04 + 0.92 * j / len(couplings), i + 0.04 + 0.92 * (j + 1) / len(couplings)
                        colour = VERDICTS[found[(c, m, rate, k)]["verdict"]][1]
                        lines.append(f"{(x0 + x1) / 2} {n + 0.5} {x0} {x1} {n + 0.03} {n + 0.97} 0x{colour[1:]}")
            lines.append("EOD")
            lines += [f"set lmargin at screen {x + 0.006}", f"set rmargin at screen {x + step_x - 0.006}",
                      f"set bmargin at screen {y + 0.012}", f"set tmargin at screen {y + step_y - 0.012}",
                      "set format x ''" if row + 1 < len(cells) else "set format x '%g'",
                      ("set ytics (" + ", ".join(f"'1e{len(str(int(c))) - 1}' {n + 0.5}" for n, c in enumerate(contact)) + ") font ',8'")
                      if column == 0 else "unset ytics",
                      "set xtics (" + ", ".join(f"'{grams(m)}' {i + 0.5}" for i, m in enumerate(masses)) + ") font ',8'"
                      if row + 1 == len(cells) else "unset xtics",
                      f"set title 'physics at {rate:g} Hz' offset 0,-0.6" if row == 0 else "unset title",
                      f"plot {block} using 1:2:3:4:5:6:7 with boxxyerror lc rgb variable"]
            # Labels and legend are drawn with the first panel only.
            if row == 0 and column == 0:
                lines += ["unset object", *(f"unset label {n + 1}" for n in range(len(VERDICTS))), "unset label 20"]
            lines.append(f"unset label {30 + row}")
    return "\n".join([*lines, "unset multiplot", ""])


def is_full(scene):
    """True where every value of every axis was run with every other, and each axis has several."""
    axes = [{c[axis] for c in scene["cells"]} for axis in AXES]
    return all(len(a) > 1 for a in axes) and len({place(c) for c in scene["cells"]}) == len(axes[0]) * len(axes[1]) * \
        len(axes[2]) * len(axes[3])


def draw(scene, file):
    subprocess.run(["gnuplot"], input=figure_script(scene, file), text=True, check=True)


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    found = json.loads(pathlib.Path(sys.argv[1]).read_text())
    check_whole(found)
    print(counts(found), against(found), failures(found), steps_of_ours(found), sep="\n\n")


if __name__ == "__main__":
    main()
