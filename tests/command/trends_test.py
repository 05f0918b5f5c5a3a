"""The method's trends on the shipped scenes, with tolerances that leave room for another seed."""
import json
import unittest

from harness import GRAPHS, CachedTest, graph_file, needs_meshes, needs_hdf5

SEED = "2001"  # not one that the scenes were tuned with


@needs_meshes
class Duck(CachedTest):
    def one_step(self, graph, *settings):
        arguments = [word for setting in settings for word in ("--set", setting)]
        summary = self.run_graph(graph_file(graph), "--seed", SEED, *arguments)
        return summary["one_step"]["force"]

    def test_the_one_step_error_falls_with_the_window_as_printed_and_is_flat_on_differences(self):
        # In a study all windows are judged where the longest is full.
        study = self.write("windows.yaml", f"graphs: [{', '.join(str(GRAPHS / f'duck/{test}_refit.yaml') for test in (1, 4, 5))}]\n"
                           "vary: {'refit.detrend, prediction.detrend': [none, difference], refit.window: [20, 300, 500]}\n"
                           f"seeds: 1\nfirst_seed: {SEED}\nreference: none\n")
        self.run_ok("study", study, "--out", self.folder / "windows")
        rows = json.loads((self.folder / "windows/study.json").read_text())["rows"]
        self.assertEqual(len(rows), 18)
        errors = [sum(row["metrics"]["one_step.force.rms_error_N"]["mean"] for row in rows[i::6]) / 3 for i in range(6)]
        shortest, middle, longest = errors[:3]
        self.assertLess(middle, shortest)
        self.assertLess(longest, 1.02 * middle)
        shortest, middle, longest = errors[3:]
        self.assertLess(middle, shortest)
        self.assertLess(abs(longest - middle), 0.05 * middle)

    def test_prediction_beats_a_hold_one_step_ahead(self):
        for test in range(1, 6):
            with self.subTest(test=test):
                error = self.one_step(f"duck_{test}_refit")
                self.assertLess(error["rms_error_N"], error["rms_error_hold_N"])


@needs_meshes
class Bunny(CachedTest):
    def test_splines_are_far_smoother_and_later_than_the_hold(self):
        out = self.folder / "cmp"
        self.run_ok("compare", *(GRAPHS / f"bunny/{p}.yaml" for p in ("off", "fixed", "refit")), "--seeds", "1",
                    "--first-seed", SEED, "--duration", "8 s", "--out", out)
        off, *splines = (g["metrics"] for g in json.loads((out / "compare.json").read_text())["graphs"])
        for spline in splines:
            for smoothness in ("rms_d2_N_per_ms2", "max_step_N"):
                name = f"delivered.force.{smoothness}"
                self.assertLess(spline[name]["mean"], 0.2 * off[name]["mean"])
            self.assertGreater(spline["delivered.force.delay_ms"]["mean"], off["delivered.force.delay_ms"]["mean"])
            self.assertGreater(spline["delivered.force.rms_error_N"]["mean"],
                               off["delivered.force.rms_error_N"]["mean"])
        self.assertGreater(off["contacts.median"]["mean"], 10)


