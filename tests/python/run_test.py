"""Whole runs from Python are those of the command: metrics, files, errors."""
import json
import re
import unittest

import numpy

from package_harness import WALL, PackageTest, command, needs_hdf5, tactor
from recorded import recorded

TIMES = {"wall_s", "cpu_s", "realtime_factor", "peak_memory_MB", "cost_us", "reference_run", "provenance"}


def deterministic(summary):
    return {key: value for key, value in summary.items() if key not in TIMES}

OWN_PREDICTOR = '''import tactor


class Last(tactor.Node):
    """Goes on with the last force."""

    role = "prediction"
    force = tactor.Input("Wrench", trigger=True, queue=64, doc="the physics force")
    forecast = tactor.Output("Forecast", doc="the force, and what is expected of it")

    def step(self, step):
        for sample in self.force.new():
            made = self.forecast.zeros()
            made["current_force"] = sample["force"]
            self.forecast.send(sample["valid_ns"], made)
'''


class Runs(PackageTest):
    def test_metrics_are_those_of_the_command_on_the_same_graph_and_seed(self):
        said = self.run_graph(WALL, "--duration", "2 s", "--seed", "7", "--set", "coupling.k_0=900 N/m")
        result = tactor.run(WALL, set={"coupling.k_0": "900 N/m"}, seed=7, duration="2 s")
        self.assertEqual(deterministic(result.summary), deterministic(said))
        self.assertEqual(result.metrics["delivered.force.rms_error_N"], said["delivered"]["force"]["rms_error_N"])
        self.assertEqual(result.metrics.units["delivered.force.rms_error_N"], "N")
        self.assertEqual(result.metrics.better["delivered.force.rms_error_N"], "lower")
        self.assertEqual(result.verdict, said["stability"]["verdict_name"])
        self.assertEqual(set(result.costs), set(said["cost_us"]))

    @needs_hdf5
    def test_files_have_the_same_bytes_as_those_of_the_command(self):
        graph = self.write("recorded.yaml", f"extends: {WALL}\nduration: 1 s\nrecord: [coupling.force, device.commanded]\n")
        self.run_graph(graph, out="by_command")
        result = tactor.run(graph, out=self.folder / "by_python")
        mine, its = (self.folder / folder for folder in ("by_python", "by_command"))
        self.assertEqual((mine / "graph.yaml").read_bytes(), (its / "graph.yaml").read_bytes())
        self.assertTrue(recorded(mine / "recording.h5") == recorded(its / "recording.h5"))
        self.assertEqual(json.loads((self.folder / "by_python/summary.json").read_text()), result.summary)
        self.assertIn("<html", (self.folder / "by_python/report.html").read_text())
        self.assertEqual(len(result.recording["device.commanded"]), 1000)
        said = self.refused(tactor.InputError, tactor.run, graph, out=self.folder / "by_python")
        self.assertIn("by_python", said)

    def test_a_run_in_which_no_force_came_says_why(self):
        result = tactor.run(WALL, set={"device.force_max": "0 N"}, duration="1 s")
        self.assertEqual(result.verdict, "no_force")
        self.assertEqual(list(result.no_force), ["device"])
        self.assertIn("the largest force is 0 N", result.no_force["device"])
        self.assertIn(result.no_force["device"], result.report)
        self.assertEqual(tactor.run(WALL, duration="2 s").no_force, {})

    def test_numbers_mappings_and_methods_are_laid_over_a_graph_in_order(self):
        base = str(WALL).replace("refit", "scene")
        graph = tactor.load(base, ["kalman", {"nodes": {"coupling": {"k_0": "300 N/m"}}, "seed": 3}], {"coupling.k_0": 500.0})
        self.assertEqual(graph.nodes["prediction"], "prediction.kalman")
        self.assertEqual(graph.seed, 3)
        self.assertIn("k_0: 500", graph.to_yaml())
        self.assertEqual(tactor.load(WALL, duration=0.25).duration, 0.25)
        numpys = tactor.load(WALL, {"scene": {"gravity": numpy.array([0, 0, -1.5])}}, {"coupling.k_0": numpy.float32(250)},
                             seed=numpy.int64(5))
        self.assertIn("gravity: [0, 0, -1.5]", numpys.to_yaml())
        self.assertIn("k_0: 250", numpys.to_yaml())
        self.assertEqual(tactor.load("wall/refit").name, "wall_refit")

    def test_what_a_run_taps_is_what_it_records(self):
        result = tactor.run(WALL, duration="1 s", taps=["device.commanded"], without_reference=True)
        force = result.taps["device.commanded"]
        numpy.testing.assert_array_equal(force["valid_ns"], numpy.arange(1000) * 1_000_000)
        self.assertEqual(force.units["force"], "N")
        self.assertNotIn("delivered.force.rms_error_N", result.metrics)
        said = self.refused(tactor.InputError, tactor.run, WALL, duration="1 s", taps=["device.comanded"])
        self.assertEqual(said, 'the run has no output device.comanded; did you mean "device.commanded"?')

    def test_what_is_tapped_runs_without_a_sink_or_a_recording(self):
        alone = {"record": None, "nodes": {"metrics": None}}
        self.assertIn("nothing would run", self.refused(tactor.InputError, tactor.run, WALL, over=alone, duration="0.2 s"))
        result = tactor.run(WALL, over=alone, duration="0.2 s", taps=["device.commanded", "coupling.force"], out=self.folder / "tapped")
        self.assertEqual(len(result.taps["device.commanded"]), 200)
        self.assertGreater(len(result.taps["coupling.force"]), 5)
        # It is not recorded, and the graph that ran does not say so.
        self.assertFalse((self.folder / "tapped/recording.h5").exists())
        self.assertNotIn("device.commanded", (self.folder / "tapped/graph.yaml").read_text().partition("record:")[2])

    def test_a_tap_that_is_not_there_loses_no_earlier_results(self):
        tactor.run(WALL, duration="0.1 s", out=self.folder / "kept")
        before = (self.folder / "kept/summary.json").read_bytes()
        self.refused(tactor.InputError, tactor.run, WALL, duration="0.2 s", out=self.folder / "kept", overwrite=True, taps=["no.such"])
        self.assertEqual((self.folder / "kept/summary.json").read_bytes(), before)

    def test_curves_have_units(self):
        result = tactor.run(WALL, duration="1 s")
        name, curve = next((name, one) for name, one in result.series.items() if one.units["value"] == "N")
        self.assertEqual(curve.units, {"time": "s", "value": "N"}, name)
        self.assertTrue((numpy.diff(curve["time"]) > 0).all())
        self.assertIn("<html", result.report)
        self.assertIn("device.faults", result.table(100))

    def test_the_curves_are_those_that_the_help_names(self):
        vectors = {f"{name}.{axis}" for name in ("commanded", "reference") for axis in ("x", "y", "z", "norm")}
        others = {"physics.x", "physics.y", "physics.z", "physics_rate", "contacts", "displacement", "one_step_error"}
        result = tactor.run(WALL, duration="1 s")
        self.assertEqual(set(result.series), vectors | others)
        told = type(result).series.__doc__
        for name in vectors | others:
            self.assertIn(name if name in others and "physics." not in name else name.rpartition(".")[0], told)
        # A force that the device was told has a norm, and stands beside the reference's.
        force, reference = result.series["commanded.norm"], result.series["reference.norm"]
        parts = [result.series[f"commanded.{axis}"]["value"] for axis in "xyz"]
        numpy.testing.assert_allclose(force["value"], numpy.sqrt(sum(part**2 for part in parts)), atol=1e-12)
        numpy.testing.assert_array_equal(force["time"], reference["time"])


