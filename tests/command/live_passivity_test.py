"""A stage in one loop with a live device: it hears of the handle in the same tick, and the port gives no more than a tick and a rounding."""
import json
import unittest

from harness import GRAPHS, CommandTest, has_plugin, needs_hdf5

HAS_LIVE = has_plugin("live")
# Physics is 50 ms away, so that a held force gives hundreds of times of what the bound allows.
AWAY = ("--over", GRAPHS / "methods/hold.yaml", "--over", GRAPHS / "passivity/delay_50ms.yaml")
STAGE = ("--over", GRAPHS / "passivity/energy_bound.yaml")
STIFF = ("coupling.k_t=6400 N/m", "scene.bodies.wall.material.stiffness=100 N/mm", "scene.bodies.tool.material.stiffness=100 N/mm",
         "device.hand_mass=0.15 kg")
STEP = 1e-5  # m, of the device's encoder


FORESEEN = {"ahead_most": 3, "held_most": 2}  # ticks, and a gap of the loop of 2 ticks
TICK = 1e-3  # s


@needs_hdf5
@unittest.skipUnless(HAS_LIVE, "this build has no CAF, so no live engine")
class LivePassivity(CommandTest):
    def played(self, *over):
        """The summary of a run; the times of its ticks (s), the net energy that the motors had given at each (J), and the two parts of the
        strict bound: what a rounding and what a tick may bring (J)."""
        import h5py
        import numpy

        settings = [part for text in ("clock=real", "duration=1.2 s", "record=[device.truth, device.commanded]", *STIFF) for part in ("--set", text)]
        out = self.folder / "out"
        self.run_ok("run", GRAPHS / "wall/closed_loop.yaml", *over, *settings, "--overwrite", "--out", out)
        with h5py.File(out / "recording.h5") as file:
            commanded, truth = (file[f"streams/device.{name}/data"][:] for name in ("commanded", "truth"))
        # The device commands nothing for some ticks before it shows a handle, so rows go together by their times.
        times, of_commanded, of_truth = numpy.intersect1d(commanded["valid_ns"], truth["valid_ns"], return_indices=True)
        self.assertEqual(len(times), len(truth))
        self.assertFalse(numpy.delete(commanded["force"], of_commanded, axis=0).any())
        force, p = commanded["force"][of_commanded], truth["p_WD"][of_truth]
        self.assertGreater(numpy.linalg.norm(force, axis=1).max(), 1)
        energy = numpy.insert(numpy.cumsum(numpy.sum(force[:-1] * numpy.diff(p, axis=0), axis=1)), 0, 0)
        rounding = numpy.linalg.norm(force, axis=1).max() * STEP
        return json.loads((out / "summary.json").read_text()), 1e-9 * times, energy, rounding, numpy.abs(numpy.diff(energy)).max()

    def test_a_bound_keeps_a_live_port_passive_up_to_what_it_has_not_heard_of(self):
        import numpy

        summary, _, energy, rounding, tick = self.played(*AWAY)
        self.assertGreater(energy.max(), 10 * (rounding + tick))
        self.assertEqual(summary["stability"]["passive"], 0)
        # The machine may keep a thread waiting: a run that is on time is tried for, and a late one is held to what its lateness explains.
        for _ in range(8):
            summary, times, energy, rounding, tick = self.played(*AWAY, *STAGE)
            self.assertEqual(summary["clock"], "real")
            of_stage = summary["passivity"]
            self.assertEqual(of_stage["ahead_most"], 1)
            late = any(of_stage[name] > most for name, most in FORESEEN.items())
            self.assertEqual(late, any("later than the bound foresees" in text for text in summary.get("remarks", ())))
            gap = numpy.diff(times).max()
            if not late and gap < 2.5 * TICK:
                self.assertLessEqual(energy.max(), rounding + tick)
                self.assertEqual(summary["stability"]["passive"], 1)
                return
            unheard = gap + TICK * sum(of_stage[name] for name in FORESEEN)
            last = numpy.searchsorted(times, times + unheard, side="right") - 1
            self.assertLessEqual(energy.max(), rounding + (energy[last] - energy).max())


if __name__ == "__main__":
    unittest.main()
