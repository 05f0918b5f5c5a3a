#!/usr/bin/python3
"""Our contact parameters, identified once for an engine on one press, and how well they explain the other scenes.

    identify.py fit GRAPH --engine mujoco|simbody --write OVERLAY   # least squares on the press GRAPH
    identify.py table GRAPH... --engine mujoco|simbody --over OVERLAY   # what is left, a row a graph

The force of our reference run is that of the same graph with our physics at 10 kHz, without encoder and costs.
"""
import argparse
import json
import pathlib
import sys
import tempfile

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import make_truth  # noqa: E402

# Both bodies get the same material, so that the pair has half the stiffness, and damping and friction as they stand.
MATERIAL = "{{stiffness: {0:.6g}, damping: {1:.6g}, friction: {2:.6g}}}"
REFERENCE = """
rate: 10 kHz
nodes:
  metrics: ~
  prediction: ~
  interpolation: ~
  collision: {cost: ~}
  device: {encoder_step: 0, encoder_step_angle: 0}
record: [coupling.force]
"""
SCENE_DAMPING = 2.0  # N s/m, of the scenes: kept where the press does not tell it
TOLD = 1.05  # the damping is told where the scene's leaves more than this much of what the best one leaves
START = {"stiffness": 2000.0, "damping": 5.0, "friction": 0.3}
MOVES = 0.01  # m/s: a tool that is slower may stick
SETTLE = 0.2  # s, left out at the start, as sink.metrics does


def overlay_of(pair):
    """The bodies of a scene with a pair of contact parameters: stiffness, damping, friction."""
    material = MATERIAL.format(2 * pair[0], pair[1], pair[2])
    return f"scene:\n  bodies:\n    base: {{material: {material}}}\n    tool: {{material: {material}}}\n"


def reference_force(tactor, graph, seed, times, options=(), overlay=""):
    """Our force and torque at these times, by physics at 10 kHz: six columns."""
    with tempfile.TemporaryDirectory() as scratch:
        file, _ = make_truth.recorded(tactor, graph, pathlib.Path(scratch), REFERENCE + overlay, [*options, "--seed", seed])
        with file:
            data = file["streams/coupling.force/data"][()]
    at = data["valid_ns"] * 1e-9
    columns = np.column_stack([data["force"], data["torque"]])
    return np.column_stack([np.interp(times, at, columns[:, i]) for i in range(6)])


def wrench_of(table):
    return np.column_stack([table[c] for c in ("fx", "fy", "fz", "tx", "ty", "tz")])


def rms(values):
    """Root mean square of the norm of rows."""
    return float(np.sqrt((values ** 2).sum(axis=1).mean()))


def least_squares(residual, start, steps=12):
    """Gauss-Newton with Levenberg's damping, in the logarithms of the parameters. Returns them and the sum of squares."""
    x, weight = np.log(start), 1e-3
    r = residual(np.exp(x))
    for _ in range(steps):
        jacobian = np.column_stack([(residual(np.exp(x + 0.02 * e)) - r) / 0.02 for e in np.eye(len(x))])
        normal = jacobian.T @ jacobian
        for _ in range(6):
            move = np.clip(np.linalg.solve(normal + weight * np.diag(np.diag(normal)), -jacobian.T @ r), -1, 1)
            trial = residual(np.exp(x + move))
            if trial @ trial < r @ r:
                break
            weight *= 10
        else:
            break
        gained = 1 - (trial @ trial) / (r @ r)
        x, r, weight = x + move, trial, weight / 10
        if gained < 1e-5 or np.abs(move).max() < 1e-4:
            break
    return np.exp(x), float(r @ r)


def fit(arguments, tactor, program, material):
    table, name = make_truth.engine_force(arguments.graphs[0], arguments.engine, tactor, program, arguments.seed, material,
                                          fineness=arguments.fineness)
    late = table["t"] >= SETTLE
    truth = wrench_of(table)[late][:, :3]

    def residual(pair):
        ours = reference_force(tactor, arguments.graphs[0], arguments.seed, table["t"][late], overlay=overlay_of(pair))
        return (ours[:, :3] - truth).ravel()

    pair, _ = least_squares(residual, [START["stiffness"], START["damping"], START["friction"]])
    left, best = rms(residual(pair).reshape(-1, 3)) / rms(truth), pair[1]
    usual = np.array([pair[0], SCENE_DAMPING, pair[2]])
    if (with_usual := rms(residual(usual).reshape(-1, 3)) / rms(truth)) < TOLD * left:
        print(f"the press does not tell the damping: {best:.2g} N s/m leaves {100 * left:.2f} %; the scene's {SCENE_DAMPING:g} N s/m is kept")
        pair, left = usual, with_usual
    print(f"{arguments.engine} on {name}: stiffness {pair[0]:.1f} N/m, damping {pair[1]:.3g} N s/m, friction {pair[2]:.4f}; "
          f"left {100 * left:.2f} % of the force RMS")
    if arguments.write:
        of = pathlib.Path(arguments.material or f"{arguments.engine}.json").name
        words = (f"# Our contact parameters for the truth of {arguments.engine} with {of}, identified once on {name} (seed {arguments.seed}) and\n# frozen: "
                 f"{pair[0]:.1f} N/m, {pair[1]:.3g} N s/m and {pair[2]:.4f} for the pair; {100 * left:.2f} % of that press' force stays unexplained.\n"
                 "# Written by bench/truth/identify.py.\n"
                 f"format: 2\ntitle: contact parameters identified on one press in {arguments.engine}\n")
        pathlib.Path(arguments.write).write_text(words + overlay_of(pair))


