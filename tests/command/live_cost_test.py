"""Costs that a live graph imposes: physics at the declared rate, told by check and seen in the results."""
import unittest

from harness import GRAPHS, CommandTest, graph_file, needs_meshes, needs_hdf5, needs_live

try:
    import h5py
    import numpy
except ImportError:
    h5py = None

WALL = f"""extends: {GRAPHS / 'wall/refit.yaml'}
clock: real
duration: 2 s
"""
IMPOSED = "live: {impose_cost: true}\n"


@needs_live
@needs_meshes
class ImposedCost(CommandTest):
    def test_physics_has_its_declared_rate_where_the_graph_imposes_the_cost_and_its_own_where_not(self):
        free = self.run_graph(self.write("free.yaml", WALL), out="free")
        held = self.run_graph(self.write("held.yaml", WALL + IMPOSED), out="held")
        # The cost is 6.7 ms without contact, 11.7 ms in contact, with a jitter of 10 %, and never less than 6.7 ms.
        self.assertLessEqual(held["physics"]["rate_hz_max"], 1e3 / 6.7)
        self.assertLessEqual(held["physics"]["steps"], 2e3 / 6.7 + 1)
        self.assertGreater(held["physics"]["steps"], 20)
        self.assertGreater(free["physics"]["steps"], held["physics"]["steps"])
        # The device goes on as ever, and the gap is there to be seen: its forces are as old as physics' results.
        self.assertGreater(held["device"]["ticks"], 1000)
        edge = "interpolation.segment -> device.segment"
        self.assertGreater(held["edges"][edge]["age_us"]["p50"], free["edges"][edge]["age_us"]["p50"])

    @needs_hdf5
    @unittest.skipIf(h5py is None, "h5py is not installed")
    def test_results_become_visible_no_sooner_than_the_declared_cost_after_their_step_began(self):
        graph = self.write("held.yaml", WALL + IMPOSED + "nodes: {collision: {cost: {constant: 30 ms}}, dynamics: {cost: "
                                                         "{constant: 5 ms}}}\nrecord: [collision.contacts, dynamics.state]\n")
        self.run_graph(graph, out="held")
        with h5py.File(self.folder / "held/recording.h5") as file:
            steps = file["streams/steps/data"][...]
        names = h5py.check_enum_dtype(steps.dtype["node"])
        for node, declared in (("collision", 30_000_000), ("dynamics", 5_000_000)):
            of_node = steps[steps["node"] == names[node]]
            self.assertGreater(len(of_node), 10)
            self.assertGreaterEqual((of_node["produced_ns"] - of_node["valid_ns"]).min(), declared)
        with h5py.File(self.folder / "held/recording.h5") as file:
            contacts = file["streams/collision.contacts/data"]["produced_ns"]
            states = file["streams/dynamics.state/data"]["produced_ns"]
        self.assertGreater(len(contacts), 10)
        # They share a thread, so that a round takes both.
        self.assertGreaterEqual(numpy.diff(contacts).min(), 35_000_000)
        self.assertGreaterEqual((states[:len(contacts)] - contacts[:len(states)]).min(), 5_000_000)

    def test_check_says_what_a_cost_does_when_the_clock_is_real(self):
        free = self.run_ok("check", "--explain", self.write("free.yaml", WALL))
        self.assertIn("have no effect", free.stdout)
        held = self.run_ok("check", "--explain", self.write("held.yaml", WALL + IMPOSED))
        self.assertIn("a step takes at least its declared cost", held.stdout)
        self.assertNotIn("no effect", held.stdout + held.stderr)

    def test_check_says_that_a_cost_in_the_realtime_lane_has_no_effect(self):
        graph = self.write("held.yaml", WALL + IMPOSED + "nodes: {device: {cost: {constant: 1 ms}}}\n")
        told = self.run_ok("check", graph).stderr
        self.assertRegex(told, r"held\.yaml:5:\d+: node device: its cost has no effect in lane realtime")
        summary = self.run_graph(graph)
        self.assertGreater(summary["device"]["ticks"], 1500)
        pooled = self.write("pooled.yaml", WALL + IMPOSED + "nodes: {device: {cost: {constant: 1 ms}, lane: pool}}\n")
        self.assertNotIn("no effect", self.run_ok("check", pooled).stderr)

    def test_the_shipped_live_graphs_impose_the_costs_that_make_the_rate_of_the_paper(self):
        for name in ("duck_live", "bunny_live", "bunny_local_live"):
            self.assertIn("a step takes at least its declared cost",
                          self.run_ok("check", "--explain", graph_file(name)).stdout, name)


if __name__ == "__main__":
    unittest.main()
