#!/usr/bin/python3
"""Draws scenes of every kind that a local model may fail on: `make.py FOLDER [--seed N] [--meshes FOLDER] [--kind NAME]`.

A kind is a function that draws sizes, materials, rates and a motion by a generator of its own, seeded by the seed and the kind's
name: a new kind changes no other. Scenes go to FOLDER as graphs that extend base.yaml beside this file, meshes to their folder.
The scenes beside this file are the draw of seed 1, at which methods may be looked at while they are developed. Pages of results take
another draw.
"""
import argparse
import math
import pathlib
import random
import sys

import shapes

HERE = pathlib.Path(__file__).resolve().parent
KINDS = {}
WARM = 130  # physics results until the slowest of the compared methods serves


def kind(title):
    def register(function):
        KINDS[function.__name__] = (title, function)
        return function

    return register


class Draw(random.Random):
    def log(self, low, high):
        """Evenly over the logarithm."""
        return math.exp(self.uniform(math.log(low), math.log(high)))

    def way(self):
        """A direction in the plane."""
        a = self.uniform(0, 2 * math.pi)
        return math.cos(a), math.sin(a)


class Path:
    """Way-points of the hand's target, in mm. A force is a depth: that of spring and contact in series."""

    def __init__(self, height, stiffness, at=(0.0, 0.0), clear=8.0):
        self.height, self.stiffness, self.clear = height, stiffness, clear  # (x, y) in m -> m; N/mm
        self.x, self.y = at
        self.t, self.turn = 0.0, (0.0, 0.0, 0.0)
        self.points = []
        self.go(0.0, -clear, depth=False)
        self.go(0.3, -clear, depth=False)

    def above(self):
        """Where a tool touches below or above the target, in mm; where there is nothing, as at the last place."""
        found = self.height(1e-3 * self.x, 1e-3 * self.y)
        if found is not None:
            self.last = 1e3 * found
        return self.last

    def go(self, seconds, newton, x=None, y=None, turn=None, depth=True):
        """To a place where the target presses with that force; without `depth` the number is mm below where it touches."""
        self.x, self.y = (self.x if x is None else x), (self.y if y is None else y)
        self.turn = self.turn if turn is None else turn
        self.t += seconds
        self.points.append((self.t, self.x, self.y, self.above() - (newton / self.stiffness if depth else newton), *self.turn))
        return self

    def press(self, newton, seconds=0.3, hold=0.2):
        return self.go(seconds, newton).go(hold, newton)

    def slide(self, x, y, newton, speed):
        """In steps of about 2 mm along the surface, at mm/s."""
        fx, fy, length = self.x, self.y, math.hypot(x - self.x, y - self.y)
        n = max(1, round(length / 2))
        for i in range(1, n + 1):
            self.go(length / n / speed, newton, fx + (x - fx) * i / n, fy + (y - fy) * i / n)
        return self

    def lift(self, seconds=0.2):
        return self.go(seconds, -self.clear, depth=False)

    def taps(self, count, newton, up=3.0, seconds=0.12):
        for _ in range(count):
            self.go(seconds, -up, depth=False).go(seconds, newton)
        return self

    def text(self, rigid):
        rows = []
        for t, x, y, z, *turn in self.points:
            more = "".join(f", r{axis}: {value:.4g} deg" for axis, value in zip("xyz", turn)) if rigid else ""
            rows.append(f"      - {{t: {t:.4f} s, x: {x:.4f} mm, y: {y:.4f} mm, z: {z:.4f} mm{more}}}")
        return "\n".join(rows)


