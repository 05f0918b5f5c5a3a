#!/usr/bin/python3
"""Bodies that deform beside Bullet's: the time of a result and the error of the force on one scene, as a Markdown table.

`bench/soft_peers.py`, with a built release preset and Debian's libbullet-dev; it takes about three minutes. A ball on a spring is pressed slowly onto
the block of graphs/gel_cube and rests there. Both programs make the same tetrahedra of it, and follow the same samples of the handle in steps
of the same results. Bullet's contact is hard, so the material of the block's surface is made a hundred times as stiff as in the graph.
The times are those of one round after the other on the same thread, without what other threads take.
"""
import json
import math
import pathlib
import statistics
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from run_time import table  # noqa: E402

BIN = ROOT / "build/release/bin"
TACTOR = BIN / "tactor"
BULLET = {"double": BIN / "bullet_soft_double", "float": BIN / "bullet_soft"}
SCENE = ROOT / "graphs/gel_cube/scene.yaml"
GEL = {"size": [0.08, 0.08, 0.04], "fixed_p": [0, 0, -0.02], "fixed_n": [0, 0, 1], "young": 20e3, "poisson": 0.45, "density": 1000, "damping": 5e-3}
BALL = {"radius": 8e-3, "mass": 0.05, "friction": 0.3}
STIFFNESS = 1000  # N/m, of the coupling, critically damped
TOP = 0.02  # m, the block's surface
REST, END = 0.35, 0.5  # s: the handle stops, the run ends
#        m: a cell of the grid, so that a node of the surface is below the ball; steps a result with which Bullet is stable, by nodes and by faces
SIZES = ((10e-3, 12, 24), (8e-3, 16, 32), (5e-3, 24, None))  # of the last, faces would take minutes
# What Bullet's demos set (examples/DeformableDemo), of implicit elasticity as VolumetricDeformable and of explicit as Pinch. A substep of theirs
# is 1/240 s. With faces, projection gives the same force in a third of the time.
IMPLICIT = {"implicit": True, "projection": True, "contacts": "nodes", "split_impulse": True, "erp": 0.3, "contact_iterations": 100,
            "line_search": False, "margin": 1e-3, "substeps": 4}
EXPLICIT = {**IMPLICIT, "implicit": False}
NODES, FACES = {**EXPLICIT, "projection": False}, {**EXPLICIT, "contacts": "faces"}
HAND = f"""format: 2
duration: {END} s
nodes:
  metrics: ~
  trajectory:
    tremor_amplitude: 0
    repeat_after: 1000 s
    points: [{{t: 0 s, z: 29 mm, x: 0 mm, y: 0 mm}}, {{t: {REST} s, z: 20 mm, x: 0 mm, y: 0 mm}}, {{t: {END} s, z: 20 mm, x: 0 mm, y: 0 mm}}]
  device: {{encoder_step: 0}}
  coupling: {{type: coupling.dynamic, k_t: {STIFFNESS} N/m, zeta: 1}}
scene:
  bodies:
    gel: {{tetrahedra: ~, material: {{stiffness: 200 N/mm}}}}
    tool: {{material: {{stiffness: 2000 N/mm}}}}
"""
DENSE = ["--set", "dynamics.soft_spacing=1 mm"]
FINE = ["--over", ROOT / "graphs/methods/floor.yaml", "--set", "dynamics.tolerance=1e-6", *DENSE]


def tactor(cell, words, folder):
    """The handle's samples, the results' (time, force on the hand along z, ball's z), and the costs of a result, of a run with that cell."""
    import h5py  # what makes tables of results is tested without it

    hand = folder / "hand.yaml"
    hand.write_text(HAND)
    subprocess.run([TACTOR, "run", SCENE, *words, "--over", hand, "--set", f"scene.bodies.gel.cell_size={cell} m", "--set",
                    "record=[device.state, coupling.force, dynamics.state]", "--overwrite", "--out", folder / "run"], check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    with h5py.File(folder / "run/recording.h5") as file:
        handle, force, state = (file[f"streams/{name}/data"][...] for name in ("device.state", "coupling.force", "dynamics.state"))
    cost = json.loads((folder / "run/summary.json").read_text())["cost_us"]["dynamics"]
    samples = [[1e-9 * int(row["valid_ns"]), *map(float, row["p_WD"]), *map(float, row["v_WD"])] for row in handle]
    results = [(1e-9 * int(f["valid_ns"]), float(f["force"][2]), float(s["p_WT"][2])) for f, s in zip(force, state)]
    return samples, results, (cost["median"] / 1e3, cost["p99"] / 1e3)


def bullet(cell, options, precision, samples, times, folder):
    """What bullet_soft says of the same motion, results at the same times; None where a signal ended it."""
    scene = {"gel": {**GEL, "cell_size": cell}, "ball": BALL, "coupling": {"k": STIFFNESS, "b": 2 * math.sqrt(STIFFNESS * BALL["mass"])},
             "handle": samples, "times": times, "bullet": options}
    file = folder / "scene.json"
    file.write_text(json.dumps(scene))
    done = subprocess.run([BULLET[precision], file], capture_output=True, text=True)
    if done.returncode < 0:
        return None
    done.check_returncode()
    return json.loads(done.stdout)


def at(results, t):
    """The force of a run at a time, straight between its results."""
    for (t0, f0, _), (t1, f1, _) in zip(results, results[1:]):
        if t0 <= t <= t1:
            return f0 + (f1 - f0) * (t - t0) / (t1 - t0)
    return results[-1][1]


def quantile(values, share):
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))]


