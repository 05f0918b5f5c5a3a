"""Two clocks, one meaning: a recorded input played live, and again under the virtual clock with the costs it had."""
import unittest

import h5py
import numpy

from harness import GRAPHS, CommandTest, built, columns, needs_meshes, needs_hdf5

HAS_LIVE = built("../lib/libtactor_live.so")
STREAMS = ["collision.contacts", "dynamics.state", "coupling.force", "refit.coefficients", "prediction.forecast",
           "interpolation.segment"]
DURATION_NS = 2_000_000_000


def flat(data):
    """The values of a stream's rows, without its stamps, as one array of doubles."""
    values = [numbers for path, numbers in columns(data) if path not in ("valid_ns", "produced_ns", "sequence")]
    return numpy.concatenate([numbers.reshape(len(data), -1).astype(float) for numbers in values], axis=1)


@needs_hdf5
@needs_meshes
@unittest.skipUnless(HAS_LIVE, "this build has no CAF, so no live engine")
class LiveContract(CommandTest):
    def streams(self, folder):
        """The rows that were visible before the end, by stream."""
        rows = {}
        with h5py.File(self.folder / folder / "recording.h5") as file:
            for name in STREAMS:
                data = file[f"streams/{name}/data"][...]
                rows[name] = data[data["produced_ns"] < DURATION_NS]
        return rows

    def test_the_method_on_recorded_motion_takes_the_same_steps_with_the_same_values(self):
        self.check_contract("false")

    def test_the_method_at_the_rate_of_the_paper_takes_the_same_steps_with_the_same_values(self):
        live = self.check_contract("true")
        # No step has passed before the cost that the graph declares for it, 6.7 ms at the least.
        costs = numpy.loadtxt(self.folder / "live/costs/collision.txt")
        self.assertIn(len(costs) - live["cost_us"]["collision"]["steps"], (0, 1))  # the last one may not have passed
        self.assertGreaterEqual(costs.min(), 6.7e-3)
        with h5py.File(self.folder / "live/recording.h5") as file:
            contacts = file["streams/collision.contacts/data"]["produced_ns"]
        self.assertGreaterEqual(numpy.diff(contacts).min(), 6_700_000)

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
        live = self.run_graph(graph, "--record-costs", out="live")
        replay = self.run_graph(self.folder / "live/replay.yaml", out="replay")
        self.assertEqual((live["clock"], replay["clock"]), ("real", "virtual"))
        for node, cost in live["cost_us"].items():
            self.assertEqual(cost["missed_ticks"], replay["cost_us"][node]["missed_ticks"], node)
        live_rows, replay_rows = self.streams("live"), self.streams("replay")
        for name in STREAMS:
            with self.subTest(stream=name):
                a, b = live_rows[name], replay_rows[name]
                self.assertGreater(len(a), 50)
                # The times at which results became visible tell the sequence of steps.
                for stamp in ("valid_ns", "produced_ns", "sequence"):
                    numpy.testing.assert_array_equal(a[stamp], b[stamp])
                numpy.testing.assert_allclose(flat(a), flat(b), rtol=0, atol=1e-12)
        forces = flat(live_rows["coupling.force"])
        self.assertGreater(numpy.abs(forces).max(), 0.1)
        return live


if __name__ == "__main__":
    unittest.main()