class Scene:
    """What a kind draws, with what is ordinary where it draws nothing."""

    def __init__(self, draw, name):
        self.draw, self.name = draw, name
        self.stiffness = draw.log(0.5, 5)  # N/mm, of the contact
        self.friction = draw.uniform(0, 0.6)
        self.coupling = draw.log(0.2, 2)  # N/mm
        self.mass = draw.log(20, 150)  # g
        self.rate = draw.log(20, 150)  # Hz, of physics in contact
        self.jitter = draw.choice((0, 10, 30))  # %
        self.encoder = draw.log(2, 30)  # um
        self.tremor = (0.05, 8, 12)  # mm, Hz
        self.force_max = 8  # N
        self.gravity = (0, 0, 0)
        self.margin = 2.0  # mm
        self.spacing = None  # mm
        self.rigid = False
        self.bodies, self.meshes, self.path = [], {}, None
        self.tool_shape = None

    def mesh(self, role, mesh):
        """Keeps a mesh; the text that names it."""
        file = f"{self.name}_{role}.off"
        self.meshes[file] = mesh
        return f"mesh: transfer/{file}"

    def body(self, name, shape, stiffness=None, more=""):
        self.bodies.append((name, shape, 2 * (stiffness or self.stiffness), more))

    def tool(self, shape, at=(0, 0, 0)):
        self.tool_shape = shape
        self.at = at

    def hand(self, height, at=(0.0, 0.0), clear=8.0, stiffness=None):
        """The path of the hand, which presses through coupling and contact."""
        k = stiffness or self.stiffness
        self.path = Path(height, 1 / (1 / self.coupling + 1 / k), at, clear)
        return self.path

    def text(self, seed):
        material = "material: {{stiffness: {k:.4g} N/mm, damping: {b:.4g} N s/m, friction: {mu:.3f}}}"
        bodies = "".join(f"    {name}:\n      {shape}\n      {material.format(k=k, b=k, mu=self.friction)}\n{more}"
                         for name, shape, k, more in self.bodies)
        x, y, z = self.path.points[0][1:4]
        end = self.path.points[-1][0]
        lasts = max(8.0, end + WARM / self.rate)
        turning = f"    k_r: {max(0.1, self.coupling):.4g} N m/rad\n" if self.rigid else ""
        spacing = f"    spacing: {self.spacing:.4g} mm\n" if self.spacing else ""
        # The gate's bound of 0.1 s is four of its results; slower physics states its own.
        slow = f"    stale_after: {4 / self.rate:.3g} s\n" if self.rate < 40 else ""
        return f"""# Drawn by make.py --seed {seed}; do not edit.
format: 2
title: {KINDS[self.name][0]}
extends: {self.base}
duration: {lasts:.3g} s

scene:
  gravity: [{", ".join(f"{g:.4g}" for g in self.gravity)}]
  tool: tool
  bodies:
{bodies}    tool:
      {self.tool_shape}
      motion: {"rigid" if self.rigid else "translation"}
      mass: {self.mass:.4g} g
      pose: {{p: [{x:.4f} mm, {y:.4f} mm, {z:.4f} mm]}}
      {material.format(k=2 * self.stiffness, b=2 * self.stiffness, mu=self.friction)}

nodes:
  trajectory:
    tremor_amplitude: {self.tremor[0]:.3g} mm
    tremor_low: {self.tremor[1]:.3g} Hz
    tremor_high: {self.tremor[2]:.3g} Hz
    repeat_after: {end + 0.2:.4f} s
    points:
{self.path.text(self.rigid)}
  device:
    encoder_step: {self.encoder:.3g} um
    encoder_step_angle: {self.encoder * 5e-4:.3g} deg
    force_max: {self.force_max:.3g} N
{slow}  collision:
    margin: {self.margin:.3g} mm
{spacing}    cost: {{constant: {1e3 / self.rate:.4g} ms, jitter: {self.jitter} %, min: {500 / self.rate:.4g} ms, max: {2000 / self.rate:.4g} ms}}
  dynamics: {{type: {"dynamics.rigid" if self.rigid else "dynamics.translation"}}}
  coupling:
    k_t: {self.coupling:.4g} N/mm
{turning}    force_max: {self.force_max:.3g} N
"""


def flat(radius_mm):
    return lambda x, y: 1e-3 * radius_mm


