"""`tactor explain` and `tactor lean` on the shipped graphs: what they tell, what is dropped, and the error by runs of their own."""
import csv
import io
import json
import math
import pathlib
import unittest

from harness import GRAPHS, TACTOR, CachedTest, needs_meshes, needs_hdf5, tactor

SETTLE = 0.2  # s, what sink.metrics leaves out


@needs_meshes
class Explain(CachedTest):
    def explain(self, graph, *arguments):
        return json.loads(self.run_ok("explain", GRAPHS / graph, "--json", *arguments).stdout)

    def test_every_node_has_its_figures_and_the_shares_are_the_whole(self):
        for graph, freedom, duration in (("duck/scene.yaml", 3, 1), ("bunny/scene.yaml", 6, 0.4)):
            with self.subTest(graph=graph):
                found = self.explain(graph, "--duration", duration)
                self.assertEqual(found["scene"]["degrees_of_freedom"], freedom)
                self.assertEqual(found["scene"]["torque"], freedom == 6)
                self.assertAlmostEqual(sum(node["share"] for node in found["nodes"]), 1, places=9)
                nodes = {node["node"]: node for node in found["nodes"]}
                # The median of three runs after one that does not count, with how far they and a fixed computation spread.
                timing, total = found["timing"], found["total_us_per_simulated_s"]
                self.assertEqual((timing["repeats"], timing["warm_up"]), (3, 1))
                self.assertGreater(timing["control_us"], 0)
                self.assertLessEqual(total["least"], total["median"])
                self.assertLessEqual(total["median"], total["most"])
                spread = (total["most"] - total["least"]) / total["median"]
                self.assertEqual(timing["warning"] != "", max(spread, timing["control_spread"]) > 0.1, timing)
                self.assertEqual(set(nodes), {"trajectory", "device", "collision", "dynamics", "coupling", "prediction",
                                              "interpolation", "metrics"})
                self.assertEqual(nodes["device"]["steps"], 1000 * duration)
                for node in nodes.values():
                    self.assertGreater(node["steps"], 0)
                    # A step that takes less than a reading of the clock costs 0, and a spread about 0 is not told.
                    if node["us_per_simulated_s"] > 0:
                        self.assertGreaterEqual(node["spread"], 0)
                    else:
                        self.assertIsNone(node["spread"])
                    self.assertAlmostEqual(node["us_per_step"] * node["steps"],
                                           node["us_per_simulated_s"] * duration, delta=1e-6 * node["us_per_simulated_s"] + 1e-6)

    def test_it_says_whether_a_step_of_physics_fits_a_tick(self):
        physics = self.explain("duck/scene.yaml", "--duration", 0.5)["physics"]
        self.assertEqual(physics["tick_us"], 1000)
        self.assertEqual({node["node"] for node in physics["nodes"]}, {"collision", "dynamics"})
        for key in ("mean_us", "p99_us"):
            self.assertGreater(physics[key], 0)
            self.assertAlmostEqual(physics[key], sum(node[key] for node in physics["nodes"]), delta=1e-9 * physics[key])
        self.assertEqual(physics["fits"], physics["p99_us"] <= 500)
        self.assertEqual(physics["declared"], "collision")
        said = self.run_ok("check", "--explain", GRAPHS / "duck/scene.yaml", "--duration", 0.5).stdout.replace("\n", " ")
        self.assertRegex(" ".join(said.split()), r"A step of physics takes \S+ us on average on this machine \(collision ")
        self.assertIn("The graph declares a cost of collision.", " ".join(said.split()))
        # A tick of 1 us is too short for anything.
        fast = self.explain("duck/scene.yaml", "--duration", 0.01, "--set", "rate=200 kHz", "--repeats", 1)["physics"]
        self.assertEqual(fast["tick_us"], 5)
        self.assertEqual(fast["fits"], fast["p99_us"] <= 2.5)
        # A device is not driven for it.
        said = self.run_ok("check", "--explain", GRAPHS / "duck/falcon.yaml").stdout
        self.assertIn("was not measured: device drives a device", " ".join(said.split()))

    def test_memory_is_told_where_it_is_counted(self):
        nodes = {node["node"]: node for node in self.explain("duck/scene.yaml", "--duration", 0.5)["nodes"]}
        if nodes["collision"]["built_bytes"] is None:
            self.skipTest("this build does not count the heap")
        for node in nodes.values():
            self.assertGreaterEqual(node["peak_bytes"], node["built_bytes"])
        # 13,926 triangles of three indices each, at least.
        self.assertGreater(nodes["collision"]["built_bytes"], 13926 * 3 * 4)

    def test_libraries_are_told_with_the_size_of_their_files(self):
        found = {item["name"]: item["bytes"] for item in self.explain("duck/scene.yaml", "--duration", 0.5)["libraries"] if item["ours"]}
        folder = pathlib.Path(TACTOR).resolve().parent / "nodes"
        if not folder.exists():
            self.skipTest("the command is installed elsewhere")
        for name in ("collision", "dynamics", "sink"):
            file = f"libtactor_{name}.so"
            self.assertEqual(found[file], (folder / file).stat().st_size)
        self.assertNotIn("libtactor_modbus.so", found)

    def test_what_was_left_out_has_a_cost_where_it_can_be_kept_in(self):
        left = {item["what"]: item for item in self.explain("duck/fixed.yaml", "--duration", 0.5)["left_out"]}
        for what in ("node refit", "torque"):
            cost = left[what]["us_per_simulated_s"]
            self.assertLessEqual(cost["least"], cost["median"])
            self.assertLessEqual(cost["median"], cost["most"])
        # Steps take time; of torque the difference of two runs is told, which noise may hide.
        self.assertGreater(left["node refit"]["us_per_simulated_s"]["least"], 0)
        edge = next(item for what, item in left.items() if what.startswith("edge"))
        self.assertIsNone(edge["us_per_simulated_s"])
        said = self.run_ok("explain", GRAPHS / "duck/fixed.yaml", "--duration", 0.5).stdout
        for word in ("3 degrees of freedom", "libtactor_prediction.so", "left out", "not measured", "us a step",
                     "the median of 3 repeats after 1 run that did not count", "spread"):
            self.assertIn(word, said)

    def test_a_bad_graph_is_bad_input(self):
        graph = self.write("bad.yaml", "clock: real\n")
        self.assertEqual(tactor("explain", graph, environment=self.environment).returncode, 2)
        live = tactor("explain", GRAPHS / "duck/scene.yaml", "--set", "clock=real", environment=self.environment)
        self.assertEqual(live.returncode, 2, live.stderr)
        self.assertIn("--set clock=virtual", live.stderr)

    def test_a_single_run_has_no_spread_and_says_so(self):
        found = self.explain("duck/scene.yaml", "--duration", 0.3, "--repeats", 1)
        self.assertEqual((found["timing"]["repeats"], found["timing"]["warm_up"]), (1, 0))
        self.assertEqual({node["spread"] for node in found["nodes"]}, {None})
        self.assertNotEqual(tactor("explain", GRAPHS / "duck/scene.yaml", "--repeats", 0, environment=self.environment).returncode, 0)


