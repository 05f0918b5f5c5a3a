"""Shipped graphs: their format, their scenes and methods for a while, their rates."""
import math
import unittest

import yaml

from harness import GRAPHS, CachedTest, few_tetrahedra, graph_name, graphs_with_clock, needs_meshes, tactor


@needs_meshes
class ShippedGraphs(CachedTest):
    def test_every_file_says_its_format_and_none_has_former_names(self):
        files = sorted(GRAPHS.glob("*/*.yaml"))
        self.assertEqual([file for file in files if yaml.safe_load(file.read_text()).get("format") != 2], [])
        copies = [self.write(f"{i}.yaml", file.read_text()) for i, file in enumerate(files)]
        said = self.run_ok("migrate", *copies).stdout.splitlines()
        self.assertEqual([line for line in said if not line.endswith("nothing to change")], [])

    def test_every_method_runs_over_a_scene(self):
        methods = sorted((GRAPHS / "methods").glob("*.yaml"))
        self.assertGreater(len(methods), 10)
        for method in methods:
            with self.subTest(method=method.name):
                summary = self.run_graph(GRAPHS / "wall/scene.yaml", "--over", method, "--duration", "1.2")
                self.assertGreater(summary["contacts"]["max"], 0)
                self.assertTrue(math.isfinite(summary["delivered"]["force"]["rms_error_N"]))

    def test_the_scene_of_every_folder_runs(self):
        scenes = [graph for graph in graphs_with_clock(clock="virtual") if graph.stem == "scene"]
        self.assertGreater(len(scenes), 10)
        for graph in scenes:
            with self.subTest(graph=graph_name(graph)):
                summary = self.run_graph(graph, "--duration", "0.6", *few_tetrahedra(graph))
                self.assertTrue(math.isfinite(summary["delivered"]["force"]["rms_error_N"]))
                self.assertEqual(summary["drops"], 0)

    def test_live_graphs_say_their_clock_lanes_and_settings(self):
        graphs = list(graphs_with_clock(clock="real"))
        self.assertGreaterEqual(len(graphs), 2)
        for graph in graphs:
            with self.subTest(graph=graph_name(graph)):
                text = self.run_ok("check", "--explain", graph).stdout
                self.assertIn("clock real", text)
                self.assertIn("a missing privilege: warn", text)
                self.assertRegex(text, r"node +type +steps +cost +lane")

    def test_one_rate_drives_the_whole_haptic_loop(self):
        for graph, follows in (("duck/blend.yaml", "interpolation"), ("bunny/local.yaml", "rollout")):
            for setting in ("rate=4 kHz", "device.rate=4000"):
                with self.subTest(graph=graph, setting=setting):
                    said = self.run_ok("check", "--explain", GRAPHS / graph, "--set", setting).stdout
                    self.assertIn("haptic loop at 4000 Hz", said)
                    self.assertNotIn("at 1000 Hz", said)
                    summary = self.run_graph(GRAPHS / graph, "--duration", "0.3", "--set", setting)
                    for node in ("trajectory", "device"):
                        self.assertEqual(summary["cost_us"][node]["steps"], 1200, node)
                    # It steps on what arrives too.
                    self.assertAlmostEqual(summary["cost_us"][follows]["steps"], 1225, delta=25)
        self.assertIn("haptic loop at 1000 Hz", self.run_ok("check", "--explain", GRAPHS / "duck/blend.yaml").stdout)

    def test_two_rates_of_the_haptic_loop_are_refused(self):
        graph = self.write("two.yaml", f"""extends: {GRAPHS}/duck/blend.yaml
nodes:
  device: {{rate: 4 kHz}}
  interpolation: {{rate: 1 kHz}}
""")
        result = tactor("run", graph, environment=self.environment, cwd=self.folder)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertEqual(result.stderr.strip(), f"{graph}:4:25: nodes.interpolation.rate: expected 4 kHz as in nodes.device.rate "
                         f"({graph}:3:18), found 1 kHz; all nodes of the haptic loop step at one rate: give it once, "
                         "as the graph's rate, and take it out of the nodes")
        self.assertFalse((self.folder / "out").exists())

    def test_a_field_of_forces_is_refused_where_the_tool_rotates_or_the_spring_is_another(self):
        def refused(verb, graph, setting, *words):
            result = tactor(verb, GRAPHS / graph, "--set", setting, environment=self.environment, cwd=self.folder)
            self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
            for word in words:
                self.assertIn(word, result.stderr)

        for graph, name in (("duck/forcegrid.yaml", "forcefield.grid"), ("duck/rbf.yaml", "forcefield.rbf")):
            for verb in ("check", "run"):
                with self.subTest(graph=graph, verb=verb):
                    refused(verb, graph, "scene.bodies.tool.motion=rigid", f"methods/{graph[5:]}:4:", f"node interpolation: {name}: ",
                            "the tool 'tool' rotates", "use a prediction.* and an interpolation.* in its place")
        refused("run", "duck/rbf.yaml", "interpolation.k_t=500", "interpolation", "this one has 353.553391 N/m; set its k_t")


if __name__ == "__main__":
    unittest.main()
