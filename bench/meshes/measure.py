"""Tries `tactor mesh repair` and `tactor new graph --mesh` on the lists of this folder; scripts/mesh_results writes the page."""
import json
import math
import pathlib
import subprocess
import time

import numpy


LONGEST = 300  # s, for a command that hangs


def run(tactor, *words):
    begin = time.monotonic()
    done = subprocess.run([str(tactor), *map(str, words)], capture_output=True, text=True, check=False, timeout=LONGEST)
    return done, time.monotonic() - begin


def read_off(file):
    """(points, triangles, face numbers of the triangles) of an ASCII OFF file, by a reader of its own."""
    words = [w for line in pathlib.Path(file).read_text(errors="replace").splitlines() for w in line.split("#")[0].split()]
    if not words[0].endswith("OFF"):
        raise ValueError(f"{file}: no OFF file")
    at = 4
    n, m = int(words[1]), int(words[2])
    stride = 3
    points = numpy.array([[float(w) for w in words[at + stride * i:at + stride * i + 3]] for i in range(n)])
    at += stride * n
    triangles, numbers = [], []
    for f in range(m):
        size = int(words[at])
        corners = [int(w) for w in words[at + 1:at + 1 + size]]
        at += 1 + size
        for k in range(2, size):
            triangles.append((corners[0], corners[k - 1], corners[k]))
            numbers.append(f)
    return points, numpy.array(triangles), numpy.array(numbers)


def samples(points, triangles, count, dice):
    """Points on triangles, more where these are larger, and as many of their corners."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    areas = numpy.linalg.norm(numpy.cross(b - a, c - a), axis=1) / 2
    if not areas.sum() > 0:
        return a
    chosen = dice.choice(len(triangles), size=count, p=areas / areas.sum())
    u, v = numpy.sqrt(dice.random(count))[:, None], dice.random(count)[:, None]
    inner = (1 - u) * a[chosen] + u * (1 - v) * b[chosen] + u * v * c[chosen]
    corners = numpy.concatenate([a, b, c])
    return numpy.concatenate([inner, corners[dice.choice(len(corners), size=min(count, len(corners)), replace=False)]])


def nearest(p, a, b, c):
    """The distance of points p from triangles (a, b, c), row by row (C. Ericson, Real-Time Collision Detection, 5.1.5)."""
    def dot(x, y):
        return (x * y).sum(axis=1)

    ab, ac = b - a, c - a
    d1, d2 = dot(ab, p - a), dot(ac, p - a)
    d3, d4 = dot(ab, p - b), dot(ac, p - b)
    d5, d6 = dot(ab, p - c), dot(ac, p - c)
    va, vb, vc = d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2
    with numpy.errstate(all="ignore"):
        inside = (va >= 0) & (vb >= 0) & (vc >= 0) & (va + vb + vc > 0)
        w = (vb / (va + vb + vc))[:, None], (vc / (va + vb + vc))[:, None]
        best = numpy.where(inside, numpy.linalg.norm(p - (a + w[0] * ab + w[1] * ac), axis=1), numpy.inf)
    for x, y in ((a, b), (b, c), (c, a)):
        side = y - x
        with numpy.errstate(all="ignore"):
            t = numpy.clip(numpy.nan_to_num(dot(p - x, side) / dot(side, side)), 0, 1)[:, None]
        best = numpy.minimum(best, numpy.linalg.norm(p - (x + t * side), axis=1))
    return best


def farthest(from_points, points, triangles):
    """The largest distance of `from_points` from triangles, each by those that bounding spheres leave."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    middle = (a + b + c) / 3
    radius = numpy.max([numpy.linalg.norm(x - middle, axis=1) for x in (a, b, c)], axis=0)
    most = 0.0
    for p in from_points:
        away = numpy.linalg.norm(middle - p, axis=1)
        g = numpy.flatnonzero(away - radius <= away.min())  # a middle lies on its triangle
        most = max(most, nearest(numpy.broadcast_to(p, (len(g), 3)), a[g], b[g], c[g]).min())
    return float(most)


def check_moved(old_file, new_file, told, count=300):
    """How far sampled points of the two surfaces are apart, as (old to new, new to old), by a computation of its own."""
    dice = numpy.random.default_rng(1)
    old_points, old_triangles, numbers = read_off(old_file)
    new_points, new_triangles, _ = read_off(new_file)
    kept = old_triangles[~numpy.isin(numbers, told["removed_faces"] + told["inside_faces"])]
    filled = numpy.zeros(len(new_triangles), bool)
    filled[told["filled_faces"]] = True
    there = farthest(samples(old_points, kept, count, dice), new_points, new_triangles) if len(kept) else 0.0
    back = farthest(samples(new_points, new_triangles[~filled], count, dice), old_points, old_triangles) if (~filled).any() else 0.0
    return there, back


def repair(tactor, name, file, out, *options):
    """What became of one mesh: a dictionary for the table."""
    before, _ = run(tactor, "mesh", "check", file, "--scale", "1")
    done, took = run(tactor, "mesh", "repair", file, "--out", out, "--overwrite", "--json", *options)
    row = {"name": name, "refused": before.returncode == 2, "took_s": took}
    if done.returncode != 0:
        return {**row, "repaired": False, "why": done.stderr.strip().split(": ", 1)[-1], "code": done.returncode}
    told = json.loads(done.stdout)
    after, _ = run(tactor, "mesh", "check", out, "--scale", "1")
    return {**row, "repaired": True, "passes": after.returncode == 0, "told": told}


def scene(tactor, name, file, folder):
    """What `new graph` and a run of what it made gave."""
    title = "scene_" + "".join(c if c.isalnum() else "_" for c in name)
    begin = time.monotonic()
    done, _ = run(tactor, "new", "graph", title, "--mesh", file, "--in", folder, "--overwrite")
    row = {"name": name, "title": title}
    if done.returncode != 0:
        return {**row, "made": False, "code": done.returncode, "why": done.stderr.strip(), "took_s": time.monotonic() - begin}
    ran, _ = run(tactor, "run", folder / title / "scene.yaml", "--out", folder / title / "out", "--overwrite")
    row.update(made=True, repaired="so it was repaired" in done.stderr, took_s=time.monotonic() - begin, code=ran.returncode)
    if ran.returncode != 0:
        return {**row, "touches": False, "why": ran.stderr.strip()}
    found = json.loads((folder / title / "out/summary.json").read_text())
    force = found["reference"]["force"]["rms_N"] if "reference" in found else math.nan
    return {**row, "contacts": found["contacts"]["max"], "force_N": force, "energy_J": found["dynamics_energy_generated_max_J"],
            "touches": found["contacts"]["max"] > 0 and force > 0}
