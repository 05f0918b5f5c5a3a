"""What scripts/results makes of studies, on metrics made up by hand."""
import gzip
import importlib.machinery
import importlib.util
import math
import pathlib
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/results"
spec = importlib.util.spec_from_loader("results", importlib.machinery.SourceFileLoader("results", str(SCRIPT)))
results = importlib.util.module_from_spec(spec)
spec.loader.exec_module(results)

FIGURES = ("delivered.force.rms_error_N", "delivered.force.delay_ms", "delivered.force.rms_d2_N_per_ms2",
           "delivered.force.max_step_N", "delivered.force.error_above_30hz_N", "delivered.force.share_beyond_jnd",
           "delivered.force.share_beyond_weber", "delivered.force.vibration_above_threshold_dB",
           "delivered.force.worst_vibration_above_threshold_dB",
           "method_us_per_result", "method_us_per_tick", "cost_us.collision.median", "cost_us.dynamics.median")


def ratio(value, width=0.01):
    return {"ratio": value, "low": value - width, "high": value + width, "count": 20, "seeds": 20}


def found():
    """Two scenes; methods by the ratio of their error and their run time a tick. Contact is lost in the first scene alone."""
    methods = {"hold": (1.0, 0.1), "line": (0.9, 0.3), "worse": (0.95, 0.3), "dear": (0.5, 2.0), "floor": (0.1, 0.1)}
    rows = []
    for scene, scale in (("wall", 1.0), ("air", 4.0)):
        for method, (error, us) in methods.items():
            metrics = {name: {"mean": 1.0} for name in FIGURES}
            metrics["delivered.force.rms_error_N"]["mean"] = error * scale
            metrics["delivered.force.max_step_N"]["mean"] = scale if method == "hold" else 3.0
            if scene == "wall":
                metrics["delivered.force.overshoot_after_loss_N"] = {"mean": 0.25}
            metrics["cost_us.dynamics.median"]["mean"] = 10 * scale
            metrics["method_us_per_tick"]["mean"] = us
            rows.append({"graph": scene, "method": method, "title": f"what {method} is", "metrics": metrics,
                         "against": {"ratio": {"delivered_rms": ratio(error)}}})
    return {"configurations": [{"method": m, "over_graphs": {"delivered_rms": ratio(e)}} for m, (e, _) in methods.items()],
            "rows": rows}


def cells(table):
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in table.strip().splitlines()]


class Interval(unittest.TestCase):
    def test_a_ratio_of_fewer_seeds_says_so_and_one_seed_has_no_interval(self):
        self.assertEqual(results.interval(ratio(0.5)), "0.500 [0.490, 0.510]")
        self.assertEqual(results.interval(ratio(0.5) | {"count": 19}), "0.500 [0.490, 0.510] over 19 seeds")
        self.assertEqual(results.interval(ratio(0.5) | {"low": None, "high": None, "count": 1}), "0.500 [-] over 1 seed")
        self.assertEqual(results.interval(ratio(0.5) | {"low": None, "high": None, "count": 1, "seeds": 1}), "0.500 [-]")
        self.assertEqual(results.interval(None), "-")


class RefitAgainstFixed(unittest.TestCase):
    def table(self, difference):
        row = {"metrics": {}, "against": {"one_step_rms": difference, "one_step_anova": {"F": 4.0, "p": 0.25}}}
        return cells(results.refit_against_fixed({"rows": [row] * 2 * len(results.PAPER_TESTS)}))[2]

    def test_one_seed_alone_has_no_difference(self):
        self.assertEqual(self.table(None)[7:11], ["-", "-", "-", "4 (0.25)"])
        said = {"mean_N": -0.5, "low_N": -0.75, "high_N": -0.25, "effect_size": 2.0, "p_wilcoxon": 0.03125}
        self.assertEqual(self.table(said)[7:11], ["-0.5000 [-0.7500, -0.2500]", "2", "0.031", "4 (0.25)"])
        same = said | {"low_N": None, "high_N": None, "effect_size": None, "p_wilcoxon": None}
        self.assertEqual(self.table(same)[7:11], ["-0.5000 [-]", "-", "-", "4 (0.25)"])


class Template(unittest.TestCase):
    def test_it_names_no_number_of_seeds_which_is_asked_for(self):
        self.assertNotRegex(SCRIPT.with_name("results.template.md").read_text(), r"\b\d+\s+seeds?\b")


