"""`tactor bridge` in real time: a client stalls, dies and is replaced; the force fades, stays in its limits and comes back."""
import csv
import io
import json
import socket
import struct
import time
import unittest

from bridge_client import EXAMPLE, Ball, Bridge
from harness import CommandTest, needs_hdf5, needs_live

# The hand presses from the first second on.
PRESSED = f"""extends: {EXAMPLE}/graph.yaml
nodes:
  hand: {{points: [{{t: 0 s, z: 6 mm}}, {{t: 0.5 s, z: 2 mm}}, {{t: 60 s, z: 2 mm}}], repeat_after: 100 s}}
  device: {{force_max: 0.5 N, stale_after: 100 ms, ramp_down_time: 100 ms, engage_time: 100 ms}}
"""
FORCE_MAX = 0.5       # N, less than the spring would give
FADED = 0.2           # s, stale_after and ramp_down_time
MARGIN = 0.05         # s, from the end of a step until its force is at the device
SETTLED = 0.5         # s, from the first result on until the force is back


@needs_live
@needs_hdf5
class Live(CommandTest):
    def setUp(self):
        super().setUp()
        graph = self.write("pressed.yaml", PRESSED)
        self.bridge = Bridge(graph, "--duration", "60 s", "--out", self.folder / "out", environment=self.environment)
        self.addCleanup(self.bridge.end)
        self.ball = Ball()

    def work(self, client, seconds):
        """Computes steps for so long; the last one that was answered."""
        end = time.monotonic() + seconds
        before = None
        while time.monotonic() < end:
            step = client.until("step")
            client.answer(self.ball.step(step))
            before = step
        return before

    def stalled(self, client, seconds):
        """A step takes so long; the ends of the steps before and after it, in s of the run."""
        before = self.work(client, 0.2)
        step = client.until("step")
        time.sleep(seconds)
        client.answer(self.ball.step(step))
        after = client.until("step")
        client.answer(self.ball.step(after))
        return before["end"] * 1e-9, after["end"] * 1e-9

    def rows(self, stream):
        return list(csv.DictReader(io.StringIO(self.run_ok("export", self.folder / "out/recording.h5", stream).stdout)))

    def finish(self):
        """Ends the run by Ctrl-C, after which its recording is read."""
        self.assertEqual(self.bridge.end(), 0, self.bridge.told)
        force = [(float(row["valid_s"]), float(row["force_z [N]"])) for row in self.rows("device.commanded")]
        # Whatever the client did.
        self.assertLessEqual(max(abs(f) for _, f in force), FORCE_MAX * (1 + 1e-12))
        return force

    def between(self, force, begin, end):
        return [f for t, f in force if begin < t < end]

    def check_faded(self, force, before, after):
        """After the last result the force fades to exactly zero, and with the first one that is new it comes back."""
        gone = self.between(force, before + FADED + MARGIN, after)
        self.assertGreater(len(gone), 50)
        self.assertEqual(set(gone), {0.0})
        self.assertGreater(max(self.between(force, after, after + SETTLED)), 0.1)
        causes = {row["cause [1]"] for row in self.rows("device.safety") if before < float(row["valid_s"]) < after}
        self.assertIn("stale", causes)

    def test_a_stall_is_late_physics(self):
        client = self.bridge.client()
        self.work(client, 1.5)
        self.stalled(client, 0.05)
        self.work(client, 0.5)
        before, after = self.stalled(client, 0.5)
        self.assertGreater(after - before, 0.5)
        last = self.work(client, SETTLED + 0.2)
        client.close()
        force = self.finish()
        self.check_faded(force, before, after)
        self.assertGreater(min(self.between(force, last["end"] * 1e-9 - 0.1, last["end"] * 1e-9)), 0.1)

    def test_after_a_stall_the_step_is_the_newest_one(self):
        client = self.bridge.client()
        self.work(client, 0.5)
        step = client.until("step")
        time.sleep(0.5)
        client.answer(self.ball.step(step))
        after = client.until("step")
        # It goes on from the handle that the client knows, to where the handle is now.
        self.assertEqual((after["id"], after["begin"], after["from"]), (step["id"] + 1, step["end"], step["handle"]))
        self.assertGreater(after["end"] - after["begin"], 0.5e9)
        client.close()
        self.finish()

    def test_a_client_that_dies_is_replaced_and_the_force_comes_back(self):
        client = self.bridge.client(packed=True)
        before = self.work(client, 1.5)["end"] * 1e-9
        client.connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        client.close()
        time.sleep(0.6)
        client = self.bridge.client()
        self.assertEqual(client.message()[0]["type"], "hello")
        first = client.until("step")
        # What was before is not for this client to compute.
        self.assertLess(first["end"] - first["begin"], 0.5e9)
        self.ball = Ball()
        client.answer(self.ball.step(first))
        self.work(client, SETTLED + 0.2)
        client.close()
        force = self.finish()
        self.check_faded(force, before, first["end"] * 1e-9)
        self.assertEqual(json.loads((self.folder / "out/bridge.json").read_text())["clients"], 2)

    def test_a_run_without_a_client_gives_no_force(self):
        time.sleep(1)
        self.assertEqual({f for _, f in self.finish()}, {0.0})

    def test_a_client_that_leaves_before_its_first_step_makes_room(self):
        self.bridge.end()
        self.bridge = Bridge(self.folder / "pressed.yaml", "--set", "physics.rate=0.1 Hz", "--duration", "3 s", "--out", self.folder / "slow",
                             environment=self.environment)
        self.addCleanup(self.bridge.end)
        # No step begins in this run.
        self.bridge.client().close()
        self.addCleanup(self.bridge.client_when_free(seconds=2).close)
        self.assertEqual(self.bridge.wait(), 0, self.bridge.told)
        figures = json.loads((self.folder / "slow/bridge.json").read_text())
        self.assertEqual((figures["clients"], figures["steps"]), (2, 0))

    def test_refused_results_let_the_force_fade(self):
        client = self.bridge.client()
        before = self.work(client, 1.5)["end"] * 1e-9
        end = time.monotonic() + 0.6
        while time.monotonic() < end:
            step = client.until("step")
            result = self.ball.step(step)
            result["tool"] = {**result["tool"], "R_WT": [0, 0, 0, 0]}
            client.answer(result)
        self.assertGreater(len(client.errors), 3)
        self.assertEqual({error["field"] for error in client.errors}, {"tool.R_WT"})
        first = client.until("step")
        client.answer(self.ball.step(first))
        self.work(client, SETTLED + 0.2)
        client.close()
        self.check_faded(self.finish(), before, first["end"] * 1e-9)


if __name__ == "__main__":
    unittest.main()
