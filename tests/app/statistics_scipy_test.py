"""The statistics of studies against scipy, on 2,000 drawn tables, most of them with ties."""
import json
import os
import subprocess
import sys
import unittest

try:
    import numpy
    import scipy.stats
except ImportError:
    print("python3-numpy or python3-scipy is not installed")
    sys.exit(77)

TABLES = 2000
FEWEST = 6  # pairs that are tested


def draw(random):
    """A pair of groups of 2 to 12 values: fine or coarse, so that few or most differences tie, and some are zero."""
    n = int(random.integers(2, 13))
    kind = random.integers(4)
    if kind == 0:  # no ties
        return random.normal(size=n), random.normal(0.5, 1, size=n)
    if kind == 1:  # few differences that are not equal; quarters are exact
        return random.integers(0, 4, size=n) / 4, random.integers(0, 4, size=n) / 4
    if kind == 2:  # as errors in N
        a = random.integers(1, 40, size=n) / 64
        return a, a + random.integers(-3, 4, size=n) / 128
    return numpy.full(n, random.integers(1, 9) / 3), numpy.full(n, random.integers(1, 9) / 7)  # copies of one run


def midranks(differences):
    return scipy.stats.rankdata(abs(differences))


def exact_p(differences):
    """Over all signs, by scipy's permutations; zeros are left out as its zero_method "wilcox" does."""
    rest = differences[differences != 0]
    if rest.size == 0:
        return None
    ranks = midranks(rest)
    if rest.size == 1:
        return 1.0  # either sign is as far out as the other
    signed = numpy.sign(rest) * ranks
    test = scipy.stats.permutation_test((signed,), lambda x, axis: x.sum(axis=axis), permutation_type="samples", vectorized=True,
                                        n_resamples=numpy.inf, alternative="two-sided")
    return float(test.pvalue)


class AgainstScipy(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        random = numpy.random.default_rng(52)
        cls.tables = [draw(random) for _ in range(TABLES)]
        text = "".join(" ".join(map(repr, map(float, a))) + " | " + " ".join(map(repr, map(float, b))) + "\n" for a, b in cls.tables)
        told = subprocess.run([os.environ["PAIRED_DIFFERENCES"]], input=text, capture_output=True, text=True, check=True).stdout
        cls.found = [json.loads(line) for line in told.splitlines()]

    def test_every_table_has_an_answer(self):
        self.assertEqual(len(self.found), TABLES)
        self.assertTrue(all(one and "mean" in one for one in self.found))

    def test_p_is_that_of_all_signs_and_never_below_the_least_possible(self):
        tied = 0
        for (a, b), found in zip(self.tables, self.found):
            if len(a) < FEWEST and not found["identical"]:
                self.assertIsNone(found["p_wilcoxon"])
                continue
            if found["identical"]:
                self.assertIsNone(found["p_wilcoxon"])
                self.assertTrue(numpy.allclose(a, b, rtol=1e-12, atol=0) or (numpy.ptp(a) == 0 and numpy.ptp(b) == 0))
                continue
            differences = b - a
            rest = differences[differences != 0]
            tied += len(set(abs(rest))) < rest.size
            self.assertAlmostEqual(found["p_wilcoxon"], exact_p(differences), delta=1e-12)
            self.assertGreaterEqual(found["p_wilcoxon"], 2 / 2**len(a))
        self.assertGreater(tied, TABLES // 4)

    def test_without_ties_and_zeros_p_is_that_of_scipys_wilcoxon(self):
        compared = 0
        for (a, b), found in zip(self.tables, self.found):
            differences = b - a
            if 0 in differences or len(set(abs(differences))) < len(a) or found["identical"] or len(a) < FEWEST:
                continue
            compared += 1
            expected = scipy.stats.wilcoxon(a, b, mode="exact").pvalue
            self.assertAlmostEqual(found["p_wilcoxon"], expected, delta=1e-12)
        self.assertGreater(compared, TABLES // 10)

    def test_an_interval_is_students_and_it_and_an_effect_size_need_spread_and_six_pairs(self):
        for (a, b), found in zip(self.tables, self.found):
            differences = b - a
            self.assertAlmostEqual(found["mean"], differences.mean(), delta=1e-12)
            if found["identical"] or numpy.ptp(differences) == 0 or len(a) < FEWEST:
                self.assertEqual((found["interval"], found["effect_size"]), ([], None))
                continue
            low, high = scipy.stats.t.interval(0.95, len(a) - 1, differences.mean(), scipy.stats.sem(differences))
            self.assertTrue(numpy.allclose(found["interval"], (low, high), rtol=1e-6, atol=1e-9), (a, b, found, low, high))
            self.assertAlmostEqual(found["effect_size"], differences.mean() / differences.std(ddof=1), delta=1e-9)

    def test_the_anova_is_scipys_where_something_varies_within_the_groups(self):
        compared = 0
        for (a, b), found in zip(self.tables, self.found):
            if numpy.ptp(a) == 0 and numpy.ptp(b) == 0:
                self.assertNotIn("anova", found)
                continue
            F, p = scipy.stats.f_oneway(a, b)
            compared += 1
            F, p = (F, p) if F > 0 else (0, 1)  # scipy rounds equal means to an F below zero, which has no p
            self.assertTrue(numpy.allclose(found["anova"], (F, p), rtol=1e-8, atol=1e-12), (a, b, found, F, p))
        self.assertGreater(compared, TABLES // 2)


if __name__ == "__main__":
    unittest.main()
