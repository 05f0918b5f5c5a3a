"""Words of the command line: verbs, options and values are refused with what was expected, what was found and the nearest name."""
import json
import unittest

from harness import GRAPHS, CommandTest, graph_verbs, needs_meshes, tactor

DUCK = GRAPHS / "duck/off.yaml"


class Refused(CommandTest):
    def assert_refused(self, *arguments, says, **options):
        result = tactor(*arguments, environment=self.environment, cwd=self.folder, **options)
        self.assertEqual(result.returncode, 2, f"{arguments}: {result.stdout}{result.stderr}")
        for text in says:
            self.assertIn(text, result.stderr)
        return result.stderr


class Values(Refused):
    def test_a_duration_has_a_unit_as_in_a_graph(self):
        graph = self.judged_small_graph()
        for text, seconds in (("300 ms", 0.3), ("0.2s", 0.2), ("0.25", 0.25)):
            with self.subTest(text=text):
                self.assertAlmostEqual(self.run_graph(graph, "--duration", text, out=text)["duration_s"], seconds)

    def test_of_what_is_laid_over_a_graph_the_later_wins(self):
        graph = self.judged_small_graph()
        over = self.write("over.yaml", "seed: 5\nduration: 0.4 s\nnodes: {device: {force_max: 5 N}}\n")
        for arguments, duration, seed in ((("--seed", "7", "--set", "seed=3"), 0.5, 3),
                                          (("--set", "seed=3", "--seed", "7"), 0.5, 7),
                                          (("--seed", "1", "--seed", "2"), 0.5, 2),
                                          (("--over", over, "--duration", "200 ms", "--seed", "7"), 0.2, 7),
                                          (("--duration", "200 ms", "--seed", "7", "--over", over), 0.4, 5),
                                          (("--set", "duration=0.1 s", "--duration", "0.3 s"), 0.3, 1)):
            with self.subTest(arguments=arguments):
                summary = self.run_graph(graph, *arguments)
                self.assertAlmostEqual(summary["duration_s"], duration)
                self.assertEqual(summary["seed"], seed)
        for arguments, force in ((("--set", "device.force_max=3", "--over", over), 5),
                                 (("--over", over, "--set", "device.force_max=3"), 3)):
            self.run_graph(graph, *arguments)
            self.assertIn(f"force_max: {force}\n", (self.folder / "out/graph.yaml").read_text())

    def test_a_study_and_a_comparison_choose_their_seeds(self):
        graph = self.judged_small_graph()
        study = self.write("study.yaml", f"graphs: [{graph}]\n")
        for verb, file in (("compare", graph), ("study", study)):
            self.assert_refused(verb, file, "--set", "seed=3", says=["--set seed=3: expected --first-seed and --seeds"])
            self.assertFalse((self.folder / "out").exists())

    def test_a_wrong_number_is_told_with_the_option_and_what_was_expected(self):
        whole = "expected a whole number from"
        for verb, option, text, expected in (
                ("run", "--seed", "-1", f"{whole} 0 to 18446744073709551615"), ("run", "--seed", "1e3", f"{whole} 0"),
                ("run", "--duration", "-1 s", "expected a time (s) above 0"), ("run", "--duration", "3 kg", "expected a time (s)"),
                ("compare", "--seeds", "0", f"{whole} 1 to 10000"), ("compare", "--first-seed", "-2", f"{whole} 0"),
                ("compare", "--jobs", "two", f"{whole} 1 to 1024"), ("compare", "--repeats", "1.5", f"{whole} 1 to 100"),
                ("study", "--seeds", "10001", f"{whole} 1 to 10000"), ("study", "--first-seed", "x", f"{whole} 0"),
                ("study", "--jobs", "0", f"{whole} 1 to 1024"), ("study", "--repeats", "0", f"{whole} 1 to 100"),
                ("explain", "--repeats", "101", f"{whole} 1 to 100"), ("explain", "--seed", "1.5", f"{whole} 0"),
                ("lean", "--budget", "3 mm", "expected a force (N)"), ("lean", "--budget", "nan", "expected a force (N)"),
                ("lean", "--torque-budget", "-1 N m", "expected a torque (N m) of at least 0"),
                ("lean", "--seeds", "101", f"{whole} 1 to 100"), ("lean", "--repeats", "0x2", f"{whole} 1 to 100"),
                ("check", "--duration", "", "expected a time (s)"), ("graph", "--duration", "~", "expected a time (s)")):
            with self.subTest(verb=verb, option=option, text=text):
                error = self.assert_refused(verb, DUCK, option, text, says=[f"{option}: {expected}", "found "])
                self.assertEqual(len(error.splitlines()), 1, error)
                self.assertLess(len(error), 200)

    def test_numbers_of_the_machine_and_the_device_have_units_too(self):
        self.assert_refused("doctor", "--seconds", "3 h", says=["--seconds: expected a time (s) from 0.1 to 3600, found 3 h"])
        self.assert_refused("device", "test", DUCK, "--force", "6 N", says=["--force: expected a force (N) from 0 to 5, found 6 N"])
        self.assert_refused("device", "test", DUCK, "--seconds", "1 m", says=["--seconds: expected a time (s), found 1 m"])
        self.run_ok("doctor", "--json", "--seconds", "100 ms")


