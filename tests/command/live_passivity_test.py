"""A stage in one loop with a live device: it hears of the handle in the same tick, and the motors give no more than a tick and a rounding."""
import json
import unittest

from harness import GRAPHS, CommandTest, has_plugin, needs_hdf5

# Physics is 50 ms away, so that a held force gives hundreds of times of what the bound allows.
AWAY = ("--over", GRAPHS / "methods/hold.yaml", "--over", GRAPHS / "passivity/delay_50ms.yaml")
STAGE = ("--over", GRAPHS / "passivity/energy_bound.yaml")
STIFF = ("coupling.k_t=6400 N/m", "scene.bodies.wall.material.stiffness=100 N/mm", "scene.bodies.tool.material.stiffness=100 N/mm",
         "device.hand_mass=0.15 kg")


@needs_hdf5
@unittest.skipUnless(has_plugin("live"), "this build has no CAF, so no live engine")
class LivePassivity(CommandTest):
    def played(self, *over):
        """The summary of a live run, and the share of the strict bound that the motors gave at most, net, by their own sub-steps."""
        settings = [part for text in ("clock=real", "duration=1.2 s", "record=[device.commanded]", *STIFF) for part in ("--set", text)]
        out = self.folder / "out"
        result = self.run_ok("run", GRAPHS / "wall/closed_loop.yaml", *over, *settings, "--overwrite", "--out", out)
        summary = json.loads((out / "summary.json").read_text())
        self.assertEqual(summary["clock"], "real")
        return summary, summary["device"]["energy_generated_J"] / summary["device"]["line"]["energy_allowed_J"], result.stdout

    def test_a_held_force_gives_far_more(self):
        _, share, text = self.played(*AWAY)
        self.assertGreater(share, 10)
        self.assertNotIn("port passive", text)

    def test_a_bound_keeps_a_live_port_passive_however_late_the_run_is(self):
        for _ in range(4):
            summary, share, text = self.played(*AWAY, *STAGE)
            self.assertEqual(summary["passivity"]["ahead_most"], 1)
            self.assertLessEqual(share, 1)
            self.assertIn("port passive", text)


if __name__ == "__main__":
    unittest.main()
