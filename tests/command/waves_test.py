"""A line of wave variables between the handle and physics that is away: what left and what the port gave are summed up here."""
import json
import unittest

from harness import GRAPHS, CommandTest, needs_hdf5, tactor

WALL = GRAPHS / "wall/closed_loop.yaml"
WAVES = ("--over", GRAPHS / "passivity/waves.yaml")
STIFF = tuple(f"scene.bodies.{body}.material.stiffness=100 N/mm" for body in ("wall", "tool"))
STEP = 1e-5  # m, of the device's encoder
T = 1e-3  # s


def away(ms):
    return ("--over", GRAPHS / f"passivity/delay_{ms}ms.yaml")


class Waves(CommandTest):
    def played(self, over, *settings, streams=()):
        """The recorded streams by name, and the summary."""
        import h5py

        out = self.folder / "out"
        names = ("device.truth", "device.commanded", *streams)
        values = [item for value in (f"record=[{', '.join(names)}]", *settings) for item in ("--set", value)]
        self.run_ok("run", WALL, *over, *values, "--overwrite", "--out", out)
        with h5py.File(out / "recording.h5") as file:
            found = {name: file[f"streams/{name}/data"][:] for name in names}
        return found, json.loads((out / "summary.json").read_text())

    @staticmethod
    def given(found):
        """J: the most net energy that the motors had given, and what a tick and a rounding may bring."""
        import numpy

        ticks = min(len(found["device.truth"]), len(found["device.commanded"]))
        force, p = found["device.commanded"]["force"][:ticks], found["device.truth"]["p_WD"][:ticks]
        energy = numpy.sum(force[:-1] * numpy.diff(p, axis=0), axis=1)
        return max(0, numpy.cumsum(energy).max()), numpy.linalg.norm(force, axis=1).max() * STEP + numpy.abs(energy).max()

    @needs_hdf5
    def test_with_physics_50_ms_away_a_held_force_gives_energy_and_a_line_of_waves_none(self):
        hold, summary = self.played(away(50), *STIFF, "coupling.k_t=800 N/m", "device.hand_mass=0.15 kg")
        most, allowed = self.given(hold)
        self.assertGreater(most, 10 * allowed)
        self.assertEqual(summary["stability"]["passive"], 0)
        for hand in ("device.hand_mass=0.15 kg", "device.hand_mass=0.55 kg", "device.hand_damping=0"):
            for ms in (10, 50, 100):
                with self.subTest(hand=hand, ms=ms):
                    waves, summary = self.played((*WAVES, *away(ms)), *STIFF, hand)
                    most, allowed = self.given(waves)
                    self.assertLessEqual(most, allowed)
                    self.assertEqual(summary["stability"]["passive"], 1)
                    # It is a wall all the same: the handle is pushed out of it.
                    self.assertGreater(waves["device.commanded"]["force"][:, 2].max(), 0.5)

    @needs_hdf5
    def test_what_leaves_is_of_the_force_commanded_and_of_the_way_that_the_encoder_showed(self):
        import numpy

        b = 12
        found, summary = self.played((*WAVES, *away(10)), f"coupling.impedance={b} N s/m", streams=("device.state", "coupling.wave"))
        force, p = found["device.commanded"]["force"], found["device.state"]["p_WD"]
        way = numpy.diff(p, axis=0)
        damped = T / b * force[:len(way)]
        out = numpy.vstack([p[:1], p[0] + numpy.cumsum(way - damped, axis=0)])
        ticks = min(len(out), len(found["coupling.wave"]))
        self.assertLess(numpy.abs(out[:ticks] - found["coupling.wave"]["p_WD"][:ticks]).max(), 1e-12)
        self.assertGreater(numpy.abs(out - p).max(), 1e-3)
        energy = summary["waves"]
        for name, ways in (("energy_out_J", way - damped), ("energy_played_J", way + damped)):
            self.assertAlmostEqual(energy[name], 0.25 * b * (ways ** 2).sum() / T, delta=1e-3 * energy[name])
        self.assertLess(energy["energy_played_J"], energy["energy_out_J"])

    @needs_hdf5
    def test_at_rest_it_is_as_stiff_as_the_impedance_over_half_the_time_there_and_back(self):
        for ms, b in ((0, 10), (50, 20)):
            with self.subTest(ms=ms):
                found, _ = self.played((*WAVES, *(away(ms) if ms else ())), *STIFF, f"coupling.impedance={b} N s/m", "duration=6 s",
                                       "device.friction=0")
                force, p = found["device.commanded"]["force"][-2000:, 2], found["device.truth"]["p_WD"][-2000:, 2]
                # Half a period of physics until a wave is in a result, as much until it is played, a tick and a half, and the ways. The query
                # goes on for a period while samples are still under way.
                half = 0.5 * (11.7e-3 + max(11.7e-3, 1e-3 * ms) + 1e-3 * ms + 1.5e-3)
                expected = 1 / (half / b + 2 / 1e5)
                self.assertAlmostEqual(force.mean() / (4e-3 - p.mean()), expected, delta=0.1 * expected)

    @needs_hdf5
    def test_a_heavy_tool_is_felt_and_its_weight_gives_no_more_than_on_the_way_of_the_handle(self):
        # A hand that stands, goes up and comes down to the wall.
        points = "[{t: 0 s, z: 40 mm}, {t: 1.2 s, z: 40 mm}, {t: 1.6 s, z: 60 mm}, {t: 3 s, z: 60 mm}, {t: 4 s, z: 0 mm}, {t: 6 s, z: 0 mm}]"
        for mass, ms in ((0.05, 50), (0.2, 10), (0.2, 50), (0.5, 100)):
            with self.subTest(mass=mass, ms=ms):
                found, summary = self.played((*WAVES, *away(ms)), *STIFF, "scene.gravity=[0, 0, -9.81]", f"scene.bodies.tool.mass={mass} kg",
                                             f"trajectory.points={points}", "duration=6 s", "device.hand_stiffness=400 N/m")
                port = summary["port"]
                self.assertLessEqual(port["energy_generated_J"], port["energy_allowed_J"])
                self.assertEqual(summary["stability"]["passive"], 1)
                weight = -9.81 * mass
                self.assertAlmostEqual(found["device.commanded"]["force"][2500:3000, 2].mean(), weight, delta=-0.15 * weight)

    def test_a_tool_that_starts_away_from_the_handle_is_refused(self):
        out = self.folder / "out"
        result = tactor("run", WALL, *WAVES, "--set", "dynamics.start_at_device=false", "--out", out)
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("start_at_device is false, and the coupling is a damper without a spring", result.stderr)

    def test_the_line_takes_the_place_of_the_coupling_whatever_the_method(self):
        for over in ((), ("--over", GRAPHS / "methods/hold.yaml"), ("--over", GRAPHS / "methods/blend.yaml")):
            with self.subTest(over=over):
                text = self.run_ok("check", "--explain", WALL, *over, *WAVES, *away(50)).stdout
                for edge in ("coupling.wave -> collision.device", "coupling.wave -> dynamics.device", "coupling.parameters -> dynamics.coupling",
                             "dynamics.state -> coupling.state", "coupling.segment -> device.segment"):
                    self.assertIn(edge, text)
                self.assertIn("passivity.waves", text)
                self.assertEqual(text.count("delay 50"), 3)

    def test_what_it_cannot_do_is_refused(self):
        for graph, settings, words in (
                (WALL, ("coupling.impedance=0",), "impedance"), (WALL, ("coupling.impedance=5 kg",), "impedance"),
                (WALL, ("coupling.impedance=26 N s/m",), "expected at most a quarter of mass * rate, 25 N s/m"),
                (WALL, ("coupling.catch_up=0 s",), "catch_up"),
                (WALL, ("scene.bodies.tool.motion=rigid", "dynamics.type=dynamics.rigid"), "no torques"),
                (WALL, ("dynamics.type=dynamics.quasistatic",), "its tool has no damper")):
            with self.subTest(settings=settings):
                result = tactor("check", graph, *WAVES, *(item for value in settings for item in ("--set", value)))
                self.assertEqual(result.returncode, 2, result.stdout)
                self.assertIn(words, result.stderr)


if __name__ == "__main__":
    unittest.main()
