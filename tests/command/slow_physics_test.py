"""Physics that is slower than a device waits: check says so and what to set, and then the force stays while physics lives."""
import re
import unittest

from harness import GRAPHS, CommandTest, needs_hdf5, needs_live

try:
    import h5py
except ImportError:
    h5py = None

SCENE = f"""format: 2
extends: {GRAPHS / 'transfer/base.yaml'}
duration: 4 s
scene:
  gravity: [0, 0, 0]
  tool: tool
  bodies:
    wall:
      plane: {{}}
      material: {{stiffness: 2 N/mm, damping: 2 N s/m, friction: 0.3}}
    tool:
      sphere: {{radius: 4 mm}}
      motion: translation
      mass: 50 g
      pose: {{p: [0, 0, 10 mm]}}
      material: {{stiffness: 2 N/mm, damping: 2 N s/m, friction: 0.3}}
nodes:
  trajectory:
    points:
      - {{t: 0 s, z: 10 mm}}
      - {{t: 0.5 s, z: 2 mm}}
      - {{t: 4 s, z: 1 mm}}
  coupling: {{k_t: 0.5 N/mm}}
"""
NOTE = "physics may take"


class SlowPhysics(CommandTest):
    def graph(self, collision, dynamics="none", more="", extra=""):
        return self.write("slow.yaml", SCENE + f"  collision: {{cost: {collision}}}\n"
                          f"  dynamics: {{type: dynamics.translation, cost: {dynamics}}}\n{more}{extra}")

    def note(self, graph, *arguments):
        """What check says of the physics, or nothing."""
        lines = [line for line in self.run_ok("check", graph, *arguments).stderr.splitlines() if NOTE in line]
        self.assertLessEqual(len(lines), 1)
        return lines[0] if lines else ""

    @staticmethod
    def remedies(note):
        """The options that set what the note says."""
        said = re.search(r"; set (.*)$", note)[1]
        options = []
        for parameter, value, unit in re.findall(r"(\S+) to ([\d.]+) (m?s)", said):
            options += ["--set", f"{parameter}={value}{unit}"]
        return options

    def test_check_names_the_device_the_time_and_what_to_set(self):
        note = self.note(self.graph("{constant: 125 ms}"))
        self.assertRegex(note, r"transfer/base\.yaml:\d+:\d+: node device: ")
        self.assertIn("physics may take 125 ms by the cost of collision, and device.stale_after is 100 ms: the force ramps to zero "
                      "between results; set device.stale_after to 260 ms", note)
        written = self.note(self.graph("{constant: 125 ms}", more="  device: {stale_after: 110 ms}\n"))
        self.assertRegex(written, r"slow\.yaml:\d+:25: node device: .*device\.stale_after is 110 ms")

    def test_what_the_note_says_to_set_is_enough(self):
        for cost in ("125 ms", "330 ms", "600 ms", "1.4 s"):
            for over in ((), ("--over", "local")):
                with self.subTest(cost=cost, over=over):
                    graph = self.graph(f"{{constant: {cost}}}")
                    note = self.note(graph, *over)
                    self.assertIn("device.stale_after", note)
                    # Samples are half a second old at most by default, and a rollout trusts them for two results within its second.
                    self.assertEqual("device.sample_age_max" in note, cost in ("600 ms", "1.4 s"))
                    self.assertEqual("rollout.trust_time_max" in note, bool(over) and cost in ("600 ms", "1.4 s"))
                    self.assertEqual(self.note(graph, *over, *self.remedies(note)), "")

    def test_what_nothing_can_be_set_for_is_said(self):
        note = self.note(self.graph("{constant: 20 s}"))
        self.assertTrue(note.endswith("between results, whatever they are set to; make physics faster"), note)

    def test_the_largest_time_is_the_one_that_the_cost_allows(self):
        self.write("trace.txt", "0.01\n0.12\n0.02\n")
        for collision, dynamics, said in (
                ("{constant: 90 ms}", "none", None),
                ("{constant: 97 ms}", "none", None),
                ("{constant: 98.5 ms}", "none", "98.5 ms by the cost of collision"),  # a result is shown a tick or two later
                ("{constant: 90 ms, jitter: 10 %}", "none", "117 ms by the cost of collision"),  # three standard deviations
                ("{constant: 90 ms, jitter: 10 %, max: 95 ms}", "none", None),
                ("{constant: 10 ms, min: 150 ms}", "none", "150 ms by the cost of collision"),
                ("{base: 6 ms, per_contact: 1 ms, max: 150 ms}", "none", "150 ms by the cost of collision"),
                ("{base: 6 ms, per_contact: 10 ms}", "none", None),  # nobody knows how many contacts
                ("{base: 120 ms, per_contact: 10 ms}", "none", "120 ms by the cost of collision"),
                (f"{{trace: {self.folder / 'trace.txt'}}}", "none", "120 ms by the cost of collision"),
                ("none", "{constant: 120 ms}", "120 ms by the cost of dynamics"),
                ("{constant: 60 ms}", "{constant: 60 ms}", "120 ms by the cost of ")):
            with self.subTest(collision=collision, dynamics=dynamics):
                note = self.note(self.graph(collision, dynamics))
                self.assertEqual(bool(note), said is not None, note)
                self.assertIn(said or "", note)

    def test_a_force_that_needs_no_physics_gets_no_note(self):
        graph = self.graph("{constant: 125 ms}")
        self.assertEqual(self.note(graph, "--over", "rbf"), "")

    def test_the_force_stays_while_slow_physics_lives(self):
        graph = self.graph("{constant: 125 ms, jitter: 5 %}")
        for over in ((), ("--over", "local")):
            with self.subTest(over=over):
                cut = self.run_graph(graph, *over, out="cut")
                self.assertGreater(cut["device"]["stale"], 10)
                note = self.note(graph, *over)
                kept = self.run_graph(graph, *over, *self.remedies(note), out="kept")
                self.assertEqual(kept["device"]["stale"], 0)
                self.assertGreater(kept["device"]["engaged_share"], 0.9)

    @needs_hdf5
    @unittest.skipIf(h5py is None, "h5py is not installed")
    def test_the_force_of_a_rollout_ends_when_its_trust_has_passed_and_a_held_one_at_the_bound(self):
        # Sixteen results, 125 ms each, and then none.
        self.write("dies.txt", "0.125\n" * 16 + "60\n")
        graph = self.graph(f"{{trace: {self.folder / 'dies.txt'}}}", more="  device: {stale_after: 1 s, sample_age_max: 1 s}\n",
                           extra="record: [coupling.force, device.commanded]\n")
        for over, expected in (((), "held"), (("--over", "local"), "rollout")):
            with self.subTest(expected):
                self.run_graph(graph, *over, out=expected)
                with h5py.File(self.folder / expected / "recording.h5") as file:
                    results = file["streams/coupling.force/data"][...]
                    commanded = file["streams/device.commanded/data"][...]
                sample, arrival = results["valid_ns"][-1], results["produced_ns"][-1]
                pushes = [any(row) for row in commanded["force"].tolist()]
                last = commanded["valid_ns"][max(i for i, push in enumerate(pushes) if push)]
                # Each result is about an interval old when it comes; three of them are trusted. A ramp of 100 ms follows.
                end = sample + 375e6 if over else arrival + 1000e6
                self.assertAlmostEqual((last - end) * 1e-6, 100, delta=5)
                self.assertFalse(any(pushes[-300:]))

    def test_a_run_says_it_too(self):
        told = self.run_ok("run", self.graph("{constant: 125 ms}"), "--out", self.folder / "out")
        self.assertIn(NOTE, told.stdout + told.stderr)

    @needs_live
    def test_a_live_graph_is_told_where_it_imposes_its_costs(self):
        graph = self.graph("{constant: 125 ms}")
        self.assertEqual(self.note(graph, "--set", "clock=real"), "")
        self.assertIn(NOTE, self.note(graph, "--set", "clock=real", "--set", "live.impose_cost=true"))


if __name__ == "__main__":
    unittest.main()