class FormerNames(Refused):
    """Graphs of an earlier release."""

    OLD = f"""# remove nothing
extends: {GRAPHS / 'duck/refit.yaml'}
nodes:
  refit: {{remove: none}}   # as printed
edges: [coupling.law -> dynamics.law]
"""

    @needs_meshes
    def test_a_former_name_is_refused_with_its_successor(self):
        graph = self.write("old.yaml", self.OLD)
        self.assert_refused("check", graph, says=[
            f"old.yaml:4:11: nodes.refit.remove is called detrend now; tactor migrate {graph} rewrites it",
            "old.yaml:5:9: edges", "dynamics.law is called coupling now"])
        said = self.assert_refused("check", DUCK.parent / "refit.yaml", "--set", "refit.remove=none",
                                   says=["nodes.refit.remove is called detrend now"])
        self.assertNotIn("migrate", said)

    @needs_meshes
    def test_migrate_rewrites_a_file_where_it_lies(self):
        graph = self.write("old.yaml", self.OLD)
        graph.chmod(0o640)
        said = self.run_ok("migrate", graph).stdout
        self.assertIn(f"{graph}:4: remove -> detrend\n", said)
        self.assertEqual(graph.read_text(), self.OLD.replace("{remove:", "{detrend:").replace(
            "coupling.law -> dynamics.law", "coupling.parameters -> dynamics.coupling").replace("\nextends", "\nformat: 2\nextends"))
        self.assertEqual(graph.stat().st_mode & 0o777, 0o640)
        self.run_ok("check", graph)
        self.assertIn("nothing to change", self.run_ok("migrate", graph).stdout)

    def test_bad_input_leaves_all_files_as_they_were(self):
        good, broken = self.write("good.yaml", "nodes: {}\n"), self.write("broken.yaml", "nodes: [\n")
        self.assert_refused("migrate", good, broken, says=["broken.yaml:1:1: not valid YAML"])
        self.assert_refused("migrate", good, self.folder / "none.yaml", says=["none.yaml: there is no such file"])
        self.assertEqual(good.read_text(), "nodes: {}\n")
        self.assertEqual(sorted(p.name for p in self.folder.glob("*.yaml*")), ["broken.yaml", "good.yaml"])

    def test_a_format_of_another_release_is_refused(self):
        graph = self.write("later.yaml", "format: 3\nduration: 1 s\nnodes: {}\n")
        self.assert_refused("check", graph, says=["later.yaml:1:9: format: expected 2, found 3"])
        study = self.write("study.yaml", f"format: two\ngraphs: [{DUCK}]\n")
        self.assert_refused("study", study, says=["study.yaml:1:9: format: expected 2, found two"])


