"""bench/transparency.py against scipy's frequency response, a force whose delay is known, and a run."""
import pathlib
import sys
import unittest

import numpy as np
from scipy import signal

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
sys.path.insert(0, str(ROOT / "bench"))
import transparency as t  # noqa: E402


class Transparency(unittest.TestCase):
    def test_what_is_asked_for_is_the_response_of_the_tool_between_spring_and_wall(self):
        k, b, m = t.SPRING, 2 * t.ZETA * np.sqrt(t.SPRING * t.MASS), t.MASS
        c, d = t.WALL * t.TOOL / (t.WALL + t.TOOL), t.CONTACT_DAMPING
        # The tool's position for the handle's: (b s + k) / (m s^2 + (b + d) s + k + c).
        w = 2 * np.pi * np.array([0.1, 3, 30, 100])
        _, tool = signal.freqresp(signal.TransferFunction([b, k], [m, b + d, k + c]), w)
        np.testing.assert_allclose(t.target(w / (2 * np.pi)), (k + 1j * w * b) * (1 - tool), rtol=1e-12)

    def test_a_spring_that_is_late_by_three_ticks_has_its_stiffness_and_that_delay_and_half_a_tick(self):
        n = round(t.PERIOD / t.TICK)
        time = np.arange(-3, n) * t.TICK
        x = t.motion(time, 101)
        found = t.rendered(-800 * x[:-3], x[3:], t.lines())
        w = 2 * np.pi * t.lines() / t.PERIOD
        held = np.sinc(w * t.TICK / (2 * np.pi)) * np.exp(-0.5j * w * t.TICK)
        np.testing.assert_allclose(found, 800 * held * np.exp(-3j * w * t.TICK), rtol=1e-6)

    def test_the_lines_are_odd_harmonics_within_the_band(self):
        self.assertTrue(np.all(t.lines() % 2 == 1))
        self.assertLess(abs(t.lines()[0] / t.PERIOD - 0.1), 0.06)
        self.assertLessEqual(t.lines(36)[-1] / t.PERIOD, 36)

    def test_physics_at_1_khz_gives_a_slow_hand_what_is_asked_for(self):
        found = t.measure_all(60, ("floor",))["floor"]
        magnitude, phase = t.errors(found[36][0])
        slow = t.lines(36) / t.PERIOD < 5
        self.assertLess(np.abs(magnitude[slow]).max(), 0.1)
        self.assertLess(np.abs(phase[slow]).max(), 360 * 5 * 1.6e-3)  # a tick and a half, and a little

    def test_local_gives_what_is_asked_for_to_30_hz_where_steps_and_ticks_are_fine(self):
        [(_, small, _, wider, degrees)] = t.causes(60, ("local, midpoint, 2 kHz",))
        self.assertLess(abs(wider), 1)
        self.assertLess(abs(degrees), 10)
        self.assertLess(abs(small), 3)


if __name__ == "__main__":
    unittest.main()
