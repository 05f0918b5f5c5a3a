"""The levels that sink.metrics tells of runs, against scipy's filters on the curves of their reports; curves against others' measurements."""
import pathlib
import sys
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "bench"))
import thresholds as t  # noqa: E402

import tactor  # noqa: E402


class Levels(unittest.TestCase):
    def test_those_of_a_run_are_those_of_scipys_filters(self):
        bands = t.curves()["bands"]
        for method in ("hold", "blend"):
            result = tactor.run("wall/scene", over=[method], duration="4 s")
            found = t.levels(result, bands)
            self.assertEqual(list(found)[-1], 400)
            name = "delivered.force.{}vibration_above_threshold_{}"
            loudest = max(found, key=lambda hz: found[hz][0])
            self.assertAlmostEqual(result.metrics[name.format("", "dB")], found[loudest][0], delta=0.01)
            self.assertEqual(result.metrics[name.format("", "Hz")], loudest)
            self.assertAlmostEqual(result.metrics[name.format("worst_", "dB")], max(worst for _, worst in found.values()), delta=0.01)

    def test_noise_has_in_a_band_what_its_spectral_density_says(self):
        # 0.1 N on each of three axes, white up to 500 Hz; a Butterworth of third order passes 1.047 of its width.
        noise = np.random.default_rng(3).normal(0, 0.1, (200_000, 3))
        for _, centre, _ in t.curves()["bands"][:8]:
            width = centre * (10 ** 0.05 - 10 ** -0.05)
            expected = 3 * 0.01 * width / 500 * (np.pi / 6) / np.sin(np.pi / 6)
            self.assertLess(abs(t.band_mean_squares(noise, centre, 1000).mean() / expected - 1), 4 / np.sqrt(3 * width * 200))


class Curves(unittest.TestCase):
    def test_the_threshold_of_vibration_is_near_those_of_other_postures(self):
        curve = t.curves()["vibration_curve"]
        at = lambda hz: np.exp(np.interp(np.log(hz), np.log([p[0] for p in curve]), np.log([p[1] for p in curve])))  # noqa: E731
        for hz, a in t.rms_acceleration(t.PEN_HOLD_UM) + t.rms_acceleration(t.GRASPED_CYLINDER_UM):
            self.assertLess(abs(20 * np.log10(at(hz) / a)), 10, f"{hz} Hz")

    def test_another_laboratorys_model_of_the_hand_gives_the_same_where_the_handle_is_what_moves(self):
        found = t.curves()
        for direction in t.STYLUS_HANDS:
            other = t.stylus_force(found["vibration_curve"], 0.1, direction)
            for (hz, force), (_, by_model) in zip(found["force_curves"]["0.1"], other):
                self.assertLess(abs(20 * np.log10(force / by_model)), 0.5 if hz > 80 else 3 if hz > 40 else 14, f"{direction} {hz:.0f} Hz")

    def test_every_row_names_its_source(self):
        found = t.curves()
        for *_, source in found["weber"] + found["vibration"] + found["hand"]:
            self.assertRegex(source, r"(19|20)\d\d")


if __name__ == "__main__":
    unittest.main()
