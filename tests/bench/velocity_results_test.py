"""What scripts/velocity_results makes of studies, motions and limits whose numbers are known."""
import importlib.machinery
import importlib.util
import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "bench"))
spec = importlib.util.spec_from_loader("velocity_results", importlib.machinery.SourceFileLoader("velocity_results", str(ROOT / "scripts/velocity_results")))
velocity_results = importlib.util.module_from_spec(spec)
spec.loader.exec_module(velocity_results)


def metrics(rms, largest, level, second=0.01, delay=0.3, us=20.0):
    """Of two seeds; `rms` and `largest` are pairs."""
    def of(values):
        return {"mean": sum(values) / len(values), "by_seed": list(values)}

    return {velocity_results.RMS: of(rms), velocity_results.LARGEST: of(largest), velocity_results.LEVEL: of([level, level]),
            velocity_results.SECOND: of([second, second]), velocity_results.DELAY: of([delay, delay]), velocity_results.TIME: of([us, us])}


def study():
    rows = []
    for graph, gain, exact in (("calm", 0.5, -5.0), ("wild", 2.0, 8.0)):
        rows += [{"graph": graph, "method": "local_several", "metrics": metrics((0.01, 0.02), (0.1, 0.1), 3.0)},
                 {"graph": graph, "method": "local", "metrics": metrics((0.01 * gain, 0.02 * gain), (0.1, 0.4), -2.0 * gain)},
                 {"graph": graph, "method": "local_exact", "metrics": metrics((0.001, 0.001), (0.1, 0.1), exact)}]
    return {"rows": rows}


class Scenes(unittest.TestCase):
    def setUp(self):
        self.scenes = velocity_results.Scenes(study())

    def test_a_scene_is_reachable_where_an_exact_encoder_is_not_felt(self):
        self.assertEqual(velocity_results.thresholds.reachable(study()), (["calm"], ["wild"]))

    def test_errors_are_by_those_of_before_with_the_same_seed(self):
        before, now = velocity_results.compared(self.scenes, ["calm", "wild"], "local")
        self.assertEqual(before[:4], ["`local_several`", "15.00", "1.000", "1"])
        self.assertEqual(now[:5], ["`local`", "18.75", "1.000", "2.000 (wild)", "2.00 (calm)"])
        self.assertEqual((before[7], now[7]), ("0 of 2", "2 of 2"))

    def test_a_scene_tells_before_and_now(self):
        [row] = velocity_results.each(self.scenes, ["calm"])
        self.assertEqual(row, ["calm", "15.0 → 7.5", "0.500", "2.00", "3.0 → -1.0", "-5.0", "10.0 → 10.0", "0.30 → 0.30"])


class Motions(unittest.TestCase):
    def test_the_worst_and_the_louder_motions_are_told(self):
        found = [(1000, 1e-5, 0, {"none": [(0.4, -90.0), (0.4, -90.0)], "slow": [(2.0, -3.0), (1.0, -9.0)], "broad": [(2.0, 1.0), (4.0, 2.0)]})]
        [row] = velocity_results.alone_rows(found)
        self.assertEqual(row, [1000, "10", "0", "1.000", "2.000 (broad)", "-2.5", "1.0 (broad)", "1 of 2"])
        self.assertEqual(list(velocity_results.motion_rows(found))[0], ["slow", "2.00 → 1.00", "-3.0 → -9.0"])


class Loop(unittest.TestCase):
    def test_a_hand_has_a_row_and_a_rate_a_column(self):
        found = [["hold", "touch", "firm", rate, step, step + 0.5] for rate, step in zip((50, 100, 150), (8, 9, 10))]
        self.assertEqual(list(velocity_results.loop_rows(found)), [["`hold`", "touch", "firm", "8.00 → 8.50", "9.00 → 9.50", "10.00 → 10.50"]])


if __name__ == "__main__":
    unittest.main()
