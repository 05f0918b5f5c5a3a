"""What scripts/transfer_results makes of a study, on errors made up by hand."""
import importlib.machinery
import importlib.util
import pathlib
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/transfer_results"
spec = importlib.util.spec_from_loader("transfer_results", importlib.machinery.SourceFileLoader("transfer_results", str(SCRIPT)))
transfer = importlib.util.module_from_spec(spec)
spec.loader.exec_module(transfer)

METHODS = ("hold_one_filter", "hold", "paper_100", "blend", "local", "direct", "floor")


def ratios(**scenes):
    """By scene the errors of two seeds by method, the largest errors twice as large; those left out are as the yardstick's."""
    rows = []
    for scene, errors in scenes.items():
        for method in METHODS:
            by_seed = errors.get(method, [1.0, 4.0])
            rows.append({"graph": scene, "method": method, "metrics": {
                transfer.ERROR: {"by_seed": by_seed}, transfer.LARGEST: {"by_seed": [2 * e for e in by_seed]},
                transfer.TIME: {"by_seed": [3.0, 5.0]}, transfer.WEBER: {"by_seed": [0.1, 0.3]}}})
    return transfer.Ratios({"rows": rows}, METHODS)


def cells(table):
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.strip().splitlines()]


class Tables(unittest.TestCase):
    def test_a_ratio_is_the_geometric_mean_of_those_of_the_seeds(self):
        found = ratios(wall={"local": [0.5, 8.0]})  # 0.5 and 2 of the yardstick
        self.assertAlmostEqual(found.mean("wall", "local"), 1)
        self.assertEqual(found.of("wall", "local"), [0.5, 2.0])

    def test_the_summary_names_the_worst_scene_and_the_worst_seed(self):
        found = ratios(wall={"local": [0.1, 0.4]}, star={"local": [0.4, 1.6]}, edge={"local": [0.9, 6.4]})
        row = next(r for r in cells(found.summary()) if r[0] == "local")
        self.assertEqual(row[1:6], ["0.363", "0.400", "1.20 (edge)", "1.60 (edge)", "33 %"])
        # Nobody told the vibration and the delay.
        self.assertEqual(row[6:], ["20", "-", "-", "4"])

    def test_scenes_that_leave_much_to_gain_or_do_harm_are_named(self):
        fine = {"local": [0.1, 0.4], "floor": [0.05, 0.2]}
        self.assertTrue(ratios(wall=fine).doubts().startswith("None"))
        said = ratios(wall=fine, half={"local": [0.5, 2.0], "floor": [0.1, 0.4]}, little={"local": [1.2, 4.8], "floor": [0.8, 3.2]}).doubts()
        self.assertNotIn("wall", said)
        self.assertIn("half: local leaves 44 % of the way from hold to floor", said)
        self.assertIn("little: local has 1.20 times the error of hold, the floor 0.80 times", said)
        self.assertIn("little: the largest error of local is 1.20 times that of hold", said)

    def test_local_is_judged_by_the_better_of_hold_and_blend(self):
        said = ratios(wall={"local": [0.15, 0.6], "blend": [0.1, 0.4], "floor": [0.1, 0.4]}).doubts()
        self.assertIn("wall: local has 1.50 times the error of the better of hold and blend", said)

    def test_the_readme_names_the_worst_scene_and_its_error_as_multiples_of_those_of_hold(self):
        found = ratios(wall={"hold": [2.0, 2.0], "local": [0.2, 0.2]}, star={"local": [0.4, 1.6]})
        row = next(r for r in cells(found.shown()["TABLE"]) if r[0].startswith("`local`"))
        self.assertEqual(row[1:4], ["0.6", "0.20", "0.40 (star, 1 N)"])
        self.assertEqual(found.shown()["SCENES"], "2")

    def test_delays_count_where_every_method_has_one(self):
        found = ratios(wall={}, star={}, edge={})
        for scene, delays in (("wall", (10, 20, 5, 1)), ("star", (12, None, 6, 2)), ("edge", (14, 30, 9, 3))):
            for method, delay in zip(transfer.SHOWN, delays):
                found.rows[scene][method][transfer.DELAY] = {"by_seed": [delay, delay]}
        self.assertEqual(found.delays(transfer.SHOWN), {"hold": [10, 14], "paper_100": [20, 30], "blend": [5, 9], "local": [1, 3]})
        self.assertEqual([row[4] for row in cells(found.shown()["TABLE"])[2:]], ["12", "25", "7", "2"])
        self.assertEqual(found.shown()["DELAYS"], "2")


if __name__ == "__main__":
    unittest.main()
