"""Methods in extreme scenes and on extreme forces: what stays finite, what grows, which error, at which run time.

A library for `scripts/extreme_results` and its test.
"""
import math
import statistics
import time

import numpy as np

METHODS = ("hold", "lowpass", "linear", "linear_position", "fixed", "paper", "refit", "burg", "rls", "kalman", "multirate", "hermite_cubic", "blend",
           "local_anchors", "direct", "local_several", "local")  # the floors have a rate of physics of their own
PHYSICS = {20: "50 ms", 100: "10 ms", 300: "3.33 ms", 1000: "1 ms"}  # Hz
ENCODERS = ("1 um", "10 um", "100 um")
MASSES = ("10 g", "100 g", "1 kg", "10 kg")
CONTACTS = {100: "0.2 N/mm", 1000: "2 N/mm", 10000: "20 N/mm", 100000: "200 N/mm"}  # N/m: two materials in series have half of each
SECONDS = 3
ERROR, LARGEST, VERDICT, TIME = "delivered.force.rms_error_N", "delivered.force.max_error_N", "stability.verdict", "method_us_per_tick"
# By the value of the metric stability.verdict. The hand never rests here, so that no limit cycle and no wrong place at rest is looked for.
VERDICTS = {0: "stable", 3: "energy from nowhere", 4: "not finite", 5: "not judged"}

FORCE_METHODS = ("hold", "fixed", "paper", "refit", "burg", "rls", "kalman", "blend")
FORCE_MAX = 1000.0  # N, of the device
TICK, PERIOD, RESULTS = 1e-3, 10e-3, 700  # s, s, count
SETTLING = 100  # ticks at the begin whose error is not judged


def study(methods_folder, methods=METHODS, short=False):
    """The text of a study file: all methods over the grid; `short`: one corner of it."""
    def pick(values):
        values = list(values)
        return values[-1:] if short else values

    rates = "\n".join(f"      {hz} Hz: {{nodes: {{collision: {{cost: {{constant: {ms}, jitter: 30 %, min: 0 ms, max: 1 s}}}}}}}}" for hz, ms in pick(PHYSICS.items()))
    return f"""format: 2
title: methods in extreme scenes
graphs: [wall/scene]
methods: [{", ".join(f"{methods_folder}/{method}.yaml" for method in methods)}]
vary:
  scene.bodies.tool.mass: [{", ".join(pick(MASSES))}]
  'scene.bodies.wall.material.stiffness, scene.bodies.tool.material.stiffness': [{", ".join(pick(CONTACTS.values()))}]
  physics:
    swap:
{rates}
  device.encoder_step: [{", ".join(pick(ENCODERS))}]
duration: {SECONDS} s
judge: whole
metrics: [{ERROR}, {LARGEST}, {VERDICT}]
seeds: 1
first_seed: 1
"""


def cells(found):
    """{method: {place in the grid: metrics}} of study.json."""
    cells = {}
    for row in found["rows"]:
        if row["method"] in METHODS:
            cells.setdefault(row["method"], {})[tuple(row["values"].values())] = row["metrics"]
    return cells


def value(metrics, name):
    """The mean over seeds; none where there is none."""
    return metrics.get(name, {}).get("mean")


def ratios(cells, method, metric=ERROR, chosen=None):
    """{place: value by the hold's} of the cells in which both are known and the hold's is not 0."""
    found = {}
    for place, metrics in cells[method].items():
        of, held = value(metrics, metric), value(cells["hold"][place], metric)
        if of is not None and held and (chosen is None or chosen(place)):
            found[place] = of / held
    return found


def method_rows(cells):
    """A row a method: cells by verdict, errors by the hold's, run time."""
    for method, of in cells.items():
        verdicts = [round(value(metrics, VERDICT)) for metrics in of.values()]
        if not set(verdicts) <= set(VERDICTS):
            raise ValueError(f"{method}: expected verdicts of {sorted(VERDICTS)}, found {sorted(set(verdicts))}")
        by, largest = ratios(cells, method), ratios(cells, method, LARGEST)
        worst = max(by, key=by.get)
        yield [f"`{method}`", len(of), *(verdicts.count(verdict) for verdict in VERDICTS), f"{statistics.geometric_mean(by.values()):.3f}",
               f"{np.quantile(list(by.values()), 0.9):.2f}", f"{by[worst]:.2f} ({', '.join(worst)})", f"{max(largest.values()):.2f}",
               f"{statistics.fmean(value(metrics, TIME) for metrics in of.values()):.2f}"]


METHOD = ["method", "cells", *VERDICTS.values(), "RMS error, ratio to the hold's, mean", "90 %", "worst", "largest error, ratio, worst", "us a tick"]


AXIS_METHODS = ("paper", "blend", "direct", "local_several", "local")


def axis_rows(cells, methods=AXIS_METHODS):
    """A row for each value of each axis: the mean error by the hold's of some methods."""
    places = list(next(iter(cells.values())))
    for axis in range(len(places[0])):
        for at in dict.fromkeys(place[axis] for place in places):
            yield [at, *(f"{statistics.geometric_mean(ratios(cells, method, chosen=lambda place: place[axis] == at).values()):.3f}" for method in methods)]


