"""The tables of experiments with people: thresholds by a fit of the psychometric function, with their uncertainty.

    from tactor import psychometrics
    table = psychometrics.trials("out/experiments/stiffness_jnd")
    fit = psychometrics.fit(table["level"], table["correct"])
    print(fit.level_at(0.75), fit.interval(0.75))

P(right | x) = guess + (1 - guess - lapse) F(x), with F(x) = 1 - exp(-(x / threshold)^slope) (`weibull`) or
F(x) = 1 / (1 + exp(-(x - threshold) / spread)) (`logistic`).
"""
from __future__ import annotations

import dataclasses
import os
import pathlib
import warnings
from typing import Any, Iterator, Sequence

import numpy
from numpy.typing import ArrayLike, NDArray

from ._errors import InputError
from ._needs import needed

SHAPES = ("weibull", "logistic")

# The deviance of the slope is twice the gain in log likelihood over one share of right answers at all levels. Up to the
# first value there is no slope: the search finds its optimum no better than that. Below the second the slope may be
# chance: without a slope the deviance is above it once in 20 times (chi square, 1 degree of freedom).
_NO_SLOPE = 1e-3
_SLOPE_BY_CHANCE = 3.841
# At most this part of the samples of a bootstrap may fail.
_MOST_FAILED = 0.1

_Reals = NDArray[numpy.float64]


def _share(shape: str, level: _Reals, threshold: float, width: float) -> Any:
    if shape == "weibull":
        return -numpy.expm1(-numpy.maximum(level / threshold, 0) ** width)
    return 0.5 + 0.5 * numpy.tanh((level - threshold) / (2 * width))


class FlatDataWarning(UserWarning):
    """The answers do not get better with the level, or no more than chance may do."""


class FailedSamplesWarning(UserWarning):
    """Samples of a bootstrap gave no level; the interval is wider for them, or open."""


@dataclasses.dataclass(frozen=True)
class Interval:
    """The low and the high end, in the unit of the level; -inf and inf where the interval is open. It unpacks into the
    two: `low, high = interval`."""
    low: float
    high: float
    failed: int     # samples that gave no level
    samples: int

    def __iter__(self) -> Iterator[float]:
        return iter((self.low, self.high))


