"""The standard renderers in graphs: the proxy against constrained minima by scipy, textures against their models' spectra."""
import unittest

import h5py
import numpy
import scipy.linalg
import scipy.optimize
import scipy.signal
import yaml

from harness import GRAPHS, CommandTest, needs_hdf5

RENDERERS = GRAPHS / "renderers"
PLANES = ([0.2, -0.1, 1.0], [1.0, 0.1, 0.35], [-0.3, 1.0, 0.5])  # outward normals, not unit
FIELD = """format: 2
clock: virtual
duration: %(duration)s
scene:
  gravity: [0, 0, 0]
  bodies:
%(bodies)s    tool: {sphere: {radius: 4 mm}, motion: translation, mass: 50 g, pose: {p: [0, 0, 30 mm]}, material: {friction: 0}}
nodes:
  trajectory: {type: source.trajectory, points: [%(points)s]}
  device: {type: device.simulated, encoder_step: 0 m}
  proxy: {type: forcefield.proxy, stiffness: 1000 N/m%(proxy)s}
%(nodes)s
edges:
  - trajectory.target -> device.target
  - device.state -> proxy.device
%(edges)s
record: [device.commanded, device.state, proxy.state]
"""


def rotation_to(normal):
    """The unit quaternion that turns z to the normal, w first."""
    n = numpy.array(normal) / numpy.linalg.norm(normal)
    q = numpy.array([1 + n[2], -n[1], n[0], 0])
    return q / numpy.linalg.norm(q), n


def constrained_minimum(goal, normals, offsets):
    """The point nearest to the goal with normals x >= offsets, in m, by sequential quadratic programming in mm."""
    goal_mm = 1e3 * goal
    found = scipy.optimize.minimize(
        lambda x: (x - goal_mm) @ (x - goal_mm), goal_mm + 30 * normals.sum(axis=0), jac=lambda x: 2 * (x - goal_mm),
        method="SLSQP", constraints={"type": "ineq", "fun": lambda x: normals @ x - 1e3 * offsets, "jac": lambda x: normals},
        options={"ftol": 1e-14, "maxiter": 200})
    return 1e-3 * found.x


def stream(recording, name):
    with h5py.File(recording) as file:
        return file[f"streams/{name}/data"][...]


@needs_hdf5
class Proxy(CommandTest):
    def test_between_oblique_planes_it_is_the_constrained_minimum(self):
        turned = [rotation_to(n) for n in PLANES]
        bodies = "".join(f"    plane{i}: {{plane: {{}}, pose: {{quaternion: [{', '.join(map(repr, map(float, q)))}]}}, "
                         f"material: {{friction: 0}}}}\n" for i, (q, _) in enumerate(turned))
        dice = numpy.random.default_rng(3)
        way = [(0, 8, 8, 30)] + [(0.1 * (k + 1), *dice.uniform(-12, 6, 3)) for k in range(24)]
        points = ", ".join(f"{{t: {t} s, x: {x} mm, y: {y} mm, z: {z} mm}}" for t, x, y, z in way)
        graph = self.write("planes.yaml", FIELD % {
            "duration": "2.4 s", "bodies": bodies, "points": points, "proxy": ", probe: point, force_max: 100 N", "nodes": "",
            "edges": "  - proxy.segment -> device.segment"})
        self.run_graph(graph)
        rows = stream(self.folder / "out/recording.h5", "proxy.state")
        normals = numpy.array([n for _, n in turned])
        touched = set()
        for row in rows[50::40]:
            expected = constrained_minimum(row["p_WD"], normals, numpy.zeros(3))
            self.assertLess(numpy.linalg.norm(row["p_WT"] - expected), 3e-6)
            self.assertLess(numpy.linalg.norm(row["contact_force"] - 1000 * (expected - row["p_WD"])), 3e-3)
            touched.add(int(row["contacts"]))
        self.assertEqual(touched & {1, 2, 3}, {1, 2, 3})


