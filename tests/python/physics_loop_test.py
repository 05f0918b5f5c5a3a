"""Physics of a program in Python: what a step has, what a result may be, and that a run is the same each time."""
import math
import time
import unittest

import numpy

from package_harness import PackageTest, needs_live, tactor

MASS, RADIUS, STIFFNESS, DAMPING = 0.05, 4e-3, 2000.0, 2.0
GRAPH = """format: 2
clock: CLOCK
duration: 0.6 s
seed: 1
record: [device.commanded, physics.state]
scene:
  gravity: [0, 0, 0]
  bodies:
    wall: {plane: {}}
    tool: {sphere: {radius: 4 mm}, motion: MOTION, mass: 50 g, pose: {p: [0, 0, 0.02 m]}}
nodes:
  trajectory:
    type: source.trajectory
    interpolation: minimum_jerk
    points: [{t: 0 s, z: 8 mm}, {t: 0.2 s, z: 0 mm}, {t: 0.4 s, z: 2 mm, x: 10 mm}, {t: 0.6 s, z: 10 mm}]
  device: {type: device.simulated}
  coupling: {type: coupling.dynamic}
  physics: {type: physics.external, rate: 100 Hz}
  prediction: {type: prediction.hold}
  interpolation: {type: interpolation.none}
edges:
  - trajectory.target -> device.target
  - device.state -> physics.device
  - coupling.parameters -> physics.coupling
  - physics.state -> coupling.state
  - coupling.force -> prediction.force
  - prediction.forecast -> interpolation.forecast
  - interpolation.segment -> device.segment
  - physics.bodies -> reader.bodies
  - physics.contacts -> reader.contacts
"""
# Somebody reads bodies and contacts, so that a live run records them.
READER = """  reader: {python: 'reader.py:Reader'}
"""
READER_CODE = '''import tactor


class Reader(tactor.Node):
    """Takes what a program tells."""

    bodies = tactor.Input("BodyStates", trigger=True, doc="bodies")
    contacts = tactor.Input("ContactSet", doc="contacts")
    count = tactor.Output("Wrench", doc="how many contacts")

    def step(self, step):
        value = self.count.zeros()
        latest = self.contacts.latest()
        value["force"][0] = 0 if latest is None else int(latest["count"])
        self.count.send(step.now_ns, value)
'''


class Ball:
    """A ball on the plane z = 0, by semi-implicit steps of 50 us, as a user would write it."""

    def __init__(self):
        self.p = self.v = None

    def push(self):
        return numpy.array([0, 0, max(0.0, STIFFNESS * (RADIUS - self.p[2]) - DAMPING * self.v[2])])

    def move(self, step, count=200):
        if self.p is None:
            self.p, self.v = step.handle(step.begin).p_WD.copy(), numpy.zeros(3)
        h = step.h / count
        for i in range(1, count + 1):
            force, _ = step.wrench(self.p, None, self.v, None, MASS, None, h, time=step.begin + i * h)
            self.v = self.v + h / MASS * (force + self.push())
            self.p = self.p + h * self.v

    def contact(self):
        return {"p_WC": [self.p[0], self.p[1], 0], "n_W": [0, 0, 1], "distance": self.p[2] - RADIUS,
                "stiffness": STIFFNESS, "damping": DAMPING}

    def send(self, loop, step):
        loop.result(step, tool={"p_WT": self.p, "v_WT": self.v}, contact=self.push(), contacts=[self.contact()])


class PhysicsTest(PackageTest):
    def graph(self, clock="virtual", motion="translation", reads=False):
        text = GRAPH.replace("CLOCK", clock).replace("MOTION", motion)
        if reads:
            (self.folder / "reader.py").write_text(READER_CODE)
            text = text.replace("edges:\n", READER + "edges:\n").replace("[device.commanded,", "[reader.count, device.commanded,")
        else:
            text = text[:text.index("  - physics.bodies")]
        return self.write("own.yaml", text)


