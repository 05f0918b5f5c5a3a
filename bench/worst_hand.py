#!/usr/bin/python3
"""Searches for the passive hand in which a method bears the softest coupling only, and writes it to graphs/hands.

`bench/worst_hand.py [--method NAME] [--hands N] [--jobs N]`, with a built release preset and Debian's python3-scipy. A run is that of
bench/closed_loop.py at the wall: a hand comes down, pushes once and rests 2 or 5 mm inside. Physics runs at 100 Hz. The device has no
friction while it is searched, because dry friction hides small cycles.

The hand is a mass on a spring and a damper, behind a grip, which is a spring and a damper too, or rigid. First come N hands of a
scrambled Sobol sequence over RANGES. Each is tried at the softest coupling that is not yet known to be restless in any hand, and a
restless one lowers that by a step of the ladder. Then Nelder and Mead's method goes on from the worst, for the hand that is fastest at
the end of the run.
"""
import argparse
import concurrent.futures
import dataclasses
import json
import math
import os
import pathlib
import sys

import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
if "TACTOR_BUILD" not in os.environ:
    sys.path.insert(0, str(ROOT / "build/release/python"))
import closed_loop  # noqa: E402
from run_time import table  # noqa: E402

METHODS = closed_loop.METHODS
RATE = 100  # Hz, of physics
LADDER = tuple(50 * 2 ** (step / 2) for step in range(-7, 16))  # N/m, 4.4 to 9,051
KNOWN_LADDER = LADDER[7:]  # from 50 N/m
FRICTION = 0.05  # N, of the graph's device
HANDS = ROOT / "graphs/hands"


@dataclasses.dataclass(frozen=True)
class Hand:
    """SI units, the names of device.simulated. Both of the grip 0: it is rigid."""
    hand_mass: float
    hand_damping: float
    hand_stiffness: float
    grip_stiffness: float = 0.0
    grip_damping: float = 0.0

    def text(self):
        grip = "rigid grip" if self.grip_stiffness == self.grip_damping == 0 else (
            f"grip {self.grip_stiffness:.3g} N/m, {self.grip_damping:.3g} N s/m")
        return f"{self.hand_mass:.3g} kg, {self.hand_damping:.3g} N s/m, {self.hand_stiffness:.3g} N/m; {grip}"


KNOWN = {"firm": Hand(0.55, 6.5, 135), "light": Hand(0.15, 2, 40), "undamped": Hand(0.55, 0, 135), "finger": Hand(0.05, 0.2, 40)}
# Ours: from a finger to an arm that leans on the handle, from a pad of skin to a fist. The stiffest hand asks for 2.5 N at rest.
RANGES = {"hand_mass": (0.02, 2), "hand_damping": (0.02, 20), "hand_stiffness": (20, 500), "grip_stiffness": (200, 20000),
          "grip_damping": (0.02, 20)}
NONE = 0.1  # of a damping's range is no damping, of the grip's stiffness a rigid grip


def hand_of(point):
    """The hand of a point in the unit cube, five coordinates; what is outside counts as at the border."""
    def logarithmic(share, name):
        low, high = RANGES[name]
        return low * (high / low) ** share

    u = [min(max(float(c), 0.0), 1.0) for c in point]
    damping, grip_damping = (0.0 if c < NONE else logarithmic((c - NONE) / (1 - NONE), name)
                             for c, name in ((u[1], "hand_damping"), (u[4], "grip_damping")))
    rigid = u[3] > 1 - NONE
    return Hand(logarithmic(u[0], "hand_mass"), damping, logarithmic(u[2], "hand_stiffness"),
                0.0 if rigid else logarithmic(u[3] / (1 - NONE), "grip_stiffness"), 0.0 if rigid else grip_damping)


