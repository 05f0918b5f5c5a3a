"""Amplitudes of bench/soft_loop.py on made-up motions, its table, and one of its cells run by the command that TACTOR names."""
import math
import os
import pathlib
import sys
import unittest

try:
    import h5py  # noqa: F401
except ImportError:
    print("h5py is not installed")
    sys.exit(77)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
import soft_loop  # noqa: E402

soft_loop.TACTOR = os.environ.get("TACTOR", soft_loop.TACTOR)


class Amplitude(unittest.TestCase):
    def test_a_sine_has_its_own_about_any_middle(self):
        for angle in (0, 0.5 * math.pi):
            points = [(7.0, 3 + 2 * math.cos(angle) * math.sin(i / 50), 2 * math.sin(angle) * math.sin(i / 50)) for i in range(1000)]
            self.assertAlmostEqual(soft_loop.amplitude(points), 2, places=3)

    def test_a_point_at_rest_has_none(self):
        self.assertEqual(soft_loop.amplitude([(1.0, 2.0, 3.0)] * 5), 0)

    def test_the_last_second_alone_counts(self):
        times = [i / 1000 for i in range(4001)]
        points = [(100.0 if t <= 3.0 else t,) for t in times]
        rest = soft_loop.at_rest(times, points)
        self.assertEqual(len(rest), 1000)
        self.assertAlmostEqual(soft_loop.amplitude(rest), 0.4995)

    def test_a_run_that_is_too_short_is_refused(self):
        with self.assertRaises(ValueError):
            soft_loop.at_rest([0, 0.5], [(0.0,), (0.0,)])


class Table(unittest.TestCase):
    FOUND = {("light", 20, 300): {"hold": (2.0, 1.0), "local": (0.001, 0.002)}, ("firm", 20, 300): {"hold": (0.0, 0.0101), "local": (0.0, 0.01)}}

    def test_a_cell_has_the_larger_of_handle_and_tool(self):
        rows = soft_loop.swing_table(self.FOUND).splitlines()
        self.assertEqual([c.strip() for c in rows[2].strip("|").split("|")], ["light", "20", "300", "2", "0.002"])
        self.assertEqual([c.strip() for c in rows[3].strip("|").split("|")], ["firm", "20", "300", "0.01", "0.01"])

    def test_more_than_a_step_of_the_encoder_is_counted(self):
        self.assertEqual(soft_loop.restless(self.FOUND, "hold"), (2, 2.0))
        self.assertEqual(soft_loop.restless(self.FOUND, "local"), (0, 0.01))


class Run(unittest.TestCase):
    def test_a_late_force_swings_a_light_hand_on_stiff_gel_and_the_local_model_does_not(self):
        settings = soft_loop.settings("light", 2000, 500)
        self.assertGreater(max(soft_loop.run("hold", settings)), 1)
        self.assertLessEqual(max(soft_loop.run("local", settings)), soft_loop.STILL)


if __name__ == "__main__":
    unittest.main()