@dataclasses.dataclass(frozen=True)
class Psychometric:
    """A fitted function, and the data it was fitted to: so many of so many answers were right at each level."""
    shape: str
    threshold: float      # in the unit of the level
    width: float          # the slope of the Weibull, 1; the spread of the logistic, in the unit of the level
    guess: float
    lapse: float
    log_likelihood: float
    levels: _Reals
    right: _Reals
    total: _Reals
    fixed_lapse: bool
    most_lapse: float

    @property
    def deviance_of_slope(self) -> float:
        """Twice the gain in log likelihood over the same share of right answers, `guess` or more, at all levels. It is
        about chi square of 1 degree where there is no slope: below 3.84 the slope may be chance."""
        share = numpy.clip(self.right.sum() / self.total.sum(), self.guess, 1.0)
        wrong = self.total - self.right
        constant = sum(numpy.sum(k[k > 0]) * numpy.log(p) for k, p in ((self.right, share), (wrong, 1 - share)) if k.sum() > 0)
        return float(2 * (self.log_likelihood - constant))

    @property
    def has_slope(self) -> bool:
        """False where the answers do not get better with the level: then there is no threshold."""
        return self.deviance_of_slope > _NO_SLOPE

    def share_right(self, level: ArrayLike) -> Any:
        """P(right) at a level, or at each of an array of them."""
        return self.guess + (1 - self.guess - self.lapse) * _share(self.shape, numpy.asarray(level, float), self.threshold, self.width)

    def level_at(self, share: float) -> float:
        """The level at which that share of the answers is right; nan where the function does not get there, and where
        the answers do not get better with the level."""
        part = (share - self.guess) / (1 - self.guess - self.lapse)
        if not (0 < part < 1 and numpy.isfinite(self.threshold)):
            return float("nan")
        if self.shape == "weibull":
            return float(self.threshold * (-numpy.log1p(-part)) ** (1 / self.width))
        return float(self.threshold + self.width * numpy.log(part / (1 - part)))

    def interval(self, share: float, confidence: float = 0.95, samples: int = 1000, seed: int = 1) -> Interval:
        """The interval of `level_at(share)` by the parametric bootstrap: answers are drawn from the fitted function at
        the levels that were presented, fitted again, and the quantiles of the levels found are taken, without
        interpolation. A sample whose answers have no slope, or whose function does not get to `share`, has failed: it
        is counted in `failed` and warned of. Its level may be anywhere, so it counts as below the low end and as above
        the high one. Where more fail than either tail holds, (1 - confidence) / 2 of the samples, both ends are open.
        Raises InputError where this fit has no such level, and where more than a tenth of the samples fail."""
        if not numpy.isfinite(self.level_at(share)):
            raise InputError(f"interval: expected a fit with a level at which {share:g} of the answers are right, found none")
        random = numpy.random.default_rng(seed)
        chances = self.share_right(self.levels)
        everywhere = _starts(self.levels, self.total, self.shape)
        found = []
        for _ in range(samples):
            drawn = random.binomial(self.total.astype(int), chances).astype(float)
            # From the fit that they were drawn from, and from anywhere where that leads nowhere.
            for starts in ([(self.threshold, self.width)], everywhere):
                again = _fit_counts(self.levels, drawn, self.total, self.shape, self.guess, self.lapse if self.fixed_lapse else None,
                                    self.most_lapse, starts)
                if again.has_slope:
                    break
            found.append(again.level_at(share))
        failed = int(numpy.sum(~numpy.isfinite(found)))
        if failed > _MOST_FAILED * samples:
            raise InputError(f"interval: {failed} of {samples} samples have no level at which {share:g} of the answers are right; "
                             "expected at most a tenth: take more trials, or levels over more of the curve")
        tail = (1 - confidence) / 2
        low = float(numpy.quantile(numpy.nan_to_num(found, nan=-numpy.inf), tail, method="lower"))
        high = float(numpy.quantile(numpy.nan_to_num(found, nan=numpy.inf), 1 - tail, method="higher"))
        if failed:
            is_open = "open" if not numpy.isfinite(high - low) else "wider for them"
            warnings.warn(f"{failed} of {samples} samples have no level at which {share:g} of the answers are right; the interval is "
                          f"{is_open}", FailedSamplesWarning, stacklevel=2)
        return Interval(low, high, failed, samples)


def _starts(levels: _Reals, total: _Reals, shape: str) -> list[tuple[float, float]]:
    """Thresholds and widths from which the search begins."""
    middles = numpy.quantile(numpy.repeat(levels, total.astype(int)), [0.3, 0.7])
    widths = (1.5, 4.0) if shape == "weibull" else tuple(float(numpy.ptp(levels) * part or levels[0] * part) for part in (0.05, 0.25))
    return [(float(m), w) for m in middles for w in widths]


def _fit_counts(levels: _Reals, right: _Reals, total: _Reals, shape: str, guess: float, lapse: float | None, most_lapse: float,
                starts: Sequence[tuple[float, float]]) -> Psychometric:
    optimize = needed("scipy.optimize", "python3-scipy", "for the fit of a psychometric function")

    def loss(x: _Reals) -> Any:
        threshold, width = numpy.exp(x[:2])
        lapse_now = x[2] if lapse is None else lapse
        p = guess + (1 - guess - lapse_now) * _share(shape, levels, threshold, width)
        p = numpy.clip(p, 1e-9, 1 - 1e-9)
        return -numpy.sum(right * numpy.log(p) + (total - right) * numpy.log1p(-p))

    span = numpy.log(levels.max() / levels.min()) if levels.max() > levels.min() else 1.0
    near, far = numpy.log(levels.min()) - span - 1, numpy.log(levels.max()) + span + 1
    widths = (numpy.log(0.1), numpy.log(50)) if shape == "weibull" else (near - 4, far + 2)
    bounds = [(near, far), widths] + ([(0, most_lapse)] if lapse is None else [])
    found = []
    for threshold, width in starts:
        x = [numpy.log(threshold), numpy.log(width)] + ([most_lapse / 3] if lapse is None else [])
        found.append(optimize.minimize(loss, numpy.clip(x, *numpy.transpose(bounds)), method="L-BFGS-B", bounds=bounds))
    best = found[int(numpy.argmin([one.fun for one in found]))]
    threshold, width = numpy.exp(best.x[:2])
    fitted = Psychometric(shape, float(threshold), float(width), guess, float(best.x[2] if lapse is None else lapse), float(-best.fun),
                          levels, right, total, lapse is not None, most_lapse)
    return fitted if fitted.has_slope else dataclasses.replace(fitted, threshold=float("nan"), width=float("nan"))


