#!/usr/bin/python3
"""Makes the trajectories beside this file from the meshes: `make.py MESH_FOLDER`.

They are constructed, not recorded from people: paths over a surface found on the mesh, with a stated depth below it.
The graphs add the tremor of a hand. Columns are seconds, metres and radians (a rotation vector).
"""
import math
import pathlib
import random
import sys

import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
TOOL_RADIUS = 0.004  # of the sphere in duck.yaml
STEP = 0.02  # s between way-points


def read_off(path):
    lines = (line.split("#")[0] for line in path.read_text().splitlines())
    words = " ".join(lines).split()
    assert words[0] == "OFF"
    n_vertices, n_faces = int(words[1]), int(words[2])
    at = 4
    vertices = np.array(words[at:at + 3 * n_vertices], dtype=float).reshape(-1, 3)
    at += 3 * n_vertices
    faces = np.array(words[at:at + 4 * n_faces], dtype=int).reshape(-1, 4)[:, 1:]
    return vertices, faces


def centre_of_mass(vertices, faces):
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    volumes = np.einsum("ij,ij->i", a, np.cross(b, c))
    return (volumes[:, None] * (a + b + c)).sum(0) / (4 * volumes.sum())


def first_hit(vertices, faces, origin, direction):
    """Where a ray meets the mesh first, by Moeller and Trumbore's test of every face."""
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    e1, e2 = b - a, c - a
    p = np.cross(direction, e2)
    det = np.einsum("ij,ij->i", e1, p)
    with np.errstate(divide="ignore", invalid="ignore"):
        s = origin - a
        u = np.einsum("ij,ij->i", s, p) / det
        q = np.cross(s, e1)
        v = q @ direction / det
        t = np.einsum("ij,ij->i", e2, q) / det
    hits = (np.abs(det) > 1e-18) & (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 0)
    return origin + t[hits].min() * direction


def smooth(values, width):
    """Moving average over `width` rows that keeps the ends."""
    if width < 2:
        return values
    padded = np.concatenate([np.repeat(values[:1], width, 0), values, np.repeat(values[-1:], width, 0)])
    kernel = np.ones(width) / width
    return np.stack([np.convolve(padded[:, i], kernel, "same")[width:-width] for i in range(values.shape[1])], 1)


def ease(t, a, b):
    """From 0 at a to 1 at b without a jerk."""
    s = np.clip((t - a) / (b - a), 0, 1)
    return s ** 3 * (10 - 15 * s + 6 * s ** 2)


def duck_path(mesh, longitude, latitude, depth, times):
    """Device positions that keep the sphere `depth(t)` below the surface met from this longitude and latitude (rad)."""
    vertices, faces = mesh
    low, high = vertices.min(0), vertices.max(0)
    centre = centre_of_mass(vertices, faces)
    points = []
    outward = []
    for t in times:
        lon, lat = longitude(t), latitude(t)
        direction = np.array([math.cos(lat) * math.cos(lon), math.cos(lat) * math.sin(lon), math.sin(lat)])
        points.append(first_hit(vertices, faces, centre + 2 * np.linalg.norm(high - low) * direction, -direction))
        outward.append(direction)
    # The facets' edges are smoothed away; the hand follows the shape, not the triangles.
    points, outward = smooth(np.array(points), 5), np.array(outward)
    return points + (TOOL_RADIUS - np.array([depth(t) for t in times]))[:, None] * outward


def write(name, times, position, rotation=None):
    rotation = np.zeros_like(position) if rotation is None else rotation
    lines = ["t [s],x [m],y [m],z [m],rx [rad],ry [rad],rz [rad]"]
    for t, p, r in zip(times, position, rotation):
        lines.append(",".join([f"{t:.2f}"] + [f"{v:.7f}" for v in (*p, *r)]))
    (HERE / name).write_text("\n".join(lines) + "\n")


def ducks(mesh):
    # 10 s of each test come after the 300 physics results that a refit wants before it is warm, 4 s after 500.
    end = 16
    times = np.arange(0, end + STEP / 2, STEP)
    above = -0.010

    def pressing(t):
        return above + (0.014 + 0.003 * math.sin(2 * math.pi * 0.5 * t)) * (ease(t, 0.4, 1.0) - ease(t, end - 1.0, end - 0.4))

    def tapping(t):
        return -0.002 + 0.006 * math.sin(2 * math.pi * 2.5 * t) if t > 0.4 else -0.002

    def sliding(t):
        return above + 0.014 * (ease(t, 0.4, 1.0) - ease(t, end - 1.0, end - 0.4))

    def making_and_breaking(t):
        return -0.001 + 0.005 * math.sin(2 * math.pi * 0.8 * t) + 0.001 * math.sin(2 * math.pi * 2.1 * t)

    tests = {
        # Pressing slowly, hardly moving along the surface.
        1: (lambda t: 0.6 + 0.02 * math.sin(t), lambda t: 0.7, pressing),
        # Tapping 2.5 times a second.
        2: (lambda t: 0.6, lambda t: 0.6 + 0.02 * t, tapping),
        # Sliding fast to and fro.
        3: (lambda t: 0.45 * math.sin(2 * math.pi * 0.6 * t), lambda t: 0.6, sliding),
        # Sliding slowly.
        4: (lambda t: 0.4 + 0.08 * t, lambda t: 0.6, sliding),
        # Contact made and broken while sliding.
        5: (lambda t: 0.5 * math.sin(2 * math.pi * 0.2 * t), lambda t: 0.7, making_and_breaking),
    }
    for number, (longitude, latitude, depth) in tests.items():
        write(f"duck_{number}.csv", times, duck_path(mesh, longitude, latitude, depth, times))