@needs_hdf5
class TexturesOnAWall(CommandTest):
    SPEED, FORCE, MASS = 0.05, 1.0, 0.1

    def slide(self, seed, duration):
        graph = self.write("slide.yaml", FIELD % {
            "duration": "41 s", "bodies": "    wall: {plane: {}, material: {friction: 0}}\n",
            "points": f"{{t: 0 s, x: 0 m, z: 3 mm}}, {{t: 41 s, x: {41 * self.SPEED} m, z: 3 mm}}", "proxy": "",
            "nodes": f"  texture: {{type: effect.texture, file: {RENDERERS / 'textures/grating.yaml'}, mass: {self.MASS} kg}}",
            "edges": "  - proxy.segment -> texture.segment\n  - device.state -> texture.device\n  - texture.segment -> device.segment"})
        self.run_graph(graph, "--seed", seed, "--overwrite", "--set", "trajectory.interpolation=linear", "--duration", duration)
        return stream(self.folder / "out/recording.h5", "device.commanded")["force"]

    def test_spectrum_and_variance_are_the_model_s(self):
        force = self.slide(1, 41)
        added = force[1000:, 2] - self.FORCE
        self.assertLess(numpy.abs(force[1000:, :2]).max(), 1e-9)
        model = yaml.safe_load((RENDERERS / "textures/grating.yaml").read_text())
        entry = next(m for m in model["models"] if m["speed"] == "50 mm/s" and m["force"] == "1 N")
        phi = numpy.array(entry["coefficients"])
        # By the companion matrix: the variance of the state that white noise drives.
        order = len(phi)
        companion = numpy.vstack([phi, numpy.eye(order)[:-1]])
        drive = numpy.zeros((order, order))
        drive[0, 0] = entry["variance"]
        variance = scipy.linalg.solve_discrete_lyapunov(companion, drive)[0, 0] * self.MASS ** 2
        self.assertLess(abs(added.var() / variance - 1), 0.06)
        frequency, measured = scipy.signal.welch(added, 1000, nperseg=500)
        _, response = scipy.signal.freqz([1], numpy.concatenate([[1], -phi]), worN=frequency, fs=1000)
        expected = self.MASS ** 2 * entry["variance"] * numpy.abs(response) ** 2 * 2 / 1000
        band = (frequency >= 10) & (frequency <= 480)
        difference = 10 * numpy.log10(measured[band] / expected[band])
        self.assertLess(numpy.abs(difference).mean(), 0.6)
        self.assertLess(numpy.abs(difference).max(), 3)

    def test_a_run_can_be_made_again_and_another_seed_is_another_surface(self):
        first, again, other = self.slide(1, 2), self.slide(1, 2), self.slide(2, 2)
        self.assertEqual(first.tobytes(), again.tobytes())
        self.assertGreater(numpy.abs(first - other).max(), 1e-3)