def keeps_moving(speeds):
    """True where in the last eighth the handle is faster than closed_loop.SPEED, and not much slower than in the one before."""
    before, last = speeds[len(speeds) * 6 // 8:len(speeds) * 7 // 8].max(), speeds[len(speeds) * 7 // 8:].max()
    return bool(last >= closed_loop.SPEED and last >= 0.7 * before)


def is_driven(positions, speeds, forces, faults=0):
    """True where the motors keep the handle moving: it keeps moving, and over the last quarter the energy that the forces (N, one a
    tick, held) give it grows. What a steady force gives does not count. A hand that rings and is slowed by the device is not driven. A
    device that was once without its force counts as driven, and so does what is not finite."""
    if faults or not numpy.isfinite(speeds).all():
        return True
    if not keeps_moving(speeds):
        return False
    quarter = len(speeds) * 3 // 4
    held = forces[quarter:-1] - forces[quarter:-1].mean(axis=0)
    given = numpy.cumsum((held * numpy.diff(positions[quarter:], axis=0)).sum(axis=1))
    # Its trend: within a swing the energy goes to and fro.
    return bool(numpy.polyfit(numpy.arange(len(given)), given, 1)[0] > 0)


def settings(stiffness, rate, hand, depth, friction):
    """What a run sets, by name; `rate` None: the method's own, `friction` None: the device's own."""
    texts = closed_loop.settings(stiffness, rate, "firm", depth)
    values = dict(text.split("=", 1) for text in texts)
    return (values | {f"device.{name}": value for name, value in vars(hand).items()} |
            ({} if friction is None else {"device.friction": friction}))




def tried(method, stiffness, hand, friction=0.0, rate=RATE):
    """(driven, largest speed in the last quarter in m/s) over both depths."""
    import tactor

    driven, fastest = False, 0.0
    for depth in closed_loop.DEPTHS:
        found = tactor.run("wall/closed_loop", over=[method], taps=["device.truth", "device.commanded"], without_reference=True,
                           set=settings(stiffness, None if method.startswith("floor") else rate, hand, depth, friction))
        truth, force = found.taps["device.truth"], found.taps["device.commanded"]["force"]
        speeds = numpy.linalg.norm(truth["v_WD"], axis=1)
        driven = driven or is_driven(truth["p_WD"], speeds, force, found.metrics["device.faults"])
        fastest = max(fastest, float(speeds[len(speeds) * 3 // 4:].max()))
        if driven:
            break
    return driven, fastest


def limit(method, hand, friction=0.0, rate=RATE, ladder=LADDER):
    """N/m: the step of the ladder before the first at which the hand is driven; 0: already the first is."""
    return closed_loop.climb(lambda stiffness: not tried(method, stiffness, hand, friction, rate)[0], ladder)


class Search:
    """Goes down the ladder as hands are found that a step drives."""

    def __init__(self, method, trial=tried):
        self.method, self.trial = method, trial
        self.level = len(LADDER) - 1  # the stiffest step at which no hand was driven yet
        self.hand = None
        self.runs = 0

    def look(self, hand):
        """Tries the hand; m/s, its speed at the stiffest step that does not drive it."""
        while self.level >= 0:
            self.runs += 1
            driven, speed = self.trial(self.method, LADDER[self.level], hand)
            if not driven:
                return speed
            self.level -= 1
            self.hand = hand
        return math.inf

    def sample(self, count, seed):
        from scipy.stats import qmc

        points = qmc.Sobol(len(RANGES), seed=seed).random(count)
        best = None
        for point in points:
            before = self.level
            speed = self.look(hand_of(point))
            if best is None or self.level < before or (self.level == best[0] and speed > best[1]):
                best = (self.level, speed, point)
        return best[2]

    def descend(self, point, evaluations):
        from scipy.optimize import minimize

        corners = numpy.vstack([point, *(numpy.where(numpy.arange(5) == i, numpy.where(point > 0.5, point - 0.2, point + 0.2), point)
                                         for i in range(5))])
        # The speed is that of the step now reached; a hand that goes down a step counts for more than any that does not.
        minimize(lambda p: -math.log(self.look(hand_of(p)) + 1e-9) + 10 * self.level, point, method="Nelder-Mead",
                 options={"maxfev": evaluations, "initial_simplex": corners})


def search(method, hands, evaluations=50, seed=1):
    """{"hand", "limit", "runs"} of the worst hand found, with the limits of the known ones in the same device."""
    found = Search(method)
    for hand in KNOWN.values():
        found.look(hand)
    point = found.sample(hands, seed)
    found.descend(point, evaluations)
    second = found.sample(hands // 4, seed + 1)
    found.descend(second, evaluations)
    hand = found.hand or hand_of(point)
    return {"method": method, "hand": vars(hand), "limit": limit(method, hand), "limit_friction": limit(method, hand, FRICTION),
            "tried": found.runs,
            "known": {name: limit(method, one, ladder=KNOWN_LADDER) for name, one in KNOWN.items()},
            "known_friction": {name: limit(method, one, FRICTION, ladder=KNOWN_LADDER) for name, one in KNOWN.items()}}


def number(value, lowest=KNOWN_LADDER[0]):
    return f"under {lowest:.3g}" if value == 0 else f"{value:.0f} or more" if value >= LADDER[-1] else f"{value:.0f}"


def limits_table(results, friction):
    """A row a method: the limits in the known hands and in the worst one, N/m."""
    suffix = "_friction" if friction else ""
    return table(["method", *KNOWN, "worst found"],
                 [[r["method"], *(number(r["known" + suffix][name]) for name in KNOWN), number(r["limit" + suffix], LADDER[0])] for r in results])


def hands_table(results):
    return table(["method", "worst hand found", "hands and steps tried"],
                 [[r["method"], Hand(**r["hand"]).text(), str(r["tried"])] for r in results])


def overlay(title, hand, comment):
    lines = "\n".join(f"    {name}: {value:.6g}" for name, value in vars(hand).items())
    return f"# {comment}\nformat: 2\ntitle: {title}\nnodes:\n  device:\n    loop: closed\n{lines}\n"


def write_overlays(results):
    HANDS.mkdir(exist_ok=True)
    for name, hand in KNOWN.items():
        (HANDS / f"{name}.yaml").write_text(overlay(f"a hand of {hand.text()}", hand, "Written by bench/worst_hand.py."))
    for r in results:
        hand, method = Hand(**r["hand"]), r["method"]
        said = f"the worst hand found for {method}: it bears a coupling of {number(r['limit'], LADDER[0])} N/m without friction"
        (HANDS / f"worst_{method}.yaml").write_text(overlay(said, hand, "Written by bench/worst_hand.py, which found it; with "
                                                                        f"{FRICTION} N of friction {number(r['limit_friction'], LADDER[0])} N/m."))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--method", action="append", choices=METHODS, help="may be repeated; none: all")
    parser.add_argument("--hands", type=int, default=64, help="of the Sobol sequence, a power of two")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--json", type=pathlib.Path, help="writes what was found")
    arguments = parser.parse_args()
    with concurrent.futures.ProcessPoolExecutor(arguments.jobs) as pool:
        results = list(pool.map(search, arguments.method or METHODS, [arguments.hands] * len(arguments.method or METHODS)))
    if arguments.json:
        arguments.json.parent.mkdir(parents=True, exist_ok=True)
        arguments.json.write_text(json.dumps(results, indent=1))
    write_overlays(results)
    print("Without friction of the device, N/m:\n")
    print(limits_table(results, False))
    print(f"With {FRICTION} N:\n")
    print(limits_table(results, True))
    print(hands_table(results), end="")
