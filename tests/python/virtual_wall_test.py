"""The simulated device, a hand with a grip and forcefield.spring make the loop that scipy computes on its own."""
import sys
import unittest

from package_harness import ROOT, PackageTest, tactor

try:
    import numpy
    import scipy.integrate
except ImportError:
    print("python3-scipy is not installed")
    sys.exit(77)

sys.path.insert(0, str(ROOT / "bench"))
import sampled_loop  # noqa: E402
import virtual_wall  # noqa: E402

HAND = {"hand_mass": 0.2, "hand_damping": 0.5, "hand_stiffness": 135.0}
GRIP = {"grip_stiffness": 900.0, "grip_damping": 0.8}
MODE = {"mode_frequency": 80.0, "mode_damping": 0.02}
DEVICES = {"bare": {"damping": 2.0}, "bolted": {**HAND}, "gripped": {**HAND, **GRIP}, "gripped, with a mode": {**HAND, **GRIP, **MODE}}


class Loop(PackageTest):
    def test_the_handle_moves_as_the_matrix_exponential_of_the_whole_says(self):
        for name, values in DEVICES.items():
            with self.subTest(device=name):
                device = sampled_loop.Device(**values)
                found = tactor.run("virtual_wall/linear", taps=["device.truth", "device.commanded"], without_reference=True,
                                   set=virtual_wall.settings(device, 1e-3, 1) | {"duration": 0.4, "wall.stiffness": 300.0,
                                                                                "wall.damping": 0.5, "wall.position": 1e-3}).taps
                x, force = found["device.truth"]["p_WD"][:, 2] - virtual_wall.START, found["device.commanded"]["force"][:, 2]
                self.assertGreater(numpy.ptp(force), 0.05)
                a, b = device.step(1e-3)
                handle = 1 if "mode_frequency" in values else 0
                state, expected = numpy.zeros(len(b)), [0.0]
                # The line delays each command by a tick.
                for command in [0.0, *force[:-2]]:
                    state = a @ state + b * command
                    expected.append(state[handle])
                self.assertGreater(max(expected), 1e-4)
                numpy.testing.assert_allclose(x, expected, rtol=0, atol=1e-12)

    def test_the_stiffest_stable_wall_is_where_the_loop_has_its_eigenvalue_on_the_unit_circle(self):
        # The other combinations: bench/virtual_wall.py.
        for name, period, lines, damping in (("bare", 1e-3, 0, 0.0), ("bare", 0.25e-3, 3, 0.8), ("bolted", 4e-3, 0, 0.8),
                                             ("gripped", 1e-3, 1, 0.4), ("gripped, with a mode", 0.5e-3, 0, 0.2)):
            with self.subTest(device=name, period=period, lines=lines, damping=damping):
                device = sampled_loop.Device(**DEVICES[name])
                exact = sampled_loop.limit(device, period, lines + 1, damping)
                self.assertGreater(exact, 10)
                found = virtual_wall.measured(device, period, lines, damping)
                self.assertLess(abs(found / exact - 1), 0.02, (found, exact))


class Theory(unittest.TestCase):
    def test_without_delay_a_wall_is_passive_up_to_two_dampings_by_the_period(self):
        for b, damping in ((2, 0), (2, 0.5), (2, -0.5)):
            self.assertAlmostEqual(sampled_loop.passive_limit(b, 1e-3, 0, damping) * 1e-3 / 2 / (b - abs(damping)), 1, delta=1e-5)

    def test_a_wall_that_is_passive_is_stable_in_every_hand(self):
        passive = sampled_loop.passive_limit(2, 1e-3, 1, 0.3)
        for mass in (1e-3, 0.03, 1):
            for spring in (0, 1e2, 1e4):
                for grip in (0, 1e2, 1e4):
                    device = sampled_loop.Device(damping=2, hand_mass=mass, hand_stiffness=spring, grip_stiffness=grip)
                    self.assertLess(sampled_loop.radius(device, 1e-3, 1, 0.99 * passive, 0.3), 1 + 1e-12, device)

    def test_a_small_delay_bears_the_dampings_by_the_delay_and_half_the_period(self):
        heavy = sampled_loop.Device(mass=10, damping=2)
        for ticks in (1, 2, 5):
            self.assertAlmostEqual(sampled_loop.limit(heavy, 1e-3, ticks, 0.5) * 1e-3 * (ticks + 0.5) / 2.5, 1, delta=2e-3)


if __name__ == "__main__":
    unittest.main()
