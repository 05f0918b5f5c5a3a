"""What a graph or a result does not say by itself: `check` refuses what `run` does, and doubtful results are told as such."""
import json
import re
import unittest

from harness import EDGES_OF_A_SMALL_GRAPH, GRAPHS, METRICS_OF_A_SMALL_GRAPH, CommandTest, needs_meshes, tactor

SMALL = EDGES_OF_A_SMALL_GRAPH.replace("nodes:\n", "nodes:\n  metrics: {type: sink.metrics}\n") + METRICS_OF_A_SMALL_GRAPH
POINTS = "    points: [{t: 0 s, x: 0 mm}, {t: 0.5 s, x: 10 mm}]\n"
WALL = GRAPHS / "wall/scene.yaml"


def plain(text):
    """Without the breaks that fit a text to the terminal."""
    return " ".join(text.split())


class Checked(CommandTest):
    def refused_alike(self, graph, *words, options=()):
        """`check` and `run` refuse the graph with exit code 2 and the same line, which holds these words."""
        graph = self.write("graph.yaml", graph) if isinstance(graph, str) else graph
        checked = tactor("check", graph, *options, environment=self.environment)
        ran = tactor("run", graph, *options, "--out", self.folder / "out", environment=self.environment)
        self.assertEqual((checked.returncode, ran.returncode), (2, 2), (checked, ran))
        for word in words:
            self.assertIn(word, checked.stderr)
        line = re.sub(r"^tactor: ", "", ran.stderr.strip())
        self.assertIn(line, checked.stderr)
        self.assertRegex(line, r": node \w+: ")

    def test_the_small_graph_is_good(self):
        self.run_ok("check", self.write("graph.yaml", SMALL))

    def test_check_refuses_way_points_whose_times_do_not_increase(self):
        self.refused_alike(SMALL.replace("{t: 0.5 s, x", "{t: 0 s, x"), "the times of way-points must increase")

    def test_check_refuses_points_and_a_file_together(self):
        self.write("path.csv", "t_s,x_mm\n0,0\n1,1\n")
        self.refused_alike(SMALL.replace(POINTS, POINTS + "    file: path.csv\n"), "exactly one of points and file is expected, found both")
        self.refused_alike(SMALL.replace(POINTS, ""), "exactly one of points and file is expected, found neither")

    def test_check_refuses_columns_that_the_file_lacks(self):
        self.write("force.csv", "t_s,F_N\n0,0\n1,1\n")
        source = "  trajectory:\n    type: source.recording\n    file: force.csv\n    columns: {%s}\n"
        old = "  trajectory:\n    type: source.trajectory\n" + POINTS
        for columns, words in (("time: t_s, position.x: x_mm", "has no column 'x_mm'"),
                               ("time: t_s, what: F_N", "what"),
                               ("time: t_s, position.x: F_N", "comes out in")):
            with self.subTest(columns=columns):
                self.refused_alike(SMALL.replace(old, source % columns), words)

    def test_check_refuses_parameters_of_the_gate_that_cannot_be(self):
        self.refused_alike(SMALL.replace("{type: device.simulated}", "{type: device.simulated, force_slew: 1 N/s}"),
                           "force_slew: expected at least", "raise force_slew or ramp_down_time")

    @needs_meshes
    def test_check_refuses_a_motion_that_the_dynamics_do_not_know(self):
        self.refused_alike(WALL, "dynamics.translation", "has motion: rigid",
                           options=("--set", "scene.bodies.tool.motion=rigid"))

    def test_check_names_the_faults_of_all_nodes_at_once(self):
        graph = self.write("graph.yaml", SMALL.replace("{t: 0.5 s, x", "{t: 0 s, x")
                           .replace("{type: device.simulated}", "{type: device.simulated, force_slew: 1 N/s}"))
        errors = tactor("check", graph).stderr
        self.assertIn("way-points must increase", errors)
        self.assertIn("force_slew: expected at least", errors)

    def test_a_study_is_refused_before_anything_runs(self):
        self.write("graph.yaml", SMALL)
        study = self.write("study.yaml", "graphs: [graph.yaml]\nvary: {device.force_slew: [2000 N/s, 1 N/s]}\nseeds: 1\n")
        result = tactor("study", study, "--out", self.folder / "out", environment=self.environment)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("force_slew: expected at least", result.stderr)
        self.assertFalse((self.folder / "out" / "study.sqlite").exists())