class Loop(PhysicsTest):
    def run_ball(self, work=lambda step: None, **options):
        ball = Ball()
        with tactor.Session(self.graph(**options)) as session:
            state, force = session.tap("physics.state"), session.tap("device.commanded")
            loop = session.physics()
            for step in loop:
                ball.move(step)
                work(step)
                ball.send(loop, step)
        return state.take(), force.take()

    def test_steps_go_from_sample_to_sample(self):
        steps = []
        state, _ = self.run_ball(steps.append)
        numpy.testing.assert_allclose([step.end for step in steps], 0.01 * numpy.arange(1, 60), atol=1e-12)
        numpy.testing.assert_allclose([step.begin for step in steps], 0.01 * numpy.arange(59), atol=1e-12)
        numpy.testing.assert_allclose([step.h for step in steps], 0.01, atol=1e-12)
        self.assertEqual(len(state), 58)
        numpy.testing.assert_array_equal(state["produced_ns"] - state["valid_ns"], 10_000_000)
        numpy.testing.assert_array_equal(state["p_WD"], [step.p_WD for step in steps[:-1]])
        first = steps[0]
        self.assertEqual((first.k_t, first.k_r, first.buttons), (500, 0, 0))
        self.assertAlmostEqual(first.b_t, 2 * math.sqrt(500 * MASS), places=12)
        self.assertEqual([len(value) for value in (first.p_WD, first.R_WD, first.v_WD, first.w_WD)], [3, 4, 3, 3])
        middle = steps[10].handle(steps[10].begin + 0.0025)
        numpy.testing.assert_allclose(middle.p_WD, 0.75 * steps[9].p_WD + 0.25 * steps[10].p_WD, atol=1e-12)
        numpy.testing.assert_array_equal(steps[10].handle().p_WD, steps[10].p_WD)

    def test_a_slow_program_makes_the_same_run(self):
        once, again = self.run_ball(), self.run_ball(lambda step: time.sleep(0.002))
        for a, b in zip(once, again):
            self.assertEqual(a.tobytes(), b.tobytes())

    def test_the_ball_comes_to_rest_where_the_springs_balance(self):
        # The hand rests at z = 2 mm; the coupling of 500 N/m and the wall of 2000 N/m share the depth.
        graph = tactor.load(self.graph(), over={"nodes": {"trajectory": {"points": [{"t": "0 s", "z": "2 mm"}, {"t": "1 s", "z": "2 mm"}]}}})
        ball = Ball()
        with tactor.Session(graph) as session:
            force = session.tap("coupling.force")
            loop = session.physics("physics")
            while (step := loop.next()) is not None:
                ball.move(step)
                ball.send(loop, step)
            self.assertIsNone(loop.next())
        rest = (500 * 2e-3 + STIFFNESS * RADIUS) / (500 + STIFFNESS)
        self.assertAlmostEqual(ball.p[2], rest, places=6)
        self.assertAlmostEqual(force.take()["force"][-1][2], 500 * (rest - 2e-3), places=4)

    def test_forms_of_the_coupling(self):
        with tactor.Session(self.graph(motion="rigid")) as session:
            step = session.physics().next()
        h, k, b = 1e-3, step.k_t, step.b_t
        self.assertGreater(step.k_r, 0)
        self.assertEqual(step.implicit_spring(), (step.k_t, step.b_t, step.k_r, step.b_r))
        self.assertAlmostEqual(step.implicit_spring(h).b_t, b + h * k, places=12)
        soft = step.erp_cfm(h)
        self.assertAlmostEqual(soft.erp_t, h * k / (h * k + b), places=12)
        self.assertAlmostEqual(soft.cfm_t, 1 / (h * k + b), places=12)
        still = {"R_WT": [1, 0, 0, 0], "v_WT": [0, 0, 0], "w_WT": [0, 0, 0]}
        inertia = numpy.diag([3e-5, 1e-5, 2e-5])
        force, torque = step.wrench(step.p_WD - [1e-3, 0, 0], still["R_WT"], step.v_WD, step.w_WD, MASS, inertia, 1e-4)
        numpy.testing.assert_allclose(force, [k * 1e-3, 0, 0], atol=1e-9)
        numpy.testing.assert_allclose(torque, 0, atol=1e-9)
        longest = (math.sqrt(b * b + 4 * k * MASS) - b) / k
        step.wrench(step.p_WD, None, step.v_WD, None, MASS, None, 0.999 * longest)
        for options in ({"mass": MASS, "inertia": None, "h": 1.001 * longest}, {"mass": MASS, "inertia": 1e-9, "h": 1e-3}):
            self.assertIn("too stiff for an explicit force", self.refused(tactor.InputError, step.wrench, step.p_WD, **still, **options))
        self.assertIn("inertia", self.refused(tactor.InputError, step.wrench, step.p_WD, **still, mass=MASS, inertia=[1, 2], h=1e-4))
        self.assertIn("p_WT: expected 3 numbers", self.refused(tactor.InputError, step.wrench, [1, 2], **still, mass=MASS, inertia=None, h=1e-4))
        self.assertIn("h: expected", self.refused(tactor.InputError, step.erp_cfm, 0))