def rotation_matrix(r):
    angle = np.linalg.norm(r)
    if angle == 0:
        return np.eye(3)
    x, y, z = r / angle
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + math.sin(angle) * k + (1 - math.cos(angle)) * k @ k


def height_field(points, cell, highest):
    """{(i, j): z} of the highest (or lowest) point over each cell of the x-y plane."""
    field = {}
    for x, y, z in points:
        key = (round(x / cell), round(y / cell))
        if key not in field or (z > field[key]) == highest:
            field[key] = z
    return field


def bunny(mesh):
    vertices, faces = mesh
    cell = 0.002
    # Centres of faces too, so that no cell under the surface is empty.
    dense = np.concatenate([vertices, vertices[faces].mean(1)])
    top = height_field(dense, cell, True)
    tool = dense - centre_of_mass(vertices, faces)
    end = 13  # 8 s after the 300 results that a refit wants
    times = np.arange(0, end + STEP / 2, STEP)
    position = []
    rotation = []
    middle = (vertices.min(0) + vertices.max(0)) / 2
    for t in times:
        r = np.array([math.radians(8) * math.sin(2 * math.pi * 0.3 * t), math.radians(6) * math.sin(2 * math.pi * 0.2 * t),
                      math.radians(10) * math.sin(2 * math.pi * 0.15 * t)])
        xy = middle[:2] + np.array([0.012 * math.sin(2 * math.pi * 0.45 * t), 0.008 * math.sin(2 * math.pi * 0.3 * t)])
        bottom = height_field(tool @ rotation_matrix(r).T + np.array([*xy, 0]), cell, False)
        touch = max(top[key] - z for key, z in bottom.items() if key in top)
        depth = -0.010 + 0.0135 * (ease(t, 0.2, 0.8) - ease(t, end - 0.5, end - 0.1)) + 0.0015 * math.sin(2 * math.pi * 0.8 * t)
        position.append([*xy, touch - depth])
        rotation.append(r)
    write("bunny.csv", times, smooth(np.array(position), 5), np.array(rotation))


def lever():
    """A recording like one of a rig: a hand pushes a lever of 0.1 kg at 75 mm against a wall, at 2 kHz, by semi-implicit Euler.

    Two strikes, then pressing with tremor, then letting go; angle in rad and torque of the wall on the lever in N m, with
    the steps of an encoder and the noise of a force sensor.
    """
    noise = random.Random(1)
    arm, mass, wall, damping = 0.075, 0.1, 1500.0, 2.0  # m, kg, N/m, N s/m
    step, substeps = 5e-4, 20
    y, v, force = -0.02, 0.0, 0.0
    with open(HERE / "lever.csv", "w", newline="\n") as file:
        file.write("t_s,x_master_rad,Fe_Nm\n")
        for i in range(6001):
            t = i * step
            angle = round(y / arm / 2.09e-5) * 2.09e-5
            file.write(f"{t:.4f},{angle:.7f},{arm * force + noise.gauss(0, 3e-4):.6f}\n")
            for k in range(substeps):
                s = t + k * step / substeps
                strikes = 0.03 * (ease(s, 0.3, 0.45) - ease(s, 0.5, 0.65) + ease(s, 0.9, 1.0) - ease(s, 1.05, 1.2))
                press = 0.032 * (ease(s, 1.5, 1.8) - ease(s, 2.6, 2.75))
                hand = -0.02 + strikes + press + 0.0005 * math.sin(2 * math.pi * 9.3 * s)
                force = min(0.0, -wall * y - damping * v) if y > 0 else 0.0
                v += step / substeps / mass * (400 * (hand - y) - 8 * v + force)
                y += step / substeps * v


if __name__ == "__main__":
    lever()
    meshes = pathlib.Path(sys.argv[1])
    ducks(read_off(meshes / "duck.off"))
    bunny(read_off(meshes / "bunny.off"))