@needs_meshes
class Touching(CommandTest):
    """A wall under a ball that hangs 15 mm above it until 0.4 s, then goes down and presses."""

    def test_a_run_without_contact_says_so_first(self):
        result = self.run_ok("run", WALL, "--duration", "0.4", "--out", self.folder / "out")
        self.assertIn("warning: the hand does not lead the tool 'tool' to any body: it keeps ", result.stderr)
        head = plain(result.stdout).split("verdict")[0]
        self.assertRegex(head, r"warning nothing touched: none of \d+ contact queries found a contact")
        summary = json.loads((self.folder / "out" / "summary.json").read_text())
        self.assertEqual(summary["collision"]["touching_queries"], 0)
        self.assertGreater(summary["collision"]["queries"], 10)
        self.assertIn("nothing touched", (self.folder / "out" / "report.html").read_text())

    def test_a_run_with_contact_says_nothing_of_it(self):
        result = self.run_ok("run", WALL, "--duration", "1.2", "--out", self.folder / "out")
        self.assertNotIn("touch:", result.stderr)
        self.assertNotIn("nothing touched", plain(result.stdout))
        summary = json.loads((self.folder / "out" / "summary.json").read_text())
        self.assertGreater(summary["collision"]["touching_queries"], 5)

    def test_check_tells_a_path_that_touches_nothing_and_one_that_leaves_the_scene(self):
        def notes(*options):
            return self.run_ok("check", WALL, *options).stderr

        self.assertEqual(notes(), "")
        self.assertIn("it keeps 11 mm away", notes("--duration", "0.4"))  # 15 mm, less 4 mm of radius and the tremor
        points = "[{t: 0 s, z: 15 mm}, {t: 5 s, z: 2 m}]"
        self.assertIn("the hand's path leaves the scene: it goes", notes("--set", f"trajectory.points={points}"))
        self.assertIn("are the units of the path and of the bodies right?", notes("--set", f"trajectory.points={points}"))

    def test_check_tells_a_tool_that_starts_inside_a_body(self):
        text = self.run_ok("check", WALL, "--set", "trajectory.points=[{t: 0 s, z: -3 mm}, {t: 5 s, z: 2 mm}]").stderr
        # The ball's lowest point is 4 mm below its centre; the tremor of 0.05 mm is on top.
        self.assertRegex(text, r"the body 'tool' starts (6\.[89]\d*|7(\.[012]\d*)?) mm inside the body 'wall'")

    def test_a_spacing_that_is_large_for_a_body_is_told(self):
        graph = self.write("graph.yaml", WALL.read_text().replace("sphere: {radius: 4 mm}", "box: {size: [17 mm, 17 mm, 8 mm]}"))
        text = self.run_ok("check", graph, "--set", "collision.spacing=15 mm").stderr
        self.assertIn("body 'tool': warning: a spacing of contact samples of 15 mm is large for a body that is 17 mm long", text)
        self.assertEqual(self.run_ok("check", graph, "--set", "collision.spacing=2 mm").stderr, "")

    def test_shipped_graphs_raise_no_doubt(self):
        for graph in ("duck/scene.yaml", "bunny/scene.yaml", "peg_in_hole/scene.yaml", "block_pushed/scene.yaml", "wall/closed_loop.yaml", "duck/rbf.yaml"):
            with self.subTest(graph=graph):
                self.assertNotIn("warning: ", self.run_ok("check", GRAPHS / graph).stderr)

    def compare(self, *arguments):
        result = self.run_ok("compare", *arguments, "--seeds", "2", "--out", self.folder / "out")
        return result, json.loads((self.folder / "out" / "compare.json").read_text()), (self.folder / "out" / "report.html").read_text()

    def test_a_comparison_in_which_nothing_touches_tests_nothing_and_begins_with_that(self):
        result, found, page = self.compare(WALL, GRAPHS / "wall/refit.yaml", "--duration", "0.4", "--judge", "whole")
        says = "nothing touches in any run: every force is that of a tool in free space, so no difference is tested"
        self.assertTrue(plain(result.stdout).startswith("WARNING: " + says), result.stdout)
        self.assertIn("wall_refit: not tested, nothing touches", plain(result.stdout))
        self.assertNotIn("ANOVA F", result.stdout)
        self.assertEqual(found["warnings"], [says])
        against = found["graphs"][1]["against"]
        self.assertNotIn("one_step_anova", against)
        self.assertIsNone(against["one_step_rms"])
        self.assertIsNone(against["delivered_rms"])
        self.assertLess(page.index(says), page.index("<details>"))

    def test_a_comparison_of_different_scenes_says_in_what_they_differ(self):
        other = self.write("other.yaml", f"extends: {WALL}\nscene: {{bodies: {{wall: {{material: {{stiffness: 1 N/mm}}}}}}}}\n")
        result, found, page = self.compare(WALL, other, "--duration", "1")
        says = "other: its scene differs from that of wall: it has another material of wall; so more than the method differs"
        self.assertIn("WARNING: " + says, plain(result.stdout))
        self.assertEqual(found["warnings"], [says])
        self.assertIn(says, page)
        self.assertIn("not ranked: another scene or coupling", page)
        self.assertEqual(found["graphs"][1]["unlike"], says.removeprefix("other: "))
        self.assertIsNone(found["graphs"][1]["against"]["delivered_rms"])

    def test_a_graph_with_another_coupling_is_neither_ranked_nor_tested(self):
        """A softer spring has smaller forces, and smaller errors for that alone."""
        soft = self.write("soft.yaml", f"extends: {WALL}\nnodes: {{coupling: {{k_0: 50 N/m}}}}\n")
        result, found, page = self.compare(WALL, soft, "--duration", "1")
        self.assertIn("soft: its coupling differs from that of wall in k_0; so more than the method differs", plain(result.stdout))
        self.assertIn("soft: not tested, more than the method differs", plain(result.stdout))
        self.assertEqual(page.count("not ranked: another scene or coupling"), 1)

    def test_methods_of_a_scene_are_graphs_beside_it_or_laid_over_it(self):
        words = ("--seeds", "1", "--duration", "1", "--judge", "whole", "--overwrite")
        errors = {}
        for name, graphs in (("by name", ("wall", "--methods", "off,refit,linear")), ("one by one", (GRAPHS / "wall/off.yaml", GRAPHS / "wall/refit.yaml"))):
            self.run_ok("compare", *graphs, *words, "--out", self.folder / "named")
            if name == "by name":
                self.assertIn("<h1>wall: off, refit, linear</h1>", (self.folder / "named/report.html").read_text())
            rows = json.loads((self.folder / "named/compare.json").read_text())["graphs"]
            errors[name] = {(row["graph"], row.get("configuration", "")): row["metrics"]["delivered.force.rms_error_N"]["mean"] for row in rows}
        linear = errors["by name"].pop(("wall", "linear"))
        self.assertEqual(errors["by name"], errors["one by one"])
        alone = self.run_graph(GRAPHS / "wall/scene.yaml", "--over", "linear", "--duration", "1", "--seed", "1", out="alone")
        self.assertEqual(alone["delivered"]["force"]["rms_error_N"], linear)
        for words, why in ((("wall", "--methods", "off,kalmann"), "kalmann: expected a graph file that exists"),
                           (("wall/off", "wall/refit", "--methods", "off"), "--methods: expected one graph, found 2"),
                           (("wal", "--methods", "off"), "wal: expected a graph file that exists")):
            refused = tactor("compare", *words, "--out", self.folder / "refused", environment=self.environment)
            self.assertEqual(refused.returncode, 2, refused.stdout + refused.stderr)
            self.assertIn(why, refused.stderr)

    def test_a_study_in_which_nothing_touches_begins_with_that(self):
        study = self.write("study.yaml", f"graphs: [{WALL}]\nmethods: [{GRAPHS}/methods/hold.yaml, {GRAPHS}/methods/burg.yaml]\n"
                           "seeds: 2\nduration: 0.4 s\njudge: whole\n")
        result = self.run_ok("study", study, "--out", self.folder / "out")
        self.assertTrue(plain(result.stdout).startswith("WARNING: nothing touches in any run"), result.stdout)
        found = json.loads((self.folder / "out" / "study.json").read_text())
        self.assertEqual(len(found["warnings"]), 1)
        self.assertIsNone(found["rows"][1]["against"]["delivered_rms"])
        self.assertIn("nothing touches in any run", (self.folder / "out" / "report.html").read_text())


@needs_meshes
class Words(CommandTest):
    def test_the_stability_of_a_run_is_told_in_words(self):
        result = self.run_ok("run", WALL, "--duration", "1", "--out", self.folder / "out")
        self.assertIn("verdict done, 1 s; stable", plain(result.stdout))
        self.assertEqual(json.loads((self.folder / "out" / "summary.json").read_text())["stability"]["verdict_name"], "stable")

    def test_lean_tries_nothing_that_nobody_reads_and_calls_no_saving_a_result(self):
        # A ball and a plane: no mesh, no samples apart, and no prediction.local that would read `local`.
        result = self.run_ok("lean", WALL, "--budget", "10", "--duration", "0.6", "--repeats", "1", "--out", self.folder / "lean.yaml")
        tried = {trial["what"] for trial in json.loads((self.folder / "lean.json").read_text())["trials"]}
        self.assertTrue(any(what.startswith("dynamics.substep") for what in tried), tried)
        for parameter in ("local_contacts", "anchors", "resolution", "spacing"):
            self.assertFalse([what for what in tried if what.startswith("collision." + parameter)], parameter)
        self.assertNotIn("1.0 times cheaper", result.stdout)


if __name__ == "__main__":
    unittest.main()