class Methods(unittest.TestCase):
    def setUp(self):
        self.methods = results.Methods(found())

    def test_the_front_is_what_nothing_undercuts_in_both_and_fast_physics_is_not_on_it(self):
        self.assertEqual(self.methods.front(), {"hold", "line", "dear"})

    def test_the_worst_scene_of_a_method_is_that_of_its_largest_ratio(self):
        self.methods.rows["line"]["air"]["against"] = {"ratio": {"delivered_rms": ratio(0.95)}}
        self.assertEqual(self.methods.worst_scene("line"), "air")
        self.methods.rows["line"]["wall"]["against"] = {"ratio": {"delivered_rms": ratio(0.97)}}
        self.assertEqual(self.methods.worst_scene("line"), "wall")

    def test_what_there_is_to_gain_has_a_row_a_scene(self):
        for rows in self.methods.rows.values():
            for row in rows.values():
                row["metrics"] |= {name: {"mean": 5.0} for name in ("reference.force.rms_N", "contacts.median",
                                                                    "physics.rate_hz_median", "physics.force.rms_error_N")}
        self.methods.rows["floor_exact"] = self.methods.rows["line"]
        self.assertEqual(cells(self.methods.what_there_is())[2:],
                         [["wall", "5", "5", "5", "1", "5", "0.1", "0.9"], ["air", "5", "5", "5", "4", "5", "0.4", "3.6"]])

    def test_multiples_of_the_hold_are_geometric_means_over_scenes(self):
        self.assertAlmostEqual(self.methods.ratio("line", "delivered.force.max_step_N"), math.sqrt(3.0 / 1 * 3.0 / 4))
        self.assertAlmostEqual(self.methods.ratio("hold", "delivered.force.max_step_N"), 1)

    def test_tables_have_a_row_a_method_in_order(self):
        for table in (self.methods.errors(), self.methods.qualities(), self.methods.by_scene("delivered.force.delay_ms")):
            self.assertEqual([row[0] for row in cells(table)[2:]], ["hold", "line", "worse", "dear", "floor"])
        self.assertEqual(cells(self.methods.errors())[0], ["method", "all", "wall", "air"])
        self.assertEqual(cells(self.methods.errors())[3], ["line"] + 3 * ["0.900 [0.890, 0.910]"])
        quality = dict(zip(cells(self.methods.qualities())[0], cells(self.methods.qualities())[3]))
        self.assertEqual(quality["front"], "front")
        # Of the scenes in which contact is lost.
        self.assertEqual(quality["pull-in, N"], "0.25")
        self.assertEqual(cells(self.methods.by_scene("delivered.force.overshoot_after_loss_N", 2))[3], ["line", "0.5", "-"])
        self.assertEqual(quality["physics, us"], "26")
        self.assertEqual([quality[name] for name in ("beyond Weber curve, %", "vibration above threshold, dB", "at worst, dB")], ["100", "1", "1"])

    def test_an_interval_without_width_is_its_value(self):
        self.assertEqual(results.interval(None), "-")


class Tables(unittest.TestCase):
    def test_windows_are_means_over_the_tests_by_removal(self):
        rows = [{"values": {"refit.detrend, prediction.detrend": removal, "refit.window": str(window)},
                 "metrics": {"one_step.force.rms_error_N": {"mean": error + test}, "cost_us.refit.median": {"mean": 2.0}}}
                for window in results.PAPER_WINDOWS for removal, error in (("none", 0.1), ("difference", 0.2)) for test in (0, 1)]
        table = cells(results.windows({"rows": rows}))
        self.assertEqual(table[2], ["100", "0.0563", "0.6", "2", "0.7", "2"])
        self.assertEqual(len(table), 2 + len(results.PAPER_WINDOWS))

    def test_run_times_come_from_the_other_study_and_errors_do_not(self):
        def of(error, us, text):
            return {"rows": [{"graph": "wall", "metrics": {"delivered.force.rms_error_N": {"mean": error}, "cost_us.refit.median": {"mean": us},
                                                           "method_us_per_tick": {"mean": 10 * us}}}], "timing": {"text": text, "warning": ""}}
        both = results.with_run_times(of(0.1, 5.0, "at once"), of(0.9, 2.0, "one at a time"))
        self.assertEqual({name: value["mean"] for name, value in both["rows"][0]["metrics"].items()},
                         {"delivered.force.rms_error_N": 0.1, "cost_us.refit.median": 2.0, "method_us_per_tick": 20.0})
        self.assertEqual(results.timing(both), "one at a time\n")
        with self.assertRaises(ValueError):
            results.with_run_times(of(0.1, 5.0, ""), {"rows": [], "timing": {}})

    def test_the_length_of_a_recording_is_from_its_first_to_its_last_line(self):
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "a.csv.gz"
            file.write_bytes(gzip.compress(b"t_s,x\n25.5,1\n26.0,2\n29.75,3\n"))
            self.assertEqual(results.length(file), 4.25)


if __name__ == "__main__":
    unittest.main()
