"""A reference run steps physics of the user's own at its own rate, and judges nothing where it cannot."""
import json
import math
import os
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "command"))
from harness import GRAPHS, IS_SANITIZED, CommandTest, tactor  # noqa: E402

if IS_SANITIZED:
    print("a Python that is not sanitized leaks by their measure")
    sys.exit(77)

FREQUENCY = 4  # Hz
# Each file is a member of the family: how a rate comes to physics.
NODES = '''import math

import tactor


class Wave(tactor.Node):
    """Physics: a force that is known at any time."""

    role = "dynamics"
    device = tactor.Input("DeviceState", doc="the handle")
    force = tactor.Output("Wrench", doc="sin(2 pi f t)")
    rate = tactor.Rate(RATE)

    def step(self, step):
        self.send(step)

    def send(self, step):
        value = self.force.zeros()
        value["force"][2] = math.sin(2 * math.pi * 4 * step.now)
        self.force.send(step.now_ns, value)


class Clock(Wave):
    """Steps others."""

    role = "other"


class Triggered(tactor.Node):
    """The same physics, stepped by a clock."""

    role = "dynamics"
    clock = tactor.Input("Wrench", trigger=True, doc="when to step")
    force = tactor.Output("Wrench", doc="sin(2 pi f t)")
    step = Wave.send


class Decimating(tactor.Node):
    """The same physics, which steps by a clock of its own."""

    role = "dynamics"
    device = tactor.Input("DeviceState", trigger=True, doc="the handle")
    force = tactor.Output("Wrench", doc="sin(2 pi f t)")
    often = tactor.Parameter(60.0, unit="Hz", min=1, doc="steps a second")

    def start(self, step):
        self.due = 0.0

    def step(self, step):
        if step.now >= self.due:
            self.due += 1 / self.often
            Wave.send(self, step)


class Slow(Wave):
    """A second field of force."""

    rate = tactor.Rate(60, SLOW)


class Sum(tactor.Node):
    """Adds two fields; steps on either."""

    role = "coupling"
    fast = tactor.Input("Wrench", trigger=True, doc="one")
    slow = tactor.Input("Wrench", trigger=True, doc="the other")
    force = tactor.Output("Wrench", doc="the sum")

    def step(self, step):
        value = self.force.zeros()
        for part in (self.fast.latest(), self.slow.latest()):
            if part is not None:
                value["force"] += part["force"]
        self.force.send(step.now_ns, value)
'''
GRAPH = """format: 2
clock: virtual
duration: 1 s
scene: {bodies: {}}
nodes:
  trajectory: {type: source.trajectory, points: [{t: 0 s, x: 0 mm}, {t: 1 s, x: 10 mm}]}
  device: {type: device.simulated}
  prediction: {type: prediction.hold}
  interpolation: {type: interpolation.none}
  metrics: {type: sink.metrics}
%s
edges:
  - trajectory.target -> device.target
  - PHYSICS.force -> prediction.force
  - prediction.forecast -> interpolation.forecast
  - interpolation.segment -> device.segment
  - device.commanded -> metrics.commanded
  - PHYSICS.force -> metrics.force
  - prediction.forecast -> metrics.forecast
%s
"""
ONE = ("  wave: {python: 'wave.py:Wave'}", "  - device.state -> wave.device", "wave")
CHAIN = ("  ticker: {python: 'wave.py:Clock'}\n  wave: {python: 'wave.py:Triggered'}",
         "  - device.state -> ticker.device\n  - ticker.force -> wave.clock", "wave")
TWO = ("  wave: {python: 'wave.py:Wave'}\n  slow: {python: 'wave.py:Slow'}\n  sum: {python: 'wave.py:Sum'}",
       "  - device.state -> wave.device\n  - device.state -> slow.device\n  - wave.force -> sum.fast\n  - slow.force -> sum.slow", "sum")
DECIMATING = ("  wave: {python: 'wave.py:Decimating'}", "  - device.state -> wave.device", "wave")
AS_GRAPH = {"rate": ("  wave: {python: 'wave.py:Wave', rate: 100 Hz}", *ONE[1:]), "often": ("  wave: {python: 'wave.py:Decimating', often: 30 Hz}", *DECIMATING[1:])}
# name: (nodes, the class's Rate, the second one's, how often the truth is known)
JUDGED = {
    "declared by the class": (ONE, "60", "", 10000),
    "given by the graph": (AS_GRAPH["rate"], "30", "", 10000),
    "without a default": (AS_GRAPH["rate"], "", "", 10000),
    "a chain of triggers": (CHAIN, "60", "", 10000),
    "two rates": (TWO, "200", "", 10000),
    "a bound": (ONE, "60, max=600", "", 600),
    "faster than most": (ONE, "4000", "", 10000),
}
# name: (nodes, the class's Rate, the second one's, what the reason names)
NOT_JUDGED = {
    "fixed": (ONE, "60, fixed=True", "", ("node wave", "60 Hz")),
    "bounded at its rate": (ONE, "60, max=60", "", ("node wave", "60 Hz")),
    "fixed and given by the graph": (AS_GRAPH["rate"], "30, fixed=True", "", ("node wave", "100 Hz")),
    "a chain from a fixed clock": (CHAIN, "60, fixed=True", "", ("node ticker", "60 Hz")),
    "two, one of them fixed": (TWO, "200", "fixed=True", ("node slow", "60 Hz")),
    "a clock of its own": (DECIMATING, "60", "", ("wave.force", "60 Hz")),
    "a clock of its own by a parameter": (AS_GRAPH["often"], "60", "", ("wave.force", "30 Hz")),
    "as fast as the reference": (ONE, "20000", "", ("wave.force", "20000 Hz")),
}
# Besides the hold: the line through the last two results, which goes on.
LINE = "{prediction: {type: prediction.linear}, interpolation: {type: interpolation.linear}}"
METHODS = "methods: [{hold: {}}, {line: {nodes: %s}}]\n" % LINE
TWO_METHODS = f"{METHODS}seeds: 2\nduration: 1 s\njudge: whole\nmetrics: [delivered.force.rms_error_N, delivered.force.delay_ms]\n"