@needs_meshes
class LocalRollout(CachedTest):
    def test_the_local_rollout_leaves_a_third_of_the_error_of_the_hold_and_hardly_ever_falls_back(self):
        for scene in ("duck", "wall", "bunny"):
            with self.subTest(scene=scene):
                arguments = GRAPHS / scene / "scene.yaml", "--duration", "2.5", "--seed", SEED
                hold = self.run_graph(*arguments, "--over", GRAPHS / "methods/hold.yaml")
                local = self.run_graph(*arguments, "--over", GRAPHS / "methods/local.yaml")
                self.assertGreater(hold["contacts"]["max"], 0)
                self.assertLess(local["delivered"]["force"]["rms_error_N"],
                                hold["delivered"]["force"]["rms_error_N"] / 3)
                self.assertEqual(local["drops"], 0)
                self.assertEqual(local["prediction"]["failed_steps"], 0)
                # At the start, while the first results say little of the contacts around.
                self.assertLess(local["fallbacks"], 0.01 * local["rollout"]["ticks"])

    def test_what_physics_force_teaches_halves_the_error_of_a_wrong_model_of_contacts(self):
        for scene, method in (("duck", "soft"), ("wall", "stiff"), ("wall", "slippery"), ("duck", "rough")):
            with self.subTest(scene=scene, method=method):
                arguments = GRAPHS / scene / "scene.yaml", "--duration", "4", "--seed", SEED
                fitted = self.run_graph(*arguments, "--over", GRAPHS / f"methods/local_{method}.yaml")
                without = self.run_graph(*arguments, "--over", GRAPHS / f"methods/local_no_fit_{method}.yaml")
                self.assertLess(fitted["delivered"]["force"]["rms_error_N"],
                                0.5 * without["delivered"]["force"]["rms_error_N"])
                self.assertGreater(fitted["local"]["fit"]["results"], 10)
                self.assertNotIn("local", without)

    def test_an_exact_model_of_contacts_is_left_as_it_is(self):
        arguments = GRAPHS / "wall/scene.yaml", "--duration", "4", "--seed", SEED
        fitted = self.run_graph(*arguments, "--over", GRAPHS / "methods/local.yaml")
        without = self.run_graph(*arguments, "--over", GRAPHS / "methods/local_no_fit.yaml")
        self.assertLess(fitted["delivered"]["force"]["rms_error_N"],
                        1.05 * without["delivered"]["force"]["rms_error_N"])
        self.assertLess(abs(fitted["local"]["fit"]["stiffness_scale"] - 1), 0.1)
        self.assertLess(abs(fitted["local"]["fit"]["friction_excess"]), 0.05)


@needs_meshes
class Forecasts(CachedTest):
    def test_a_forecast_at_the_device_s_own_time_is_nearer_earlier_and_smoother_than_the_hold(self):
        for scene in ("duck", "bunny", "peg_in_hole"):
            out = self.folder / scene
            self.run_ok("compare", *(GRAPHS / scene / f"{p}.yaml" for p in ("off", "blend")), "--seeds", "1",
                        "--first-seed", "21", "--duration", "6 s", "--out", out)
            off, blend = (g["metrics"] for g in json.loads((out / "compare.json").read_text())["graphs"])
            for metric, most in (("rms_error_N", 0.9), ("delay_ms", 0.75), ("rms_d2_N_per_ms2", 0.5)):
                with self.subTest(scene=scene, metric=metric):
                    name = f"delivered.force.{metric}"
                    self.assertLess(blend[name]["mean"], most * off[name]["mean"])


@needs_meshes
@needs_hdf5
class PegAtRest(CachedTest):
    def hanging(self, grams):
        graph = self.write(f"rest_{grams}.yaml", f"""
extends: {GRAPHS / 'peg_free/off.yaml'}
duration: 1 s
scene: {{bodies: {{tool: {{mass: {grams} g}}}}}}
nodes: {{trajectory: {{tremor_amplitude: 0 mm}}}}
record: [dynamics.state, coupling.force]
""")
        self.run_graph(graph, out=f"rest_{grams}")
        recording = self.folder / f"rest_{grams}" / "recording.h5"

        def last(stream):
            lines = self.run_ok("export", recording, stream).stdout.splitlines()
            return dict(zip(lines[0].split(","), map(float, lines[-1].split(","))))

        state = last("dynamics.state")
        return -last("coupling.force")["force_z [N]"], state["p_WD_z [m]"] - state["p_WT_z [m]"]

    def test_the_force_is_the_weight_and_the_sag_grows_less_than_linearly(self):
        sags = []
        for grams in (50, 100, 150):
            force, sag = self.hanging(grams)
            weight = 9.81e-3 * grams
            self.assertLess(abs(force - weight), 0.01 * weight)
            sags.append(sag / grams)
        self.assertGreater(sags[0], sags[1])
        self.assertGreater(sags[1], sags[2])
        self.assertGreater(2 * sags[1], sags[0])  # the sag itself grows


if __name__ == "__main__":
    unittest.main()