def figures(results, reference):
    """Of (time, force, z): force and depth at rest, errors at rest and in motion, and how far the force swings at rest; None: not finite."""
    if any(f is None or not math.isfinite(f) or abs(f) > 1e3 for _, f, _ in results):
        return None
    resting = [(f, z) for t, f, z in results if t > END - 0.1]
    force, depth = statistics.fmean(f for f, _ in resting), TOP + BALL["radius"] - statistics.fmean(z for _, z in resting)
    ideal = reference[-1][1]
    moving = [f - at(reference, t) for t, f, _ in results if t <= REST]
    return {"force": force, "depth": 1e3 * depth, "error": 100 * (force / ideal - 1), "moving": math.sqrt(statistics.fmean(e * e for e in moving)),
            "swing": max(f for f, _ in resting) - min(f for f, _ in resting)}


HEAD = ["tetrahedra", "program", "steps a result", "a result, ms", "p99, ms", "time / Tactor's", "force at rest, N", "error at rest, %",
        "swing at rest, N", "error in motion, N", "block pushes with, N", "depth, mm"]


def row(count, name, steps, cost, ours, found, tissue):
    start = [count, name, steps, cost[0], cost[1], cost[0] / ours]
    if found is None:
        return [*start, "unstable", *[None] * 5]
    return [*start, found["force"], found["error"], found["swing"], found["moving"], tissue, found["depth"]]


def kinds(by_nodes, by_faces, first):
    """(name, options, precision) of what Bullet is run with; of the first mesh also what shows what a setting does."""
    yield "Bullet, implicit, nodes", IMPLICIT, "double"
    yield "Bullet, explicit, nodes", {**NODES, "substeps": by_nodes}, "double"
    if by_faces:
        yield "Bullet, explicit, faces", {**FACES, "substeps": by_faces}, "double"
    if first:
        yield "Bullet, explicit, faces", FACES, "double"
        yield "Bullet, explicit, faces", {**FACES, "substeps": 2 * by_faces}, "double"
        yield "Bullet, explicit, faces, float", {**FACES, "substeps": by_faces}, "float"


def rows(cell, by_nodes, by_faces, folder):
    """The rows of a mesh."""
    _, reference, _ = tactor(cell, FINE, folder)
    _, dense, dense_cost = tactor(cell, DENSE, folder)
    samples, results, cost = tactor(cell, [], folder)
    times = [t for t, _, _ in results]
    count = f"{5 * math.prod(round(edge / cell) for edge in GEL['size']):,}"
    body = []
    for name, options, precision in kinds(by_nodes, by_faces, cell == SIZES[0][0]):
        said = bullet(cell, options, precision, samples, times, folder)
        if said is None:
            body.append([count, name, options["substeps"], None, None, None, "crashed", *[None] * 5])
            continue
        theirs = [(r["t"], r["force"][2], r["p"][2]) for r in said["results"]]
        costs = [r["cost_us"] / 1e3 for r in said["results"]]
        body.append(row(count, name, options["substeps"], (statistics.median(costs), quantile(costs, 0.99)), cost[0],
                        figures(theirs, reference), abs(said["tissue_force"][2] or math.nan)))
        print(*body[-1], file=sys.stderr, flush=True)
    for name, found, taken in (("Tactor, samples 1 mm apart", dense, dense_cost), ("Tactor", results, cost)):
        ours = figures(found, reference)
        body.insert(0, row(count, name, 2, taken, cost[0], ours, ours["force"]))
        print(*body[0], file=sys.stderr, flush=True)
    return body


def peers():
    """A Markdown table, or why there is none."""
    missing = [program.name for program in BULLET.values() if not program.exists()]
    if missing:
        return f"Not measured: {' and '.join(missing)} are not built, which need Debian's libbullet-dev.\n"
    with tempfile.TemporaryDirectory() as name:
        return table(HEAD, [line for size in SIZES for line in rows(*size, pathlib.Path(name))])


if __name__ == "__main__":
    if not TACTOR.exists():
        sys.exit("build first: scripts/build")
    print(peers(), end="")
