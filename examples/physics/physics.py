"""Physics of our own: a ball on a plane, which the hand of graph.yaml feels.

    /usr/bin/python3 physics.py            # the force held
    /usr/bin/python3 physics.py local      # a method laid over the graph
"""
import pathlib
import sys

import numpy as np
import tactor

HERE = pathlib.Path(__file__).resolve().parent
SUBSTEP = 2.5e-4  # s


class Ball:
    """A ball on the plane z = 0, by semi-implicit Euler steps. The plane is a spring and damper with friction."""

    mass, radius = 0.05, 4e-3  # kg, m: as in the graph
    stiffness, damping, friction = 2000.0, 2.0, 0.1  # N/m, N s/m, Coulomb coefficient

    def __init__(self) -> None:
        self.p = self.v = self.force = np.zeros(3)  # m, m/s, N of the plane
        self.begun = False

    def move(self, step: tactor.PhysicsStep) -> None:
        """From the sample of the handle at `step.begin` to that at `step.end`."""
        if not self.begun:
            self.p, self.begun = step.handle(step.begin).p_WD, True
        count = int(np.ceil(step.h / SUBSTEP))
        h = step.h / count
        for i in range(1, count + 1):
            pull, _ = step.wrench(self.p, None, self.v, None, self.mass, None, h, time=step.begin + i * h)
            self.force = self.contact_force()
            self.v = self.v + h / self.mass * (pull + self.force)
            self.p = self.p + h * self.v

    def contact_force(self) -> np.ndarray:
        normal = max(0.0, self.stiffness * (self.radius - self.p[2]) - self.damping * self.v[2])
        slip = self.v * [1, 1, 0]
        return np.array([0, 0, normal]) - self.friction * normal * slip / max(float(np.linalg.norm(slip)), 1e-3)

    def contacts(self) -> list:
        """Told before they touch, so that a method knows them in time."""
        return [{"p_WC": self.p * [1, 1, 0], "n_W": [0, 0, 1], "distance": self.p[2] - self.radius,
                 "stiffness": self.stiffness, "damping": self.damping, "friction": self.friction}]


def run(method: str = "hold", rate: float = 60.0):
    """The displayed force and that of physics, each as times (s) and forces (N, rows of 3)."""
    over = [] if method == "hold" else [method]
    graph = tactor.load(HERE / "graph.yaml", over=over, set={"physics.rate": rate})
    ball = Ball()
    with tactor.Session(graph) as session:
        displayed, felt = session.tap("device.commanded"), session.tap("coupling.force")
        loop = session.physics()
        for step in loop:
            ball.move(step)
            loop.result(step, tool={"p_WT": ball.p, "v_WT": ball.v}, contact=ball.force, contacts=ball.contacts())
    return [(messages.time, messages["force"]) for messages in (displayed.take(), felt.take())]


def main() -> None:
    method = sys.argv[1] if len(sys.argv) > 1 else "hold"
    (time, force), _ = run(method)
    size = np.linalg.norm(force, axis=1)
    print(f"{method}: {len(time)} forces, {size.mean():.3f} N on average, {size.max():.3f} N at most")


if __name__ == "__main__":
    main()
