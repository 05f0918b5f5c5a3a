"""What scripts/limits makes of maps, on cells made up by hand, and what bench/study_overhead.py reads of a study."""
import importlib.machinery
import importlib.util
import os
import pathlib
import sys
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
spec = importlib.util.spec_from_loader("limits", importlib.machinery.SourceFileLoader("limits", str(ROOT / "scripts/limits")))
limits = importlib.util.module_from_spec(spec)
spec.loader.exec_module(limits)
sys.path.insert(0, str(ROOT / "bench"))
import study_overhead  # noqa: E402

study_overhead.TACTOR = os.environ.get("TACTOR", study_overhead.TACTOR)


def cell(x, y, verdict="stable", energy=0.0, reason="", swing=None):
    """`swing` is the amplitude, m."""
    return {"x": x, "y": y, "verdict": verdict, "reason": reason, "peak_energy_J": 2 * energy, "passivity_violation_J": energy,
            "oscillation_amplitude_m": swing, "oscillation_frequency_Hz": swing and 7.0}


class Rows(unittest.TestCase):
    def test_neighbours_are_drawn_together(self):
        self.assertEqual(limits.ranges(["d", "a", "b"], ["a", "b", "c", "d"]), "a to b, d")
        self.assertEqual(limits.ranges(["c"], ["a", "b", "c"]), "c")

    def test_each_value_of_y_names_what_is_unstable_and_the_worst_with_its_reason(self):
        cells = [cell("1", "low"), cell("2", "low"), cell("4", "low"), cell("1", "high"), cell("2", "high", "energy", 0.1, "a tenth"),
                 cell("4", "high", "energy", 0.2, "a fifth"), cell("8", "high", "limit_cycle", 0.0, "it swings", 0.003), cell("8", "low")]
        self.assertEqual(list(limits.rows(cells)), [["low", "none", "", "", "", ""], ["high", "2 to 4", "energy growth", "4: a fifth", "", ""],
                                                    ["high", "8", "limit cycle", "8: it swings", "6", "7"]])

    def test_what_stable_cells_come_to_is_said_of_these_alone(self):
        cells = [cell("1", "low", energy=1e-3), cell("2", "low", energy=3e-3, swing=4e-6), cell("4", "low", "energy", 5.0, swing=0.1)]
        said = limits.calm(cells)
        self.assertIn("peaks at 6 mJ", said)
        self.assertIn("the hand gets 3 mJ more", said)
        self.assertIn("8 um", said)
        self.assertEqual(limits.calm(cells[2:]), "")
        self.assertEqual([limits.amount(v) for v in (0, 2e-7, 0.01, 290.4)], ["0", "less than 0.01", "0.01", "290"])

    def test_the_name_of_an_axis_is_short(self):
        self.assertEqual(limits.short_name("scene.bodies.wall.mass, scene.bodies.tool.mass"), "wall.mass")


class Overhead(unittest.TestCase):
    def test_the_time_inside_runs_is_part_of_that_of_the_process(self):
        found = study_overhead.measure(8, 0.5, 2)
        self.assertEqual(found["runs"], 8)
        self.assertGreater(found["run_cpu_s"], 0)
        self.assertLess(found["run_cpu_s"] + found["reference_cpu_s"], found["total_cpu_s"])
        self.assertLess(found["total_cpu_s"], found["process_cpu_s"])
        self.assertGreater(found["waited_for_core_s"], 0)
        self.assertEqual(len(list(study_overhead.rows(found))), 10)

    def test_a_study_of_many_short_runs_spends_its_time_inside_them(self):
        found = study_overhead.measure(100, 0.5, 2)
        for share in study_overhead.shares(found):
            self.assertGreaterEqual(share, 0.8, found)
        self.assertGreaterEqual((found["run_cpu_s"] + found["reference_cpu_s"]) / found["process_cpu_s"], 0.8, found)


if __name__ == "__main__":
    unittest.main()
