"""Cells of stability_bench: ours are stable, the metrics whole, and the tables count what is there.

`stability_test.py PROGRAM MESHES`: PROGRAM is stability_bench, MESHES the folder of the meshes.
"""
import json
import pathlib
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "bench"))
import stability  # noqa: E402

PROGRAM, MESHES = sys.argv[1:3]
ANALYTIC = ("sphere_plane", "box_plane", "deep_start", "mass_ratio", "no_gravity")


def run(*options):
    with tempfile.TemporaryDirectory() as scratch:
        said = subprocess.run([PROGRAM, "--meshes", MESHES, "--scratch", scratch, *map(str, options)], check=True,
                              capture_output=True, text=True).stdout
    return json.loads(said)


def cell(contender="tactor", verdict="stable", rate=1000.0, **metrics):
    return {"contender": contender, "contact_stiffness": 1e3, "mass": 0.1, "rate": rate, "coupling_stiffness": 1e2,
            "verdict": verdict, "generated": 0.0, "peak_to_peak_m": 0.0, "rest_error_m": 2e-6, "step_s": 0.5, "query_s": 0.1, "left_out": 0,
            "simulated_s": 4.0, "damped_steps": 0, "stopped_steps": 0} | metrics


class Program(unittest.TestCase):
    def test_a_few_cells_of_ours_are_stable_in_every_analytic_scene(self):
        found = run("--most", 6, "--rate", 50, "--rate", 1000, "--contact-stiffness", 1e4, "--contact-stiffness", 1e6,
                    "--contender", "tactor", *(word for name in ANALYTIC for word in ("--scene", name)))
        stability.check_whole(found)
        self.assertEqual([scene["name"] for scene in found["scenes"] if scene["cells"]], list(ANALYTIC))
        for scene in found["scenes"]:
            for c in scene["cells"]:
                self.assertEqual(c["verdict"], "stable", f"{scene['name']}: {c}")

    def test_the_same_box_on_a_box_is_stable(self):
        found = run("--scene", "box_on_box", "--rate", 100, "--contender", "tactor")
        stability.check_whole(found)
        self.assertGreater(len(found["scenes"][0]["cells"]), 0)
        for c in found["scenes"][0]["cells"]:
            self.assertEqual(c["verdict"], "stable", c)

    def test_bodies_that_come_fast_get_no_energy_from_a_late_contact(self):
        """The ball of 100 m goes some 4 m in a period of 20 ms, the bunny is thrown at 10 m/s; where the energy of the late contact
        stays in the motion, both fail."""
        found = run("--scene", "size_1e2_m", "--scene", "bunny_thrown", "--rate", 50, "--mass", 1, "--contact-stiffness", 1e5,
                    "--contender", "tactor", "--contender", "tactor_as_made")
        stability.check_whole(found)
        for scene in found["scenes"]:
            self.assertEqual([(c["contender"], c["verdict"]) for c in scene["cells"]],
                             [("tactor", "stable"), ("tactor_as_made", "energy")], scene)

    def test_a_jammed_peg_is_stable_with_all_its_contacts_and_with_more_than_fit(self):
        found = run("--scene", "peg_jammed", "--scene", "peg_jammed_full", "--rate", 50, "--mass", 1,
                    "--contact-stiffness", 1e5, "--contender", "tactor", "--contender", "tactor_as_made")
        stability.check_whole(found)
        few, full = found["scenes"]
        for c in few["cells"] + full["cells"]:
            self.assertEqual(c["verdict"], "stable", c)
        self.assertEqual(max(c["left_out"] for c in few["cells"]), 0)
        self.assertGreater(min(c["left_out"] for c in full["cells"]), 1000)

    def test_ode_rests_where_springs_in_series_do(self):
        """So its joints have the stiffness that the comparison says."""
        cells = run("--scene", "sphere_plane", "--rate", 1000, "--mass", 0.1, "--contender", "ode", "--contender", "ode_substeps",
                    "--contender", "ode_explicit", "--coupling-stiffness", 1000)["scenes"][0]["cells"]
        self.assertEqual(len(cells), 15)
        for c in cells:
            self.assertLess(c["rest_error_m"], 1e-9, c)

    def test_an_explicit_spring_beyond_its_limit_is_seen_to_make_energy(self):
        """k = 1e5 N/m on 0.1 kg swings at 1000 rad/s: an explicit spring with steps of 20 ms cannot hold it."""
        cells = run("--scene", "sphere_plane", "--rate", 50, "--mass", 0.1, "--contact-stiffness", 1e4, "--coupling-stiffness", 1e5,
                    "--contender", "ode_explicit")["scenes"][0]["cells"]
        self.assertEqual(len(cells), 1)
        self.assertIn(cells[0]["verdict"], ("energy", "not_finite"))


class Tables(unittest.TestCase):
    def test_a_cell_without_a_figure_is_refused(self):
        broken = cell()
        del broken["peak_to_peak_m"]
        with self.assertRaisesRegex(ValueError, "press: a cell without peak_to_peak_m"):
            stability.check_whole({"scenes": [{"name": "press", "cells": [broken]}]})

    def test_contenders_that_ran_other_cells_are_refused(self):
        with self.assertRaisesRegex(ValueError, "press: expected the same cells of all"):
            stability.check_whole({"scenes": [{"name": "press", "cells": [cell(), cell("ode", rate=50.0)]}]})

    def test_an_unknown_verdict_is_refused(self):
        with self.assertRaisesRegex(ValueError, "found 'odd'"):
            stability.check_whole({"scenes": [{"name": "press", "cells": [cell(verdict="odd")]}]})

    def test_cells_are_counted_by_verdict_and_timed_at_one_kilohertz(self):
        found = {"scenes": [{"name": "press", "title": "", "cells": [
            cell(), cell(rate=50.0, verdict="limit_cycle", step_s=100), cell("ode", verdict="energy"), cell("ode", rate=50.0)]}]}
        rows = [[c.strip() for c in line.strip("|").split("|")] for line in stability.counts(found).splitlines()[2:]]
        self.assertEqual(rows[0], ["press", "tactor", "2", "1", "1", "0", "0", "0", "2", "2", "125"])
        self.assertEqual(rows[1][2:8], ["2", "1", "0", "0", "1", "0"])
        against = [[c.strip() for c in line.strip("|").split("|")] for line in stability.against(found).splitlines()[2:]]
        self.assertEqual(against, [["press", "ODE", "0", "1", "1", "0"]])

    def test_cells_without_a_balance_are_counted(self):
        found = {"scenes": [{"name": "press", "cells": [cell(), cell(rate=50.0, rest_error_m=None), cell("ode", rest_error_m=None)]},
                            {"name": "throw", "cells": [cell()]}]}
        self.assertEqual(stability.without_balance(found), "1 of the 2 cells of `press`")
        self.assertEqual(stability.without_balance({"scenes": found["scenes"][1:]}), "none")

    def test_colours_grow_darker_from_stable_to_worst(self):
        grey = [sum(w * int(colour[i:i + 2], 16) for w, i in ((0.299, 1), (0.587, 3), (0.114, 5)))
                for _, colour in stability.VERDICTS.values()]
        self.assertEqual(grey, sorted(grey))
        self.assertGreater(min(b - a for a, b in zip(grey, grey[1:])), 25)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
