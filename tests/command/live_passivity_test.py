"""A stage before a live device: it hears of the handle a tick late, and the port gives no more than a tick and a rounding."""
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


@needs_hdf5
@unittest.skipUnless(HAS_LIVE, "this build has no CAF, so no live engine")
class LivePassivity(CommandTest):
    def played(self, *over):
        """J: the most net energy that the motors had given, and what a tick and a rounding may bring; the longest gap (s) and the summary."""
        import h5py
        import numpy

        settings = [part for text in ("clock=real", "duration=2 s", "record=[device.truth, device.commanded]", *STIFF) for part in ("--set", text)]
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
        given = numpy.sum(force[:-1] * numpy.diff(p, axis=0), axis=1)
        allowed = numpy.linalg.norm(force, axis=1).max() * STEP + numpy.abs(given).max()
        return max(0, numpy.cumsum(given).max()), allowed, 1e-9 * numpy.diff(times).max(), json.loads((out / "summary.json").read_text())

    def test_a_bound_keeps_a_live_port_passive_where_nothing_is_later_than_it_foresees(self):
        given, allowed, _, summary = self.played(*AWAY)
        self.assertGreater(given, 10 * allowed)
        self.assertEqual(summary["stability"]["passive"], 0)
        for _ in range(8):
            given, allowed, gap, summary = self.played(*AWAY, *STAGE)
            self.assertEqual(summary["clock"], "real")
            of_stage = summary["passivity"]
            self.assertGreaterEqual(of_stage["ahead_most"], 2)
            # The machine may keep a thread waiting, and the run says so.
            late = of_stage["ahead_most"] > 3 or of_stage["held_most"] > 2
            self.assertEqual(late, any("later than the bound foresees" in text for text in summary.get("remarks", ())))
            if late or gap > 2.5e-3:
                continue
            self.assertLessEqual(given, allowed)
            self.assertEqual(summary["stability"]["passive"], 1)
            return
        self.fail("this machine was late in each of eight runs")


if __name__ == "__main__":
    unittest.main()
