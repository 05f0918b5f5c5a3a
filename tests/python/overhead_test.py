"""bench/python_overhead.py measures the same runs three ways, and its page has a place for each table."""
import re
import sys
import unittest

from package_harness import ROOT, PackageTest

sys.path.insert(0, str(ROOT / "bench"))
import python_overhead  # noqa: E402
from run_time import table  # noqa: E402


class Overhead(PackageTest):
    def test_every_kind_of_run_is_measured_beside_the_command(self):
        found = python_overhead.overhead(2, {"wall/refit": 0.5})
        self.assertEqual({kind: len(values) for kind, values in found["wall/refit"].items()}, dict.fromkeys(python_overhead.RUNS, 2))
        rows = list(python_overhead.overhead_rows(found))
        self.assertEqual([row[-1] for row in rows][0], "1.000")
        self.assertEqual(table(python_overhead.HEAD, rows).count("\n"), 5)

    def test_ratios_are_medians_of_those_of_each_round(self):
        found = {"g": {"command": [(1.0, 2.0), (4.0, 2.0), (2.0, 2.0)], "run": [(2.0, 2.0), (4.0, 1.0), (6.0, 4.0)]}}
        rows = list(python_overhead.overhead_rows(found))
        self.assertEqual(rows[1][2:], [4000.0, 2000.0, "2.000", "1.000"])

    def test_a_tap_is_counted(self):
        found = python_overhead.tap(2, "virtual")
        self.assertEqual((found["messages"], found["lost"], found["dropped"]), (2000, 0, 0))

    def test_the_page_asks_for_what_the_script_has(self):
        asked = set(re.findall(r"\{\{(\w+)\}\}", (ROOT / "scripts/python_results.template.md").read_text()))
        self.assertEqual(asked, {"MACHINE", "ROUNDS", "OVERHEAD", "CALLS", "TAPS"})


if __name__ == "__main__":
    unittest.main()
