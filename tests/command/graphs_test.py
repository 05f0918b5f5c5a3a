"""Every shipped graph is checked, and run for a while."""
import math
import unittest

from harness import GRAPHS, CommandTest, needs_collision


@needs_collision
class ShippedGraphs(CommandTest):
    def test_every_graph_checks(self):
        graphs = sorted(GRAPHS.rglob("*.yaml"))
        self.assertGreater(len(graphs), 20)
        self.run_ok("check", *graphs)

    def test_every_graph_runs(self):
        for graph in sorted(GRAPHS.glob("*.yaml")):
            with self.subTest(graph=graph.name):
                # Past the settling time of the metrics, so that every figure is there.
                summary = self.run_graph(graph, "--duration", "0.4")
                self.assertTrue(math.isfinite(summary["delivered"]["force"]["rms_error_N"]))
                self.assertEqual(summary["drops"], 0)


if __name__ == "__main__":
    unittest.main()