def table_of(arguments, tactor, program, material):
    """Prints a row a graph: RMS of the force, of what is left of it with the overlay and with the scene's own material."""
    rows = []
    print("| graph | seed | force RMS, N | left with the overlay | left where it moves | left with the scene's own | torque RMS, mN m | left with the overlay |")
    print("|---|---|---|---|---|---|---|---|")
    for graph in arguments.graphs:
        table, name = make_truth.engine_force(graph, arguments.engine, tactor, program, arguments.seed, material, fineness=arguments.fineness)
        late = table["t"] >= SETTLE
        truth = wrench_of(table)[late]
        moves = np.linalg.norm(np.column_stack([table[c][late] for c in ("vx", "vy", "vz")]), axis=1) > MOVES
        row = {"graph": name, "seed": arguments.seed, "force_rms_N": rms(truth[:, :3]), "torque_rms_Nm": rms(truth[:, 3:])}
        for label, options in (("overlay", ["--over", arguments.over]), ("own", [])):
            ours = reference_force(tactor, graph, arguments.seed, table["t"][late], options)
            row[label] = rms((ours - truth)[:, :3]) / row["force_rms_N"]
            row[label + "_moving"] = rms((ours - truth)[moves, :3]) / rms(truth[moves, :3])
            row[label + "_torque"] = rms((ours - truth)[:, 3:]) / row["torque_rms_Nm"] if row["torque_rms_Nm"] > 1e-9 else None
        rows.append(row)
        torque = f"{1e3 * row['torque_rms_Nm']:.2f} | {100 * row['overlay_torque']:.1f} %" if row["overlay_torque"] is not None else "none | "
        print(f"| {name} | {row['seed']} | {row['force_rms_N']:.3f} | {100 * row['overlay']:.1f} % | {100 * row['overlay_moving']:.1f} % | {100 * row['own']:.1f} % | {torque} |", flush=True)
    if arguments.json:
        pathlib.Path(arguments.json).write_text(json.dumps(rows, indent=1))


def converge(arguments, tactor, program, material):
    """Prints a row a graph: by how much the force changes where the step is halved, or the accuracy is ten times finer."""
    coarse = float(arguments.fineness or {"mujoco": 5e-5, "simbody": 1e-6}[arguments.engine])
    fine = coarse / {"mujoco": 2, "simbody": 10}[arguments.engine]
    print(f"| graph | change of the force from {coarse:g} to {fine:g} |\n|---|---|")
    for graph in arguments.graphs:
        force = []
        for fineness in (coarse, fine):
            table, name = make_truth.engine_force(graph, arguments.engine, tactor, program, arguments.seed, material, fineness=fineness)
            force.append(wrench_of(table)[:, :3])
        print(f"| {name} | {100 * rms(force[0] - force[1]) / rms(force[1]):.3f} % |", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("what", choices=("fit", "table", "converge"))
    parser.add_argument("graphs", nargs="+")
    parser.add_argument("--engine", required=True, choices=make_truth.ENGINES)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--over", help="table: the overlay that was identified")
    parser.add_argument("--write", help="fit: the overlay to write")
    parser.add_argument("--json", help="table: the rows as JSON too")
    parser.add_argument("--material", help="the engine's contact parameters (default: ENGINE.json beside this program)")
    parser.add_argument("--fineness", help="MuJoCo: the step in s (5e-5); Simbody: the accuracy (1e-6)")
    parser.add_argument("--tactor", help="the command tactor (default: TACTOR, or that of the PATH)")
    parser.add_argument("--programs", help="the folder of truth_mujoco and truth_simbody")
    arguments = parser.parse_args()
    try:
        if arguments.what == "table" and not arguments.over:
            raise make_truth.BadInput("table: expected --over FILE, the overlay that was identified")
        tactor = make_truth.tactor_program(arguments.tactor)
        program = make_truth.engine_program(arguments.engine, tactor, arguments.programs)
        material = make_truth.read_material(arguments.engine, arguments.material)
        {"fit": fit, "table": table_of, "converge": converge}[arguments.what](arguments, tactor, program, material)
    except make_truth.BadInput as error:
        print(error, file=sys.stderr)
        sys.exit(2)
    except make_truth.Failed as error:
        print(error, file=sys.stderr)
        sys.exit(1)


if __name__ == "__main__":
    main()