def bumps(draw, count, size, slowest=2.0, fastest=5.0):
    """Waves of a blob, whose amplitudes together are `size` of its radius."""
    waves = []
    for _ in range(count):
        d = [draw.gauss(0, 1) for _ in range(3)]
        norm = math.sqrt(sum(x * x for x in d))
        waves.append((size / count, [x / norm for x in d], draw.uniform(slowest, fastest), draw.uniform(0, 6.3)))
    return waves


def wander(path, draw, reach, force, speed, legs=6):
    """Slides between places within `reach` mm, with a press and taps between."""
    for leg in range(legs):
        path.slide(draw.uniform(-reach, reach), draw.uniform(-reach, reach), draw.uniform(0.5, 1) * force, speed)
        if leg % 3 == 1:
            path.press(force)
        if leg % 3 == 2:
            path.taps(2, 0.6 * force)
    return path.lift()


@kind("a small ball over fine waves")
def waves(s, d):
    length = d.uniform(2, 4)
    height = length * d.uniform(0.06, 0.12)
    angle = d.uniform(0, math.pi)
    mesh = shapes.height_field(0.03, 96, 0.005, lambda x, y: 5e-4 * height * math.cos(
        2e3 * math.pi / length * (x * math.cos(angle) + y * math.sin(angle))))
    radius = d.uniform(0.6, 1.2)
    s.body("plate", s.mesh("plate", mesh))
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    wander(s.hand(shapes.Heights(mesh, shapes.ball(1e-3 * radius)).touch).press(1), d, 11, d.uniform(0.5, 1.5), d.uniform(20, 60))


@kind("a cube slides over the edges of another")
def cube_edges(s, d):
    s.rigid = True
    a, b = d.uniform(20, 35), d.uniform(8, 16)
    fixed, tool = (shapes.box(*(1e-3 * x,) * 3) for x in (a, b))
    s.body("cube", s.mesh("cube", fixed))
    s.tool(s.mesh("tool", tool))
    path = s.hand(shapes.Heights(fixed, tool).touch).press(1)
    for _ in range(4):
        ux, uy = d.way()
        path.slide(ux * 0.55 * a, uy * 0.55 * a, d.uniform(0.5, 2), d.uniform(30, 80))
        path.go(0.3, d.uniform(0.5, 1.5), turn=[d.uniform(-15, 15) for _ in "xyz"])
        path.slide(-ux * 0.2 * a, -uy * 0.2 * a, d.uniform(0.5, 2), d.uniform(30, 80))
    path.lift()


@kind("a ball along walls into corners")
def corners(s, d):
    radius = d.uniform(2, 5)
    s.body("floor", "plane: {}")
    s.body("left", "box: {size: [20 mm, 120 mm, 60 mm]}", more="      pose: {p: [-30 mm, 0 mm, 20 mm]}\n")
    s.body("back", "box: {size: [120 mm, 20 mm, 60 mm]}", more="      pose: {p: [0 mm, 30 mm, 20 mm]}\n")
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    path = s.hand(flat(radius)).press(1)
    deep = d.uniform(0.5, 1.5) / path.stiffness  # mm into the side walls
    for _ in range(3):
        speed = d.uniform(60, 150)
        path.slide(-20 + radius + deep, d.uniform(-10, 10), d.uniform(0.5, 2), speed)
        path.slide(-20 + radius - deep, 20 - radius + deep, d.uniform(0.5, 2), speed)
        path.slide(d.uniform(-5, 10), 20 - radius + deep, d.uniform(0.5, 2), speed)
        path.slide(0, 0, 1, speed).lift()
        path.go(0.2, 1)
    path.lift()


