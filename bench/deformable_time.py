#!/usr/bin/python3
"""What the parts of a step of elastic bodies take by the number of tetrahedra, solvers beside each other, as a table and a plot.

`bench/deformable_time.py`, with a built release preset and google-benchmark: bench/deformable_bench.cpp measures.
"""
import json
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from run_time import table  # noqa: E402
from thresholds import plot  # noqa: E402

BENCH = ROOT / "build/release/bin/deformable_bench"
PICTURE = ROOT / "docs/images/deformable_time.svg"
#         name in the bench             column, title in the plot
PARTS = (("forces/corotational_linear", "forces"), ("assembly/warped_linear", "assembly"), ("factor/eigen", "factor, Eigen"),
         ("factor/simplicial", "factor, simplicial"), ("factor/supernodal", "factor, supernodal"),
         ("solve/supernodal", "solve, supernodal"), ("conjugate/small_turn", "CG, 0.05 rad"), ("conjugate/large_turn", "CG, 0.5 rad"))
COLOURS = ("#888888", "black", "#cc6677", "#ddaa33", "#228833", "#66ccee", "#4477aa", "#aa3377")


def measured():
    """{part: {tetrahedra asked for: (ms, iterations of CG or None)}}."""
    names = "|".join(name for name, _ in PARTS)
    said = subprocess.run([BENCH, f"--benchmark_filter=^({names})/", "--benchmark_format=json"], capture_output=True, text=True, check=True)
    found = {}
    for run in json.loads(said.stdout)["benchmarks"]:
        part, tetrahedra = run["name"].rsplit("/", 1)
        found.setdefault(part, {})[int(tetrahedra)] = (run["cpu_time"], run.get("cg_iterations"))
    return found


def scaling():
    """A Markdown table; draws the picture beside it."""
    found = measured()
    sizes = sorted({size for times in found.values() for size in times})

    def cell(part, size):
        if size not in found[part]:
            return ""
        time, iterations = found[part][size]
        return f"{time:.3g}" + (f" ({iterations:.0f})" if iterations else "")
    body = [[f"{size:,}", *(cell(part, size) for part, _ in PARTS)] for size in sizes]
    plot(PICTURE, "tetrahedra", "ms of CPU",
         [(title, [(size, times[0]) for size, times in sorted(found[part].items())], f"linespoints lw 2 pt 7 ps 0.5 lc rgb '{colour}'")
          for (part, title), colour in zip(PARTS, COLOURS)], "set logscale y\nset xrange [800:125000]\nset key outside right")
    return table(["tetrahedra", *(f"{title}, ms" for _, title in PARTS)], body)


if __name__ == "__main__":
    print(scaling())
