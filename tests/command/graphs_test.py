"""Every shipped graph is checked, and run for a while."""
import json
import math
import re
import unittest

import yaml

from harness import GRAPHS, CachedTest, graph_files, graph_name, graphs_with_clock, needs_meshes, tactor


@needs_meshes
class ShippedGraphs(CachedTest):
    def test_every_graph_checks(self):
        graphs = graph_files()
        self.assertGreater(len(graphs), 20)
        self.run_ok("check", *graphs)

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

    def test_every_graph_runs(self):
        for graph in graphs_with_clock(clock="virtual"):
            with self.subTest(graph=graph_name(graph)):
                # Past the settling time of the metrics, so that every metric is there.
                few = () if graph.parent.name != "bunny_soft" else ("--set", "scene.bodies.bunny.tetrahedra=500")
                summary = self.run_graph(graph, "--duration", "0.6", *few)
                if "delivered" not in summary:  # a refit was warm just before the end, which left nothing to judge
                    self.assertGreater(summary["warm_from_s"] + 0.2, 0.6)  # 0.2 s: until the metrics have settled
                    summary = self.run_graph(graph, "--duration", "1.2", *few)
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


# What a verb may refuse although `run` takes the graph, and the words that say why.
REFUSALS = {
    # The trials here are shorter than any window.
    "lean": "found a device in closed loop|no node reports the error|no error can be told|is not warm after",
}


@needs_meshes
class EveryVerb(CachedTest):
    """What one verb takes the others take, and none crashes. Cheap verbs take every file, dear ones graphs that have every
    type of node between them."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.files = sorted(file for file in GRAPHS.glob("**/*.yaml") if file.parent.name not in ("studies", "textures", "costs"))
        cls.checked = {file: cls.tell("check", file) for file in cls.files}
        cls.taken = [file for file in cls.files if cls.checked[file].returncode == 0]
        cls.drawn = {file: cls.tell("graph", file) for file in cls.files}
        cls.types = {file: set(re.findall(r'<br/>([a-z_]+\.[a-z_]+)"\]', cls.drawn[file].stdout)) for file in cls.taken}

    @classmethod
    def tell(cls, *arguments):
        return tactor(*arguments, environment={"TACTOR_CACHE": cls.cache})

    def covering(self):
        """A few of the graphs, which have every type of node that any of them has."""
        left = set().union(*self.types.values())
        while left:
            best = max(self.types, key=lambda file: (len(self.types[file] & left), -len(self.types[file]), str(file)))
            left -= self.types[best]
            yield best

    def takes(self, verb, graph, *arguments):
        """Whether it takes the graph, which it may refuse with a reason and must not crash on; the reason."""
        done = self.tell(verb, graph, *arguments)
        self.assertIn(done.returncode, (0, 2), f"{verb} {graph} ended with {done.returncode}:\n{done.stdout}\n{done.stderr}")
        return done.returncode == 0, done.stderr

    def test_check_and_graph_take_the_same_files_and_refuse_the_others_by_their_place(self):
        self.assertGreater(len(self.files), 180)
        self.assertGreater(len(self.taken), 90)
        self.assertEqual(len(self.files), len(set(self.files)))
        for file in self.files:
            with self.subTest(graph=str(file.relative_to(GRAPHS))):
                checked, drawn = self.checked[file], self.drawn[file]
                self.assertIn(checked.returncode, (0, 2), checked.stderr)
                self.assertEqual(drawn.returncode, checked.returncode, drawn.stderr)
                if checked.returncode == 2:
                    self.assertIn(file.name, checked.stderr)

    def test_the_dear_verbs_take_graphs_that_have_every_type_of_node(self):
        graphs = list(self.covering())
        self.assertGreater(len(graphs), 10)
        few = ("--set", "scene.bodies.bunny.tetrahedra=500")
        for graph in graphs:
            soft = few if graph.parent.name == "bunny_soft" else ()
            short = ("--duration", "30 ms", "--set", "clock=virtual", *soft)
            with self.subTest(graph=str(graph.relative_to(GRAPHS))):
                again = self.write("again.yaml", f"extends: {graph}\n")
                taken, why = self.takes("run", graph, *short, "--out", self.folder / "run", "--overwrite")
                others = {
                    "explain": ("--repeats", "1"),
                    "lean": ("--budget", "1000", "--seeds", "1", "--repeats", "1", "--out", self.folder / "lean.yaml", "--overwrite"),
                    "compare": (again, "--seeds", "1", "--judge", "whole", "--out", self.folder / "compare", "--overwrite"),
                }
                for verb, more in others.items():
                    also, refused = self.takes(verb, graph, *more, *short)
                    if taken and not also:
                        self.assertRegex(refused, REFUSALS.get(verb, "$^"), verb)
                if not taken:
                    self.assertRegex(why, "expected|drives hardware")

    def test_explain_follows_a_run_whose_nodes_set_parameters_of_others(self):
        """A trial of the simulated experiment: the first setting comes after 6 s, the next after 12 s."""
        found = json.loads(self.run_ok("explain", GRAPHS / "experiments/simulated.yaml", "--duration", "13 s", "--repeats", "1", "--json").stdout)
        nodes = {node["node"]: node for node in found["nodes"]}
        self.assertGreater(nodes["protocol"]["steps"], 2000)
        self.assertTrue(all(node["steps"] > 0 for node in nodes.values()), nodes)


if __name__ == "__main__":
    unittest.main()