@kind("a ball up and down stairs")
def stairs(s, d):
    tread, rise = d.uniform(4, 8), d.uniform(0.5, 2)
    mesh = shapes.stairs(5, 1e-3 * tread, 1e-3 * rise, 0.03)
    radius = d.uniform(1.5, 4)
    s.body("stairs", s.mesh("stairs", mesh))
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    reach = 2 * tread
    path = s.hand(shapes.Heights(mesh, shapes.ball(1e-3 * radius)).touch, at=(-reach, 0)).press(1)
    for end in (1, -1, 1, -1):
        path.slide(end * reach, d.uniform(-8, 8), d.uniform(0.4, 1.5), d.uniform(20, 120))
    path.lift()


@kind("a fast sweep over the tips of a star")
def star_sweep(s, d):
    tips, r_out = d.randint(5, 9), d.uniform(18, 28)
    r_in, radius = r_out * d.uniform(0.45, 0.7), d.uniform(2, 4)
    mesh = shapes.star(tips, 1e-3 * r_in, 1e-3 * r_out, 8e-3)
    s.body("star", s.mesh("star", mesh))
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    path = s.hand(lambda x, y: 0.0, at=(r_out + radius + 6, 0), clear=0)
    speed, begin = d.uniform(200, 500), d.uniform(0, 6.3)
    for lap in range(4):
        way = r_out + radius - d.uniform(0.3, 1.2) / path.stiffness
        direction = 1 if lap % 2 == 0 else -1
        n = 90
        for i in range(n + 1):
            a = begin + direction * 2 * math.pi * i / n
            path.go(0.3 if i == 0 else 2 * math.pi * way / n / speed, 0, way * math.cos(a), way * math.sin(a))
        path.go(0.15, 0, (r_out + radius + 6) * math.cos(begin), (r_out + radius + 6) * math.sin(begin))
    path.go(0.3, 0, r_out + radius + 6, 0)


@kind("a thin wall is poked, and poked through")
def thin_wall(s, d):
    thick, radius = d.uniform(0.6, 1.6), d.uniform(1.5, 3.5)
    s.stiffness = d.log(0.5, 2)
    mesh = shapes.box(0.04, 0.04, 1e-3 * thick)
    s.body("wall", s.mesh("wall", mesh))
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    path = s.hand(flat(radius + thick / 2))
    enough = 0.5 * thick * s.stiffness  # the force at which the middle is reached
    for _ in range(3):
        path.go(0.2, 0.5 * enough, d.uniform(-10, 10), d.uniform(-10, 10)).slide(d.uniform(-10, 10), d.uniform(-10, 10), 0.6 * enough, 50)
        path.go(0.3, 1.3 * (enough + 0.3)).go(0.1, 1.3 * (enough + 0.3)).go(0.3, thick + 2 * radius + 4, depth=False)
        path.go(0.2, thick + 2 * radius + 4, depth=False).go(0.5, -4, depth=False)
    path.lift()


@kind("a knot over a knot")
def knots(s, d):
    s.rigid, s.rate = True, d.log(18, 60)
    fixed, tool = (shapes.knot(2, d.choice((3, 5)), r, t) for r, t in ((0.025, 5e-3), (0.016, 3.5e-3)))
    s.body("knot", s.mesh("knot", fixed))
    s.tool(s.mesh("tool", tool))
    path = s.hand(shapes.Heights(fixed, tool).touch).press(1.5)
    for _ in range(4):
        path.slide(d.uniform(-12, 12), d.uniform(-12, 12), d.uniform(0.5, 2), d.uniform(20, 60))
        path.go(0.4, 1, turn=[d.uniform(-20, 20) for _ in "xyz"])
    path.lift()


