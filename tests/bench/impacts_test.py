"""What bench/impacts.py finds in forces whose rise is known."""
import pathlib
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
import impacts  # noqa: E402


def ramp(t, begin, slope):
    """N: a hit at `begin` (s) that rises to 2 N and is held for 100 ms."""
    return np.where(t < begin + 0.1, np.clip(slope * (t - begin), 0, 2), 0)


class Events(unittest.TestCase):
    def test_a_late_steep_force_is_told_as_late_and_steep(self):
        t = 1e-3 * np.arange(1000)
        reference = ramp(t, 0.2, 100.0) + ramp(t, 0.6, 100.0)
        force = ramp(t, 0.2045, 125.0) + ramp(t, 0.6045, 125.0)
        found = impacts.events(t, force, reference)
        self.assertEqual(len(found), 2)
        for late, slope, error in found.values():
            # At 0.6 N, the middle of the rise, it is 4.5 ms later, less 6 ms * (1 - 0.8).
            self.assertAlmostEqual(late, 3.3, places=2)
            self.assertAlmostEqual(slope, 1.25, places=2)
            self.assertGreater(error, 0.4)

    def test_the_reference_itself_has_no_error(self):
        t = 1e-3 * np.arange(1000)
        reference = ramp(t, 0.3, 150.0)
        [(late, slope, error)] = impacts.events(t, reference, reference).values()
        self.assertEqual((round(late, 9), round(slope, 9), error), (0, 1, 0))

    def test_a_force_that_bounces_is_one_hit(self):
        t = 1e-3 * np.arange(1000)
        reference = ramp(t, 0.3, 150.0) * np.where(abs(t - 0.33) < 0.004, 0, 1)
        self.assertEqual(len(impacts.events(t, reference, reference)), 1)

    def test_a_hit_that_is_missed_stays_in_the_list(self):
        t = 1e-3 * np.arange(1000)
        [(late, slope, error)] = impacts.events(t, 0 * t, ramp(t, 0.3, 150.0)).values()
        self.assertTrue(np.isnan(late) and np.isnan(slope))
        self.assertEqual(error, 2)


class Path(unittest.TestCase):
    def test_the_handle_touches_at_speeds_within_their_bounds(self):
        points = impacts.path(hits=40)
        touched = 0
        for (begin, above), (end, below) in zip(points, points[1:]):
            if below >= above:
                continue
            # A motion of minimum jerk: s = 10 u^3 - 15 u^4 + 6 u^5.
            u = np.linspace(0, 1, 2001)
            z = above + (below - above) * (10 * u**3 - 15 * u**4 + 6 * u**5)
            at = np.argmax(z <= impacts.TOUCHES)
            speed = (z[at - 1] - z[at]) / ((u[at] - u[at - 1]) * (end - begin))
            self.assertTrue(0.99 * impacts.SLOWEST <= speed <= 1.01 * impacts.FASTEST, speed)
            touched += 1
        self.assertEqual(touched, 40)


if __name__ == "__main__":
    unittest.main()
