"""Physics of a scene that deforms stalls for 0.3 s: the force fades and comes back as it does with rigid bodies."""
import json
import unittest

from faults_test import ENGAGED, NONE, PERIOD, RAMPING, STALE, FaultRun, Recording
from harness import GRAPHS, CommandTest, needs_hdf5, needs_live

try:
    import h5py
    import numpy
except ImportError:
    h5py = None

RESULT, STALLED = 0.016, 0.3  # s, what a step of physics takes
BEFORE = 60  # steps before the one that stalls
TRUST, STALE_AFTER = 0.25, 0.1  # s, the defaults of rollout and device
STRONGER_THAN_NOTHING = 0.02  # N
SOFT = f"""format: 2
extends: {GRAPHS / 'gel_cube/local.yaml'}
duration: 2.5 s
scene: {{bodies: {{gel: {{tetrahedra: 300}}}}}}
nodes:
  trajectory: {{tremor_amplitude: 0, repeat_after: 100 s, points: %s}}
  dynamics: {{cost: {{trace: costs.txt}}}}
  device: {{stale_after: %g s}}
record: [dynamics.state, device.commanded, device.interpolated, device.safety]
"""
# The same hand on a block that does not deform, of the same pace.
RIGID = """format: 2
extends: soft.yaml
scene:
  bodies:
    gel: ~
    block:
      box: {size: [80 mm, 80 mm, 40 mm]}
      material: {stiffness: 0.5 N/mm, damping: 1 N s/m, friction: 0.3, patch_area: 1 cm^2}
nodes:
  collision: {cost: none}
  dynamics: {type: dynamics.translation, cost: {trace: costs.txt}}
"""
STAYS = "[{t: 0 s, z: 32 mm}, {t: 0.4 s, z: 22 mm}, {t: 2.5 s, z: 22 mm, x: 5 mm}]"
# The stall begins at 0.96 s.
LEAVES = "[{t: 0 s, z: 32 mm}, {t: 0.4 s, z: 22 mm}, {t: 1 s, z: 22 mm}, {t: 1.1 s, z: 36 mm}, {t: 2.5 s, z: 36 mm}]"
SLIDES_FAR = """[{t: 0 s, z: 32 mm, x: -25 mm}, {t: 0.4 s, z: 22 mm, x: -25 mm}, {t: 0.97 s, z: 22 mm, x: -25 mm},
                 {t: 1.17 s, z: 22 mm, x: 25 mm}, {t: 2.5 s, z: 22 mm, x: 25 mm}]"""