@kind("a gear turned in the teeth of another, a stiff coupling")
def gears(s, d):
    s.rigid, s.coupling, s.stiffness = True, d.log(2, 5), d.log(2, 8)
    teeth = d.randint(8, 14)
    module = 2.0  # mm of radius a tooth
    r = module * teeth / 2
    fixed = shapes.gear(teeth, 1e-3 * (r - 1.1 * module), 1e-3 * (r + 0.9 * module), 8e-3)
    s.body("gear", s.mesh("gear", fixed))
    s.tool(s.mesh("tool", fixed))
    half = 180 / teeth if teeth % 2 == 0 else 0
    path = s.hand(lambda x, y: 0.0, at=(2 * r + 2.2 * module, 0), clear=0)
    path.go(0.1, 0, turn=(0, 0, half))
    path.go(0.6, 0, x=2 * r + d.uniform(0.0, 0.2))
    for sign in (1, -1, 1):
        lean = 180 / math.pi * d.uniform(1, 3) / s.coupling / r
        path.go(0.4, 0, turn=(0, 0, half + sign * (lean + d.uniform(2, 6)))).go(0.3, 0)
        path.go(0.3, 0, x=2 * r - d.uniform(0.5, 1.5) / path.stiffness).go(0.4, 0, turn=(0, 0, half)).go(0.2, 0, x=2 * r + 0.2)
    path.go(0.5, 0, x=2 * r + 2.2 * module).go(0.2, 0)


@kind("a peg with play in a ring")
def spool(s, d):
    s.rigid, s.margin = True, 0.4
    r, play = d.uniform(6, 10), d.uniform(0.3, 0.8)
    hole = shapes.ring(1e-3 * (r + play), 1e-3 * (r + 12), 0.012, 40)
    peg = shapes.cylinder(1e-3 * r, 0.04, 40)
    s.spacing = 2
    s.body("ring", s.mesh("ring", hole))
    s.tool(s.mesh("peg", peg))
    path = s.hand(lambda x, y: 0.0, clear=-32)
    path.go(0.8, -24, depth=False, x=d.uniform(-1, 1), y=d.uniform(-1, 1)).go(0.5, -18, depth=False, x=0, y=0)
    for _ in range(4):
        path.go(0.5, d.uniform(-15, 5), depth=False, x=d.uniform(-1.5, 1.5), y=d.uniform(-1.5, 1.5),
                turn=(d.uniform(-4, 4), d.uniform(-4, 4), d.uniform(-20, 20)))
    path.go(1.0, -32, depth=False, x=0, y=0, turn=(0, 0, 0))


@kind("stiff blobs, slow physics")
def stiff_blobs(s, d):
    s.rigid, s.stiffness, s.rate = True, d.log(5, 20), d.log(20, 35)
    fixed, tool = shapes.blob(0.03, bumps(d, 5, 0.15)), shapes.blob(0.012, bumps(d, 4, 0.2))
    s.body("blob", s.mesh("blob", fixed))
    s.tool(s.mesh("tool", tool))
    wander(s.hand(shapes.Heights(fixed, tool).touch).press(1.5), d, 10, d.uniform(1, 3), d.uniform(20, 60))


@kind("a hand that trembles at 20 to 60 Hz")
def trembling(s, d):
    low = d.uniform(18, 35)
    s.tremor = (d.uniform(0.05, 0.2), low, min(60, low * d.uniform(1.3, 2.2)))
    mesh = shapes.blob(0.03, bumps(d, 4, 0.1))
    radius = d.uniform(2, 5)
    s.body("blob", s.mesh("blob", mesh))
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    wander(s.hand(shapes.Heights(mesh, shapes.ball(1e-3 * radius)).touch).press(1), d, 9, d.uniform(0.8, 2), d.uniform(20, 60))


@kind("very slow physics")
def slow(s, d):
    s.rate = d.uniform(8, 14)
    mesh = shapes.blob(0.03, bumps(d, 4, 0.12))
    radius = d.uniform(2, 5)
    s.body("blob", s.mesh("blob", mesh))
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    wander(s.hand(shapes.Heights(mesh, shapes.ball(1e-3 * radius)).touch).press(1), d, 9, d.uniform(0.8, 2), d.uniform(15, 40))


