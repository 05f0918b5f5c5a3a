"""Verdicts of bench/closed_loop.py on made-up motions, its tables, and a few of its cells run by the command that TACTOR names."""
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
import closed_loop  # noqa: E402

closed_loop.TACTOR = os.environ.get("TACTOR", closed_loop.TACTOR)


def swing(amplitude, decay=0.0):
    """Speeds over 4 s of a handle that swings at 20 Hz."""
    return [abs(amplitude * math.exp(-decay * i / 1000) * math.sin(2 * math.pi * 20 * i / 1000)) for i in range(4000)]


class Verdict(unittest.TestCase):
    def test_what_comes_to_rest_in_the_first_half_is_quiet(self):
        self.assertTrue(closed_loop.is_quiet([0.1] * 2000 + [0.0] * 2000))
        self.assertTrue(closed_loop.is_quiet(swing(0.1, decay=2)))  # 1.83 mm/s after 2 s

    def test_what_goes_on_swinging_is_not(self):
        self.assertFalse(closed_loop.is_quiet(swing(0.1, decay=1.9)))  # 2.24 mm/s after 2 s
        self.assertFalse(closed_loop.is_quiet(swing(0.0021)))
        self.assertTrue(closed_loop.is_quiet(swing(0.0019)))

    def test_one_jerk_in_the_second_half_is_enough(self):
        self.assertFalse(closed_loop.is_quiet([0.0] * 3999 + [0.0021]))
        self.assertFalse(closed_loop.is_quiet([0.0] * 2000 + [0.0021] + [0.0] * 1999))
        self.assertTrue(closed_loop.is_quiet([0.0] * 1999 + [0.0021] + [0.0] * 2000))

    def test_a_device_without_its_force_and_speeds_that_are_not_finite_are_not_quiet(self):
        self.assertFalse(closed_loop.is_quiet([0.0] * 4000, faults=1))
        self.assertFalse(closed_loop.is_quiet([0.0] * 3000 + [math.nan] * 1000))
        with self.assertRaises(ValueError):
            closed_loop.is_quiet([])


class Ladder(unittest.TestCase):
    def test_the_limit_is_the_step_before_the_first_restless_one(self):
        tried = []

        def quiet(stiffness):
            tried.append(stiffness)
            return stiffness != 4  # quiet again above

        self.assertEqual(closed_loop.climb(quiet, (1, 2, 4, 8)), 2)
        self.assertEqual(tried, [1, 2, 4])
        self.assertEqual(closed_loop.climb(lambda k: True, (1, 2, 4)), 4)
        self.assertEqual(closed_loop.climb(lambda k: False, (1, 2, 4)), 0)

    def test_it_goes_from_50_beyond_8000_in_fourth_roots_of_two(self):
        self.assertEqual(closed_loop.LADDER[0], 50)
        self.assertGreater(closed_loop.LADDER[-1], 8000)
        for a, b in zip(closed_loop.LADDER, closed_loop.LADDER[1:]):
            self.assertAlmostEqual(b / a, 2 ** 0.25)

    def test_a_table_tells_limits_at_the_ends_of_the_ladder_and_one_of_the_floor_for_all_rates(self):
        found = {("hold", r, g): (0.0, None) for r in closed_loop.RATES for g in closed_loop.GRIPS}
        found["hold", 100, "firm"] = (200.0, 1.5)
        found |= {("floor", None, g): (closed_loop.LADDER[-1], 0.0) for g in closed_loop.GRIPS}
        lines = [[c.strip() for c in line.strip("|").split("|")] for line in closed_loop.limit_table(found).splitlines()]
        self.assertEqual(lines[2], ["hold", "none", "200", "none", "none", "none", "none", "1.5"])
        self.assertEqual(lines[3], ["floor"] + 6 * ["9051 or more"] + ["0"])


class Runs(unittest.TestCase):
    def test_the_exact_floor_has_no_encoder_steps_on_any_device(self):
        found = {}
        for method in ("floor", "floor_exact"):
            speeds, _ = closed_loop.run("duck", method, ["device.loop=closed", "duration=1 s"], closed_loop.DEVICES["touch"])
            found[method] = speeds
        self.assertNotEqual(found["floor"], found["floor_exact"])


class Cells(unittest.TestCase):
    def quiet(self, method, stiffness, rate, grip, depth=5e-3, surface=None):
        speeds, summary = closed_loop.run("wall_closed_loop", method, closed_loop.settings(stiffness, rate, grip, depth, surface), surface=surface)
        self.assertEqual(len(speeds), 4000)
        self.assertGreater(max(speeds[:2000]), 0.05)  # it came down and was pushed
        return closed_loop.is_quiet(speeds, summary["device"]["faults"]), closed_loop.generated(summary)

    def test_a_held_force_bears_a_soft_coupling_and_swings_on_a_stiff_one(self):
        self.assertTrue(self.quiet("hold", 100, 100, "firm")[0])
        quiet, generated = self.quiet("hold", 4000, 100, "firm")
        self.assertFalse(quiet)
        self.assertGreater(generated, 10)

    def test_the_local_rollout_bears_4000_N_per_m_in_a_light_hand_and_makes_no_energy(self):
        for rate in closed_loop.RATES:
            quiet, generated = self.quiet("local", 4000, rate, "light")
            self.assertTrue(quiet, f"{rate} Hz")
            self.assertLess(generated, 1)

    def test_the_local_rollout_is_as_quiet_on_an_edge_and_on_texture(self):
        for surface in closed_loop.SURFACES:
            for grip, stiffness in (("firm", 8000), ("light", 4000)):
                quiet, generated = self.quiet("local", stiffness, 50, grip, surface=surface)
                self.assertTrue(quiet, f"{surface}, {grip}")
                self.assertLess(generated, 1)


if __name__ == "__main__":
    unittest.main()