class Own(PackageTest):
    def test_the_command_sets_a_node_to_a_class_of_a_file(self):
        file = self.write("last.py", OWN_PREDICTOR)
        said = command("check", "--explain", "wall/scene", "--set", f"prediction={{python: {file}:Last}}", environment=self.environment)
        self.assertEqual(said.returncode, 0, said.stderr)
        self.assertIn("Last", said.stdout)


class Errors(PackageTest):
    def check_said(self, graph, *options, **arguments):
        """The command and the package refuse the graph with the same text, but for `--set` and `set`."""
        said = command("check", graph, *options, environment=self.environment)
        self.assertEqual(said.returncode, 2, said.stdout)
        with self.assertRaises(tactor.InputError) as caught:
            tactor.check(graph, **arguments)
        self.assertEqual(str(caught.exception), re.sub(r"^--(set|over) ", r"\1 ", said.stderr.strip(), flags=re.MULTILINE))
        self.assertNotIn("--", str(caught.exception))
        return caught.exception

    def test_all_errors_of_a_file_with_their_places(self):
        graph = self.write("bad.yaml", f"extends: {WALL}\nnodes:\n  device: {{rate: 3 kg}}\n  coupling: {{nope: 1}}\n")
        error = self.check_said(str(graph))
        self.assertEqual([(one.line, one.column) for one in error.diagnostics], [(3, 18), (4, 14)])
        self.assertEqual((error.file, error.line, error.column), (str(graph), 3, 18))
        self.assertIsInstance(error, ValueError)

    def test_values_that_are_laid_over(self):
        self.check_said(WALL, "--set", "seed=-1", set={"seed": -1})
        self.check_said(WALL, "--set", "duration=soon", set={"duration": "soon"})
        self.check_said(WALL, "--set", "coupling.k_0=3 kg", set={"coupling.k_0": "3 kg"})
        self.check_said(WALL, "--over", "no_such_method", over="no_such_method")

    def test_files_that_are_missing_or_bound_to_fail(self):
        self.check_said("no_such_graph")
        self.check_said(str(self.write("list.yaml", "[1, 2]\n")))
        self.check_said(str(self.write("mesh.yaml", f"extends: {WALL}\nscene: {{bodies: {{wall: {{plane: ~, mesh: no.off}}}}}}\n")))

    def test_a_loaded_graph_takes_no_more_over(self):
        graph = tactor.load(WALL)
        self.refused(TypeError, tactor.run, graph, seed=3)
        self.assertIn("follow", self.refused(tactor.InputError, tactor.run, graph, follow=True))

    def test_what_nodes_say_of_their_input_is_a_warning(self):
        graph = self.write("far.yaml", f"extends: {WALL}\nnodes: {{trajectory: {{points: [{{t: 0 s, z: 1 m}}, {{t: 1 s, z: 1.01 m}}]}}}}\n")
        notes = tactor.check(graph)
        self.assertTrue(notes)
        with self.assertWarns(tactor.InputWarning) as caught:
            tactor.run(graph, duration="0.1 s")
        self.assertIn(str(caught.warning), notes)


if __name__ == "__main__":
    unittest.main()