@needs_hdf5
class ImpactsInAGrip(CommandTest):
    """A hand behind a grip, against the device's transfer function in closed form, which scipy makes a discrete one of."""
    FREQUENCY, DECAY, AMPLITUDE = 60, 0.01, 0.8  # Hz, s, 1/s
    HAND = {"hand_mass": 0.4, "hand_damping": 5, "hand_stiffness": 150, "grip_stiffness": 900, "grip_damping": 2.5}
    PARTS = {"mass": 0.2, "damping": 0.3, "amplifier_bandwidth": 1100, "mode_frequency": 86, "mode_damping": 0.05, "motor_share": 0.4}

    def accelerations(self, force, mode):
        """m/s^2 of the handle, mean over each tick, by force (N) held over each tick: X(s) = u / D from the impedances."""
        h, p = self.HAND, self.PARTS
        polynomial = numpy.polynomial.Polynomial
        s = polynomial([0, 1])
        grip, hand = h["grip_stiffness"] + h["grip_damping"] * s, h["hand_stiffness"] + h["hand_damping"] * s + h["hand_mass"] * s * s
        # Behind the handle: grip and hand in series, grip hand / (grip + hand).
        load, under = grip * hand, grip + hand
        if mode:
            motor, handle = p["motor_share"] * p["mass"], (1 - p["motor_share"]) * p["mass"]
            turn, reduced = 2 * numpy.pi * p["mode_frequency"], motor * handle / p["mass"]
            link = turn * turn * reduced + 2 * p["mode_damping"] * turn * reduced * s
            first, second = motor * s * s + p["damping"] * s + link, (handle * s * s + link) * under + load
            above, below = link * under, first * second - link * link * under
        else:
            above, below = under, (p["mass"] * s * s + p["damping"] * s) * under + load
        lag = 1 + s * (1 / (2 * numpy.pi * p["amplifier_bandwidth"]))
        velocity = (above * s).coef[::-1], (below * lag).coef[::-1]
        above, below, _ = scipy.signal.cont2discrete(velocity, 1e-3, method="zoh")
        v = scipy.signal.lfilter(above.ravel(), below.ravel(), numpy.append(force, 0))
        return numpy.diff(v) / 1e-3

    def tap(self, *sets):
        """(summary, commanded force, the handle's velocity, N and m/s along z) of a hand that comes down at 0.2 m/s onto next to nothing."""
        graph = self.write("tap.yaml", FIELD % {
            "duration": "0.7 s", "bodies": "    wall: {plane: {}, material: {friction: 0}}\n",
            "points": "{t: 0 s, z: 84 mm}, {t: 1 s, z: -116 mm}", "proxy": "", "nodes": "  impact: {type: effect.impact}",
            "edges": "  - proxy.segment -> impact.segment\n  - device.state -> impact.device\n  - proxy.state -> impact.contact\n"
                     "  - impact.segment -> device.segment"})
        settings = {"trajectory.interpolation": "linear", "proxy.stiffness": 1e-6, "device.loop": "closed", "device.friction": 0, "device.force_slew": 1e6,
                    "impact.frequency": self.FREQUENCY, "impact.decay": self.DECAY, "impact.amplitude": self.AMPLITUDE,
                    **{f"device.{name}": value for name, value in (self.HAND | self.PARTS).items()}}
        words = [f"{name}={value}" for name, value in settings.items()] + list(sets)
        summary = self.run_graph(graph, *(word for text in words for word in ("--set", text)), "--set", "record=[device.commanded, device.truth, proxy.state]",
                                 "--overwrite")
        self.assertEqual((summary["impact"]["events"], summary["impact"]["limited_events"], summary["device"]["slewed_ticks"]), (1, 0, 0))
        rows = {name: stream(self.folder / "out/recording.h5", name) for name in ("device.commanded", "device.truth", "proxy.state")}
        touching = rows["proxy.state"][int(numpy.argmax(rows["proxy.state"]["contacts"] > 0))]
        return summary, rows["device.commanded"]["force"][:, 2], rows["device.truth"]["v_WD"][:, 2], -touching["v_WD"][2]

    def test_match_and_acceleration_are_those_of_the_closed_form(self):
        s = -1 / self.DECAY + 2j * numpy.pi * self.FREQUENCY
        ticks = numpy.arange(61)  # six decays and one
        for mode in (True, False):
            with self.subTest(mode=mode):
                mode_off = [] if mode else ["device.mode_frequency=0"]
                summary, force, velocity, speed = self.tap(*mode_off)
                begin = int(numpy.argmax(numpy.abs(force) > 1e-5))
                wanted = self.AMPLITUDE * speed * (numpy.exp(s * ticks * 1e-3) * (numpy.exp(s * 1e-3) - 1) / s).imag / 1e-3
                made = self.accelerations(force[begin:begin + len(ticks)], mode)
                match = numpy.sqrt(numpy.mean((made - wanted) ** 2) / numpy.mean(wanted ** 2))
                self.assertAlmostEqual(match, summary["impact"]["match_error"], delta=2e-3)
                self.assertLess(match, 0.1)
                silent = self.tap("impact.amplitude=0", *mode_off)[2]
                moved = numpy.diff(velocity - silent)[begin:begin + len(ticks)] / 1e-3
                self.assertLess(numpy.sqrt(numpy.mean((moved - wanted) ** 2) / numpy.mean(wanted ** 2)), 0.1)
                # A model that takes the hand for bolted to the handle is far off.
                _, force, _, _ = self.tap("impact.grip_stiffness=0", "impact.grip_damping=0", *mode_off)
                made = self.accelerations(force[begin:begin + len(ticks)], mode)
                self.assertGreater(numpy.sqrt(numpy.mean((made - wanted) ** 2) / numpy.mean(wanted ** 2)), 0.5)


if __name__ == "__main__":
    unittest.main()
