"""bench/palpation.py: the smallest force that is noticed, where a finger touches, and the presses of its hand."""
import pathlib
import sys
import tempfile
import unittest

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
import palpation  # noqa: E402

ROOF = """OFF
6 4 0  # two slopes of 45 degrees that meet above y = 0, 10 mm high
-0.05 -0.05 -0.04
0.05 -0.05 -0.04
0.05 0 0.01
-0.05 0 0.01
0.05 0.05 -0.04
-0.05 0.05 -0.04
3 0 1 2
3 0 2 3
3 3 2 4
3 3 4 5
"""


class Palpation(unittest.TestCase):
    def test_the_smallest_difference_is_that_of_the_table_in_docs(self):
        for force, expected in ((0.02, 0.04), (0.04, 0.04), (2.5, 0.175), (10, 0.7), (20, 1.4)):
            self.assertAlmostEqual(palpation.noticed(force), expected)
        # Shares that docs/results/thresholds.md names.
        for force, share in ((0.1, 0.55), (0.3, 0.27), (0.5, 0.20), (1, 0.13)):
            self.assertAlmostEqual(palpation.noticed(force) / force, share, delta=0.01)

    def test_a_ball_touches_a_roof_at_the_ridge_or_at_its_slope(self):
        with tempfile.NamedTemporaryFile("w", suffix=".off") as file:
            file.write(ROOF)
            file.flush()
            points = palpation.surface(pathlib.Path(file.name))
        self.assertLess(numpy.abs(points[:, 2] - 0.01 + numpy.abs(points[:, 1])).max(), 1e-12)
        # Points are close enough together that the ball is lower by less than a step of them.
        radius = palpation.RADIUS
        self.assertAlmostEqual(palpation.touches_at(points, 0, 0), 0.01 + radius, delta=1e-4)
        self.assertAlmostEqual(palpation.touches_at(points, 0, 0.02), 0.01 - 0.02 + radius * 2 ** 0.5, delta=2e-3)


if __name__ == "__main__":
    unittest.main()
