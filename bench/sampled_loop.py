"""The exact discrete loop of device.simulated, a hand and forcefield.spring, and what theory says of it. Needs numpy and scipy.

The device and the hand are masses in a row, with springs and dampers between (devices/simulated/mass_chain.hpp). Between two samples
the force on the first one is held. So the state goes from one sample to the next by a matrix exponential, and the loop is stable where
its spectral radius is below 1. Nothing here is taken from the C++ code.
"""
import dataclasses
import math

import numpy
from scipy.linalg import expm
from scipy.optimize import brentq


@dataclasses.dataclass(frozen=True)
class Device:
    """SI units, the names of device.simulated. Without `grip_stiffness` and `grip_damping` the hand's mass is bolted to the handle."""
    mass: float = 0.1
    damping: float = 0.2
    hand_mass: float = 0.0
    hand_damping: float = 0.0
    hand_stiffness: float = 0.0
    grip_stiffness: float = 0.0
    grip_damping: float = 0.0
    mode_frequency: float = 0.0
    mode_damping: float = 0.05
    motor_share: float = 0.5

    def chain(self):
        """Masses, and (stiffness, damping) of the links from each to the next, from the motors to the hand."""
        masses, links = [self.mass], []
        if self.mode_frequency > 0:
            motors, handle = self.motor_share * self.mass, (1 - self.motor_share) * self.mass
            reduced, omega = motors * handle / self.mass, 2 * math.pi * self.mode_frequency
            masses, links = [motors, handle], [(omega**2 * reduced, 2 * self.mode_damping * omega * reduced)]
        if self.grip_stiffness > 0 or self.grip_damping > 0:
            masses.append(self.hand_mass)
            links.append((self.grip_stiffness, self.grip_damping))
        else:
            masses[-1] += self.hand_mass
        return masses, links

    def matrices(self):
        """A and B of d/dt (x_1, ..., x_n, v_1, ..., v_n) = A s + B f, with the motors' force f on the first mass and the hand's
        target at rest in 0."""
        masses, links = self.chain()
        n = len(masses)
        stiffness, damping = numpy.zeros((n, n)), numpy.zeros((n, n))
        for i, (k, c) in enumerate(links):
            pair = numpy.ix_([i, i + 1], [i, i + 1])
            stiffness[pair] += k * numpy.array([[1, -1], [-1, 1]])
            damping[pair] += c * numpy.array([[1, -1], [-1, 1]])
        damping[0, 0] += self.damping
        stiffness[-1, -1] += self.hand_stiffness
        damping[-1, -1] += self.hand_damping
        inverse = numpy.diag(1 / numpy.array(masses))
        a = numpy.block([[numpy.zeros((n, n)), numpy.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
        b = numpy.zeros(2 * n)
        b[n] = 1 / masses[0]
        return a, b

    def step(self, period):
        """The same from one sample to the next, the force held."""
        a, b = self.matrices()
        n = len(b)
        whole = numpy.zeros((n + 1, n + 1))
        whole[:n, :n], whole[:n, n] = a, b
        e = expm(whole * period)
        return e[:n, :n], e[:n, n]


def transition(device, period, ticks, stiffness, damping):
    """The loop's matrix. The state: that of the device at sample n, x of sample n - 1, and the forces of samples n - 1 to n - ticks;
    the last one acts from sample n on. `ticks` from a sample to the first command made from it: 0 or more, 1 in Tactor."""
    a, b = device.step(period)
    n = len(b)
    m = numpy.zeros((n + 1 + ticks, n + 1 + ticks))
    force = numpy.zeros(n + 1 + ticks)  # of sample n, a row
    force[0] = -stiffness - damping / period
    force[n] = damping / period
    acts = force if ticks == 0 else numpy.eye(n + 1 + ticks)[-1]
    m[:n, :n] = a
    m[:n] += numpy.outer(b, acts)
    m[n, 0] = 1
    if ticks > 0:
        m[n + 1] = force
        for i in range(1, ticks):
            m[n + 1 + i, n + i] = 1
    return m


def radius(device, period, ticks, stiffness, damping):
    return max(abs(numpy.linalg.eigvals(transition(device, period, ticks, stiffness, damping))))


def limit(device, period, ticks, damping, lowest=1e-2, highest=1e7, steps=400):
    """N/m: the stiffness at which the loop first loses its stability as it grows; 0 where the lowest is not stable."""
    def excess(log):
        return radius(device, period, ticks, math.exp(log), damping) - 1

    logs = numpy.linspace(math.log(lowest), math.log(highest), steps)
    if excess(logs[0]) >= 0:
        return 0.0
    for low, high in zip(logs, logs[1:]):
        if excess(high) >= 0:
            return math.exp(brentq(excess, low, high, xtol=1e-10))
    return math.inf


def passive_limit(b, period, ticks, damping, frequencies=4000):
    """N/m: the largest stiffness with which the sampled wall H(z) = (K + B (1 - 1/z) / T) z^-ticks is passive on a rigid device of the
    damping b, whatever passive hand holds it; 0 where none is. That is, at all frequencies up to half the sampling rate
      b > T / (2 (1 - cos wT)) Re{(1 - e^{-jwT}) H(e^{jwT})}."""
    w = numpy.linspace(0, math.pi, frequencies + 1)[1:]
    z = numpy.exp(1j * w)
    weight = period / (2 * (1 - numpy.cos(w)))
    of_spring = weight * ((1 - 1 / z) * z**-ticks).real
    of_damper = weight * ((1 - 1 / z)**2 / period * z**-ticks).real
    left = b - damping * of_damper
    rising, falling = of_spring > 0, of_spring < 0
    most = float(numpy.min(left[rising] / of_spring[rising]))
    # Where a spring helps, it may have to be stiff enough.
    least = float(numpy.max(left[falling] / of_spring[falling], initial=0.0))
    return most if most > 0 and most >= least else 0.0
