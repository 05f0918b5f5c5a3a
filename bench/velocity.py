"""The velocity filters of devices alone: how they show given motions, and how much a filter gains that is fitted to the motion.

A library for `scripts/velocity_results` and its test. A force is k p + b v, with the position as the encoder shows it and the velocity
of a filter. Errors are against the force of the true motion.
"""
import json
import os
import pathlib
import subprocess

import numpy as np
from scipy import signal

import page
import thresholds

ROOT = pathlib.Path(__file__).resolve().parent.parent
BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
DAMPING, STIFFNESS = 3.0, 105.0  # N s/m, N/m, of the coupling
SECONDS = 8
AT_REST = "none"  # the name of a motion
SETTLING = 0.5  # s, not judged
WEIGHT = 10  # of what is felt, beside the mean square, in the fit
TAIL = 160.0  # Hz; above, W grows with frequency
LAGS = 160  # samples that the fitted filter looks back
FROZEN = "ca1e9997"  # the commit after which no constant of the filter was changed


def new_scenes(out):
    """The graphs that the generator draws, into a folder of `out`, from the number of the commit FROZEN."""
    return page.drawn_scenes(out / f"draw_{FROZEN}", int(FROZEN, 16))


def program():
    return next(p for p in BUILD.rglob("velocity_bench") if p.is_file())


def estimated(position, filter, interval, step, noise=0.0, seed=1):
    """(shown position in m, estimated velocity in m/s), arrays of samples by axes, of a true position in m."""
    said = subprocess.run([program(), "estimate", filter, repr(interval), repr(step), repr(noise), str(seed)], check=True,
                          input=np.ascontiguousarray(position, dtype=float).tobytes(), stdout=subprocess.PIPE).stdout
    rows = np.frombuffer(said).reshape(-1, 6)
    return rows[:, :3], rows[:, 3:]


def times():
    """{filter: {"us": ..., "rotates_us": ...}}, CPU time of a sample."""
    return json.loads(subprocess.run([program(), "time"], check=True, capture_output=True, text=True).stdout)


class Motion:
    """Sums of sinusoids of random phases, so that the velocity is exact."""

    def __init__(self, seed=0):
        self.random, self.lines = np.random.default_rng(seed), []

    def band(self, low, high, rms, count=60):
        """Adds a band of frequencies, Hz, with a root of the mean square in m for each axis."""
        w = 2 * np.pi * np.linspace(low, high, count)
        phases = self.random.uniform(0, 2 * np.pi, (3, count))
        self.lines.append((w, rms * np.sqrt(2 / count), phases))
        return self

    def at(self, interval, seconds=SECONDS):
        """(position in m, velocity in m/s), samples by axes."""
        t = interval * np.arange(round(seconds / interval))
        p, v = np.tile([1.23e-6, 2e-6, 3.1e-6], (len(t), 1)), np.zeros((len(t), 3))
        for w, amplitude, phases in self.lines:
            for axis in range(3):
                angle = np.outer(t, w) + phases[axis]
                p[:, axis] += amplitude * np.cos(angle).sum(axis=1)
                v[:, axis] -= amplitude * (np.sin(angle) @ w)
        return p, v


def motions():
    """{name: Motion}: none, slow, broad ones, and tremors on a hand that moves slowly."""
    found = {AT_REST: Motion(), "slow": Motion(1).band(0.1, 1, 5e-3)}
    for um in (20, 200, 1000):
        found[f"3 to 25 Hz, {um} um"] = Motion(um).band(3, 25, 1e-6 * um)
    for hertz in (4, 6, 8, 10, 12, 15, 18):
        found[f"tremor of {hertz} Hz, 200 um"] = Motion(hertz).band(0.1, 1, 1e-3).band(0.93 * hertz, 1.07 * hertz, 2e-4)
    return found


def error_of(position, velocity, shown, estimate):
    """N, samples by axes."""
    return STIFFNESS * (shown - position) + DAMPING * (estimate - velocity)


def judged(error, interval, bands, settling=SETTLING):
    """(RMS error in mN, the highest third of an octave over its threshold in dB) of an error in N; bands as thresholds.curves() has them."""
    error = error[round(settling / interval):]
    mean_square = (error**2).sum(axis=1).mean()
    loudest = max(10 * np.log10(max(squares.mean() / threshold**2, 1e-9)) for _, threshold, squares in thresholds.bands_of(error, 1 / interval, bands))
    return 1e3 * float(np.sqrt(mean_square)), float(loudest)


def weigh(values, interval, curve):
    """Values filtered, without delay, by W: the inverse of the curve [(Hz, N)] by its least value up to TAIL, then growing with frequency."""
    hertz = np.fft.rfftfreq(len(values), interval)
    points = np.array(curve)
    inverse = np.exp(-np.interp(np.log(np.maximum(hertz, points[0, 0])), np.log(points[:, 0]), np.log(points[:, 1])))
    inverse /= inverse[hertz <= TAIL].max()
    inverse[hertz > TAIL] = hertz[hertz > TAIL] / TAIL
    return np.fft.irfft(np.fft.rfft(values, axis=0) * inverse[:, None], len(values), axis=0)


def fitted(position, velocity, shown, interval, curve, weight=WEIGHT):
    """The velocity, m/s, of the causal linear filter of the last LAGS shown positions that has the least E e^2 + weight E (W e)^2 over the
    first half of the motion, axis by axis; over all of it. Judge the second half."""
    estimate = np.zeros_like(position)
    half = len(position) // 2
    rows = np.arange(round(SETTLING / interval), half)

    def lagged(x):
        return np.stack([x[rows - lag] - x[rows - LAGS] for lag in range(LAGS)], axis=1)

    for axis in range(3):
        x = shown[:, axis]
        if np.ptp(x[:half]) == 0:
            continue  # nothing is learned from an axis that does not move
        # The spring has the shown position; the sum is free to make up for its error.
        wanted = (velocity + STIFFNESS / DAMPING * (position - shown))[:, axis]
        heavy = np.sqrt(weight) * weigh(np.stack([x, wanted], axis=1) - [x[0], 0], interval, curve)
        features = np.concatenate([lagged(x), lagged(heavy[:, 0])])
        target = np.concatenate([wanted[rows], heavy[rows, 1]])
        square = features.T @ features
        square[np.diag_indices(LAGS)] += 1e-9 * np.trace(square) / LAGS
        taps = np.linalg.solve(square, features.T @ target)
        # A sum of differences to the oldest sample, which has minus the sum of the others.
        estimate[:, axis] = signal.lfilter(np.append(taps, -taps.sum()), 1, x - x[0])
    return estimate