AXIS = ["cells with", *AXIS_METHODS]


def kinds():
    """{name: force in N of result k, 3 axes}: what a fit of auto-regressive coefficients may fail on."""
    random, k = np.random.default_rng(1), np.arange(RESULTS)

    def along(x, y=0.0, z=0.0):
        return np.stack(np.broadcast_arrays(np.asarray(x, dtype=float), y, z), axis=1)

    wave = np.sin(0.2 * k)
    found = {"zero": along(0 * k), "constant, 1 N": along(1 + 0 * k), "constant, 1e-9 N of noise": along(1 + 1e-9 * random.standard_normal(RESULTS)),
             "one sinusoid": along(wave), "two axes alike": along(wave, wave), "ramp to 7 N": along(0.01 * k), "powers of 1.05": along(1e-12 * 1.05 ** k),
             "alternating, 1 N": along((-1.0) ** k), "alternating, 0 and 1e6 N": along(1e6 * (k % 2)), "huge, 1e6 N": along(1e6 * wave),
             "tiny, 1e-9 N": along(1e-9 * wave), "smallest, 1e-150 N": along(1e-150 * wave), "a step of 1e6 N": along(np.where(k < 400, wave, 1e6)),
             "noise, 1 N": random.standard_normal((RESULTS, 3)), "rare blows of 1e6 N": along(wave + 1e6 * (k % 97 == 50))}
    for name, bad in (("NaN in ten", math.nan), ("infinity in ten", math.inf)):
        found[name] = along(np.where(k % 10 == 3, bad, wave))
    return found


def played(method, forces):
    """(force that the device is to show, N, a row a tick, before its safety gate; CPU time of a tick, us) where forces come as results of physics,
    every PERIOD."""
    import tactor

    graph = {"record": ["device.interpolated"],
             "nodes": {"metrics": None, "recording": None, "coupling": None, "prediction": {"force_max": FORCE_MAX}, "device": {"force_max": FORCE_MAX, "force_slew": 1e6}}}
    inputs = tactor.load("recorded/scene", over=[method]).inputs
    feeds = [name for name in inputs if name.endswith(".force") and name != "metrics.force"]
    with tactor.Session("recorded/scene", over=[method, graph], duration=(len(forces) + 1) * PERIOD, feeds=[*feeds, "device.target"]) as session:
        ports = []
        for name in feeds:
            try:
                ports.append(session.feed(name))
            except tactor.InputError:
                pass  # a node that the method does not need is not in the run
        interpolated, shown = session.tap("device.interpolated"), []
        session.start()
        session.feed("device.target").send(p_WH=[0, 0, 0], R_WH=[1, 0, 0, 0], v_WH=[0, 0, 0], w_WH=[0, 0, 0])
        begin = time.process_time()
        for force in forces:
            for port in ports:
                port.send(force=force, torque=[0, 0, 0])
            session.advance(PERIOD)
            shown.append(interpolated.take()["force"])
        us = 1e6 * (time.process_time() - begin) / (len(forces) * round(PERIOD / TICK))
    return np.concatenate(shown), us


def judged(shown, forces):
    """(ticks that are not finite, largest shown by largest sent, RMS error in N) of what was shown of forces. The truth is a straight line
    between results, within the device's bounds; a result that is not finite is the one before."""
    good = np.isfinite(forces).all(axis=1)
    known = np.array([forces[np.flatnonzero(good[:k + 1])[-1]] for k in range(len(forces))])
    known *= np.minimum(1, FORCE_MAX / np.maximum(np.linalg.norm(known, axis=1), 1e-300))[:, None]
    t = TICK * np.arange(len(shown))
    truth = np.stack([np.interp(t, PERIOD * np.arange(len(known)), axis) for axis in known.T], axis=1)
    unit, finite = np.abs(known).max() or 1.0, np.isfinite(shown).all(axis=1)
    known, shown, truth = known / unit, shown[finite] / unit, truth[finite] / unit  # squares of tiny forces would be 0
    largest, size = (np.linalg.norm(x, axis=1).max() for x in (known, shown))
    return int((~finite).sum()), size / largest if largest else size, unit * float(np.sqrt(((shown - truth)[SETTLING:] ** 2).sum(axis=1).mean()))


def force_rows(methods=FORCE_METHODS):
    """A row a kind of force: ticks that are not finite, all methods together; for each method the error by the hold's, and the largest force
    shown by the largest sent. Then a row of run times."""
    times = {method: [] for method in methods}
    for name, forces in kinds().items():
        row, bad, held, least = [], 0, None, 1e-9 * min(FORCE_MAX, np.abs(forces[np.isfinite(forces)]).max())
        for method in methods:
            shown, us = played(method, forces)
            times[method].append(us)
            not_finite, size, error = judged(shown, forces)
            bad, held = bad + not_finite, error if held is None else held
            row.append((f"{error / held:.2f}" if held > least else "exact" if error <= least else f"{error:.2g} N") + f" ({size:.2f})")
        yield [name, bad, *row]
    yield ["**us a tick**", "", *(f"{statistics.median(of):.2f}" for of in times.values())]


FORCE = ["force", "ticks not finite", *FORCE_METHODS]
