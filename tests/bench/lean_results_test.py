"""What scripts/lean_results makes of lean graphs, on metrics made up by hand: a promise that is not kept ends it."""
import copy
import importlib.machinery
import importlib.util
import json
import pathlib
import subprocess
import tempfile
import unittest

SCRIPT = pathlib.Path(__file__).resolve().parents[2] / "scripts/lean_results"
PAGE = SCRIPT.parents[1] / "docs/results/lean_results.md"
spec = importlib.util.spec_from_loader("lean_results", importlib.machinery.SourceFileLoader("lean_results", str(SCRIPT)))
lean_results = importlib.util.module_from_spec(spec)
spec.loader.exec_module(lean_results)


def graph(name, original, lean, steps, error=0.04):
    return {"graph": name, "check": {"original": {"cost_us_per_s": original}, "lean": {"cost_us_per_s": lean, "error_N": error}},
            "steps": [{"what": what, "taken_back": False} for what in steps]}


KEPT = {"budget": 0.05,
        "graphs": [graph("bunny_fine", 300, 100, ()),
                   graph("duck_fine", 100, 50, ("without rotation and torque of tool",)),
                   graph("duck_tapped_fine", 100, 50, ("without rotation and torque of tool", "without friction of tool"))]}


class Promises(unittest.TestCase):
    def broken(self, change):
        found = copy.deepcopy(KEPT)
        change(found["graphs"])
        return lean_results.broken_promises(found)

    def test_three_times_cheaper_keeps_the_promise_and_less_does_not(self):
        self.assertEqual(lean_results.broken_promises(KEPT), [])
        said = self.broken(lambda graphs: graphs[0]["check"]["lean"].update(cost_us_per_s=101))
        self.assertEqual(said, ["bunny_fine: expected 3 times cheaper at least, found 2.97"])

    def test_an_error_over_the_budget_and_a_duck_that_keeps_its_friction_do_not(self):
        said = self.broken(lambda graphs: graphs[0]["check"]["lean"].update(error_N=0.051))
        self.assertIn("within 0.05 N, found 0.051 N", said[0])
        said = self.broken(lambda graphs: graphs[2]["steps"].pop())
        self.assertIn("duck_tapped_fine: expected the step \"without friction of tool\"", said[0])
        said = self.broken(lambda graphs: graphs[1]["steps"][0].update(taken_back=True))
        self.assertIn("duck_fine: expected the step", said[0])

    def test_the_script_fails_then_and_leaves_the_page_alone(self):
        found = copy.deepcopy(KEPT)
        found["graphs"][0]["check"]["lean"]["cost_us_per_s"] = 200
        before = PAGE.read_bytes()
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "found.json"
            file.write_text(json.dumps(found))
            done = subprocess.run(["/usr/bin/python3", SCRIPT, "--from", file], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("found 1.50", done.stderr)
        self.assertEqual(PAGE.read_bytes(), before)


if __name__ == "__main__":
    unittest.main()
