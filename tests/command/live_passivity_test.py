"""A stage before a live device: it hears of the handle a tick late, and the port gives no more than a tick and a rounding."""
import json
import unittest

from harness import GRAPHS, CommandTest, built, needs_hdf5

HAS_LIVE = built("../lib/libtactor_live.so")
STIFF = ("coupling.k_t=6400 N/m", "scene.bodies.wall.material.stiffness=100 N/mm", "scene.bodies.tool.material.stiffness=100 N/mm",
         "device.hand_mass=0.15 kg")
STEP = 1e-5  # m, of the device's encoder


@needs_hdf5
@unittest.skipUnless(HAS_LIVE, "this build has no CAF, so no live engine")
class LivePassivity(CommandTest):
    def played(self):
        """The wrenches commanded (N), the true handle (m) and its times (ns), and the summary."""
        import h5py

        settings = [part for text in ("clock=real", "duration=2 s", "record=[device.truth, device.commanded]", *STIFF) for part in ("--set", text)]
        out = self.folder / "out"
        self.run_ok("run", GRAPHS / "wall/closed_loop.yaml", "--over", GRAPHS / "methods/local.yaml", "--over",
                    GRAPHS / "passivity/energy_bound.yaml", *settings, "--overwrite", "--out", out)
        with h5py.File(out / "recording.h5") as file:
            force = file["streams/device.commanded/data"]["force"][:]
            truth = file["streams/device.truth/data"][:]
        ticks = min(len(force), len(truth))
        return force[:ticks], truth["p_WD"][:ticks], truth["valid_ns"][:ticks], json.loads((out / "summary.json").read_text())

    def test_a_bound_keeps_a_live_port_passive_where_nothing_is_later_than_it_foresees(self):
        import numpy

        for _ in range(8):
            force, p, times, summary = self.played()
            self.assertEqual(summary["clock"], "real")
            self.assertGreaterEqual(summary["passivity"]["ahead_most"], 2)
            self.assertGreater(numpy.linalg.norm(force, axis=1).max(), 1)
            # The machine may keep a thread waiting.
            if summary["passivity"]["ahead_most"] > 3 or numpy.diff(times).max() > 2_500_000:
                continue
            given = numpy.sum(force[:-1] * numpy.diff(p, axis=0), axis=1)
            self.assertLessEqual(max(0, numpy.cumsum(given).max()), numpy.linalg.norm(force, axis=1).max() * STEP + numpy.abs(given).max())
            self.assertEqual(summary["stability"]["passive"], 1)
            return
        self.skipTest("this machine was late in each of eight runs")


if __name__ == "__main__":
    unittest.main()
