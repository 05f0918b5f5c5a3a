"""An error points at the file and line where the value was written that it is about, however late the value is looked at."""
import unittest

from harness import CommandTest, needs_meshes, tactor

GRAPH = """clock: virtual
duration: 1 s
scene:
  bodies:
    wall:
      mesh: good.off
    tool:
      sphere: {radius: 4 mm}
      motion: translation
nodes:
  trajectory:
    type: source.trajectory
    points: [{t: 0 s, x: 0 mm}, {t: 1 s, x: 10 mm}]
  device: {type: device.simulated}
  collision: {type: collision.primitive}
  dynamics: {type: dynamics.translation}
  coupling: {type: coupling.adaptive}
  refit: {type: prediction.refit}
  prediction: {type: prediction.ar}
  metrics: {type: sink.metrics}
edges:
  - trajectory.target -> device.target
  - device.state -> collision.device
  - device.state -> dynamics.device
  - collision.contacts -> dynamics.contacts
  - dynamics.state -> collision.state
  - coupling.parameters -> dynamics.coupling
  - dynamics.state -> coupling.state
  - coupling.force -> refit.force
  - coupling.force -> prediction.force
  - refit.coefficients -> prediction.coefficients
  - prediction.forecast -> metrics.forecast
  - coupling.force -> metrics.force
  - device.commanded -> metrics.commanded
"""
# A tetrahedron of 10 mm, closed and counter-clockwise from outside.
TETRAHEDRON = "OFF\n4 4 0\n0 0 0\n0.01 0 0\n0 0.01 0\n0 0 0.01\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n"


@needs_meshes
class Places(CommandTest):
    def setUp(self):
        super().setUp()
        self.write("good.off", TETRAHEDRON)
        self.write("bad.off", TETRAHEDRON.replace("0.01 0 0", "nonsense 0 0"))
        self.write("huge.off", TETRAHEDRON.replace("0.01", "100"))
        self.base = self.write("base.yaml", GRAPH)

    def line(self, file, text):
        """`file:line:` of the line that holds the text."""
        lines = (self.folder / file).read_text().splitlines()
        return f"{file}:{next(i for i, line in enumerate(lines, 1) if text in line)}:"

    def error(self, graph, *arguments):
        result = tactor("run", graph, *arguments, environment=self.environment, cwd=self.folder)
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        return result.stderr

    def assert_at(self, place, graph, *arguments, says):
        error = self.error(graph, *arguments)
        for text in says:
            self.assertIn(text, error)
        self.assertTrue(error.startswith((place, f"{self.folder}/{place}")), f"expected {place}, found {error}")

    def test_the_graph_is_good(self):
        self.run_ok("check", self.base)

    def test_a_mesh_is_reported_where_the_graph_names_it(self):
        graph = self.write("own.yaml", GRAPH.replace("good.off", "bad.off"))
        self.assert_at(self.line("own.yaml", "mesh:"), graph, says=["body 'wall'", "bad.off:4"])

    def test_a_mesh_of_an_overriding_file_is_reported_there(self):
        over = self.write("over.yaml", "title: over\n\nscene:\n  bodies:\n    wall: {mesh: bad.off}\n")
        self.assert_at("over.yaml:5:18:", self.base, "--over", over, says=["bad.off:4"])

    def test_a_mesh_of_an_extending_file_is_reported_there(self):
        child = self.write("child.yaml", "extends: base.yaml\nscene:\n  bodies:\n    wall:\n      mesh: bad.off\n")
        self.assert_at("child.yaml:5:13:", child, says=["bad.off:4"])

    def test_a_mesh_of_the_command_line_is_reported_there(self):
        said = f"scene.bodies.wall.mesh={self.folder / 'bad.off'}"
        self.assert_at(f"--set {said}:", self.base, "--set", said, says=["bad.off:4"])

    def test_a_value_of_the_command_line_is_not_blamed_for_another_one(self):
        graph = self.write("own.yaml", GRAPH.replace("good.off", "bad.off"))
        self.assert_at(self.line("own.yaml", "mesh:"), graph, "--set", "collision.margin=2 mm", says=["bad.off:4"])

    def test_the_size_of_a_body_is_reported_at_its_scale_or_its_mesh(self):
        over = self.write("over.yaml", "scene:\n  bodies:\n    wall: {mesh: huge.off}\n")
        self.assert_at("over.yaml:3:18:", self.base, "--over", over, says=["write scale: 0.001"])
        over = self.write("over.yaml", "scene:\n  bodies:\n    wall:\n      scale: 1e9\n")
        self.assert_at("over.yaml:4:14:", self.base, "--over", over, says=["a body must be 1 um to 1 km long"])

    def test_way_points_of_a_file_are_reported_where_it_is_named(self):
        self.write("path.csv", "t_s,x_mm\n0,0\n1,1\n1,2\n")
        over = self.write("over.yaml", "nodes:\n  trajectory:\n    points: ~\n    file: path.csv\n")
        self.assert_at("over.yaml:4:11:", self.base, "--over", over, says=["path.csv:4", "must increase"])

    def test_a_recording_and_its_columns_are_reported_where_they_are_named(self):
        self.write("forces.csv", "t_s,F_N\n0,0\n1,1\n2,oops\n")
        replay = self.write("replay.yaml", "duration: 1 s\nnodes:\n  recording:\n    type: source.recording\n    file: forces.csv\n"
                                           "    columns: {time: t_s, force.x: F_N}\n  metrics: {type: sink.metrics}\n"
                                           "edges: [recording.force -> metrics.force, recording.force -> metrics.commanded]\n")
        self.assert_at("replay.yaml:5:11:", replay, says=["forces.csv:4"])
        self.write("forces.csv", "t_s,F_N\n0,0\n1,1\n2,2\n")
        over = self.write("over.yaml", "nodes:\n  recording:\n    columns:\n      force.x: G_N\n")
        self.assert_at("over.yaml:3:5:", replay, "--over", over, says=["G_N"])

    def test_a_parameter_that_a_node_refuses_late_is_reported_where_it_was_written(self):
        over = self.write("over.yaml", "nodes:\n  refit:\n    window: 30\n    order: 20\n")
        self.assert_at("over.yaml:4:12:", self.base, "--over", over, says=["order: expected at most window / 3"])
        said = "refit.order=200"
        self.assert_at(f"--set {said}:", self.base, "--set", said, says=["order"])
        self.assert_at("--set trajectory.tremor_low=30 Hz:", self.base, "--set", "trajectory.tremor_low=30 Hz",
                       says=["tremor_low must not be above tremor_high"])

    def test_the_motion_of_a_body_that_its_dynamics_refuses_is_reported_there(self):
        over = self.write("over.yaml", "scene:\n  bodies:\n    tool:\n      motion: rigid\n")
        self.assert_at("over.yaml:4:15:", self.base, "--over", over, says=["has motion: rigid"])

    def test_a_study_points_at_its_own_value(self):
        study = self.write("study.yaml", "graphs: [base.yaml]\nseeds: 1\nset:\n  scene.bodies.wall.mesh: bad.off\n")
        self.write("graphs.txt", "")
        result = tactor("study", study, "--out", "out", environment=self.environment, cwd=self.folder)
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        self.assertRegex(result.stderr, r"(?m)^(.*/)?study\.yaml:4:")


if __name__ == "__main__":
    unittest.main()
