"""What scripts/precision_results makes of a study's points, on metrics made up by hand."""
import importlib.machinery
import importlib.util
import pathlib
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/precision_results"
spec = importlib.util.spec_from_loader("precision", importlib.machinery.SourceFileLoader("precision", str(SCRIPT)))
precision = importlib.util.module_from_spec(spec)
spec.loader.exec_module(precision)


def quantity(centre, width=0.0):
    return {"centre": centre, "low": centre - width, "high": centre + width}


def point(curve, values="", front=(), bound=False):
    return {"curve": curve, "values": values, "error": quantity(0.5, 0.25), "cpu_ms_per_s": quantity(3.0), "method_us_per_tick": quantity(0.125),
            "bound": bound, "front_run": "run" in front, "front_tick": "tick" in front}


class Rows(unittest.TestCase):
    def test_a_row_names_its_point_and_on_which_front_it_is(self):
        points = [point("burg", "order=5", ("run", "tick")), point("floor", bound=True), point("", front=("tick",))]
        self.assertEqual(precision.times_of(points), ["run", "tick"])
        self.assertEqual(list(precision.rows(points, ["run", "tick"])),
                         [["burg order=5", "0.5 [0.25, 0.75]", "3", "0.125", "run, tick"], ["floor", "0.5 [0.25, 0.75]", "3", "0.125", "a bound"],
                          ["as it is", "0.5 [0.25, 0.75]", "3", "0.125", "tick"]])

    def test_a_run_time_on_whose_front_nothing_is_has_no_column(self):
        self.assertEqual(precision.times_of([point("a", front=("run",)), point("b")]), ["run"])

    def test_what_no_run_reports_is_nothing(self):
        self.assertIsNone(precision.spread({"centre": None, "low": None, "high": None}))

    def test_one_seed_alone_has_no_brackets(self):
        self.assertEqual(precision.spread({"centre": 0.5, "low": None, "high": None}), "0.5")


if __name__ == "__main__":
    unittest.main()
