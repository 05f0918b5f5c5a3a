"""The tables of bench/rates.py from figures whose means and ratios are known."""
import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "bench"))
import rates  # noqa: E402


class Rates(unittest.TestCase):
    def test_a_step_is_the_mean_of_each_node_of_a_kind(self):
        summary = {"cost_us": {"a": {"type": "prediction.local", "steps": 4, "total_s": 2e-4},
                               "b": {"type": "prediction.ar", "steps": 2, "total_s": 2e-5},
                               "idle": {"type": "prediction.refit", "steps": 0, "total_s": 0},
                               "c": {"type": "interpolation.rollout", "steps": 10, "total_s": 1e-5}}}
        self.assertAlmostEqual(rates.step_us(summary, rates.RESULT), 60)
        self.assertAlmostEqual(rates.step_us(summary, rates.TICK), 1)

    def test_rows_compare_each_scene_with_itself(self):
        def figures(error, result):
            return {"error": error, "delay": error, "result": result, "tick": 3.0}

        found = {1: {"x": figures(1.0, 10), "y": figures(4.0, 20)}, 4: {"x": figures(2.0, 10), "y": figures(2.0, 80)}}
        (_, mean, worst, delay, *_), (rate, mean_4, worst_4, _, cost, ratio, worst_ratio, tick) = rates.rows(found, {"x": 2.0, "y": 2.0})
        self.assertEqual((mean, worst, delay), (1.0, 2.0, 2.5))
        self.assertEqual((rate, mean_4, worst_4, cost, worst_ratio, tick), (4, 1.0, 1.0, 45, 4.0, 3.0))
        self.assertAlmostEqual(ratio, 2)


if __name__ == "__main__":
    unittest.main()