@kind("physics nearly as fast as the device, a fine encoder")
def fast(s, d):
    s.rigid, s.rate, s.encoder = True, d.uniform(200, 300), d.uniform(1, 2)
    fixed, tool = shapes.blob(0.03, bumps(d, 5, 0.12)), shapes.blob(0.012, bumps(d, 4, 0.15))
    s.body("blob", s.mesh("blob", fixed))
    s.tool(s.mesh("tool", tool))
    wander(s.hand(shapes.Heights(fixed, tool).touch).press(1), d, 9, d.uniform(0.8, 2), d.uniform(20, 60))


@kind("stick and slip")
def stick_slip(s, d):
    s.friction = d.uniform(0.6, 1)
    radius = d.uniform(2, 5)
    s.body("wall", "plane: {}")
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    path = s.hand(flat(radius)).press(1)
    for _ in range(6):
        path.go(d.uniform(0.5, 0.9), d.uniform(0.8, 2), d.uniform(-12, 12), d.uniform(-12, 12)).go(0.2, 1)
    path.lift()


@kind("impacts of a heavy tool on a stiff wall")
def impacts(s, d):
    s.stiffness, s.mass, s.friction = d.log(4, 15), d.uniform(100, 300), d.uniform(0, 0.3)
    radius = d.uniform(3, 6)
    s.body("wall", "plane: {}")
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    path = s.hand(flat(radius), clear=25)
    for _ in range(8):
        path.go(d.uniform(0.07, 0.15), d.uniform(1, 3), d.uniform(-10, 10), d.uniform(-10, 10)).go(0.15, 1).go(0.15, -d.uniform(10, 25), depth=False)
    path.lift()


@kind("a slide over soft and stiff materials")
def materials(s, d):
    radius = d.uniform(2, 4)
    hardness = [d.log(0.3, 20) for _ in range(4)]
    for i, k in enumerate(hardness):
        s.body(f"block_{i}", "box: {size: [12 mm, 40 mm, 20 mm]}", stiffness=k, more=f"      pose: {{p: [{12 * i - 18} mm, 0 mm, -10 mm]}}\n")
    s.stiffness = 20
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    path = s.hand(flat(radius), at=(-18, 0), stiffness=sorted(hardness)[1]).press(0.8)
    for end in (20, -20, 20, -20):
        path.slide(end, d.uniform(-12, 12), d.uniform(0.4, 1.2), d.uniform(30, 120))
    path.lift()


@kind("a free block is pushed")
def free_body(s, d):
    s.rigid, s.gravity, s.friction = True, (0, 0, -9.81), d.uniform(0.2, 0.5)
    s.stiffness = d.log(2, 6)
    radius, wide = d.uniform(6, 9), d.uniform(30, 45)
    s.body("table", "plane: {}")
    s.body("block", f"box: {{size: [{wide:.3g} mm, 40 mm, 30 mm]}}", more=f"      motion: rigid\n      mass: {d.uniform(100, 300):.3g} g\n"
           "      pose: {p: [0, 0, 15 mm]}\n")
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    s.spacing = 8
    at = -wide / 2 - radius
    path = s.hand(lambda x, y: 0.015, at=(at - 12, 0), clear=0)
    path.go(0.8, 0, x=at + 2).go(1.2, 0, x=at + d.uniform(15, 25), y=d.uniform(-4, 4)).go(0.5, 0, x=at - 10)
    path.go(0.6, 0, x=at + d.uniform(25, 35)).go(0.4, 0).go(0.6, 0, x=at - 12, y=0)


@kind("a force beyond the device's largest")
def saturation(s, d):
    s.force_max = d.uniform(2, 4)
    mesh = shapes.blob(0.03, bumps(d, 4, 0.1))
    radius = d.uniform(2, 5)
    s.body("blob", s.mesh("blob", mesh))
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    wander(s.hand(shapes.Heights(mesh, shapes.ball(1e-3 * radius)).touch).press(5), d, 9, 1.6 * s.force_max, d.uniform(20, 60))


