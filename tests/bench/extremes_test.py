"""What bench/extremes.py makes of forces and studies whose judgement is known."""
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))
BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
sys.path.insert(0, str(BUILD / "python"))
import extremes  # noqa: E402


class Judging(unittest.TestCase):
    def test_a_force_that_is_shown_as_it_is_has_no_error(self):
        forces = np.stack([np.linspace(1, 7, 30), np.zeros(30), np.zeros(30)], axis=1)
        t = extremes.TICK * np.arange(291)
        shown = np.stack([np.interp(t, extremes.PERIOD * np.arange(30), forces[:, 0]), 0 * t, 0 * t], axis=1)
        not_finite, size, error = extremes.judged(shown, forces)
        self.assertEqual(not_finite, 0)
        self.assertAlmostEqual(size, 1, places=6)
        self.assertAlmostEqual(error, 0, places=12)

    def test_what_is_not_finite_is_counted_and_growth_is_told(self):
        forces = np.ones((30, 3))
        shown = np.full((300, 3), 2.0)
        shown[7] = math.nan
        not_finite, size, _ = extremes.judged(shown, forces)
        self.assertEqual((not_finite, round(size, 9)), (1, 2))

    def test_a_huge_force_is_judged_within_the_device(self):
        forces = np.tile([1e6, 0, 0], (30, 1))
        _, size, error = extremes.judged(np.tile([extremes.FORCE_MAX, 0, 0], (300, 1)), forces)
        self.assertEqual((size, error), (1, 0))


class Methods(unittest.TestCase):
    def test_no_method_shows_a_force_that_is_not_finite_or_beyond_the_device(self):
        for name, forces in extremes.kinds().items():
            for method in ("hold", "refit", "paper"):
                with self.subTest(force=name, method=method):
                    shown, _ = extremes.played(method, forces)
                    self.assertTrue(np.isfinite(shown).all())
                    # A spline between points within the bounds may leave them by a little.
                    self.assertLessEqual(np.linalg.norm(shown, axis=1).max(), 1.5 * extremes.FORCE_MAX)

    def test_a_corner_of_the_grid_has_a_row_for_each_method(self):
        methods = ("hold", "local")
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "study.yaml"
            file.write_text(extremes.study(ROOT / "graphs/methods", methods, short=True))
            subprocess.run([BUILD / "bin/tactor", "study", file, "--jobs", "1", "--out", pathlib.Path(folder) / "out"], check=True, stdout=subprocess.DEVNULL)
            cells = extremes.cells(json.loads((pathlib.Path(folder) / "out/study.json").read_text()))
        rows = list(extremes.method_rows(cells))
        self.assertEqual([row[0] for row in rows], ["`hold`", "`local`"])
        self.assertEqual([row[1] for row in rows], [1, 1])
        self.assertEqual([row[2:6] for row in rows], [[1, 0, 0, 0]] * 2)
        self.assertEqual(rows[0][6], "1.000")


if __name__ == "__main__":
    unittest.main()