class OwnPhysics(CommandTest):
    def graph(self, nodes, rate, slow, name="own.yaml"):
        parts, edges, physics = nodes
        self.write("wave.py", NODES.replace("RATE", rate).replace("SLOW", slow))
        return self.write(name, (GRAPH % (parts, edges)).replace("PHYSICS", physics))

    def nobody_is_best(self, html):
        self.assertNotIn('aria-label="best"', html)
        for word in ("nearest", "smoothest", "nearest in time", "not undercut\">run", "(least)"):
            self.assertNotIn(word, html)

    def test_the_truth_is_as_fine_as_the_reference_whatever_gives_the_rate(self):
        for name, (nodes, rate, slow, hz) in JUDGED.items():
            with self.subTest(name):
                summary = self.run_graph(self.graph(nodes, rate, slow))
                self.assertLess(abs(summary["reference"]["rate_hz"] / hz - 1), 0.01)
                self.assertEqual(summary["reference_run"]["rate_hz"], summary["reference"]["rate_hz"])
                self.assertNotIn("reference_too_coarse", summary)
                self.assertTrue(math.isfinite(summary["delivered"]["force"]["rms_error_N"]))

    def test_nothing_is_judged_where_it_is_no_finer_and_the_reason_names_node_and_rate(self):
        for name, (nodes, rate, slow, named) in NOT_JUDGED.items():
            with self.subTest(name):
                graph = self.graph(nodes, rate, slow)
                shown = self.run_ok("run", graph, "--out", self.folder / "out", "--overwrite").stdout
                summary = json.loads((self.folder / "out/summary.json").read_text())
                why = summary["reference_too_coarse"]
                self.assertIn("no finer than the run", why)
                for part in named:
                    if not part.endswith("30 Hz"):  # of a clock of its own, that meets the device's ticks
                        self.assertRegex(why, part.replace("60 Hz", r"(60|59\.\d|58\.\d) Hz"))
                self.assertIn(why, shown)
                self.assertIn(why, summary["remarks"][0])
                self.assertNotIn("rms_error_N", summary["delivered"]["force"])
                self.assertNotIn("error  ", shown)

    def test_a_recorded_force_is_its_own_truth_and_judges_nothing(self):
        rows = "".join(f"{k / 60},{math.sin(2 * math.pi * FREQUENCY * k / 60)}\n" for k in range(61))
        self.write("force.csv", "t,F\n" + rows)
        nodes = ("  player: {type: source.recording, file: force.csv, columns: {time: 't [s]', force.x: 'F [N]'}}", "", "player")
        summary = self.run_graph(self.graph(nodes, "60", ""))
        self.assertRegex(summary["reference_too_coarse"], r"player\.force comes at 6\d(\.\d)? Hz")

    def test_the_truth_is_the_force_that_the_physics_has_at_any_time(self):
        """Between results 1/10000 s apart a sine is a straight line to (2 pi f / 10000)^2 / 8."""
        try:
            import numpy
            import tactor as package
        except ImportError:
            self.skipTest("the package is not built")
        graph = self.graph(*JUDGED["declared by the class"][:3])
        os.environ["TACTOR_CACHE"] = self.environment["TACTOR_CACHE"]
        result = package.run(str(graph))
        self.assertIsNone(result.not_judged)
        curve = result.series["reference.norm"]
        late = curve[curve["time"] > 0.01]
        expected = abs(numpy.sin(2 * math.pi * FREQUENCY * late["time"]))
        self.assertGreater(len(late), 500)
        self.assertLess(numpy.max(abs(late["value"] - expected)), 2e-3)  # a tick of the reference late, at most
        coarse = package.run(str(self.graph(*NOT_JUDGED["fixed"][:3])))
        self.assertIn("60 Hz", coarse.not_judged)
        self.assertNotIn("delivered.force.rms_error_N", coarse.metrics)

    def test_a_study_has_the_errors_of_one_whose_reference_is_told_the_rate(self):
        graph = self.graph(*JUDGED["declared by the class"][:3])
        found = []
        for name, reference in (("own", ""), ("told", "reference: {set: {wave.rate: 10 kHz}}\n")):
            study = self.write(f"study_{name}.yaml", f"graphs: [{graph.name}]\n{TWO_METHODS}{reference}")
            self.run_ok("study", study, "--out", self.folder / name)
            found.append((self.folder / name / "study.csv").read_bytes())
        self.assertEqual(*found)
        self.assertGreater(len(found[0].splitlines()), 4)

    def test_six_seeds_of_a_graph_without_chance_are_said_to_be_identical_and_not_tested(self):
        graph = self.graph(*JUDGED["declared by the class"][:3])
        study = self.write("study.yaml", f"graphs: [{graph.name}]\n" + TWO_METHODS.replace("seeds: 2", "seeds: 6"))
        shown = self.run_ok("study", study, "--out", self.folder / "study").stdout
        self.assertIn("the runs of all seeds are identical in each row", shown)
        self.assertRegex(shown, r"delivered [+-]0\.\d{4} N, the 6 seeds are identical: not tested")
        for word in ("d_z = ", " p = ", "ANOVA"):
            self.assertNotIn(word, shown)
        against = json.loads((self.folder / "study/study.json").read_text())["rows"][1]["against"]
        self.assertNotIn("one_step_anova", against)
        for name in ("low_N", "high_N", "effect_size", "p_wilcoxon"):
            self.assertIsNone(against["delivered_rms"][name], name)
        self.assertEqual(against["delivered_rms"]["identical"], "seeds")
        self.assertIsNone(against["ratio"]["delivered_rms"]["low"])

    def test_no_report_ranks_what_has_no_truth_and_each_says_why(self):
        graph = self.graph(*NOT_JUDGED["fixed"][:3])
        why = "node wave steps at 60 Hz in both"
        study = self.write("study.yaml", f"graphs: [{graph.name}]\n{TWO_METHODS}")
        shown = self.run_ok("study", study, "--out", self.folder / "study").stdout
        self.assertIn(f"nothing is ranked: the reference run is no finer than the run: {why}", shown)
        told = json.loads((self.folder / "study/study.json").read_text())
        self.assertIn(why, told["warnings"][0])
        for row in told["rows"]:
            self.assertIn(why, row["reference_too_coarse"])
            self.assertIsNone(row["against"]["delivered_rms"])
            self.assertIsNone(row["against"]["ratio"]["delivered_rms"])
            self.assertNotIn("delivered.force.rms_error_N", row["metrics"])
        self.assertIsNotNone(told["rows"][1]["against"]["one_step_rms"])
        report = (self.folder / "study/report.html").read_text()
        self.assertIn(why, report)
        self.nobody_is_best(report)

        front = self.write("front.yaml", f"graphs: [{graph.name}]\n{METHODS}seeds: 1\njudge: whole\n"
                           "timing: {repeats: 1, warm_up: 0}\n"
                           "report: {kind: work_precision, error: delivered.force.rms_d2_N_per_ms2}\n")
        self.run_ok("study", front, "--out", self.folder / "front")
        told = json.loads((self.folder / "front/study.json").read_text())
        points = [point for one in told["work_precision"]["graphs"] for point in one["points"]]
        self.assertEqual(len(points), 2)
        self.assertFalse(any(point[name] for point in points for name in point if name.startswith("front")))

        other = self.write("other.yaml", f"extends: {graph.name}\nnodes: {LINE}\n")
        shown = self.run_ok("compare", graph, other, "--seeds", "2", "--judge", "whole", "--out", self.folder / "compare").stdout
        self.assertIn(why, shown)
        told = json.loads((self.folder / "compare/compare.json").read_text())
        self.assertTrue(all(row["against"]["delivered_rms"] is None for row in told["graphs"]))
        report = (self.folder / "compare/report.html").read_text()
        self.assertIn("No method is ranked.", report)
        self.assertIn(why, report)
        self.nobody_is_best(report)

        refused = tactor("lean", graph, "--budget", "1", "--out", self.folder / "lean.yaml", environment=self.environment)
        self.assertEqual(refused.returncode, 2, refused.stdout + refused.stderr)
        self.assertIn(why, refused.stderr)

    def test_a_row_without_a_truth_is_not_ranked_among_those_that_have_one(self):
        slow = self.graph(*NOT_JUDGED["two, one of them fixed"][:3])
        fine = self.graph(*JUDGED["two rates"][:1], "200", "fixed=True", name="fine.yaml")
        fine.write_text(fine.read_text().replace("  slow: {python: 'wave.py:Slow'}", "  slow: {python: 'wave.py:Wave'}"))
        blend = self.write("blend.yaml", f"extends: {fine.name}\nnodes: {LINE}\n")
        self.run_ok("compare", fine, blend, slow, "--seeds", "2", "--judge", "whole", "--out", self.folder / "compare")
        report = (self.folder / "compare/report.html").read_text()
        self.assertIn("has the least", report)
        self.assertRegex(report, r"Not ranked, because the reference run is no finer[^:]*: node slow steps at 60 Hz[^:]*: [^:]*own")


if __name__ == "__main__":
    unittest.main()
