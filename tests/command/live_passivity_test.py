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
    def test_a_bound_keeps_a_live_port_passive(self):
        import h5py
        import numpy

        settings = [part for text in ("clock=real", "duration=3 s", "record=[device.truth, device.commanded]", *STIFF) for part in ("--set", text)]
        out = self.folder / "out"
        self.run_ok("run", GRAPHS / "wall/closed_loop.yaml", "--over", GRAPHS / "methods/local.yaml", "--over",
                    GRAPHS / "passivity/energy_bound.yaml", *settings, "--out", out)
        summary = json.loads((out / "summary.json").read_text())
        with h5py.File(out / "recording.h5") as file:
            force = file["streams/device.commanded/data"]["force"][:]
            p = file["streams/device.truth/data"]["p_WD"][:]
        ticks = min(len(force), len(p))
        force, p = force[:ticks], p[:ticks]
        given = numpy.sum(force[:-1] * numpy.diff(p, axis=0), axis=1)
        self.assertGreater(numpy.linalg.norm(force, axis=1).max(), 1)
        self.assertEqual(summary["clock"], "real")
        self.assertLessEqual(max(0, numpy.cumsum(given).max()), numpy.linalg.norm(force, axis=1).max() * STEP + numpy.abs(given).max())
        self.assertEqual(summary["stability"]["passive"], 1)


if __name__ == "__main__":
    unittest.main()
