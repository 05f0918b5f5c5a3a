"""What bench/velocity.py makes of motions: exact velocities, errors of filters, and the filter that is fitted to a motion."""
import pathlib
import sys
import unittest

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
import thresholds  # noqa: E402
import velocity  # noqa: E402

TICK = 1e-3


class Motions(unittest.TestCase):
    def test_the_velocity_is_the_derivative_of_the_position(self):
        for name, motion in velocity.motions().items():
            with self.subTest(motion=name):
                fine = 1e-5
                p, v = motion.at(fine, 0.05)
                self.assertLess(np.abs((p[2:] - p[:-2]) / (2 * fine) - v[1:-1]).max(), 1e-5 * max(1, np.abs(v).max()))

    def test_a_band_has_the_amplitude_that_was_asked_for(self):
        p, _ = velocity.Motion().band(3, 25, 2e-4).at(TICK, 200)
        self.assertTrue(np.allclose(p.std(axis=0), 2e-4, rtol=0.05))


class Filters(unittest.TestCase):
    def test_an_encoder_rounds_and_a_filter_follows_a_steady_motion(self):
        t = TICK * np.arange(2000)
        p = np.stack([0.05 * t, -0.02 * t, 0 * t], axis=1)
        for filter in ("several", "mixed", "one"):
            shown, estimate = velocity.estimated(p, filter, TICK, 1e-5)
            self.assertTrue(np.array_equal(shown, 1e-5 * np.round(p / 1e-5)))
            self.assertLess(np.abs(estimate[1000:] - [0.05, -0.02, 0]).max(), 1e-3)

    def test_noise_is_added_before_rounding(self):
        shown, _ = velocity.estimated(np.zeros((20000, 3)), "several", TICK, 0.0, 5e-6)
        self.assertTrue(np.allclose(shown.std(axis=0), 5e-6, rtol=0.05))


class Judging(unittest.TestCase):
    def test_a_sinusoid_has_the_level_of_its_band(self):
        bands = thresholds.curves()["bands"]
        [(_, centre, threshold)] = [band for band in bands if band[0] == 100]
        t = TICK * np.arange(8000)
        error = np.zeros((8000, 3))
        error[:, 1] = 2 * threshold * np.sqrt(2) * np.sin(2 * np.pi * centre * t)
        rms, level = velocity.judged(error, TICK, bands)
        self.assertAlmostEqual(rms, 2e3 * threshold, delta=0.01 * 2e3 * threshold)
        self.assertAlmostEqual(level, 20 * np.log10(2), delta=0.2)

    def test_the_weight_is_the_inverse_of_the_curve_and_then_grows(self):
        curve = thresholds.curves()["force_curves"]["0.1"]
        t = TICK * np.arange(10000)
        gain = {hz: velocity.weigh(np.sin(2 * np.pi * hz * t)[:, None], TICK, curve).std() * np.sqrt(2) for hz in (20, 100, 320)}
        at = {hz: np.exp(np.interp(np.log(hz), *np.log(np.array(curve)).T)) for hz in gain}
        self.assertAlmostEqual(gain[20] / gain[100], at[100] / at[20], places=2)
        self.assertAlmostEqual(gain[320], 2, places=2)


class Fitted(unittest.TestCase):
    def test_no_filter_is_better_than_the_one_fitted_to_a_steady_motion(self):
        found = thresholds.curves()
        for name in ("slow", "3 to 25 Hz, 200 um", "tremor of 10 Hz, 200 um"):
            with self.subTest(motion=name):
                p, v = velocity.motions()[name].at(TICK)
                half, judged = len(p) // 2, {}
                for filter in ("several", "mixed"):
                    shown, estimate = velocity.estimated(p, filter, TICK, 1e-5)
                    judged[filter] = velocity.judged(velocity.error_of(p, v, shown, estimate)[half:], TICK, found["bands"])
                for weight in (0, velocity.WEIGHT):
                    best = velocity.fitted(p, v, shown, TICK, found["force_curves"]["0.1"], weight)
                    judged[weight] = velocity.judged(velocity.error_of(p, v, shown, best)[half:], TICK, found["bands"])
                self.assertLess(judged[0][0], min(judged["several"][0], judged["mixed"][0]))
                self.assertLess(judged[0][0], judged[velocity.WEIGHT][0])
                self.assertLess(judged[velocity.WEIGHT][1], min(judged["several"][1], judged["mixed"][1], judged[0][1]))


if __name__ == "__main__":
    unittest.main()