# What does not matter begins as coarse as can be and is not tried, which saves time.
FEW = ("--set", "collision={type: collision.primitive, cost: none, margin: 0.2 mm, max_contacts: 8, local_contacts: 4, anchors: 1}",
       "--set", "dynamics.iterations=5", "--set", "dynamics.substep=1 ms")


@needs_meshes
class Lean(CachedTest):
    def lean(self, graph, *arguments):
        """The results as JSON; the lean graph is self.folder / lean.yaml."""
        self.run_ok("lean", GRAPHS / graph, "--repeats", 1, "--overwrite", "--out", self.folder / "lean.yaml", *arguments)
        return json.loads((self.folder / "lean.json").read_text())

    def steps(self, found):
        return [step["what"] for step in found["steps"] if not step["taken_back"]]

    def displayed(self, graph, *arguments):
        """(t, x, y, z) of what a run of its own displays after the start."""
        self.run_graph(graph, "--set", "record=[device.commanded]", *arguments)
        text = self.run_ok("export", self.folder / "out/recording.h5", "device.commanded").stdout
        rows = [[float(cell) for cell in row] for row in list(csv.reader(io.StringIO(text)))[1:]]
        return [(row[0], *row[3:6]) for row in rows if row[0] >= SETTLE]

    def apart(self, a, b):
        """How far two displayed forces are apart, RMS in N."""
        self.assertEqual(len(a), len(b))
        return math.sqrt(sum(math.dist(p[1:], q[1:]) ** 2 for p, q in zip(a, b)) / len(a))

    @needs_hdf5
    def test_a_tapped_duck_needs_neither_rotation_nor_torque_nor_friction(self):
        short = ("--duration", 1.5)
        found = self.lean("duck/tapped_fine.yaml", "--budget", 0.08, *short, *FEW)
        steps = self.steps(found)
        self.assertIn("without rotation and torque of tool", steps)
        self.assertIn("without friction of tool", steps)
        lean = self.folder / "lean.yaml"
        self.assertIn("extends:", lean.read_text())
        self.assertIn("motion: translation", lean.read_text())
        self.assertIn("friction: 0", lean.read_text())
        self.assertIn("without friction of tool", (self.folder / "lean.md").read_text())

        # Both run anew, on the seed of the check: the original errs as it says, the two differ by what the errors allow.
        seed = ("--seed", found["check_seeds"][0], *short)
        original, result = found["check"]["original"]["error_N"], found["check"]["lean"]["error_N"]
        self.assertLessEqual(result, 0.08)
        summary = self.run_graph(GRAPHS / "duck/tapped_fine.yaml", *seed, *FEW)
        self.assertAlmostEqual(summary["delivered"]["force"]["rms_error_N"], original, delta=1e-9)
        self.assertIn("torque", summary["delivered"])
        self.assertNotIn("torque", self.run_graph(lean, *seed)["delivered"])
        a, b = self.displayed(GRAPHS / "duck/tapped_fine.yaml", *seed, *FEW), self.displayed(lean, *seed)
        apart = self.apart(a, b)
        self.assertLessEqual(apart, result + original + 1e-6)
        self.assertGreaterEqual(apart, result - original - 1e-6)

    def test_a_duck_that_is_slid_over_keeps_its_friction(self):
        found = self.lean("duck/fine.yaml", "--budget", 0.04, "--duration", 1.5, *FEW)
        steps = self.steps(found)
        self.assertIn("without rotation and torque of tool", steps)
        self.assertNotIn("without friction of tool", steps)
        friction = [trial for trial in found["trials"] if trial["what"] == "without friction of tool"]
        self.assertEqual([trial["outcome"] for trial in friction], ["over the budget"])
        self.assertGreater(friction[0]["metrics"]["error_N"], 0.05)
        self.assertNotIn("friction", (self.folder / "lean.yaml").read_text().replace("title", ""))
        # A tool without mass is tried, and jumps.
        massless = [trial for trial in found["trials"] if trial["what"].endswith("-> dynamics.quasistatic")]
        self.assertIn("over the budget", [trial["outcome"] for trial in massless])

    @needs_hdf5
    def test_the_bunny_does_a_fifth_of_the_work_within_the_budget(self):
        seconds = ("--duration", 0.7)  # they touch after 0.45 s
        few = [f"--set={name}" for name in ("dynamics.iterations=5", "collision.margin=0.2 mm", "collision.max_contacts=8",
                                            "collision.local_contacts=4", "collision.anchors=1")]
        found = self.lean("bunny/fine.yaml", "--budget", 0.05, *seconds, *few)
        steps = self.steps(found)
        # The dear parts: the search of all faces, and the sub-steps.
        self.assertIn("collision: collision.exact -> collision.sdf", steps)
        self.assertTrue(any(step.startswith("dynamics.substep:") for step in steps), steps)
        # Fewer contact samples save a fifth of what is left, which a busy machine may hide. The budget allows them.
        spaced = [trial for trial in found["trials"] if trial["what"] == "collision.spacing: 0 -> 8 mm" and "metrics" in trial]
        self.assertTrue(spaced)
        for trial in spaced:
            self.assertLessEqual(trial["metrics"]["error_N"], 0.05)
        for what in ("without rotation and torque of tool", "without friction of tool"):
            outcomes = [trial["outcome"] for trial in found["trials"] if trial["what"] == what]
            self.assertEqual(outcomes, ["over the budget"])
        self.assertTrue([trial for trial in found["trials"] if trial["what"].endswith("-> dynamics.quasistatic")])
        # Coarser cells are tried. Distances are exact whatever the cells are, so that the error stays.
        cells = [trial for trial in found["trials"] if trial["what"].startswith("collision.resolution: 128 ->")]
        self.assertTrue(cells)
        for trial in cells:
            self.assertEqual(trial["metrics"]["error_N"], trial["before"]["error_N"])

        # Both run anew on the seed of the check: errors by what is displayed, work by what is counted.
        seed = ("--seed", found["check_seeds"][0], *seconds)
        errors = {name: found["check"][name]["error_N"] for name in ("original", "lean")}
        self.assertLessEqual(errors["lean"], 0.05)
        shown, work = {}, {}
        for name, graph in (("original", GRAPHS / "bunny/fine.yaml"), ("lean", self.folder / "lean.yaml")):
            shown[name] = self.displayed(graph, *seed, *(few if name == "original" else ()))
            summary = json.loads((self.folder / "out/summary.json").read_text())
            self.assertGreater(summary["contacts"]["max"], 0)
            work[name] = summary["dynamics_steps"] * summary["contacts"]["median"]
            if name == "original":
                self.assertAlmostEqual(summary["delivered"]["force"]["rms_error_N"], errors[name], delta=1e-9)
        apart = self.apart(shown["original"], shown["lean"])
        self.assertLessEqual(apart, errors["lean"] + errors["original"] + 1e-6)
        self.assertGreaterEqual(apart, errors["lean"] - errors["original"] - 1e-6)
        self.assertGreaterEqual(work["original"], 5 * work["lean"])

    @needs_hdf5
    def test_soft_tissue_may_do_with_fewer_and_simpler_elements_and_a_smaller_patch(self):
        settings = [f"--set={name}" for name in ("scene.bodies.gel.tetrahedra=400", "dynamics.elements=quadratic", "dynamics.patch_nodes=12",
                                                 "dynamics.patch_far_nodes=0", "dynamics.solver=simplicial", "dynamics.cost.constant=33 ms",
                                                 *(f"dynamics.{coarsest}" for coarsest in ("iterations=5", "newton_iterations=2", "tolerance=0.05",
                                                                                           "soft_spacing=8 mm")),
                                                 "local.resimulate=false", "local.curvature=false")]
        short = ("--duration", 0.3)  # the ball touches after 0.1 s
        found = self.lean("gel_cube/local.yaml", "--budget", 1, *short, *settings)
        tried = {trial["what"]: trial for trial in reversed(found["trials"])}
        fewer, simpler, smaller = "tetrahedra of gel: 400 -> 200", "dynamics.elements: quadratic -> linear", "dynamics.patch_nodes: 12 -> 8"
        for what in (fewer, simpler, smaller):
            self.assertIn(what, tried)
        self.assertNotIn("tetrahedra of gel: 400 -> 100", tried)
        steps = self.steps(found)
        self.assertIn(fewer, steps)
        self.assertIn(simpler, steps)
        lean = self.folder / "lean.yaml"
        self.assertIn("tetrahedra: 200", lean.read_text())
        self.assertNotIn("quadratic", lean.read_text())  # linear is the default

        # Both run anew on the seed of the check: what is displayed differs by what the errors allow.
        seed = ("--seed", found["check_seeds"][0], *short)
        errors = {name: found["check"][name]["error_N"] for name in ("original", "lean")}
        self.assertLessEqual(errors["lean"], 1)
        apart = self.apart(self.displayed(GRAPHS / "gel_cube/local.yaml", *seed, *settings), self.displayed(lean, *seed))
        self.assertGreater(apart, 1e-3)
        self.assertLessEqual(apart, errors["lean"] + errors["original"] + 1e-6)
        self.assertGreaterEqual(apart, errors["lean"] - errors["original"] - 1e-6)

    def test_values_of_the_command_line_are_in_the_graph_that_is_written(self):
        found = self.lean("duck/fine.yaml", "--budget", 0.5, "--duration", 0.6, "--set", "scene.bodies.tool.mass=70g",
                          "--set", "coupling.k_0=400", *FEW)
        self.assertIn("without friction of tool", self.steps(found))
        summary = self.run_graph(self.folder / "lean.yaml", "--duration", 0.6)
        self.assertNotIn("torque", summary["delivered"])
        resolved = (self.folder / "out/graph.yaml").read_text()
        self.assertIn("mass: 0.07", resolved)
        self.assertIn("k_0: 400", resolved)
        # The duration of the search is none of the graph's, which has that of the file it extends.
        self.assertNotIn("duration:", (self.folder / "lean.yaml").read_text())

    def test_bad_input_is_told_and_nothing_is_written(self):
        out = self.folder / "never.yaml"
        cases = (
            (("duck/fine.yaml",), "--budget"),
            (("duck/fine.yaml", "--budget", "0"), "--budget: expected a force (N) above 0, found 0"),
            (("duck/fine.yaml", "--budget", "nan"), "--budget"),
            (("duck/fine.yaml", "--budget", "0.05", "--torque-budget", "-1"), "--torque-budget: expected a torque (N m) of at least 0, found -1"),
            (("duck/fine.yaml", "--budget", "0.05", "--metric", "felt"), "felt"),
            (("duck/fine.yaml", "--budget", "0.05", "--set", "clock=real"), "clock=virtual"),
            (("duck/closed_loop.yaml", "--budget", "0.05"), "closed loop"),
            (("duck/scene.yaml", "--budget", "0.0001", "--duration", "0.6"), "expected a graph within the budget"),
            (("duck/fine.yaml", "--budget", "0.05", "--duration", "0.1"), "settle"),
        )
        for arguments, said in cases:
            with self.subTest(arguments=arguments):
                result = tactor("lean", GRAPHS / arguments[0], *arguments[1:], "--out", out, environment=self.environment)
                self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
                self.assertIn(said, result.stderr)
                self.assertFalse(out.exists())
        result = tactor("lean", GRAPHS / "duck/fine.yaml", "--budget", "1", "--out", self.folder / "x.txt",
                        environment=self.environment)
        self.assertEqual(result.returncode, 2)


if __name__ == "__main__":
    unittest.main()
