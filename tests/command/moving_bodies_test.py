"""Graphs in which several bodies move: they run end to end, and what they lack is told before they run."""
import unittest

import h5py
import numpy

from harness import GRAPHS, CommandTest, needs_meshes, needs_hdf5, tactor

BLOCK = GRAPHS / "block_pushed/scene.yaml"
EDGE = "  - dynamics.bodies -> collision.bodies\n"
FREE = f"""
extends: {BLOCK}
scene: {{gravity: [0, 0, 0], bodies: {{table: ~}}}}
nodes:
  collision: {{cost: {{base: 0.1 ms, per_contact: 0 ms, jitter: 0 %}}}}
record: [dynamics.state, dynamics.bodies]
"""


@needs_meshes
class SeveralBodies(CommandTest):
    def recorded(self, text):
        graph = self.write("graph.yaml", text)
        summary = self.run_graph(graph)
        self.assertEqual((summary["dynamics_damped_steps"], summary["dynamics_stopped_steps"]), (0, 0), summary)
        with h5py.File(self.folder / "out" / "recording.h5") as file:
            return {name: file[f"streams/{name}/data"][...] for name in file["streams"]}

    @needs_hdf5
    def test_a_pushed_block_rests_where_friction_and_springs_put_it(self):
        bodies = self.recorded(f"extends: {BLOCK}\nrecord: [dynamics.bodies]\n")["dynamics.bodies"]
        self.assertTrue((bodies["count"] == 2).all())
        block = numpy.hstack([bodies["X_WB"]["p"][:, 1], bodies["X_WB"]["R"][:, 1]])
        twist = numpy.hstack([bodies["V_WB"]["v"][:, 1], bodies["V_WB"]["w"][:, 1]])
        self.assertLess(abs(block[0, :3] - [0, 0, 0.015]).max(), 1e-4)
        # Pushed until the ball is 8 mm short of the middle, less what sliding friction stretches the coupling (500 N/m)
        # and presses the contact (two surfaces of 4 N/mm) by. A contact of speed below 0.1 mm/s creeps on.
        friction = 0.3 * 0.2 * 9.81
        self.assertAlmostEqual(block[-1, 0], 0.030 - friction / 500 - friction / 2000, delta=2e-4)
        self.assertLess(abs(block[-1, 1]), 1e-4)
        self.assertAlmostEqual(block[-1, 2], 0.015, delta=2e-4)
        self.assertLess(abs(block[-1, 4:]).max(), 2e-3)
        self.assertLess(abs(twist[-1]).max(), 1e-6)
        # The ball is back where the hand is, lower by its weight over the coupling's stiffness.
        self.assertLess(abs(bodies["X_WB"]["p"][-1, 0] - [-0.05, 0, 0.015 - 0.05 * 9.81 / 500]).max(), 1e-4)

    @needs_hdf5
    def test_in_free_space_the_block_gets_the_momentum_that_the_tool_gives(self):
        recorded = self.recorded(FREE)
        bodies, state = recorded["dynamics.bodies"], recorded["dynamics.state"]
        numpy.testing.assert_array_equal(numpy.diff(bodies["valid_ns"]), 1_000_000)
        given = -0.001 * numpy.cumsum(state["contact_force"], axis=0)
        taken = 0.2 * bodies["V_WB"]["v"][:, 1]
        self.assertGreater(taken[-1, 0], 0.001)
        self.assertLess(abs(taken - taken[0] - given + given[0]).max(), 1e-12)

    def refused(self, text, *words):
        """By `check` and by `run`, with the place in the file that says it."""
        graph = self.write("graph.yaml", text)
        for verb in ("check", "run"):
            result = tactor(verb, graph, environment=self.environment)
            self.assertEqual(result.returncode, 2, result.stderr)
            for word in words:
                self.assertIn(word, result.stderr)

    def test_collision_that_is_not_told_where_several_bodies_are_is_refused(self):
        text = BLOCK.read_text()
        self.assertIn(EDGE, text)
        self.refused(text.replace(EDGE, ""), "graph.yaml:",
                     "nodes.collision: expected an edge into collision.bodies (BodyStates), because 2 bodies move: tool, "
                     "block, found none; outputs of that type: dynamics.bodies")
        # One body is told of by the state, or by nothing.
        one = text.replace(EDGE, "").replace("motion: rigid\n      mass: 200 g", "motion: static")
        self.assertEqual(tactor("check", self.write("one.yaml", one), environment=self.environment).returncode, 0)

    def test_a_massless_coupling_for_bodies_of_mass_is_refused(self):
        self.refused(f"extends: {BLOCK}\nnodes: {{coupling: {{type: coupling.static}}}}\n",
                     "block_pushed/scene.yaml:", "edge coupling.parameters -> dynamics.coupling: dynamics (dynamics.rigid) does not take the massless parameters of "
                     "coupling (coupling.static)", "use dynamics.quasistatic")
        graph = self.write("balance.yaml", f"extends: {GRAPHS / 'peg_in_hole/scene.yaml'}\nnodes:\n"
                                           "  coupling: {type: coupling.static}\n  dynamics: {type: dynamics.quasistatic}\n")
        self.assertEqual(tactor("check", graph, environment=self.environment).returncode, 0)


if __name__ == "__main__":
    unittest.main()
