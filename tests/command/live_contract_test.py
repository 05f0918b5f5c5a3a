"""Two clocks, one meaning: a recorded input played live, and again under the virtual clock with the costs it had."""
import unittest

import h5py
import numpy

from harness import GRAPHS, CommandTest, columns, has_plugin, needs_meshes, needs_hdf5

HAS_LIVE = has_plugin("live")
STREAMS = ["collision.contacts", "dynamics.state", "coupling.force", "refit.coefficients", "prediction.forecast",
           "interpolation.segment"]


def flat(data):
    """The values of a stream's rows, without its stamps, as one array of doubles."""
    values = [numbers for path, numbers in columns(data) if path not in ("valid_ns", "produced_ns", "sequence")]
    return numpy.concatenate([numbers.reshape(len(data), -1).astype(float) for numbers in values], axis=1)


@needs_hdf5
@needs_meshes
@unittest.skipUnless(HAS_LIVE, "this build has no CAF, so no live engine")
class LiveContract(CommandTest):
    def streams(self, folder):
        """The rows of every stream by its name."""
        with h5py.File(self.folder / folder / "recording.h5") as file:
            return {name: stream["data"][...] for name, stream in file["streams"].items()}

    def test_the_method_on_recorded_motion_takes_the_same_steps_with_the_same_values(self):
        self.check_contract("false")

    def test_the_method_at_the_rate_of_the_paper_takes_the_same_steps_with_the_same_values(self):
        live = self.check_contract("true")
        # No step has passed before the cost that the graph declares for it, 6.7 ms at the least.
        steps = live["steps"]
        steps = steps[steps["node"] == h5py.check_enum_dtype(steps.dtype["node"])["collision"]]
        self.assertGreaterEqual((steps["produced_ns"] - steps["valid_ns"]).min(), 6_700_000)
        self.assertGreaterEqual(numpy.diff(live["collision.contacts"]["produced_ns"]).min(), 6_700_000)

    def check_contract(self, imposed):
        """Runs the method live and again under the virtual clock: the same steps and values; the live summary."""
        recorded = self.write("recorded.yaml", f"extends: {GRAPHS / 'duck/refit.yaml'}\nrecord: [device.state]\n")
        self.run_graph(recorded, "--duration", "2", out="input")
        graph = self.write("contract.yaml", f"""
extends: {GRAPHS / 'duck/live.yaml'}
duration: 2 s
live: {{impose_cost: {imposed}}}
nodes:
  trajectory: ~
  device: ~
  metrics: ~
  refit: {{window: 50}}
  player: {{type: source.recording, file: input/recording.h5, stream: device.state}}
edges:
  - player.device -> collision.device
  - player.device -> dynamics.device
record: [{', '.join(STREAMS)}]
""")
        self.assertEqual(self.run_graph(graph, out="live")["clock"], "real")
        self.run_ok("replay", self.folder / "live/recording.h5", "--out", self.folder / "replay")
        live_rows, replay_rows = self.streams("live"), self.streams("replay")
        self.assertEqual(sorted(live_rows), sorted((*STREAMS, "steps", "ticks", "sets", "stop")))
        for name in live_rows:
            with self.subTest(stream=name):
                self.assertEqual(live_rows[name].tobytes(), replay_rows[name].tobytes())
        for name in (*STREAMS, "steps"):
            self.assertGreater(len(live_rows[name]), 50, name)
        forces = flat(live_rows["coupling.force"])
        self.assertGreater(numpy.abs(forces).max(), 0.1)
        return live_rows


if __name__ == "__main__":
    unittest.main()
