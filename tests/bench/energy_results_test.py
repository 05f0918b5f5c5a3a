"""What scripts/energy_results makes of the numbers of energy_bench, on two scenes."""
import importlib.machinery
import importlib.util
import json
import os
import pathlib
import subprocess
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/energy_results"
spec = importlib.util.spec_from_loader("energy_results", importlib.machinery.SourceFileLoader("energy_results", str(SCRIPT)))
energy_results = importlib.util.module_from_spec(spec)
spec.loader.exec_module(energy_results)


class Tables(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.found = json.loads(subprocess.run([os.environ["ENERGY_BENCH"], "--scenes", "2"], check=True, stdout=subprocess.PIPE, text=True).stdout)

    def test_a_rebound_has_a_row_for_each_stiffness_and_mass(self):
        for table in (energy_results.rebounds, energy_results.damped):
            self.assertEqual(len(table(self.found["rebound"]).splitlines()), 2 + 9)
        self.assertIn("| 2 | 100 | 0.14 |", energy_results.rebounds(self.found["rebound"]))

    def test_the_family_has_a_row_for_each_integrator_and_sub_step(self):
        self.assertEqual(len(energy_results.family(self.found["family"]).splitlines()), 2 + 8)

    def test_errors_are_compared_in_the_same_scene(self):
        def row(scene, integrator, error):
            return {"scene": scene, "integrator": integrator, "substep": 1e-3, "position_error": error, "force_error": error / 2, "contact_wh": scene + 0.5}

        rows = [row(0, "implicit_euler", 2), row(0, "midpoint", 1), row(1, "implicit_euler", 1), row(1, "midpoint", 3)]
        self.assertEqual(energy_results.compared(rows).splitlines()[-1], "| 1 | 1.750 | 3.00 | 1 | 1.750 | 3.00 | 1 | 1.50 |")

    def test_a_scene_has_its_errors_in_mN_beside_the_run_time(self):
        metrics = {"physics.force.rms_error_N": {"mean": 0.0015}, "delivered.force.rms_error_N": {"mean": 0.06}, "cpu_ms_per_s": {"mean": 7.125}}
        row = {"graph": "wall", "values": {"encoder": "as it is", "dynamics.integrator": "midpoint", "dynamics.substep": "1 ms"}, "metrics": metrics}
        self.assertEqual(energy_results.scenes({"rows": [row]}).splitlines()[-1], "| `wall` | as it is | `midpoint` | 1 ms | 1.5 | 60 | 7.12 |")

    def test_every_key_of_the_page_has_a_value(self):
        values = energy_results.values(self.found)
        page = energy_results.page.filled(SCRIPT.with_name("energy_results.template.md").read_text(), values | {"MACHINE": "here", "SHIPPED": "those"})
        self.assertIn("2 random scenes", page)


if __name__ == "__main__":
    unittest.main()