def fit(levels: ArrayLike, right: ArrayLike, total: ArrayLike | None = None, *, shape: str = "weibull", guess: float = 0.5,
        lapse: float | None = None, most_lapse: float = 0.06) -> Psychometric:
    """The function of the largest likelihood. `levels` and `right`: a row a trial (right 1 or 0), or with `total` a row a
    level (so many right of so many). `lapse`: fixed to that value; None: fitted, between 0 and `most_lapse`. Where the
    answers do not get better with the level, threshold and width are nan, with a FlatDataWarning; one also warns where
    they get better by no more than chance may do."""
    if shape not in SHAPES:
        raise InputError(f"shape: expected one of {', '.join(SHAPES)}, found {shape}")
    x, k = numpy.asarray(levels, float), numpy.asarray(right, float)
    n = numpy.ones_like(x) if total is None else numpy.asarray(total, float)
    if not x.size or x.shape != k.shape or x.shape != n.shape:
        raise InputError(f"expected levels and answers of one length, found {x.size}, {k.size} and {n.size}")
    if not (numpy.isfinite(x).all() and (x > 0).all() and (k >= 0).all() and (k <= n).all()):
        raise InputError("expected levels above 0 and from 0 to all answers right at each; pairs have no level to fit")
    unique, place = numpy.unique(x, return_inverse=True)
    k, n = numpy.bincount(place, k).astype(float), numpy.bincount(place, n).astype(float)
    fitted = _fit_counts(unique, k, n, shape, guess, lapse, most_lapse, _starts(unique, n, shape))
    if not fitted.has_slope:
        warnings.warn("the answers do not get better with the level: there is no threshold", FlatDataWarning, stacklevel=2)
    elif fitted.deviance_of_slope < _SLOPE_BY_CHANCE:
        warnings.warn(f"the answers get better with the level by no more than chance may do (deviance {fitted.deviance_of_slope:.2f}, "
                      f"expected {_SLOPE_BY_CHANCE} or more): the threshold is not to be relied on", FlatDataWarning, stacklevel=2)
    return fitted


def staircase_threshold(levels: Sequence[float], right: Sequence[int], *, down: int, averaged: int, scale: str = "linear") -> float:
    """The mean of the levels at the last `averaged` reversals of one staircase (`factor`: the geometric mean), from its
    trials in their order and the rule `down` that the graph gives; nan where there are fewer reversals. It is what the
    protocol finds."""
    reversals, in_a_row, before = [], 0, 0
    for level, is_right in zip(levels, right):
        in_a_row = in_a_row + 1 if is_right else 0
        if is_right and in_a_row < down:
            continue
        direction = -1 if is_right else 1
        in_a_row = 0
        if before and direction != before:
            reversals.append(float(level))
        before = direction
    if len(reversals) < averaged:
        return float("nan")
    last = numpy.asarray(reversals[-averaged:])
    return float(numpy.exp(numpy.log(last).mean()) if scale == "factor" else last.mean())


def trials(folder: str | os.PathLike[str]) -> Any:
    """The tables of all participants in a folder, as one DataFrame with a column `participant`."""
    pandas = needed("pandas", "python3-pandas", "for tables")
    files = sorted(pathlib.Path(folder).glob("*.csv"))
    if not files:
        raise InputError(f"{folder}: expected tables of participants such as P01.csv, found none")
    tables = [pandas.read_csv(file, dtype={"seed": str, "design": str}).assign(participant=file.stem) for file in files]
    return pandas.concat(tables, ignore_index=True)
