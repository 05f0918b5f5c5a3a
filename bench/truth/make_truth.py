#!/usr/bin/python3
"""Recordings of `coupling.force` by another engine, in the place of a reference run.

    make_truth.py GRAPH --engine mujoco|simbody --seeds N --first-seed S --out FOLDER [--duration TIME]

Each seed gives FOLDER/<graph>_<seed>.h5. README.md says what is in it, and what it does not show.
"""
import argparse
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile

import h5py
import numpy as np
import yaml

HERE = pathlib.Path(__file__).resolve().parent
ENGINES = ("mujoco", "simbody")
MOTION = "t,px,py,pz,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz"
# What only shows or judges a force is left out: the handle's motion does not depend on it.
HANDLE_ALONE = """
nodes: {metrics: ~, prediction: ~, interpolation: ~}
record: [device.truth, coupling.parameters]
"""


class BadInput(Exception):
    """The caller asked for something that cannot be: exit code 2."""


class Failed(Exception):
    """Something failed while running: exit code 1."""


def run(command):
    """The standard output of a command. Its error text is passed on where it fails."""
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True, check=False)
    if done.returncode == 0:
        return done.stdout
    raise (BadInput if done.returncode == 2 else Failed)(done.stderr.strip() or f"{command[0]} ended with {done.returncode}")


def tactor_program(given=None):
    found = given or os.environ.get("TACTOR") or shutil.which("tactor")
    if not found:
        raise BadInput("there is no command tactor: give --tactor FILE, or set TACTOR")
    return pathlib.Path(found)


def engine_program(engine, tactor, given=None):
    """truth_mujoco or truth_simbody: in the folder that is given, in that of TACTOR_TRUTH, or beside tactor."""
    folders = [given, os.environ.get("TACTOR_TRUTH"), tactor.resolve().parent]
    for folder in folders:
        if folder and (pathlib.Path(folder) / f"truth_{engine}").exists():
            return pathlib.Path(folder) / f"truth_{engine}"
    raise BadInput(f"there is no program truth_{engine}: build it (the library may be missing), or give --programs FOLDER")


def read_material(engine, file=None):
    """What the engine's file says of its own contacts."""
    path = pathlib.Path(file) if file else HERE / f"{engine}.json"
    try:
        return json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise BadInput(f"{path}: {error}") from error


def recorded(tactor, graph, folder, overlay, options=()):
    """Runs a graph with a text laid over it; the recording, open, and the graph's name without that of the text."""
    over = folder / "over.yaml"
    over.write_text(overlay)
    run([tactor, "run", graph, *options, "--over", over, "--out", folder / "run", "--overwrite"])
    name = json.loads((folder / "run/summary.json").read_text())["graph"]
    return h5py.File(folder / "run/recording.h5"), name.removesuffix(f"_{over.stem}")


def handle_motion(file):
    """Times and columns of MOTION out of the stream device.truth."""
    data = file["streams/device.truth/data"][()]
    columns = [data[name].reshape(len(data), -1) for name in ("p_WD", "R_WD", "v_WD", "w_WD")]
    return np.column_stack([data["valid_ns"] * 1e-9, *columns])


def number(value):
    """YAML 1.1 takes 1e-04 for a text."""
    return float(value)


def numbers(values):
    return [number(v) for v in values]


def inertia_of(body):
    """The principal moments of a solid of even density, in its frame."""
    mass = number(body["mass"])
    if body.get("inertia"):
        return numbers(body["inertia"])
    if "sphere" in body:
        return [0.4 * mass * number(body["sphere"]["radius"]) ** 2] * 3
    if "box" in body:
        x, y, z = (s * s for s in numbers(body["box"]["size"]))
        return [mass / 12 * (y + z), mass / 12 * (x + z), mass / 12 * (x + y)]
    r, l = number(body["capsule"]["radius"]), number(body["capsule"]["length"])
    cylinder = mass * l / (l + 4 / 3 * r)
    ball = mass - cylinder
    across = cylinder * (l * l / 12 + r * r / 4) + ball * (0.4 * r * r + l * l / 4 + 3 / 8 * l * r)
    return [across, across, cylinder * r * r / 2 + 0.4 * ball * r * r]


def shape_of(name, body):
    for kind in ("sphere", "capsule", "box"):
        if kind in body:
            return {kind: {k: numbers(v) if isinstance(v, list) else number(v) for k, v in body[kind].items()}}
    if "plane" in body:
        return {"plane": {}}
    if "mesh" in body:
        return {"mesh": {"file": body["mesh"], "scale": number(body.get("scale") or 1)}}
    raise BadInput(f"scene.bodies.{name}: expected a sphere, a capsule, a box, a plane or a mesh")


def pose_of(body):
    pose = body.get("pose", {})
    return {"p": numbers(pose.get("p", [0, 0, 0])), "quaternion": numbers(pose.get("quaternion", [1, 0, 0, 0]))}


