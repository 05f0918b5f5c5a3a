#!/usr/bin/python3
"""The stiffest virtual wall that is stable, measured in closed loop and computed from the loop's eigenvalues, as a Markdown table.

`bench/virtual_wall.py`, with a built release preset and Debian's python3-scipy. Each row is a period of the device, a delay of its
lines and a pair of dampings: graphs/virtual_wall/linear.yaml, two-sided, without friction and encoder steps. The measured limit is
found by bisection; a run is stable where what is left of the first micrometre is less in the last third of the run than in the
second.
"""
import itertools
import math
import os
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
if "TACTOR_BUILD" not in os.environ:
    sys.path.insert(0, str(ROOT / "build/release/python"))
import sampled_loop  # noqa: E402
from run_time import table  # noqa: E402

PERIODS = (0.25e-3, 0.5e-3, 1e-3, 2e-3, 4e-3)  # s
LINES = (0, 1, 3)  # ticks of delay_out, beside the one from each sample to its command
DAMPINGS = ((2.0, 0.0), (1.0, 0.8))  # N s/m, of the device and of the wall
TICKS = 3000
START = 1e-6  # m


def settings(device, period, lines):
    """What a run of graphs/virtual_wall/linear.yaml sets."""
    duration = TICKS * period
    found = {f"device.{name}": value for name, value in vars(device).items()}
    return found | {"rate": 1 / period, "duration": duration, "device.delay_out": lines * period, "device.sub_step": 1e-2,
                    "trajectory.points": f"[{{t: 0 s, z: {START} m}}, {{t: {duration} s, z: {START} m}}]"}


def motion(device, period, lines, stiffness, damping):
    """m, the handle's position at each tick, let go at START."""
    import tactor

    result = tactor.run("virtual_wall/linear", taps=["device.truth"], without_reference=True,
                        set=settings(device, period, lines) | {"wall.stiffness": stiffness, "wall.damping": damping})
    return abs(result.taps["device.truth"]["p_WD"][:, 2])


def is_stable(x):
    """True where a motion in sizes (m) from START dies out."""
    third = len(x) // 3
    return max(x) < 1e3 * START and max(x[-third:]) < max(x[third:-third])


def measured(device, period, lines, damping, guess=100.0, accuracy=0.01):
    """N/m: the largest stable stiffness below the first unstable one, within `accuracy` of itself; looked for from `guess` on."""
    def stable(stiffness):
        return is_stable(motion(device, period, lines, stiffness, damping))

    low = high = guess
    while not stable(low):
        low /= 1.5
        if low < 1e-3:
            return 0.0
    high = max(high, 1.5 * low)
    while stable(high):
        low, high = high, 1.5 * high
    while high > (1 + accuracy) * low:
        middle = math.sqrt(low * high)
        low, high = (middle, high) if stable(middle) else (low, middle)
    return math.sqrt(low * high)


def gil(period, lines, dampings):
    """N/m: (b + B) / (T/2 + t_d), with the delay t_d from sample to command."""
    return sum(dampings) / (period / 2 + (lines + 1) * period)


def rows():
    for period, lines, dampings in itertools.product(PERIODS, LINES, DAMPINGS):
        device = sampled_loop.Device(damping=dampings[0])
        found = measured(device, period, lines, dampings[1])
        exact = sampled_loop.limit(device, period, lines + 1, dampings[1])
        passive = sampled_loop.passive_limit(dampings[0], period, lines + 1, dampings[1])
        yield [f"{1e3 * period:g}", lines + 1, f"{dampings[0]:g}", f"{dampings[1]:g}", f"{found:.0f}", f"{exact:.0f}",
               f"{100 * (found / exact - 1):+.1f}", f"{gil(period, lines, dampings):.0f}", f"{passive:.0f}" if passive > 0 else "none"]


HEAD = ["period, ms", "ticks late", "b, N s/m", "B, N s/m", "measured, N/m", "exact loop, N/m", "off by, %", "(b + B)/(T/2 + t_d), N/m",
        "passive up to, N/m"]

if __name__ == "__main__":
    print(table(HEAD, list(rows())), end="")
