"""What the steps of a run took, recorded as files that a graph reads as costs."""
import os
import pathlib
import unittest

from harness import GRAPHS, CommandTest, needs_live, tactor


def durations(file):
    """The times in a trace, in s, without its head."""
    return [float(line) for line in file.read_text().splitlines() if not line.startswith("#")]


class RecordCosts(CommandTest):
    def setUp(self):
        super().setUp()
        self.graph = self.write("wall.yaml", f"extends: {GRAPHS / 'wall/off.yaml'}\nduration: 1 s\n")
        self.costs = self.folder / "costs"

    def test_each_node_outside_of_the_realtime_lane_gets_a_file_with_a_line_a_step(self):
        summary = self.run_graph(self.graph, "--record-costs", self.costs)
        for node, cost in summary["cost_us"].items():
            file = self.costs / f"{node}.csv"
            if node == "device":
                self.assertFalse(file.exists(), "the device is in the real-time lane")
                continue
            times = durations(file)
            self.assertEqual(len(times), cost["steps"], node)
            self.assertAlmostEqual(sum(times), cost["total_s"], delta=1e-6 * len(times), msg=node)
        head = (self.costs / "dynamics.csv").read_text().splitlines()[:3]
        self.assertIn("dynamics.", head[0])
        self.assertIn("wall", head[1])
        self.assertIn(f"{os.cpu_count()} cores", head[2])

    def test_a_graph_that_reads_the_trace_takes_these_costs_step_by_step(self):
        self.run_graph(self.graph, "--record-costs", self.costs, out="first")
        # By these costs, the only ones, a step ends when it took so long: results come as fast as the trace says.
        replay = self.write("replay.yaml", f"extends: {self.graph}\nnodes:\n"
                                           f"  collision: {{cost: none}}\n  dynamics: {{cost: {{trace: {self.costs}/slow.csv}}}}\n")
        times = durations(self.costs / "dynamics.csv")
        # As long as a millisecond and more, so that the device's samples every millisecond are what physics waits for.
        (self.costs / "slow.csv").write_text("".join(f"{10 * (1 + k % 3)}e-3\n" for k in range(len(times))))
        steps = self.run_graph(replay, out="slow")["cost_us"]["dynamics"]["steps"]
        # 10, 20 and 30 ms in turn, 50 results a second.
        self.assertAlmostEqual(steps, 50, delta=2)
        as_recorded = self.write("as_recorded.yaml", f"extends: {self.graph}\nnodes:\n"
                                                     f"  collision: {{cost: none}}\n  dynamics: {{cost: {{trace: {self.costs}/dynamics.csv}}}}\n")
        steps = self.run_graph(as_recorded, out="as_recorded")["cost_us"]["dynamics"]["steps"]
        # Steps of microseconds: every sample of the device gets its own.
        self.assertGreater(steps, 900)

    def test_a_name_that_is_taken_is_refused_before_anything_runs(self):
        self.costs.mkdir()
        (self.costs / "mine.csv").write_text("1\n")
        for name in (self.costs, self.costs / "mine.csv"):
            result = tactor("run", self.graph, "--out", self.folder / "out", "--record-costs", name)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn("expected a folder that does not exist yet", result.stderr)
        self.assertEqual((self.costs / "mine.csv").read_text(), "1\n")
        self.assertFalse((self.folder / "out/summary.json").exists())

    def test_a_folder_that_cannot_be_made_is_refused(self):
        (self.folder / "file").write_text("")
        result = tactor("run", self.graph, "--out", self.folder / "out", "--record-costs", self.folder / "file/costs")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("cannot make this folder", result.stderr)

    def test_a_run_that_is_refused_leaves_no_folder(self):
        result = tactor("run", self.graph, "--out", self.folder / "out", "--record-costs", self.costs,
                        "--reference", self.folder / "missing.h5")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertFalse(self.costs.exists())

    @needs_live
    def test_live_each_step_in_the_pool_is_recorded_and_an_imposed_cost_is_refused(self):
        live = self.write("live.yaml", f"extends: {self.graph}\nclock: real\n")
        summary = self.run_graph(live, "--record-costs", self.costs, out="live")
        times = durations(self.costs / "dynamics.csv")
        # The ramp-down is not judged, so that a few more steps are recorded than are counted.
        self.assertGreaterEqual(len(times), summary["cost_us"]["dynamics"]["steps"])
        self.assertGreater(min(times), 0)
        result = tactor("run", live, "--set", "live.impose_cost=true", "--out", self.folder / "imposed",
                        "--record-costs", self.folder / "imposed_costs")
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("live.impose_cost", result.stderr)
        self.assertFalse(pathlib.Path(self.folder / "imposed_costs").exists())


if __name__ == "__main__":
    unittest.main()
