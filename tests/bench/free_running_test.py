"""bench/free_running.py: the distance of two tracks by hand, and that slow physics takes a hand farther than fast physics does."""
import pathlib
import sys
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "bench"))
import free_running  # noqa: E402


class FreeRunning(unittest.TestCase):
    def test_the_distance_of_tracks_is_that_of_their_samples(self):
        rms, worst = free_running.apart(np.array([[0, 0, 0], [3, 0, 0.0]]), np.array([[0, 0, 0], [0, 4, 0.0]]))
        self.assertAlmostEqual(rms, np.sqrt(12.5))
        self.assertEqual(worst, 5)

    def test_physics_at_each_tick_leaves_the_hand_near_the_ideal_and_a_hold_at_60_hz_does_not(self):
        rows = {row[2]: row[3:] for row in free_running.rows(("wall/closed_loop",), {"firm": free_running.HANDS["firm"]}, ("hold", "floor"))}
        self.assertLess(rows["floor"][0], 0.05)  # mm; the encoder has steps of 0.01
        self.assertGreater(rows["hold"][0], 20 * rows["floor"][0])
        self.assertLess(rows["ideal, 2 kHz"][2], rows["hold"][2] / 20)


if __name__ == "__main__":
    unittest.main()
