"""bench/soft_peers.py: figures of made-up forces, its table without Bullet, and what BULLET_SOFT says of a ball on a block, where it is built."""
import os
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
import soft_peers  # noqa: E402

PROGRAM = os.environ.get("BULLET_SOFT", "")
PERIOD = 1 / 60


def times(end):
    return [PERIOD * i for i in range(int(end / PERIOD) + 1)]


class Figures(unittest.TestCase):
    reference = [(0.0, 0.0, 0.03), (soft_peers.REST, 2.0, 0.022), (soft_peers.END, 2.0, 0.022)]

    def test_a_force_that_is_the_reference_everywhere_has_no_error(self):
        found = soft_peers.figures([(t, soft_peers.at(self.reference, t), 0.022) for t in times(soft_peers.END)], self.reference)
        self.assertAlmostEqual(found["error"], 0)
        self.assertAlmostEqual(found["moving"], 0)
        self.assertAlmostEqual(found["swing"], 0)
        self.assertAlmostEqual(found["depth"], 6)

    def test_errors_at_rest_and_in_motion_are_told_apart(self):
        later = [(t, soft_peers.at(self.reference, t) + (0.5 if t <= soft_peers.REST else -0.2), 0.022) for t in times(soft_peers.END)]
        found = soft_peers.figures(later, self.reference)
        self.assertAlmostEqual(found["error"], -10)
        self.assertAlmostEqual(found["moving"], 0.5)

    def test_a_force_that_is_not_finite_or_beyond_belief_has_no_figures(self):
        for force in (None, float("nan"), 1e9):
            self.assertIsNone(soft_peers.figures([(0.0, 0.0, 0.0), (soft_peers.END, force, 0.0)], self.reference))

    def test_a_force_is_straight_between_results_and_held_after_the_last(self):
        self.assertAlmostEqual(soft_peers.at(self.reference, 0.25 * soft_peers.REST), 0.5)
        self.assertEqual(soft_peers.at(self.reference, 99), 2.0)


class Missing(unittest.TestCase):
    def test_without_the_programs_a_sentence_says_what_to_install(self):
        kept, soft_peers.BULLET = soft_peers.BULLET, {"double": pathlib.Path("/nonexistent/bullet_soft_double")}
        try:
            said = soft_peers.peers()
        finally:
            soft_peers.BULLET = kept
        self.assertIn("libbullet-dev", said)
        self.assertIn("bullet_soft_double", said)


@unittest.skipUnless(os.path.exists(PROGRAM), "bullet_soft is not built")
class Program(unittest.TestCase):
    def pressed(self, options, cell=0.02, handle=0.024):
        """What the program says of a handle that is led down from where the ball touches, and rests."""
        soft_peers.BULLET = {"double": pathlib.Path(PROGRAM)}
        samples = [[0.0, 0, 0, 0.028, 0, 0, (handle - 0.028) / 0.2], [0.2, 0, 0, handle, 0, 0, (handle - 0.028) / 0.2],
                   [0.2001, 0, 0, handle, 0, 0, 0], [9.0, 0, 0, handle, 0, 0, 0]]
        with tempfile.TemporaryDirectory() as folder:
            return soft_peers.bullet(cell, options, "double", samples, times(0.6), pathlib.Path(folder))

    def test_by_nodes_the_hand_carries_what_the_tissue_pushes_with(self):
        said = self.pressed({**soft_peers.NODES, "substeps": 12})
        self.assertEqual(said["precision"], "double")
        self.assertEqual(said["tetrahedra"], 4 * 4 * 2 * 5)
        last = said["results"][-1]
        self.assertGreater(last["force"][2], 0.2)
        self.assertAlmostEqual(last["force"][2], said["tissue_force"][2], delta=0.01 * last["force"][2])

    def test_the_spring_at_rest_is_as_long_as_its_force_says(self):
        last = self.pressed({**soft_peers.NODES, "substeps": 12})["results"][-1]
        self.assertAlmostEqual(last["force"][2], soft_peers.STIFFNESS * (last["p"][2] - 0.024), delta=1e-3 * last["force"][2])

    def test_a_ball_that_does_not_touch_feels_nothing(self):
        last = self.pressed({**soft_peers.NODES, "substeps": 12}, handle=0.03)["results"][-1]
        self.assertAlmostEqual(last["force"][2], 0, delta=1e-6)


if __name__ == "__main__":
    unittest.main()
