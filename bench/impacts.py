"""Hits on a wall: how late, how steeply and how exactly a method's force rises, beside the force of the reference."""
import numpy as np

HITS = 115
TOUCHES = 4e-3  # m, the handle's height at which the tool of wall/scene touches
ABOVE, BELOW = 11e-3, -3e-3  # m, of the handle: it touches half way
SLOWEST, FASTEST = 0.05, 0.4  # m/s, at the touch
FASTEST_BY_MEAN = 1.875  # of a motion of minimum jerk, which is fastest half way
LOOKED_AT = 0.05  # s after the reference's force begins
BEGINS, LOW, HIGH = 0.05, 0.2, 1.0  # N


def path(seed=1, hits=HITS):
    """[(s, m)] of the handle's height: hits of random speeds and pauses, to be joined by motions of minimum jerk."""
    random = np.random.default_rng(seed)
    t, points = 0.5, [(0.0, ABOVE), (0.5, ABOVE)]
    for _ in range(hits):
        for pause, height in ((random.uniform(0.15, 0.25), BELOW), (random.uniform(0.2, 0.3), ABOVE)):
            t += FASTEST_BY_MEAN * (ABOVE - BELOW) / np.exp(random.uniform(np.log(SLOWEST), np.log(FASTEST)))
            points.append((t, height))
            t += pause
            points.append((t, height))
    return points


def forces(method, velocity_filter, seed=1):
    """(s, N, N): times, the force of the motors and that of the reference along the wall's normal, one a tick."""
    import tactor

    points = path(seed)
    text = "[" + ", ".join(f"{{t: {t:.6g} s, z: {1e3 * z:.6g} mm}}" for t, z in points) + "]"
    result = tactor.run("wall/scene", over=[method], seed=seed,
                        set={"trajectory.points": text, "trajectory.interpolation": "minimum_jerk", "trajectory.repeat_after": 0,
                             "device.velocity_filter": velocity_filter, "duration": f"{points[-1][0] + 0.2:.6g} s"})
    commanded, reference = (result.series[f"{name}.z"] for name in ("commanded", "reference"))
    return commanded["time"], commanded["value"], reference["value"]


def crossing(t, force, level):
    """s, the first time at which a force reaches a level, between two samples; NaN where it does not, or is there at once."""
    above = np.flatnonzero(force >= level)
    if not len(above) or above[0] == 0:
        return np.nan
    i = above[0]
    return t[i - 1] + (level - force[i - 1]) / (force[i] - force[i - 1]) * (t[i] - t[i - 1])


def events(t, force, reference):
    """{s: (ms late, slope by the reference's, largest error in N)} of the hits, by the time at which the reference's force begins from
    nothing. Hits in which the reference does not rise to HIGH are left out. One in which the force does not is late and flat by NaN."""
    found = {}
    window = round(LOOKED_AT / (t[1] - t[0]))
    for i in range(5, len(t) - window):
        if reference[i] < BEGINS or np.any(reference[max(0, i - window):i] >= BEGINS):
            continue
        of = slice(i - 5, i + window)
        (low, high), (true_low, true_high) = ([crossing(t[of], values[of], level) for level in (LOW, HIGH)] for values in (force, reference))
        if np.isnan(true_low + true_high):
            continue
        late = 0.5 * (low + high - true_low - true_high)
        found[round(float(t[i]), 6)] = (1e3 * late, (true_high - true_low) / (high - low), float(np.abs(force[of] - reference[of]).max()))
    return found