def scene_of(file, engine, material):
    """The scene for the engine's program, out of the resolved graph and the coupling that a recording holds."""
    text = file.attrs["graph"]
    scene = yaml.safe_load(text.decode() if isinstance(text, bytes) else text)["scene"]
    for node, values in yaml.safe_load(text.decode() if isinstance(text, bytes) else text)["nodes"].items():
        if values.get("loop") == "closed":
            raise BadInput(f"nodes.{node}.loop: expected open, for a hand whose path does not depend on the forces, found closed")
    moving = {name: body for name, body in scene["bodies"].items() if body.get("motion", "static") != "static"}
    if len(moving) != 1:
        raise BadInput(f"expected a scene in which one body moves, found {len(moving)}: {', '.join(moving)}")
    (name, tool), = moving.items()
    if "mesh" in tool or "plane" in tool:
        raise BadInput(f"scene.bodies.{name}: expected a sphere, a capsule or a box as the tool")
    law = file["streams/coupling.parameters/data"][0]
    if law["massless"]:
        raise BadInput("expected a tool with mass, found the coupling of a massless one")
    return {
        "gravity": numbers(scene["gravity"]),
        "coupling": {key: float(law[key]) for key in ("k_t", "b_t", "k_r", "b_r", "force_max", "torque_max")},
        "tool": {"shape": shape_of(name, tool), "motion": tool["motion"], "mass": number(tool["mass"]), "inertia": inertia_of(tool)},
        "fixed": [{"name": n, "shape": shape_of(n, b), "pose": pose_of(b)} for n, b in scene["bodies"].items() if n != name],
        engine: material,
    }


def simulate(program, scene, motion, folder, fineness=None):
    """The table of the engine's program, by column."""
    (folder / "scene.json").write_text(json.dumps(scene, indent=1))
    np.savetxt(folder / "motion.csv", motion, delimiter=",", header=MOTION, comments="", fmt="%.15g")
    run([program, folder / "scene.json", folder / "motion.csv", folder / "truth.csv", *([fineness] if fineness else [])])
    return np.genfromtxt(folder / "truth.csv", delimiter=",", names=True)


def write_import(table, path):
    """A CSV that `tactor import --type Wrench` takes."""
    with open(path, "w", newline="") as out:
        rows = csv.writer(out)
        rows.writerow(["valid_s", "produced_s", "sequence", *(f"force_{a} [N]" for a in "xyz"), *(f"torque_{a} [N m]" for a in "xyz")])
        for i, row in enumerate(table):
            at = f"{row['t']:.9f}"
            rows.writerow([at, at, i, *(repr(float(row[c])) for c in ("fx", "fy", "fz", "tx", "ty", "tz"))])


def engine_force(graph, engine, tactor, program, seed, material, options=(), fineness=None, keep=None):
    """The engine's table for one seed, and the graph's name. `keep`: where scene, motion and table stay."""
    with tempfile.TemporaryDirectory() as scratch:
        folder = pathlib.Path(keep or scratch)
        folder.mkdir(parents=True, exist_ok=True)
        file, name = recorded(tactor, graph, pathlib.Path(scratch), HANDLE_ALONE, [*options, "--seed", seed])
        with file:
            scene, motion = scene_of(file, engine, material), handle_motion(file)
        return simulate(program, scene, motion, folder, fineness), name


def make(arguments):
    tactor = tactor_program(arguments.tactor)
    program = engine_program(arguments.engine, tactor, arguments.programs)
    material = read_material(arguments.engine, arguments.material)
    out = pathlib.Path(arguments.out)
    out.mkdir(parents=True, exist_ok=True)
    options = [word for over in arguments.over for word in ("--over", over)] + [word for value in arguments.set for word in ("--set", value)]
    if arguments.duration:
        options += ["--duration", arguments.duration]
    for seed in range(arguments.first_seed, arguments.first_seed + arguments.seeds):
        table, name = engine_force(arguments.graph, arguments.engine, tactor, program, seed, material, options, arguments.fineness)
        recording = out / f"{name}_{seed}.h5"
        if recording.exists():
            if not arguments.overwrite:
                raise BadInput(f"{recording} is there already; --overwrite replaces it")
            recording.unlink()
        with tempfile.TemporaryDirectory() as scratch:
            write_import(table, pathlib.Path(scratch) / "force.csv")
            run([tactor, "import", pathlib.Path(scratch) / "force.csv", recording, "--type", "Wrench", "--stream", "coupling.force"])
        force = np.column_stack([table[c] for c in ("fx", "fy", "fz")])
        print(f"{recording}: {len(table)} samples, force {np.sqrt((force ** 2).sum(1).mean()):.3f} N RMS")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("graph")
    parser.add_argument("--engine", required=True, choices=ENGINES)
    parser.add_argument("--seeds", type=int, default=1, help="how many (default 1)")
    parser.add_argument("--first-seed", type=int, default=1)
    parser.add_argument("--out", required=True, help="folder of the recordings")
    parser.add_argument("--duration", help="of the run, as `3 s` (default: the graph's)")
    parser.add_argument("--over", action="append", default=[], help="a file to lay over the graph")
    parser.add_argument("--set", action="append", default=[], help="a value of the graph: node.parameter=value")
    parser.add_argument("--material", help="the engine's contact parameters (default: ENGINE.json beside this program)")
    parser.add_argument("--fineness", help="MuJoCo: the step in s (5e-5); Simbody: the accuracy (1e-6)")
    parser.add_argument("--overwrite", action="store_true", help="replace recordings that are there")
    parser.add_argument("--tactor", help="the command tactor (default: TACTOR, or that of the PATH)")
    parser.add_argument("--programs", help="the folder of truth_mujoco and truth_simbody")
    try:
        make(parser.parse_args())
    except BadInput as error:
        print(error, file=sys.stderr)
        sys.exit(2)
    except Failed as error:
        print(error, file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    main()