class Names(Refused):
    def test_a_verb_that_does_not_exist_names_the_nearest(self):
        self.assert_refused("chek", DUCK, says=["found chek", 'did you mean "check"?', "run, compare, study"])
        self.assert_refused("device", "tset", DUCK, says=["found tset", 'did you mean "test"?'])

    def test_a_parameter_of_which_the_first_word_was_typed_is_named(self):
        self.assert_refused("check", DUCK, "--set", "coupling.k=3", says=["nodes.coupling.k: expected a parameter", 'did you mean "k_0"?'])

    def test_a_method_that_is_no_graph_of_the_scene_is_said_to_go_over_it(self):
        self.assert_refused("run", "wall/local", says=["wall/local: expected a graph file", "local is a method", "wall/scene --over local"])
        self.assertNotIn("is a method", self.assert_refused("run", "wall/lcoal", says=[]))

    def test_an_option_that_does_not_exist_names_the_nearest(self):
        self.assert_refused("run", DUCK, "--duratoin", "3", says=["found --duratoin", 'did you mean "--duration"?'])
        self.assert_refused("check", DUCK, "--explian", says=['did you mean "--explain"?'])

    @needs_meshes
    def test_a_method_that_does_not_exist_lists_those_that_do(self):
        for over in (GRAPHS / "methods/kalmann.yaml", "kalmann.yaml", "kalmann"):
            with self.subTest(over=over):
                self.assert_refused("check", GRAPHS / "duck/scene.yaml", "--over", over,
                                    says=[f"{over}: expected a graph file that exists; looked for ", "burg.yaml, ", 'did you mean "kalman.yaml"?'])
        study = self.write("study.yaml", f"graphs: [{GRAPHS / 'duck/scene.yaml'}]\nmethods: [{GRAPHS / 'methods/kalmann.yaml'}]\n")
        self.assert_refused("study", study, says=["study.yaml:2:", "burg.yaml, ", 'did you mean "kalman.yaml"?'])

    def test_a_graph_that_does_not_exist_names_the_nearest(self):
        small = self.small_graph()
        for verb, options in graph_verbs():
            self.assert_refused(*verb, self.folder / "smal.yaml", *options, says=["smal.yaml: expected a graph file that exists; looked for ", f'did you mean "{small.name}"?'])
        over = self.write("over.yaml", "extends: smal.yaml\n")
        self.assert_refused("check", over, says=["over.yaml:1:10", 'did you mean "small.yaml"?'])

    def test_a_bad_name_of_a_shipped_graph_lists_where_it_was_looked_for(self):
        self.environment["TACTOR_GRAPH_PATH"] = f"/nowhere:{self.folder}"
        error = self.assert_refused("check", "duck/refti", says=['did you mean "refit.yaml"?', "/duck holds 1_fixed.yaml, "])
        self.assertTrue(error.startswith(f"duck/refti: expected a graph file that exists; looked for {self.folder}/duck/refti, "
                                         f"/nowhere/duck/refti.yaml, {self.folder}/duck/refti.yaml, "), error)
        study = self.assert_refused("study", "method", says=['did you mean "methods.yaml"?'])
        self.assertTrue(study.startswith("method: expected a study file that exists; looked for "), study)

    @needs_meshes
    def test_shipped_graphs_and_methods_are_found_by_their_names(self):
        said = self.run_ok("check", "--explain", "duck/scene", "--over", "kalman", cwd=self.folder).stdout
        self.assertIn("prediction.kalman", said)
        # Those of the user come first.
        self.write("mine.yaml", "extends: duck/scene\ntitle: mine\n")
        self.environment["TACTOR_GRAPH_PATH"] = str(self.folder)
        self.assertIn("mine: mine", self.run_ok("check", "--explain", "mine", cwd="/").stdout)

    def test_what_is_laid_over_a_graph_stands_in_its_name_its_title_and_its_folder(self):
        self.write("scene.yaml", "extends: wall/scene\ntitle: a ball on a wall\nduration: 0.3 s\n")
        self.write("mine.yaml", "nodes: {prediction: {type: prediction.kalman}}\n")
        self.write("named.yaml", "title: my own\nnodes: {prediction: {type: prediction.kalman}}\n")
        base = self.folder.name  # the graph is a scene, which has its folder's name
        for overs, name, title in ((("mine",), f"{base}_mine", "a ball on a wall, here with mine"), (("named",), f"{base}_named", "my own"),
                                   (("mine", "kalman"), f"{base}_mine_kalman", "a Kalman filter of the force and its rate, gone along until the next, here with mine"),
                                   ((), base, "a ball on a wall")):
            with self.subTest(overs=overs):
                options = [word for over in overs for word in ("--over", over)]
                said = self.run_ok("run", "scene.yaml", *options, cwd=self.folder).stdout
                self.assertTrue(said.startswith(f"\n{name}: {title} (seed "), said)
                summary = json.loads((self.folder / "out" / name / "summary.json").read_text())
                self.assertEqual(summary["graph"], name)
                self.assertIn(f"<h1>{name}</h1>", (self.folder / "out" / name / "report.html").read_text().replace("<wbr>", ""))

    def test_a_method_beside_a_study_is_found_by_its_stem(self):
        self.write("mine.yaml", "nodes: {prediction: {type: prediction.kalman}}\n")
        study = self.write("study.yaml", "graphs: [wall/scene]\nmethods: [hold, mine]\nseeds: 1\nduration: 0.5 s\njudge: whole\n")
        self.run_ok("study", study, "--out", self.folder / "out", cwd="/")
        rows = (self.folder / "out/study.csv").read_text().splitlines()[1:]
        self.assertEqual([row.split(",")[1] for row in rows], ["hold", "mine"])

    def test_a_missing_node_library_names_the_path_that_it_is_looked_for_in(self):
        graph = self.write("own.yaml", "duration: 1 s\nnodes: {gain: {type: own.gain}}\n")
        self.environment["TACTOR_NODE_PATH"] = ""
        self.assert_refused("check", graph, says=["libtactor_own.so was not found in", "TACTOR_NODE_PATH, which is not set"])
        self.environment["TACTOR_NODE_PATH"] = str(self.folder)
        self.assert_refused("check", graph, says=[str(self.folder), f"TACTOR_NODE_PATH, which is {self.folder}"])
        self.assert_refused("nodes", "own.gain", says=["TACTOR_NODE_PATH"])


class Taken(Refused):
    def test_a_null_takes_the_points_out_so_that_a_file_can_stand_in_their_place(self):
        csv = self.write("path.csv", "t_s,x_m,y_m,z_m\n0,0,0,0\n1,0,0,0.01\n")
        self.run_ok("check", self.judged_small_graph(), "--set", f"trajectory.file={csv}", "--set", "trajectory.points=~")

    def test_a_null_that_takes_out_nothing_is_refused(self):
        graph = self.judged_small_graph()
        self.assert_refused("check", graph, "--set", "device.encoder_step=~", says=["found nothing"])


if __name__ == "__main__":
    unittest.main()
