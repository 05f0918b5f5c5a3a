"""Fits of psychometric functions against closed forms and a search of the likelihood that knows nothing of the package."""
import contextlib
import io
import math
import os
import pathlib
import re
import unittest

import numpy

from package_harness import PackageTest, command, tactor

try:
    import pandas  # noqa: F401
    import scipy.optimize
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
        """Every program of docs/experiments.md, on tables that the simulated study makes; the interval holds the truth."""
        page = (ROOT / "docs/experiments.md").read_text()
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
        self.assertEqual(len(lines), 7)
        exact = 0.2 * math.log(2) ** (1 / 3)
        found = [float(re.search(r": ([0-9.]+),", line)[1]) for line in lines[:6]]
        self.assertLess(abs(numpy.mean(found) / exact - 1), 0.15)
        # The observer knows no condition: the factor is one.
        low, high = map(float, re.search(r"from ([0-9.]+) to ([0-9.]+)", lines[6]).groups())
        self.assertLess(low, 1)
        self.assertGreater(high, 1)

    def test_a_staircase_by_hand(self):
        levels = [10, 10, 6, 6, 8, 8, 6, 8, 8]
        right = [1, 1, 1, 0, 1, 1, 0, 1, 1]
        self.assertEqual(psychometrics.staircase_threshold(levels, right, down=2, averaged=2), 7)
        self.assertTrue(math.isnan(psychometrics.staircase_threshold(levels, right, down=2, averaged=5)))

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