class Results(PhysicsTest):
    GOOD = {"p_WT": [0, 0, 0.003], "v_WT": [0, 0, 0]}
    TOUCH = {"p_WC": [0, 0, 0], "n_W": [0, 0, 1], "distance": -1e-3, "stiffness": 1000}

    def test_what_does_not_fit_is_told_by_its_name_and_not_sent(self):
        good, touch = self.GOOD, self.TOUCH
        cases = [
            ({"tool": {"p_WT": [0, 0, 0]}}, "tool: .*found none named v_WT"),
            ({"tool": [0, 0, 0]}, "tool: expected a mapping with p_WT"),
            ({"tool": {**good, "R_WT": [1, 0, 0, 0]}}, "tool: .*none named w_WT"),
            ({"tool": {**good, "q": 1}}, "tool: .*found a field q"),
            ({"tool": {**good, "p_WT": [0, 0]}}, r"tool\.p_WT: expected 3 numbers"),
            ({"tool": {**good, "p_WT": [0, 0, "x"]}}, r"tool\.p_WT: expected 3 numbers"),
            ({"tool": {**good, "p_WT": [0, 0, math.nan]}}, r"tool\.p_WT: expected finite"),
            ({"tool": {**good, "R_WT": [1, 1, 0, 0], "w_WT": [0, 0, 0]}}, r"tool\.R_WT: .*length 1"),
            ({"tool": good, "felt": [1, 2]}, "felt: expected force and torque"),
            ({"tool": good, "felt": {"torque": [1, 2, 3]}}, "felt: .*none named force"),
            ({"tool": good, "contact": [0, 0, math.inf]}, r"contact\.force: expected finite"),
            ({"tool": good, "contacts": [{**touch, "n_W": [0, 0, 2]}]}, r"contacts\[0\]\.n_W: expected a normal"),
            ({"tool": good, "contacts": [touch, {**touch, "stif": 1}]}, r"contacts\[1\]: .*found a field stif"),
            ({"tool": good, "contacts": [{"n_W": [0, 0, 1], "distance": 0}]}, r"contacts\[0\]: .*none named p_WC"),
            ({"tool": good, "contacts": [{**touch, "friction": -1}]}, r"contacts\[0\]\.friction: expected 0 or more"),
            ({"tool": good, "contacts": [{**touch, "body": 1}]}, r"contacts\[0\]\.body: expected a moving body"),
            ({"tool": good, "contacts": [{**touch, "other": 0}]}, r"contacts\[0\]\.other"),
            ({"tool": good, "contacts": [{**touch, "body": 0.5}]}, r"contacts\[0\]\.body: expected a whole number"),
            ({"tool": good, "contacts": [touch] * 129}, "contacts: expected at most 128 of them, found 129"),
            ({"tool": good, "contacts": [{**touch, "inertia": -1}]}, r"contacts\[0\]\.inertia: expected 0 or more"),
            ({"tool": good, "contacts": [{**touch, "p_TC": [0, 0, 0]}]}, r"contacts\[0\]\.p_TC: .*-0\.004 m in the body's frame"),
            ({"tool": good, "contacts": [{**touch, "p_WC": [0, math.nan, 0]}]}, r"contacts\[0\]\.p_WC: expected finite"),
            ({"tool": good, "bodies": [{"p_WB": good["p_WT"], "v_WB": [0, 0, 1]}]}, r"bodies\[0\]: expected the pose and velocity"),
            ({"bodies": [{"p_WB": [0, 0, 0], "v_WB": [0, 0, 0]}] * 2}, "bodies: .*which are 1, found 2"),
            ({"bodies": []}, "bodies: .*found 0"),
            ({"contacts": [touch]}, "tool: expected a pose, because contacts"),
            ({}, "tool: expected a pose, or a wrench"),
            ({"tool": good, "time": 3}, "time: expected .*found 3 s"),
            ({"tool": good, "time": "3 kg"}, "time"),
        ]
        with tactor.Session(self.graph()) as session:
            state = session.tap("physics.state")
            loop = session.physics()
            step = loop.next()
            for given, said in cases:
                with self.subTest(said):
                    self.assertRegex(self.refused(tactor.InputError, loop.result, step, **given), said)
            loop.result(step, tool=good)
            loop.next()
            self.assertEqual(len(state.take()), 1)

    def test_a_result_may_be_short_or_whole(self):
        with tactor.Session(self.graph(reads=True)) as session:
            taps = {name: session.tap("physics." + name) for name in ("state", "bodies", "contacts", "force")}
            loop = session.physics()
            step = loop.next()
            body = {"p_WB": [0, 0, 3e-3], "v_WB": [0, 0, 0.1], "R_WB": numpy.array([0.6, 0, 0, 0.8]), "w_WB": numpy.zeros(3)}
            loop.result(step, bodies=[body], felt={"force": [1, 2, 3], "torque": [4, 5, 6]}, contact=[0, 0, 1, 0, 0, 2],
                        contacts=[{**self.TOUCH, "p_WC": [0.002, 0, 0]}], time=step.end - 0.5e-3)
            loop.result(step, tool=self.GOOD, contacts=[])
            loop.next()
            messages = {name: tap.take() for name, tap in taps.items()}
        self.assertEqual({name: len(found) for name, found in messages.items()}, {"state": 2, "bodies": 2, "contacts": 2, "force": 1})
        state, contacts = messages["state"], messages["contacts"]
        numpy.testing.assert_array_equal(state["valid_ns"], [9_500_000, 10_000_000])
        numpy.testing.assert_allclose(state["R_WT"][0], [0.6, 0, 0, 0.8])
        numpy.testing.assert_array_equal(state["damped"], [0, 1])
        numpy.testing.assert_array_equal(messages["force"]["torque"][0], [4, 5, 6])
        numpy.testing.assert_array_equal(contacts["count"], [1, 0])
        found = contacts["contact"][0][0]
        self.assertEqual((found["weight"], found["stiffness"], found["friction"]), (1, 1000, 0))
        # The tool's point lies 1 mm below the wall's; the tool is turned by 2 atan2(0.8, 0.6) about z.
        turn = -2 * math.atan2(0.8, 0.6)
        numpy.testing.assert_allclose(found["p_TC"], [0.002 * math.cos(turn), 0.002 * math.sin(turn), -0.004], atol=1e-12)

    def test_a_tool_that_turns_needs_its_rotation(self):
        with tactor.Session(self.graph(motion="rigid")) as session:
            loop = session.physics()
            step = loop.next()
            self.assertRegex(self.refused(tactor.InputError, loop.result, step, tool=self.GOOD), r"tool\.R_WT: expected a rotation")
            body = {"p_WB": [0, 0, 0], "v_WB": [0, 0, 0]}
            self.assertRegex(self.refused(tactor.InputError, loop.result, step, bodies=[body]), r"bodies\[0\]\.R_WB: expected a rotation")
            loop.result(step, tool={**self.GOOD, "R_WT": [1, 0, 0, 0], "w_WT": [0, 0, 0]})

    def test_contacts_that_the_graph_reads_are_told(self):
        with tactor.Session(self.graph(reads=True)) as session:
            loop = session.physics()
            step = loop.next()
            self.assertIn("contacts: expected a list", self.refused(tactor.InputError, loop.result, step, tool=self.GOOD))
            loop.result(step, tool=self.GOOD, contacts=[])

    def test_a_node_has_one_loop(self):
        with tactor.Session(self.graph()) as session, tactor.Session(self.graph()) as other:
            loop = session.physics()
            self.assertIs(session.physics("physics"), loop)
            loop.next()
            foreign = other.physics().next()
            self.assertIn("step: expected a step of this loop", self.refused(tactor.InputError, loop.result, foreign, tool=self.GOOD))

    def test_misuse_is_told(self):
        self.assertIn("no node of type physics.external", self.refused(tactor.InputError, lambda: tactor.Session("wall/scene").physics()))
        session = tactor.Session(self.graph())
        self.assertIn("no node physic ", self.refused(tactor.InputError, session.physics, "physic"))
        loop = session.physics()
        step = loop.next()
        session.finish()
        self.assertIsNone(loop.next())
        self.assertIn("finished", self.refused(tactor.RunError, loop.result, step, tool=self.GOOD))
        self.assertIn("finished", self.refused(tactor.RunError, session.physics))
        del session
        self.assertIn("gone", self.refused(tactor.RunError, loop.next))

    def test_without_a_coupling_the_program_says_what_is_felt(self):
        text = (self.graph()).read_text()
        for old, new in (("coupling.force -> prediction", "physics.force -> prediction"), ("  - coupling.parameters -> physics.coupling\n", ""),
                         ("  - physics.state -> coupling.state\n", "")):
            self.assertIn(old, text)
            text = text.replace(old, new)
        with tactor.Session(self.write("felt.yaml", text)) as session:
            force = session.tap("device.commanded")
            loop = session.physics()
            for step in loop:
                self.assertIn("physics.coupling", self.refused(tactor.InputError, step.erp_cfm, 1e-3))
                loop.result(step, felt=[0, 0, 0.5])
        self.assertAlmostEqual(force.take()["force"][-1][2], 0.5, places=9)
        with tactor.Session(self.folder / "felt.yaml") as session:
            loop = session.physics()
            self.assertIn("felt: expected a wrench", self.refused(tactor.InputError, loop.result, loop.next(), tool=self.GOOD))


@needs_live
class Live(PhysicsTest):
    def test_a_stall_is_late_physics(self):
        ball, steps = Ball(), []
        with tactor.Session(self.graph("real")) as session:
            loop = session.physics()
            for step in loop:
                steps.append(step)
                ball.move(step)
                if len(steps) == 10:
                    time.sleep(0.15)
                ball.send(loop, step)
        self.assertGreater(len(steps), 11)
        self.assertGreater(steps[10].h, 0.1)
        for before, after in zip(steps, steps[1:]):
            self.assertEqual(before.end, after.begin)


if __name__ == "__main__":
    unittest.main()