@kind("a blob rolled about in a bowl")
def bowl(s, d):
    s.rigid = True
    inside, thick = d.uniform(22, 32), 4
    curve = [(0, -inside - thick)]
    curve += [((inside + thick) * math.sin(a), -(inside + thick) * math.cos(a)) for a in (0.075 * i for i in range(1, 17))]
    curve += [(inside * math.sin(a), -inside * math.cos(a)) for a in (0.075 * i for i in range(16, 0, -1))]
    curve += [(0, -inside)]
    mesh = shapes.revolved([(1e-3 * r, 1e-3 * z) for r, z in curve], 48)
    tool = shapes.blob(0.008, bumps(d, 4, 0.15))
    s.body("bowl", s.mesh("bowl", mesh))
    s.tool(s.mesh("tool", tool))
    path = s.hand(shapes.Heights(mesh, tool).touch).press(1)
    for _ in range(5):
        path.slide(d.uniform(-12, 12), d.uniform(-12, 12), d.uniform(0.5, 2), d.uniform(40, 120))
        path.go(0.3, 1, turn=[d.uniform(-30, 30) for _ in "xyz"])
    path.lift()


@kind("a mesh of many separate parts")
def parts(s, d):
    radius, pitch = d.uniform(1.5, 3), d.uniform(5, 8)
    mesh = shapes.joined(*(shapes.moved(shapes.ball(1e-3 * radius, 16), (1e-3 * pitch * i, 1e-3 * pitch * j, d.uniform(-3e-4, 3e-4)))
                           for i in range(-2, 3) for j in range(-2, 3)))
    ball = d.uniform(3, 6)
    s.body("parts", s.mesh("parts", mesh))
    s.tool(f"sphere: {{radius: {ball:.4g} mm}}")
    wander(s.hand(shapes.Heights(mesh, shapes.ball(1e-3 * ball)).touch).press(1), d, 2 * pitch, d.uniform(0.5, 1.5), d.uniform(30, 80))


@kind("a needle over a blob")
def needle(s, d):
    s.rigid = True
    length, wide = d.uniform(20, 35), d.uniform(2, 4)
    tip = d.uniform(0.15, 0.4)
    tool = shapes.revolved([(0, -1e-3 * length / 2), (1e-3 * tip, -1e-3 * (length / 2 - tip)), (1e-3 * wide, 1e-3 * length / 3),
                            (1e-3 * wide, 1e-3 * length / 2), (0, 1e-3 * length / 2)], 20)
    fixed = shapes.blob(0.03, bumps(d, 5, 0.12))
    s.body("blob", s.mesh("blob", fixed))
    s.tool(s.mesh("needle", tool))
    path = s.hand(shapes.Heights(fixed, tool).touch).press(0.8)
    for _ in range(4):
        path.slide(d.uniform(-9, 9), d.uniform(-9, 9), d.uniform(0.3, 1), d.uniform(20, 50))
        path.go(0.3, 0.6, turn=(d.uniform(-25, 25), d.uniform(-25, 25), 0)).taps(1, 0.8)
    path.lift()


@kind("a heavy tool on soft ground, a soft coupling")
def soft(s, d):
    s.stiffness, s.coupling, s.mass = d.log(0.3, 0.6), d.log(0.1, 0.3), d.uniform(150, 300)
    s.gravity = (0, 0, -9.81)
    radius = d.uniform(4, 8)
    mesh = shapes.blob(0.03, bumps(d, 4, 0.1))
    s.body("blob", s.mesh("blob", mesh))
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    wander(s.hand(shapes.Heights(mesh, shapes.ball(1e-3 * radius)).touch, clear=15).press(1), d, 8, d.uniform(0.6, 1.5), d.uniform(20, 50))


@kind("a coarse encoder")
def coarse(s, d):
    s.encoder = d.uniform(40, 100)
    mesh = shapes.blob(0.03, bumps(d, 4, 0.12))
    radius = d.uniform(2, 5)
    s.body("blob", s.mesh("blob", mesh))
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    wander(s.hand(shapes.Heights(mesh, shapes.ball(1e-3 * radius)).touch).press(1), d, 9, d.uniform(0.8, 2), d.uniform(20, 60))


