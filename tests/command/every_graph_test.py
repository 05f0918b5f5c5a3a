"""Every shipped graph is run for a while, and reports what it says that it will."""
import math
import re
import unittest

from harness import CachedTest, few_tetrahedra, graph_name, graphs_with_clock, needs_meshes


@needs_meshes
class EveryGraph(CachedTest):
    def test_every_graph_runs(self):
        for graph in graphs_with_clock(clock="virtual"):
            with self.subTest(graph=graph_name(graph)):
                # Past the settling time of the metrics, so that every metric is there.
                summary = self.run_graph(graph, "--duration", "0.6", *few_tetrahedra(graph))
                if "delivered" not in summary:  # a refit was warm just before the end, which left nothing to judge
                    self.assertGreater(summary["warm_from_s"] + 0.2, 0.6)  # 0.2 s: until the metrics have settled
                    summary = self.run_graph(graph, "--duration", "1.2", *few_tetrahedra(graph))
                self.assertTrue(math.isfinite(summary["delivered"]["force"]["rms_error_N"]))
                self.assertEqual(summary["drops"], 0)
                self.assert_has_metrics(summary, graph)

    def assert_has_metrics(self, summary, graph):
        """Of the metrics told before the run, those are in the summary that no event in it decides. (Of others than
        these that a run reports, the run itself fails.)"""
        said = self.run_ok("check", "--metrics", graph).stdout.partition("\nmetrics\n")[2].partition("\n\n")[0]
        told = [name for name, what in re.findall(r"(?m)^  (\S+) \(.*\)\n      (.*)$", said) if "missing where" not in what]
        self.assertGreater(len(told), 5)
        for name in told:
            at = summary
            for part in name.split("."):
                self.assertIn(part, at, name)
                at = at[part]


if __name__ == "__main__":
    unittest.main()
