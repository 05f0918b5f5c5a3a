"""Every shipped graph in real time runs for a while, and tells how late it was."""
import math
import unittest

from harness import CachedTest, check_loop, graph_name, graphs_with_clock, needs_live, needs_meshes


@needs_meshes
@needs_live
class LiveGraphs(CachedTest):
    def assert_rising(self, metrics, *names):
        values = [metrics[name] for name in names]
        self.assertEqual(values, sorted(values))
        self.assertGreaterEqual(values[0], 0)

    def test_every_live_graph_runs_and_tells_its_latencies_ages_and_drops(self):
        for graph in graphs_with_clock(clock="real"):
            with self.subTest(graph=graph_name(graph)):
                summary = self.run_graph(graph, "--duration", "0.8")
                self.assertEqual((summary["clock"], summary["duration_s"]), ("real", 0.8))
                self.assertNotIn("failure", summary)
                self.assertFalse(summary["interrupted"])
                device = summary["device"]
                # The ramp to zero at the end has ticks of its own.
                self.assertGreaterEqual(device["ticks"] + device["missed"], 800)
                self.assert_rising(device["wakeup_us"], "p50", "p99", "p99_9", "p99_99", "max")
                self.assert_rising(device["body_us"], "p50", "p99", "max")
                self.assert_rising(summary["end_to_end_us"], "p50", "p99", "max")
                check_loop(self, device)
                self.assertEqual(summary["record_drops"], 0)
                self.assertEqual(summary["stalled"], 0)
                edges = summary["edges"]
                shown = [name for name in edges if name.endswith(".segment -> device.segment")]
                self.assertEqual(len(shown), 1)
                to_physics = next(name for name in ("device.state -> collision.device", "device.state -> dynamics.device") if name in edges)
                for edge in (*shown, to_physics):
                    self.assert_rising(edges[edge]["age_us"], "p50", "p99", "max")
                for edge in edges.values():
                    self.assertGreaterEqual(edge["drops"], 0)
                self.assertEqual(summary["drops"], sum(edge["drops"] for edge in edges.values()))
                self.assertTrue(math.isfinite(summary["delivered"]["force"]["rms_error_N"]))


if __name__ == "__main__":
    unittest.main()