@kind("the rim of a thin disc over a blob")
def thin_disc(s, d):
    s.rigid = True
    tool = shapes.revolved([(0, -5e-4), (0.01, -5e-4), (0.01, 5e-4), (0, 5e-4)], 48)
    fixed = shapes.blob(0.03, bumps(d, 5, 0.1))
    s.spacing = 1
    s.body("blob", s.mesh("blob", fixed))
    s.tool(s.mesh("disc", tool))
    tilt = d.uniform(20, 50)
    path = s.hand(shapes.Heights(fixed, tool).touch, clear=18).go(0.3, -14, turn=(tilt, 0, 0), depth=False)
    lift = 10 * math.sin(math.radians(tilt))  # the rim is that much below the middle
    path.height = (lambda touch: lambda x, y: None if touch(x, y) is None else touch(x, y) + 1e-3 * (lift - 0.5) * 0.8)(path.height)
    path.press(1)
    for _ in range(5):
        path.slide(d.uniform(-8, 8), d.uniform(-8, 8), d.uniform(0.4, 1.5), d.uniform(20, 60))
        path.go(0.3, 0.8, turn=(tilt + d.uniform(-15, 15), d.uniform(-20, 20), d.uniform(-30, 30)))
    path.lift()


@kind("a physics period that varies by half")
def jitter(s, d):
    s.jitter, s.rate = 50, d.log(25, 80)
    mesh = shapes.blob(0.03, bumps(d, 4, 0.12))
    radius = d.uniform(2, 5)
    s.body("blob", s.mesh("blob", mesh))
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    wander(s.hand(shapes.Heights(mesh, shapes.ball(1e-3 * radius)).touch).press(1), d, 9, d.uniform(0.8, 2), d.uniform(20, 60))


@kind("a smooth and slow slide")
def smooth(s, d):
    mesh = shapes.tube([[((0.022 + 0.008 * math.cos(b)) * math.cos(a), (0.022 + 0.008 * math.cos(b)) * math.sin(a), 0.008 * math.sin(b))
                         for b in (2 * math.pi * k / 32 for k in range(32))] for a in (2 * math.pi * k / 64 for k in range(64))])
    radius = d.uniform(3, 6)
    s.body("torus", s.mesh("torus", mesh))
    s.tool(f"sphere: {{radius: {radius:.4g} mm}}")
    path = s.hand(shapes.Heights(mesh, shapes.ball(1e-3 * radius)).touch, at=(22, 0)).press(1)
    for i in range(1, 5):
        a = d.uniform(0.6, 1.2) * i
        path.slide(22 * math.cos(a), 22 * math.sin(a), d.uniform(0.5, 1.5), d.uniform(8, 25))
    path.lift()


def scene(name, seed):
    draw = Draw(f"{seed}/{name}")
    made = Scene(draw, name)
    KINDS[name][1](made, draw)
    return made


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=pathlib.Path, nargs="?", help="for the graphs")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--meshes", type=pathlib.Path, help="folder for the meshes, in which graphs look for transfer/")
    parser.add_argument("--kind", action="append", choices=KINDS)
    arguments = parser.parse_args()
    if not arguments.folder and not arguments.meshes:
        parser.error("nothing to write: name a folder for the graphs, or --meshes")
    for name in arguments.kind or KINDS:
        made = scene(name, arguments.seed)
        if arguments.folder:
            arguments.folder.mkdir(parents=True, exist_ok=True)
            made.base = "base.yaml" if arguments.folder.resolve() == HERE else HERE / "base.yaml"
            (arguments.folder / f"{name}.yaml").write_text(made.text(arguments.seed))
        if arguments.meshes:
            (arguments.meshes / "transfer").mkdir(parents=True, exist_ok=True)
            for file, mesh in made.meshes.items():
                shapes.write_off(mesh, arguments.meshes / "transfer" / file)


if __name__ == "__main__":
    sys.exit(main())
