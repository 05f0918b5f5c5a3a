"""Stages that keep the port passive, laid over the scenes: the energy is summed up here from the recording."""
import json
import unittest

from harness import GRAPHS, CommandTest, needs_hdf5, tactor

STAGES = ("controller", "energy_bound")
WALL = GRAPHS / "wall/closed_loop.yaml"
STIFF = ("coupling.k_t=6400 N/m", "scene.bodies.wall.material.stiffness=100 N/mm", "scene.bodies.tool.material.stiffness=100 N/mm",
         "device.hand_mass=0.15 kg")
STEP = 1e-5  # m, of the device's encoder
T = 1e-3  # s


def over(stage):
    return ("--over", GRAPHS / f"passivity/{stage}.yaml") if stage else ()


class Passivity(CommandTest):
    def played(self, graph, method, stage, *settings):
        """The wrenches commanded (N), the true handle (m), and the summary."""
        import h5py

        out = self.folder / "out"
        values = [item for value in ("record=[device.truth, device.commanded]", *settings) for item in ("--set", value)]
        self.run_ok("run", graph, "--over", GRAPHS / f"methods/{method}.yaml", *over(stage), *values, "--overwrite", "--out", out)
        with h5py.File(out / "recording.h5") as file:
            force = file["streams/device.commanded/data"]["force"][:]
            p = file["streams/device.truth/data"]["p_WD"][:]
        ticks = min(len(force), len(p))
        return force[:ticks], p[:ticks], json.loads((out / "summary.json").read_text())

    @needs_hdf5
    def test_a_wall_that_gives_energy_gives_no_more_than_a_tick_and_a_rounding_with_a_stage(self):
        import numpy

        for stage in (None, *STAGES):
            with self.subTest(stage=stage):
                force, p, summary = self.played(WALL, "hold", stage, *STIFF)
                given = numpy.sum(force[:-1] * numpy.diff(p, axis=0), axis=1)
                most = max(0, numpy.cumsum(given).max())
                allowed = numpy.linalg.norm(force, axis=1).max() * STEP + numpy.abs(given).max()
                self.assertAlmostEqual(summary["port"]["energy_generated_J"], most, delta=1e-9)
                self.assertAlmostEqual(summary["port"]["energy_allowed_J"], allowed, delta=1e-3 * allowed)
                # What the simulated motors know of themselves, by their sub-steps.
                self.assertAlmostEqual(summary["device"]["energy_generated_J"], most, delta=1e-3 * allowed)
                self.assertEqual(summary["stability"]["passive"], 1 if stage else 0)
                if stage:
                    self.assertLessEqual(most, allowed)
                    self.assertGreater(summary["passivity"]["changed_share"], 0.01)
                else:
                    self.assertGreater(most, 100 * allowed)

    @needs_hdf5
    def test_a_run_that_is_passive_is_left_as_it_is(self):
        for graph, method in ((GRAPHS / "wall/scene.yaml", "local"), (GRAPHS / "wall/scene.yaml", "hold"), (WALL, "local")):
            plain = self.played(graph, method, None, "metrics=~", "duration=3 s")
            for stage in STAGES:
                with self.subTest(graph=graph, method=method, stage=stage):
                    force, p, summary = self.played(graph, method, stage, "metrics=~", "duration=3 s")
                    self.assertEqual((force == plain[0]).all() and (p == plain[1]).all(), True)
                    self.assertEqual(summary["passivity"]["changed_share"], 0)

    def test_a_stage_goes_between_the_method_and_the_device_whatever_the_method(self):
        for method, source in (("hold", "interpolation.segment"), ("local", "rollout.segment"), ("direct", "direct.segment")):
            for stage in STAGES:
                with self.subTest(method=method, stage=stage):
                    text = self.run_ok("check", "--explain", WALL, "--over", GRAPHS / f"methods/{method}.yaml", *over(stage)).stdout
                    self.assertIn(f"passivity.{stage}", text)
                    self.assertIn(f"{source} -> passivity.segment", text)
                    self.assertIn("passivity.segment -> device.segment", text)
        # One stage takes the place of the other, and none twice.
        text = self.run_ok("check", "--explain", WALL, *over("controller"), *over("energy_bound"), *over("energy_bound")).stdout
        self.assertIn("passivity.energy_bound", text)
        self.assertNotIn("passivity.controller", text)
        self.assertIn("interpolation.segment -> passivity.segment", text)

    def test_an_edge_from_what_feeds_an_input_needs_one_that_feeds_it(self):
        child = self.write("child.yaml", f"extends: {WALL}\nedges: [into device.segmnt -> metrics.commanded]\n")
        result = tactor("check", child)
        self.assertEqual(result.returncode, 2)
        self.assertIn("into device.segmnt: expected an edge into device.segmnt in the file that this one is laid over", result.stderr)

    def test_bad_parameters_are_refused(self):
        for stage, value in (("controller", "damping_share=2"), ("controller", "mass=0"), ("energy_bound", "acceleration=-1"),
                             ("energy_bound", "rounding=1.5"), ("energy_bound", "stiffness_min=0"), ("controller", "lever=0"),
                             ("energy_bound", "device_damping=1 kg")):
            with self.subTest(stage=stage, value=value):
                result = tactor("check", WALL, *over(stage), "--set", f"passivity.{value}")
                self.assertEqual(result.returncode, 2, result.stdout)
                self.assertIn(value.split("=")[0], result.stderr)


if __name__ == "__main__":
    unittest.main()
