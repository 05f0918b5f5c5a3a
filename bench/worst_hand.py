#!/usr/bin/python3
"""Searches for the passive hand in which a method bears the softest coupling only, and writes it to graphs/hands.

`bench/worst_hand.py [--method NAME] [--hands N] [--jobs N]`, with a built release preset and Debian's python3-scipy. A run is that of
bench/closed_loop.py at the wall: a hand comes down, pushes once and rests 2 or 5 mm inside. Physics runs at 100 Hz. The device has no
friction while it is searched, because dry friction hides small cycles.

The hand is a mass on a spring and a damper, behind a grip, which is a spring and a damper too, or rigid. First come N hands of a
scrambled Sobol sequence over RANGES. Each is tried at the softest coupling that is not yet known to be restless in any hand, and a
restless one lowers that by a step of the ladder. Then Nelder and Mead's method goes on from the worst, for the hand that is fastest at
the end of the run. Two kinds of hands are searched: any in RANGES, and those that are damped (LEAST_RATIO).
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


LEAST_RATIO = {"any": 0.0, "damped": 0.1}  # least damping ratio of the hand on its spring, and of handle and hand in the grip
HANDLE = 0.1  # kg, of the graph's device


def hand_of(point, ratio=0.0):
    """The hand of a point in the unit cube, five coordinates; what is outside counts as at the border. Its damping ratios are `ratio` at
    least."""
    def logarithmic(share, name):
        low, high = RANGES[name]
        return low * (high / low) ** share

    u = [min(max(float(c), 0.0), 1.0) for c in point]
    damping, grip_damping = (0.0 if c < NONE else logarithmic((c - NONE) / (1 - NONE), name)
                             for c, name in ((u[1], "hand_damping"), (u[4], "grip_damping")))
    mass, stiffness = logarithmic(u[0], "hand_mass"), logarithmic(u[2], "hand_stiffness")
    damping = max(damping, 2 * ratio * math.sqrt(stiffness * mass))
    if u[3] > 1 - NONE:
        return Hand(mass, damping, stiffness)
    grip = logarithmic(u[3] / (1 - NONE), "grip_stiffness")
    reduced = mass * HANDLE / (mass + HANDLE)
    return Hand(mass, damping, stiffness, grip, max(grip_damping, 2 * ratio * math.sqrt(grip * reduced)))


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




# The graph's motion with a longer rest: a heavy hand swings once in two seconds.
LONG = {"duration": 9.5, "trajectory.points": "[{t: 0 s, z: 10 mm}, {t: 0.3 s, z: 10 mm}, {t: 0.5 s, z: -1 mm}, {t: 0.9 s, z: -1 mm}, "
                                              "{t: 0.95 s, z: -31 mm}, {t: 1.05 s, z: -31 mm}, {t: 1.1 s, z: -1 mm}, {t: 9.5 s, z: -1 mm}]"}


def run(method, values):
    """(driven, largest speed in the last quarter in m/s)."""
    import tactor

    found = tactor.run("wall/closed_loop", over=[method], taps=["device.truth", "device.commanded"], without_reference=True, set=values)
    truth, force = found.taps["device.truth"], found.taps["device.commanded"]["force"]
    speeds = numpy.linalg.norm(truth["v_WD"], axis=1)
    return is_driven(truth["p_WD"], speeds, force, found.metrics["device.faults"]), float(speeds[len(speeds) * 3 // 4:].max())


def tried(method, stiffness, hand, friction=0.0, rate=RATE):
    """(driven, largest speed in the last quarter in m/s) over both depths. A hand is driven that is so in a long run too."""
    fastest = 0.0
    for depth in closed_loop.DEPTHS:
        values = settings(stiffness, None if method.startswith("floor") else rate, hand, depth, friction)
        driven, speed = run(method, values)
        fastest = max(fastest, speed)
        if driven and run(method, values | LONG)[0]:
            return True, fastest
    return False, fastest


def limit(method, hand, friction=0.0, rate=RATE, ladder=LADDER):
    """N/m: the step of the ladder before the first at which the hand is driven; 0: already the first is."""
    return closed_loop.climb(lambda stiffness: not tried(method, stiffness, hand, friction, rate)[0], ladder)


class Search:
    """Goes down the ladder as hands are found that a step drives."""

    def __init__(self, method, trial=tried, ratio=0.0):
        self.method, self.trial, self.ratio = method, trial, ratio
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
            speed = self.look(hand_of(point, self.ratio))
            if best is None or self.level < before or (self.level == best[0] and speed > best[1]):
                best = (self.level, speed, point)
        return best[2]

    def descend(self, point, evaluations):
        from scipy.optimize import minimize

        corners = numpy.vstack([point, *(numpy.where(numpy.arange(5) == i, numpy.where(point > 0.5, point - 0.2, point + 0.2), point)
                                         for i in range(5))])
        # The speed is that of the step now reached; a hand that goes down a step counts for more than any that does not.
        minimize(lambda p: -math.log(self.look(hand_of(p, self.ratio)) + 1e-9) + 10 * self.level, point, method="Nelder-Mead",
                 options={"maxfev": evaluations, "initial_simplex": corners})


def search(key, evaluations=40):
    """Of a method, a kind of hands and a number of them: the worst hand found, and what it bears."""
    method, kind, hands = key
    found = Search(method, ratio=LEAST_RATIO[kind])
    for name in KNOWN if kind == "any" else ("firm", "light"):
        found.look(KNOWN[name])
    first = found.sample(hands, seed=1)
    found.descend(first, evaluations)
    second = found.sample(hands // 4, seed=2)
    found.descend(second, evaluations)
    hand = found.hand or hand_of(first, found.ratio)
    return {"hand": vars(hand), "limit": limit(method, hand), "limit_friction": limit(method, hand, FRICTION), "tried": found.runs}


def known_limits(key):
    method, name, friction = key
    return limit(method, KNOWN[name], friction, ladder=KNOWN_LADDER)


def search_all(jobs, methods=METHODS, hands=64):
    """A row a method: {"method", "known", "known_friction": {name: N/m}, "any", "damped": of `search`}."""
    searches = [(m, kind, hands) for m in methods for kind in LEAST_RATIO]
    known = [(m, name, friction) for m in methods for name in KNOWN for friction in (0.0, FRICTION)]
    with concurrent.futures.ProcessPoolExecutor(jobs) as pool:
        found = dict(zip(searches, pool.map(search, searches)))
        limits = dict(zip(known, pool.map(known_limits, known)))
    return [{"method": m, "known": {n: limits[m, n, 0.0] for n in KNOWN}, "known_friction": {n: limits[m, n, FRICTION] for n in KNOWN}} |
            {kind: found[m, kind, hands] for kind in LEAST_RATIO} for m in methods]


def number(value, lowest=KNOWN_LADDER[0]):
    return f"under {lowest:.3g}" if value == 0 else f"{value:.0f} or more" if value >= LADDER[-1] else f"{value:.0f}"


def limits_table(results, friction):
    """A row a method: the limits in the known hands and in the worst ones, N/m."""
    suffix = "_friction" if friction else ""
    return table(["method", *KNOWN, *(f"worst, {kind}" for kind in LEAST_RATIO)],
                 [[r["method"], *(number(r["known" + suffix][name]) for name in KNOWN),
                   *(number(r[kind]["limit" + suffix], LADDER[0]) for kind in LEAST_RATIO)] for r in results])


def hands_table(results):
    return table(["method", "kind", "worst hand found", "file", "hands and steps tried"],
                 [[r["method"], kind, Hand(**r[kind]["hand"]).text(), f"`{file_of(r['method'], kind)}`", str(r[kind]["tried"])]
                  for r in results for kind in LEAST_RATIO])


def file_of(method, kind):
    return f"worst_{method}.yaml" if kind == "any" else f"worst_{kind}_{method}.yaml"


def overlay(title, hand, comment):
    lines = "\n".join(f"    {name}: {value:.6g}" for name, value in vars(hand).items())
    return f"# {comment}\nformat: 2\ntitle: {title}\nnodes:\n  device:\n    loop: closed\n{lines}\n"


def write_overlays(results):
    HANDS.mkdir(exist_ok=True)
    for name, hand in KNOWN.items():
        (HANDS / f"{name}.yaml").write_text(overlay(f"a hand of {hand.text()}", hand, "Written by bench/worst_hand.py."))
    for r in results:
        for kind in LEAST_RATIO:
            found, method = r[kind], r["method"]
            hand = Hand(**found["hand"])
            which = "hand" if kind == "any" else f"hand with damping ratios of {LEAST_RATIO[kind]:g} or more"
            said = f"the worst {which} found for {method}; it bears a coupling of {number(found['limit'], LADDER[0])} N/m"
            (HANDS / file_of(method, kind)).write_text(overlay(
                said, hand, f"Written by bench/worst_hand.py. A device without friction; with {FRICTION} N it bears "
                            f"{number(found['limit_friction'], LADDER[0])} N/m."))


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--method", action="append", choices=METHODS, help="may be repeated; none: all")
    parser.add_argument("--hands", type=int, default=64, help="of the Sobol sequence, a power of two")
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--json", type=pathlib.Path, help="writes what was found")
    arguments = parser.parse_args()
    results = search_all(arguments.jobs, arguments.method or METHODS, arguments.hands)
    if arguments.json:
        arguments.json.parent.mkdir(parents=True, exist_ok=True)
        arguments.json.write_text(json.dumps(results, indent=1))
    write_overlays(results)
    print("Without friction of the device, N/m:\n")
    print(limits_table(results, False))
    print(f"With {FRICTION} N:\n")
    print(limits_table(results, True))
    print(hands_table(results), end="")
