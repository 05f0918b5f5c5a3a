"""Verdicts and search of bench/worst_hand.py on made-up motions and hands, what it writes, and the plots of bench/z_width.py."""
import math
import pathlib
import sys
import unittest

try:
    import numpy
    import scipy.stats  # noqa: F401
    import yaml
except ImportError:
    print("python3-numpy, python3-scipy or python3-yaml is not installed")
    sys.exit(77)

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
import worst_hand  # noqa: E402
import z_width  # noqa: E402

T = numpy.arange(4000) / 1000


def swing(amplitude, decay, lag):
    """Positions, speeds and forces of a handle that swings at 20 Hz on a spring of 1 N/mm whose force is late by `lag` s."""
    def at(t):
        return amplitude * numpy.exp(-decay * t) * numpy.sin(2 * math.pi * 20 * t)

    x = at(T)
    speed = abs(numpy.gradient(x, T))
    zeros = numpy.zeros_like(x)
    return numpy.stack([zeros, zeros, x], 1), speed, numpy.stack([zeros, zeros, 3 - 1000 * at(T - lag)], 1)


class Verdict(unittest.TestCase):
    def test_a_force_that_comes_late_drives_a_swing_that_goes_on(self):
        self.assertTrue(worst_hand.is_driven(*swing(1e-3, 0, 2e-3)))

    def test_a_force_that_comes_early_brakes_so_the_hand_swings_by_itself(self):
        self.assertFalse(worst_hand.is_driven(*swing(1e-3, 0, -2e-3)))

    def test_what_dies_out_or_is_small_is_not_driven(self):
        self.assertFalse(worst_hand.is_driven(*swing(1e-3, 1, 2e-3)))
        self.assertFalse(worst_hand.is_driven(*swing(1e-5, 0, 2e-3)))  # 1.3 mm/s
        self.assertTrue(worst_hand.is_driven(*swing(2e-5, 0, 2e-3)))

    def test_a_fault_and_what_is_not_finite_count_as_driven(self):
        x, speeds, forces = swing(1e-6, 0, 0)
        self.assertTrue(worst_hand.is_driven(x, speeds, forces, 1))
        speeds[10] = math.nan
        self.assertTrue(worst_hand.is_driven(x, speeds, forces))


class Hands(unittest.TestCase):
    def test_the_corners_of_the_cube_are_the_ends_of_the_ranges(self):
        low, high = worst_hand.hand_of([0] * 5), worst_hand.hand_of([1, 1, 1, 0.9, 1])
        self.assertEqual((low.hand_mass, low.hand_damping, low.hand_stiffness, low.grip_stiffness, low.grip_damping), (0.02, 0, 20, 200, 0))
        for name, (_, most) in worst_hand.RANGES.items():
            self.assertAlmostEqual(getattr(high, name), most, delta=1e-9 * most)

    def test_the_end_of_the_grip_is_rigid_and_what_is_outside_counts_as_at_the_border(self):
        self.assertEqual(worst_hand.hand_of([0.5, 0.5, 0.5, 0.95, 0.5]).grip_damping, 0)
        self.assertEqual(worst_hand.hand_of([-1, 2, 0, 0, 0]), worst_hand.hand_of([0, 1, 0, 0, 0]))

    def test_damped_hands_have_their_least_damping_ratios(self):
        for share in (0, 0.3, 0.85):
            hand = worst_hand.hand_of([share] * 5, 0.1)
            reduced = hand.hand_mass * worst_hand.HANDLE / (hand.hand_mass + worst_hand.HANDLE)
            self.assertGreater(hand.hand_damping / (2 * math.sqrt(hand.hand_stiffness * hand.hand_mass)), 0.1 - 1e-12)
            self.assertGreater(hand.grip_damping / (2 * math.sqrt(hand.grip_stiffness * reduced)), 0.1 - 1e-12)


class Searching(unittest.TestCase):
    def test_it_comes_near_the_worst_of_a_made_up_device(self):
        def bears(hand):
            """N/m: least at 0.1 kg and a grip of 2 kN/m."""
            return 20 * 10 ** (math.log10(hand.hand_mass / 0.1)**2 + math.log10(max(hand.grip_stiffness, 1) / 2000)**2)

        def trial(method, stiffness, hand):
            return stiffness > bears(hand), stiffness / bears(hand)

        found = worst_hand.Search("made up", trial)
        found.descend(found.sample(64, seed=3), 60)
        self.assertLess(bears(found.hand), 20 * math.sqrt(2))
        self.assertLessEqual(worst_hand.LADDER[found.level], bears(found.hand))
        self.assertGreater(found.runs, 100)

    def test_it_says_so_where_no_hand_is_driven(self):
        found = worst_hand.Search("made up", lambda method, stiffness, hand: (False, 0.0))
        found.sample(4, seed=1)
        self.assertIsNone(found.hand)
        self.assertEqual(found.level, len(worst_hand.LADDER) - 1)


class Written(unittest.TestCase):
    def test_an_overlay_has_the_hand_and_what_it_bears(self):
        hand = worst_hand.Hand(0.1, 0, 135, 500, 0.5)
        tree = yaml.safe_load(worst_hand.overlay("one", hand, "a comment"))
        self.assertEqual(tree["nodes"]["device"], {"loop": "closed", **vars(hand)})
        self.assertEqual((tree["format"], tree["title"]), (2, "one"))

    def test_a_plot_has_a_panel_a_rate_and_a_line_a_theory(self):
        found = {rate: {hand: [100.0] * len(z_width.DAMPINGS) for hand in z_width.HANDS} for rate in z_width.RATES}
        values = dict.fromkeys(z_width.LINES, 50.0) | {"passive, linear": -1.0}
        said = {rate: {"ticks": 1, "undamped": values, "lines": {name: [v] * len(z_width.GRID) for name, v in values.items()}} for rate in z_width.RATES}
        script = z_width.figure_script("made_up", found, said, "x.svg")
        self.assertEqual(script.count("\nplot $m"), len(z_width.RATES))
        for line in z_width.LINES:
            self.assertEqual(script.count(f"title '{line}'"), len(z_width.RATES))
        self.assertIn(" nan ", script)
        row = z_width.best_table({"made_up": found}, {"made_up": said}).splitlines()[2]
        self.assertEqual(row, "| made_up | 1000 | 1 | 100 | 100 at 0.125 | 100 | 100 at 0.125 | 50 | 50 | 50 | none | 50 | 50 |")


if __name__ == "__main__":
    unittest.main()
