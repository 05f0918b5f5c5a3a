"""Fits of psychometric functions against closed forms and a search of the likelihood that knows nothing of the package."""
import contextlib
import copy
import dataclasses
import io
import math
import os
import pathlib
import pickle
import re
import unittest
import warnings

import numpy

from package_harness import PackageTest, command, tactor

try:
    import pandas  # noqa: F401
    import scipy.optimize
    import scipy.special
    import scipy.stats
    from tactor import psychometrics
except ImportError:
    scipy = None

ROOT = pathlib.Path(__file__).resolve().parents[2]


def weibull(x, threshold, slope, lapse=0.0):
    return 0.5 + (0.5 - lapse) * (1 - math.exp(-((x / threshold) ** slope)))


def logistic(x, threshold, spread, lapse=0.0):
    return 0.5 + (0.5 - lapse) / (1 + math.exp(-(x - threshold) / spread))


def log_likelihood(function, parameters, levels, right, total):
    sum_ = 0.0
    for x, k, n in zip(levels, right, total):
        p = min(max(function(x, *parameters), 1e-9), 1 - 1e-9)
        sum_ += k * math.log(p) + (n - k) * math.log(1 - p)
    return sum_


@unittest.skipIf(scipy is None, "scipy or pandas is not installed")
class Fits(PackageTest):
    LEVELS = [0.05, 0.1, 0.15, 0.2, 0.3, 0.45]

    def drawn(self, function, parameters, seed, total=40):
        random = numpy.random.default_rng(seed)
        return [int(random.binomial(total, function(x, *parameters))) for x in self.LEVELS], [total] * len(self.LEVELS)

    def test_two_levels_are_met_exactly(self):
        """Two parameters and two levels: the largest likelihood goes through the shares that were seen."""
        for shape in psychometrics.SHAPES:
            fit = psychometrics.fit([0.1, 0.3], [65, 92], [100, 100], shape=shape, lapse=0)
            self.assertAlmostEqual(float(fit.share_right(0.1)), 0.65, places=4)
            self.assertAlmostEqual(float(fit.share_right(0.3)), 0.92, places=4)
            self.assertAlmostEqual(fit.level_at(0.65) / 0.1, 1, places=3)

    def test_no_other_parameters_are_likelier(self):
        for shape, function, truth in (("weibull", weibull, (0.2, 3.0, 0.02)), ("logistic", logistic, (0.2, 0.05, 0.02))):
            for seed in range(3):
                right, total = self.drawn(function, truth, seed)
                fit = psychometrics.fit(self.LEVELS, right, total, shape=shape)
                # scipy's search by evolution, over the whole box, with a likelihood written here.
                box = [(0.02, 1.2), (0.5, 30) if shape == "weibull" else (0.002, 0.5), (0, 0.06)]
                other = scipy.optimize.differential_evolution(lambda p: -log_likelihood(function, p, self.LEVELS, right, total), box, seed=1,
                                                              popsize=8, maxiter=50, tol=1e-7)
                self.assertGreater(fit.log_likelihood, -other.fun - 1e-3, (shape, seed))
                self.assertAlmostEqual(fit.log_likelihood, log_likelihood(function, (fit.threshold, fit.width, fit.lapse), self.LEVELS, right, total),
                                       places=6)

    def test_constant_stimuli_find_the_threshold(self):
        """The mean of many simulated participants within 5 %; the spread of single ones is printed."""
        for shape, function, truth in (("weibull", weibull, (0.2, 3.0, 0.01)), ("logistic", logistic, (0.2, 0.05, 0.01))):
            fits = [psychometrics.fit(self.LEVELS, *self.drawn(function, truth, seed), shape=shape) for seed in range(60)]
            for share in (0.75, 0.8315):
                exact = scipy.optimize.brentq(lambda x: function(x, *truth) - share, 1e-3, 2)
                found = [fit.level_at(share) for fit in fits]
                off, spread = numpy.mean(found) / exact - 1, numpy.std(found) / exact
                print(f"{shape} at {100 * share} %: mean {100 * off:+.1f} %, single participants {100 * spread:.1f} %")
                self.assertLess(abs(off), 0.05)
                self.assertLess(spread, 0.2)

    def test_the_interval_holds_the_truth_about_as_often_as_it_says(self):
        truth = (0.2, 3.0)
        exact = scipy.optimize.brentq(lambda x: weibull(x, *truth) - 0.75, 1e-3, 2)
        held = 0
        for seed in range(20):
            right, total = self.drawn(weibull, truth, seed)
            low, high = psychometrics.fit(self.LEVELS, right, total, lapse=0).interval(0.75, samples=30, seed=seed)
            held += low <= exact <= high
        # Of 20 intervals of 95 %, 19 on average; 15 or fewer have a chance of 3 in 1,000.
        self.assertGreater(held, 15)

    def test_rows_of_trials_are_counted_by_level(self):
        a = psychometrics.fit([0.1] * 10 + [0.3] * 10, [1] * 6 + [0] * 4 + [1] * 9 + [0], lapse=0)
        b = psychometrics.fit([0.3, 0.1], [9, 6], [10, 10], lapse=0)
        self.assertEqual((a.threshold, a.width), (b.threshold, b.width))

    def test_the_programs_of_the_page_run(self):
        """Every program of docs/howto/experiments.md, on tables that the simulated study makes; the interval holds the truth."""
        page = (ROOT / "docs/howto/experiments.md").read_text()
        programs = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
        self.assertEqual(len(programs), 2)
        for participant in ("P01", "P02", "P03"):
            options = [word for setting in ("protocol.folder=out/experiments/stiffness_jnd", f"protocol.participant={participant}",
                                            "protocol.interval=0.05 s", "protocol.change=0.15 s", "observer.response_time=20 ms",
                                            "protocol.reversals=30") for word in ("--set", setting)]
            made = command("run", ROOT / "graphs/experiments/simulated.yaml", "--out", self.folder / participant, *options, cwd=self.folder,
                           environment=self.environment)
            self.assertEqual(made.returncode, 0, made.stderr)
        here = os.getcwd()
        os.chdir(self.folder)
        self.addCleanup(os.chdir, here)
        said = io.StringIO()
        with contextlib.redirect_stdout(said):
            names = {}
            for program in programs:
                exec(program.replace("samples=200", "samples=30"), names)  # pylint: disable=exec-used
        lines = said.getvalue().splitlines()
        self.assertEqual(len(lines), 8)
        self.assertEqual(lines[6], "3 of 3 people")
        exact = 0.2 * math.log(2) ** (1 / 3)
        found = [float(re.search(r": ([0-9.]+),", line)[1]) for line in lines[:6]]
        self.assertLess(abs(numpy.mean(found) / exact - 1), 0.15)
        # The observer knows no condition: the factor is one.
        low, high = map(float, re.search(r"from ([0-9.]+) to ([0-9.]+)", lines[7]).groups())
        self.assertLess(low, 1)
        self.assertGreater(high, 1)

    def test_a_staircase_by_hand(self):
        levels = [10, 10, 6, 6, 8, 8, 6, 8, 8]
        right = [1, 1, 1, 0, 1, 1, 0, 1, 1]
        self.assertEqual(psychometrics.staircase_threshold(levels, right, down=2, averaged=2), 7)
        self.assertTrue(math.isnan(psychometrics.staircase_threshold(levels, right, down=2, averaged=5)))

    def test_answers_that_do_not_get_better_have_no_threshold(self):
        n = [40] * 6
        # All alike, all right, at chance, and worse and worse: nothing rises.
        for right in ([30] * 6, [40] * 6, [20] * 6, [39, 35, 30, 28, 25, 21]):
            for shape in psychometrics.SHAPES:
                with self.assertWarnsRegex(psychometrics.FlatDataWarning, "do not get better with the level"):
                    fit = psychometrics.fit(self.LEVELS, right, n, shape=shape)
                self.assertFalse(fit.has_slope)
                self.assertTrue(math.isnan(fit.threshold) and math.isnan(fit.width) and math.isnan(fit.level_at(0.75)), (right, shape))
                with self.assertRaisesRegex(tactor.InputError, "expected a fit with a level"):
                    fit.interval(0.75, samples=10)
        with self.assertWarns(psychometrics.FlatDataWarning):
            self.assertFalse(psychometrics.fit([0.2], [30], [40]).has_slope)

    def test_the_deviance_is_that_of_scipy_and_chance_seldom_passes_for_a_slope(self):
        """The deviance of the slope against scipy's likelihoods of the binomial, and against its chi square where there is no slope."""
        random = numpy.random.default_rng(3)
        n = numpy.full(6, 40)
        passed = 0
        for _ in range(100):
            right = random.binomial(40, 0.75, 6)
            with warnings.catch_warnings(record=True) as told:
                warnings.simplefilter("always")
                fit = psychometrics.fit(self.LEVELS, right, n, lapse=0)
            passed += not told
            self.assertEqual(bool(told), fit.deviance_of_slope < scipy.stats.chi2.ppf(0.95, 1))
        # 5 % pass at most; of 100, 12 or more with a chance of 4 in 1,000.
        self.assertLess(passed, 12)
        right, _ = self.drawn(weibull, (0.2, 3.0), 1)
        fit = psychometrics.fit(self.LEVELS, right, n, lapse=0)
        rising = scipy.stats.binom.logpmf(right, n, [weibull(x, fit.threshold, fit.width) for x in self.LEVELS]).sum()
        constant = scipy.stats.binom.logpmf(right, n, sum(right) / 240).sum()
        self.assertAlmostEqual(fit.deviance_of_slope, 2 * (rising - constant), places=5)
        self.assertTrue(fit.has_slope)

    def test_samples_of_a_bootstrap_that_fail_are_counted_and_too_many_refused(self):
        good = psychometrics.fit(self.LEVELS, [20, 22, 25, 30, 38, 40], [40] * 6, lapse=0)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            interval = good.interval(0.75, samples=50)
        self.assertEqual((interval.failed, interval.samples), (0, 50))
        low, high = interval
        self.assertLess(low, good.level_at(0.75))
        self.assertGreater(high, good.level_at(0.75))
        # A slope that may be chance: every few samples have none.
        with self.assertWarnsRegex(psychometrics.FlatDataWarning, "no more than chance"):
            weak = psychometrics.fit(self.LEVELS, [22, 21, 24, 23, 25, 27], [40] * 6)
        with self.assertRaisesRegex(tactor.InputError, r"\d+ of 100 samples have no level at which 0.75"):
            weak.interval(0.75, samples=100)
        # Between the two: each sample fails with a chance that scipy's binomial knows, as below one share is at each level. Two levels
        # whose answers are at 0.5 and p: there is no slope where not more are right at the second.
        n, p = 20, 0.75
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            two = psychometrics.fit([0.1, 0.3], [n // 2, p * n], [n, n], lapse=0)
        shares = [float(two.share_right(x)) for x in (0.1, 0.3)]
        # Not more right at the second, or no more than chance: then the model, which is at chance at least, does not rise.
        chance = sum(scipy.stats.binom.pmf(j, n, shares[0]) * scipy.stats.binom.pmf(k, n, shares[1])
                     for j in range(n + 1) for k in range(n + 1) if k <= max(j, n // 2))
        samples = 400
        self.assertLess(chance, 0.08)
        # More than a tail of 2.5 %: the interval of 95 % is open.
        self.assertGreater(chance, 0.03)
        with self.assertWarnsRegex(psychometrics.FailedSamplesWarning, "the interval is open"):
            interval = two.interval(shares[1] - 0.01, samples=samples)
        self.assertEqual(tuple(interval), (-math.inf, math.inf))
        spread = math.sqrt(samples * chance * (1 - chance))
        self.assertLess(abs(interval.failed - samples * chance), 4 * spread + 1)
        self.assertGreater(interval.failed, 0)
        # A wider tail than what fails, 20 %, and the ends are those of any level that a failed sample may have.
        with self.assertWarnsRegex(psychometrics.FailedSamplesWarning, "the interval is wider for them"):
            interval = two.interval(shares[1] - 0.01, confidence=0.6, samples=samples)
        self.assertTrue(0 < interval.low < two.level_at(shares[1] - 0.01) < interval.high < math.inf)

    def test_an_interval_is_copied_and_pickled(self):
        interval = psychometrics.Interval(0.1, 0.3, 2, 100)
        for again in (copy.copy(interval), copy.deepcopy(interval), pickle.loads(pickle.dumps(interval))):
            self.assertEqual(again, interval)
            self.assertEqual((*again, again.failed, again.samples), (0.1, 0.3, 2, 100))
        with self.assertRaises(dataclasses.FrozenInstanceError):
            interval.low = 0.2

    def test_what_cannot_be_fitted_is_refused(self):
        for levels, right in (([], []), ([0.1], [1, 0]), ([0.0, 0.1], [1, 0]), ([0.1, 0.2], [2, 0]), ([0.1, float("nan")], [1, 0])):
            with self.assertRaises(tactor.InputError):
                psychometrics.fit(levels, right)
        with self.assertRaises(tactor.InputError):
            psychometrics.fit([0.1], [1], shape="cubic")
        with self.assertRaises(tactor.InputError):
            psychometrics.trials(self.folder)


if __name__ == "__main__":
    unittest.main()
