"""A ball above a plane as the physics of `tactor bridge graph.yaml`; messages are JSON. Needs python3-websockets."""
import asyncio
import json
import math
import sys

RADIUS, MASS = 0.004, 0.05       # m, kg
STIFFNESS, DAMPING = 2000.0, 2.0  # N/m, N s/m, of the plane
SUBSTEP = 2.5e-4                 # s


class Ball:
    """Implicit Euler: m (v' - v) / dt = k (x_D - x - dt v') + b (v_D - v') + the force of the plane."""

    def __init__(self):
        self.p = None
        self.v = [0.0, 0.0, 0.0]

    def step(self, step):
        begin, end, coupling = step["from"]["p_WD"], step["handle"]["p_WD"], step["coupling"]
        if self.p is None:
            self.p = list(begin)
        span = (step["end"] - step["begin"]) * 1e-9
        count = max(1, math.ceil(span / SUBSTEP))
        dt, push = span / count, 0.0
        for i in range(1, count + 1):
            for axis in range(3):
                handle = begin[axis] + (end[axis] - begin[axis]) * i / count
                speed = (end[axis] - begin[axis]) / span
                k, b = coupling["k_t"], coupling["b_t"]
                pull = k * (handle - self.p[axis]) + b * speed
                resistance = MASS + dt * b + dt * dt * k
                self.v[axis] = (MASS * self.v[axis] + dt * pull) / resistance if axis < 2 else self.v[axis]
                if axis == 2:
                    self.v[2], push = self.above_plane(MASS * self.v[2] + dt * pull, resistance, dt)
                self.p[axis] += dt * self.v[axis]
        return {"type": "result", "id": step["id"],
                "tool": {"p_WT": self.p, "R_WT": [1, 0, 0, 0], "v_WT": self.v, "w_WT": [0, 0, 0]},
                "contact": {"force": [0, 0, push], "torque": [0, 0, 0]}}

    def above_plane(self, momentum, resistance, dt):
        """The speed along z at the end of a sub-step, and the force of the plane, which only pushes."""
        depth = RADIUS - self.p[2]
        speed = (momentum + dt * STIFFNESS * depth) / (resistance + dt * DAMPING + dt * dt * STIFFNESS)
        push = STIFFNESS * (depth - dt * speed) - DAMPING * speed
        return (speed, push) if depth > 0 and push > 0 else (momentum / resistance, 0.0)


async def main(url):
    import websockets

    address, _, token = url.partition("#")
    ball = Ball()
    async with websockets.connect(address, subprotocols=["tactor.bridge", f"token.{token}"]) as bridge:
        async for text in bridge:
            message = json.loads(text)
            if message["type"] == "step":
                try:
                    await bridge.send(json.dumps(ball.step(message)))
                except websockets.ConnectionClosedOK:
                    return  # the run is over
            elif message["type"] == "hello":
                print(message["graph"], "at", message["rate"], "Hz")
            else:
                print(message["field"], message["message"], file=sys.stderr)


if __name__ == "__main__":
    asyncio.run(main(sys.argv[1]))