@needs_hdf5
@unittest.skipIf(h5py is None, "h5py is not installed")
class UnderTheVirtualClock(CommandTest):
    def run_stalled(self, hand=STAYS, stale_after=STALE_AFTER, rigid=False, stalled=STALLED):
        """Runs the scene with a step that takes as long; the recording, with the metrics of the run."""
        self.write("costs.txt", f"{RESULT}\n" * BEFORE + f"{stalled}\n" + f"{RESULT}\n" * 200)
        graph = self.write("soft.yaml", SOFT % (hand, stale_after))
        if rigid:
            graph = self.write("rigid.yaml", RIGID)
        self.run_graph(graph, "--overwrite", out="out")
        recording = Recording(self.folder / "out/recording.h5")
        recording.summary = json.loads((self.folder / "out/summary.json").read_text())
        recording.fallbacks = recording.summary["fallbacks"]
        with h5py.File(self.folder / "out/recording.h5") as file:
            wanted = file["streams/device.interpolated/data"][...]
            recording.results = file["streams/dynamics.state/data"][...]["produced_ns"] * 1e-9
        # There is none before the first result.
        recording.wanted = numpy.full_like(recording.force, numpy.nan)
        recording.wanted[numpy.isin(recording.ns, wanted["valid_ns"])] = wanted["force"]
        gap = numpy.argmax(numpy.diff(recording.results))
        recording.last, recording.next = recording.results[gap:gap + 2]
        self.assertTrue((numpy.diff(recording.ns) == 1_000_000).all(), "the device's loop misses no tick")
        return recording

    def test_the_force_fades_and_comes_back_at_the_ticks_at_which_it_does_with_a_rigid_body(self):
        soft, rigid = self.run_stalled(), self.run_stalled(rigid=True)
        self.assertAlmostEqual(soft.next - soft.last, STALLED, delta=1e-6)
        for of_one, of_other in zip((soft.ns, soft.engagement, soft.cause, soft.norm == 0, soft.results),
                                    (rigid.ns, rigid.engagement, rigid.cause, rigid.norm == 0, rigid.results)):
            self.assertEqual(of_one.tolist(), of_other.tolist())
        self.assertGreater(soft.fallbacks, 0)
        self.assertEqual(soft.fallbacks, rigid.fallbacks)
        self.assertEqual(soft.summary["device"]["stale"], rigid.summary["device"]["stale"])

    def test_the_fall_back_is_counted_from_when_the_result_is_no_longer_trusted_to_the_next(self):
        soft = self.run_stalled()
        # The last result before the stall is of a sample that is one step older. That of the stall is too old when it comes, and the
        # one after it is used.
        begun = soft.last - RESULT
        self.assertAlmostEqual(soft.fallbacks * PERIOD, soft.next + RESULT - (begun + TRUST), delta=4 * PERIOD)

    def test_the_force_ramps_to_zero_and_is_that_of_a_run_without_a_stall_afterwards(self):
        soft, calm = self.run_stalled(), self.run_stalled(stalled=RESULT)
        self.assertEqual(calm.fallbacks, 0)
        stale = soft.first(soft.cause == STALE)
        self.assertAlmostEqual(soft.t[stale], soft.last + STALE_AFTER, delta=4 * PERIOD)
        self.assertGreater(soft.norm[stale], 0.5)
        quiet = (soft.t > soft.t[stale] + 0.1 + 2 * PERIOD) & (soft.t < soft.next)
        self.assertGreater(numpy.count_nonzero(quiet), 50)
        self.assertTrue((soft.norm[quiet] == 0).all())
        back = soft.first((soft.engagement == RAMPING) & (soft.cause == NONE), after=soft.next)
        engaged = soft.first(soft.engagement == ENGAGED, after=soft.t[back])
        self.assertAlmostEqual(soft.t[engaged], soft.next + RESULT + 0.1, delta=5 * PERIOD)
        later = soft.t > soft.t[engaged] + 0.1
        self.assertLess(numpy.linalg.norm(soft.force[later] - calm.force[later], axis=1).max(), 0.01)

    def test_a_hand_that_leaves_during_the_stall_is_pushed_by_nothing(self):
        # Here the gate alone would hold the force for a second.
        soft = self.run_stalled(LEAVES, stale_after=1)
        left = (soft.t > 1.15) & (soft.t < soft.next)
        self.assertGreater(numpy.count_nonzero(left), 100)
        self.assertGreater(soft.norm[soft.first(soft.t > 0.99)], 0.5)
        self.assertLess(numpy.linalg.norm(soft.wanted[left], axis=1).max(), STRONGER_THAN_NOTHING)

    def test_a_hand_that_slides_far_from_where_the_surface_is_known_is_a_fall_back_before_its_time(self):
        soft = self.run_stalled(SLIDES_FAR, stale_after=1)
        # It has gone 2 cm by 1.06 s, while the result is trusted until 1.19 s.
        self.assertGreater(soft.fallbacks * PERIOD, soft.next - 1.1)
        # The force is held then, and does not drop as if there were no gel.
        held = (soft.t > 1.1) & (soft.t < soft.next)
        self.assertGreater(numpy.linalg.norm(soft.wanted[held], axis=1).min(), 0.5)

    def test_where_the_gate_waits_for_longer_the_force_ends_with_the_trust_in_the_patch(self):
        soft = self.run_stalled(stale_after=1, stalled=0.6)
        begun = soft.last - RESULT
        last_push = soft.t[numpy.flatnonzero((soft.norm > 0) & (soft.t < soft.next))[-1]]
        self.assertAlmostEqual(last_push, begun + TRUST + 0.1, delta=4 * PERIOD)


LIVE = f"""format: 2
extends: {GRAPHS / 'gel_cube/local.yaml'}
clock: real
duration: 3 s
live: {{on_missing_privilege: warn, on_stall: recover, stall_timeout: 0.2 s}}
scene: {{bodies: {{gel: {{tetrahedra: 300}}}}}}
nodes:
  trajectory: {{tremor_amplitude: 0, repeat_after: 100 s, points: {STAYS}}}
  dynamics: {{cost: none}}
  local: {{cost: none}}
  rollout: {{lane: realtime}}
  metrics: ~
  stall: {{type: fault.stall, at: 1.2 s, lasts: %g s, lane: thread, thread: physics}}
edges:
  - dynamics.state -> stall.in
  - stall.out -> coupling.state
record: [device.state, device.commanded, device.safety, dynamics.state]
"""


@needs_live
class Live(FaultRun):
    def test_a_stall_is_ramped_out_and_in_and_the_loop_of_the_device_goes_on(self):
        self.run_fault(LIVE % STALLED, 0)
        recorded = self.recording()
        stale = recorded.first(recorded.cause == STALE, after=1.2)
        self.assertGreater(recorded.norm[stale - 1], 0.5)
        self.assert_zero_in_time(recorded, stale, 0.1)
        back = recorded.first((recorded.engagement == RAMPING) & (recorded.cause == NONE), after=recorded.t[stale])
        self.assertEqual(recorded.norm[back - 1], 0)
        self.assertGreaterEqual(recorded.t[back], 1.2 + STALLED - 0.01)
        engaged = recorded.first(recorded.engagement == ENGAGED, after=recorded.t[back])
        self.assertGreater(recorded.norm[engaged:].max(), 0.5)
        summary = self.results()
        self.assertNotIn("failure", summary)
        self.assertGreater(summary["fallbacks"], 0)


if __name__ == "__main__":
    unittest.main()
