"""The truths of bench/truth against closed forms, what they refuse, and a recording that is made of one.

TACTOR_TRUTH is the folder of truth_mujoco and truth_simbody; a test of an engine that is not there is skipped by name. TACTOR is the command,
for the test that makes a recording.
"""
import csv
import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

BENCH = pathlib.Path(__file__).resolve().parents[2] / "bench/truth"
GRAPHS = pathlib.Path(__file__).resolve().parents[2] / "graphs/foreign"
PROGRAMS = pathlib.Path(os.environ.get("TACTOR_TRUTH", "."))
MATERIAL = {engine: json.loads((BENCH / f"{engine}.json").read_text()) for engine in ("mujoco", "simbody")}
MASS, RADIUS, K, B, GRAVITY = 0.05, 0.004, 350.0, 8.0, 9.81
HEADER = "t,px,py,pz,qw,qx,qy,qz,vx,vy,vz,wx,wy,wz"
STILL = (1, 0, 0, 0)


def scene(engine, **changes):
    """A ball of 50 g over a plane."""
    whole = {"gravity": [0, 0, -GRAVITY], "coupling": {"k_t": K, "b_t": B, "k_r": 0.2, "b_r": 1e-3},
             "tool": {"shape": {"sphere": {"radius": RADIUS}}, "motion": "translation", "mass": MASS},
             "fixed": [{"name": "base", "shape": {"plane": {}}}], engine: MATERIAL[engine]}
    return whole | changes


def still(z, seconds=1.0, x=0.0):
    """A handle that stays."""
    return [(i / 1000, x, 0, z, *STILL, 0, 0, 0, 0, 0, 0) for i in range(round(seconds * 1e3) + 1)]


def pressed(z, speed=0.0, seconds=3.0):
    """A handle that comes down from where the ball touches to z in half a second, and slides along x from 1 s on."""
    rows = []
    for i in range(round(seconds * 1e3) + 1):
        t = i / 1000
        share, rate = (t / 0.5, 2.0) if t < 0.5 else (1.0, 0.0)
        slides = t > 1
        rows.append((t, speed * (t - 1) if slides else 0, 0, RADIUS + (z - RADIUS) * share, *STILL,
                     speed if slides else 0, 0, (z - RADIUS) * rate, 0, 0, 0))
    return rows


class Program(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def call(self, engine, words, motion, *arguments):
        """The finished process. `words`: the scene as an object, or as text."""
        program = PROGRAMS / f"truth_{engine}"
        if not program.exists():
            self.skipTest(f"truth_{engine} is not built: the library is not installed")
        (self.folder / "scene.json").write_text(words if isinstance(words, str) else json.dumps(words))
        text = motion if isinstance(motion, str) else "\n".join([HEADER, *(",".join(repr(v) for v in row) for row in motion)]) + "\n"
        (self.folder / "motion.csv").write_text(text)
        files = [self.folder / name for name in ("scene.json", "motion.csv", "truth.csv")]
        return subprocess.run([program, *files, *arguments], capture_output=True, text=True, check=False)

    def rows(self, engine, words, motion, *arguments):
        done = self.call(engine, words, motion, *arguments)
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        with open(self.folder / "truth.csv", newline="") as file:
            rows = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
        self.assertEqual([row["t"] for row in rows], [row[0] for row in motion])
        return rows


class ClosedForms:
    """Of both engines."""

    engine = ""

    def stiffness_law(self, depth):
        """The normal force of a ball on the plane, still, by the engine's documents."""
        raise NotImplementedError

    def test_a_hanging_ball_sags_by_its_weight_over_the_stiffness(self):
        last = self.rows(self.engine, scene(self.engine), still(0.05))[-1]
        self.assertAlmostEqual(last["fz"], -MASS * GRAVITY, delta=1e-6)
        self.assertAlmostEqual(last["pz"], 0.05 - MASS * GRAVITY / K, delta=1e-8)
        self.assertEqual((last["contacts"], last["cz"]), (0, 0))

    def test_a_pressed_ball_is_in_balance_at_the_depth_of_the_engines_law(self):
        last = self.rows(self.engine, scene(self.engine), pressed(-0.002))[-1]
        self.assertEqual(last["contacts"], 1)
        self.assertAlmostEqual(last["fz"], K * (last["pz"] + 0.002), delta=1e-6)
        self.assertAlmostEqual(last["cz"], last["fz"] + MASS * GRAVITY, delta=1e-4)
        self.assertAlmostEqual(last["cz"] / self.stiffness_law(RADIUS - last["pz"]), 1, delta=1e-3)
        for sideways in ("fx", "fy", "cx", "cy"):
            self.assertAlmostEqual(last[sideways], 0, delta=1e-9)

    def test_a_ball_that_slides_evenly_drags_by_friction_times_the_normal_force(self):
        last = self.rows(self.engine, scene(self.engine), pressed(-0.002, speed=0.02))[-1]
        self.assertAlmostEqual(last["vx"], 0.02, delta=1e-4)
        self.assertAlmostEqual(last["cx"] / last["cz"], -MATERIAL[self.engine]["friction"], delta=1e-3)
        self.assertAlmostEqual(last["fx"], last["cx"], delta=1e-3)

    def test_a_ball_let_go_swings_at_the_springs_frequency_and_dies_by_its_damper(self):
        words = scene(self.engine, gravity=[0, 0, 0], coupling={"k_t": K, "b_t": 1.0})
        words["tool"]["pose"] = {"p": [0.01, 0, 0.05]}
        rows = self.rows(self.engine, words, still(0.05))
        decay = 1.0 / (2 * MASS)
        swing = math.sqrt(K / MASS - decay ** 2)
        for row in rows:
            t = row["t"]
            x = 0.01 * math.exp(-decay * t) * (math.cos(swing * t) + decay / swing * math.sin(swing * t))
            self.assertAlmostEqual(row["px"], x, delta=4e-5)

    def test_a_body_let_go_turned_swings_likewise(self):
        words = scene(self.engine, gravity=[0, 0, 0], coupling={"k_t": K, "b_t": B, "k_r": 0.2, "b_r": 2e-4})
        words["tool"] |= {"motion": "rigid", "inertia": [2e-6, 3e-6, 4e-6],
                          "pose": {"p": [0, 0, 0.05], "quaternion": [math.cos(0.15), 0, math.sin(0.15), 0]}}
        decay = 2e-4 / (2 * 3e-6)
        swing = math.sqrt(0.2 / 3e-6 - decay ** 2)
        for row in self.rows(self.engine, words, still(0.05, 0.2)):
            t = row["t"]
            angle = 0.3 * math.exp(-decay * t) * (math.cos(swing * t) + decay / swing * math.sin(swing * t))
            self.assertAlmostEqual(2 * math.atan2(row["qy"], row["qw"]), angle, delta=3e-3)

    def test_the_torque_on_the_handle_is_that_of_the_arc_between(self):
        words = scene(self.engine, gravity=[0, 0, 0])
        words["tool"] |= {"motion": "rigid", "inertia": [1.0, 1.0, 1.0], "pose": {"p": [0, 0, 0.05]}}
        turned = [(row[0], *row[1:4], math.cos(0.2), 0, 0, math.sin(0.2), *row[8:]) for row in still(0.05, 0.01)]
        self.assertAlmostEqual(self.rows(self.engine, words, turned)[0]["tz"], -0.2 * 0.4, delta=1e-9)

    def test_what_the_device_gets_is_limited_by_norm_and_the_tool_feels_the_whole(self):
        words = scene(self.engine)
        words["coupling"] |= {"force_max": 0.2}
        last = self.rows(self.engine, words, still(0.05))[-1]
        self.assertAlmostEqual(last["fz"], -0.2, delta=1e-9)
        self.assertAlmostEqual(last["pz"], 0.05 - MASS * GRAVITY / K, delta=1e-8)

    def test_a_wall_pushes_as_a_plane_does(self):
        wall = scene(self.engine, gravity=[0, 0, 0])
        wall["fixed"] = [{"name": "base", "shape": {"box": {"size": [0.02, 0.3, 0.3]}}, "pose": {"p": [-0.01, 0, 0]}}]
        plane = scene(self.engine, gravity=[0, 0, 0])
        down = pressed(-0.002)
        aside = [(t, z, x, y, *STILL, vz, vx, vy, *w) for t, x, y, z, _, _, _, _, vx, vy, vz, *w in down]
        a = self.rows(self.engine, plane, down)[-1]
        b = self.rows(self.engine, wall, aside)[-1]
        self.assertAlmostEqual(a["fz"], b["fx"], delta=1e-4)
        self.assertGreater(b["fx"], 1)

    def lying_box(self):
        words = scene(self.engine)
        words["tool"] |= {"shape": {"box": {"size": [0.024, 0.016, 2 * RADIUS]}}, "motion": "rigid", "inertia": [2e-6, 3e-6, 4e-6]}
        last = self.rows(self.engine, words, pressed(-0.002))[-1]
        self.assertAlmostEqual(last["cz"], last["fz"] + MASS * GRAVITY, delta=1e-4)
        self.assertAlmostEqual(last["qw"], 1, delta=1e-9)
        return last

    def test_a_flat_box_is_in_balance(self):
        self.lying_box()

    def test_a_lying_capsule_touches_with_both_ends(self):
        words = scene(self.engine)
        words["tool"] |= {"shape": {"capsule": {"radius": RADIUS, "length": 0.02}}, "motion": "rigid", "inertia": [3e-6, 3e-6, 1e-6]}
        lying = [(row[0], *row[1:4], math.sqrt(0.5), 0, math.sqrt(0.5), 0, *row[8:]) for row in pressed(-0.002)]
        last = self.rows(self.engine, words, lying)[-1]
        self.assertEqual(last["contacts"], 2)
        self.assertAlmostEqual(last["cz"], last["fz"] + MASS * GRAVITY, delta=1e-4)

    def test_half_the_step_changes_the_force_by_less_than_a_hundredth(self):
        coarse, fine = (["5e-5"], ["2.5e-5"]) if self.engine == "mujoco" else (["1e-6"], ["1e-7"])
        motion = pressed(-0.002, speed=0.05, seconds=1.5)
        a, b = (self.rows(self.engine, scene(self.engine), motion, *fineness) for fineness in (coarse, fine))
        axes = ("fx", "fy", "fz")
        differs = sum((p[c] - q[c]) ** 2 for p, q in zip(a, b) for c in axes)
        self.assertLess(math.sqrt(differs / sum(q[c] ** 2 for q in b for c in axes)), 0.01)

    def test_bad_scenes_are_refused_with_file_and_key(self):
        def changed(path, value):
            words = json.loads(json.dumps(scene(self.engine)))
            at = words
            for key in path[:-1]:
                at = at[key]
            if value is None:
                del at[path[-1]]
            else:
                at[path[-1]] = value
            return words

        for path, value, said in (
                (("gravity",), None, "gravity: this key is missing"),
                (("gravity",), [0, 0], "gravity: expected 3 numbers"),
                (("tool", "mass"), -1, "tool.mass: expected a number above 0, found -1"),
                (("tool", "mass"), "heavy", "tool.mass: expected a number"),
                (("tool", "motion"), "static", "tool.motion: expected rigid or translation"),
                (("tool", "motion"), "rigid", "tool.inertia: this key is missing"),
                (("tool", "shape"), {"plane": {}}, "tool.shape: expected a sphere, a capsule or a box"),
                (("tool", "shape", "sphere", "radius"), 0, "tool.shape.sphere.radius: expected a number above 0"),
                (("tool", "colour"), "red", "tool.colour: there is no such key here"),
                (("coupling", "k_t"), None, "coupling.k_t: this key is missing"),
                (("fixed",), {}, "fixed: expected a list"),
                (("fixed", 0, "pose"), {"quaternion": [1, 1, 0, 0]}, "fixed[0].pose.quaternion: expected a unit quaternion"),
                (("fixed", 0, "shape"), {"mesh": {"file": "none.off"}}, "fixed[0].shape.mesh.file: there is no file"),
                ((self.engine,), None, f"{self.engine}: this key is missing"),
                ((self.engine, "friction"), -0.1, f"{self.engine}.friction: expected a number not below 0")):
            with self.subTest(path=path, value=value):
                done = self.call(self.engine, changed(path, value), still(0.05, 0.01))
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn("scene.json: " + said, done.stderr)

    def test_bad_motions_are_refused_with_file_and_line(self):
        row = "0.05,1,0,0,0,0,0,0,0,0,0"
        good = f"{HEADER}\n0,0,0,{row}\n"
        for motion, said in ((HEADER, "motion.csv: expected two samples or more"), ("t,x\n", "motion.csv:1: expected the columns"),
                             (good + f"0,0,0,{row}\n", "motion.csv:3: t: the times must increase"),
                             (good + "1,2\n", "motion.csv:3: expected 14 numbers, found 2"),
                             (good + f"1,nan,0,{row}\n", "motion.csv:3: expected a number"),
                             (good + "1,0,0,0.05,2,0,0,0,0,0,0,0,0,0\n", "motion.csv:3: qw: expected a unit quaternion")):
            with self.subTest(said=said):
                done = self.call(self.engine, scene(self.engine), motion)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn(said, done.stderr)

    def test_text_that_is_no_json_a_bad_step_and_too_few_files_are_refused(self):
        self.assertIn("scene.json: not JSON", self.call(self.engine, "{", still(0.05, 0.01)).stderr)
        for step in ("0", "-1", "fast"):
            done = self.call(self.engine, scene(self.engine), still(0.05, 0.01), step)
            self.assertEqual(done.returncode, 2, done.stderr)
        done = subprocess.run([PROGRAMS / f"truth_{self.engine}"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("usage", done.stderr)


class Mujoco(ClosedForms, Program):
    engine = "mujoco"

    def stiffness_law(self, depth):
        """Still, f = m d k r / (1 - d), with k = stiffness d / d_width^2 (MuJoCo, Modeling: Solver parameters); d is even here."""
        (stiffness, _), (d, width) = (MATERIAL["mujoco"][key][:2] for key in ("solref", "solimp"))
        self.assertEqual(d, width)
        return MASS * d * (-stiffness * d / width ** 2) * depth / (1 - d)

    def test_a_mesh_is_refused_for_it_would_be_its_hull(self):
        (self.folder / "some.off").write_text("OFF\n0 0 0\n")
        words = scene("mujoco", fixed=[{"name": "base", "shape": {"mesh": {"file": "some.off"}}}])
        done = self.call("mujoco", words, still(0.05, 0.01))
        self.assertEqual(done.returncode, 2)
        self.assertIn("fixed.base.shape: MuJoCo takes a mesh as its convex hull", done.stderr)

    def test_a_simulation_that_breaks_ends_with_1(self):
        done = self.call("mujoco", scene("mujoco", coupling={"k_t": 1e14, "b_t": 0}), still(0.05, 0.1))
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertRegex(done.stderr, "MuJoCo failed at|not finite")


class Simbody(ClosedForms, Program):
    engine = "simbody"

    def stiffness_law(self, depth):
        """Hertz: f = 4/3 sqrt(R) k^(3/2) x^(3/2), k = E^(2/3) / 2 of two like materials (CompliantContactSubsystem.cpp)."""
        stiffness = MATERIAL["simbody"]["stiffness"]
        return 4 / 3 * math.sqrt(RADIUS) * (stiffness ** (2 / 3) / 2 * depth) ** 1.5

    def test_a_box_lies_on_the_springs_of_its_four_corners(self):
        last = self.lying_box()
        depth = RADIUS - last["pz"]
        self.assertAlmostEqual(last["cz"], 4 * MATERIAL["simbody"]["vertex_stiffness"] / 2 * depth, delta=1e-4)

    def cube(self, half, top):
        """A cube as a mesh whose upper face is at z = top, in one file; its triangles are some 1.1 mm wide when refined."""
        corners = [(x, y, z) for z in (top - 2 * half, top) for y in (-half, half) for x in (-half, half)]
        quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
        faces = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
        text = f"OFF\n# a cube\n{len(corners)} {len(faces)} 0\n" + "".join(f"{x} {y} {z}\n" for x, y, z in corners)
        (self.folder / "cube.off").write_text(text + "".join(f"3 {a} {b} {c}\n" for a, b, c in faces))

    def test_a_ball_on_a_mesh_feels_the_springs_of_its_layer(self):
        """On flat ground each place inside the ball has a spring k/h towards the ball's surface: pi k/h (R - x) x^2 in all."""
        self.cube(0.01, 0)
        words = scene("simbody", fixed=[{"name": "base", "shape": {"mesh": {"file": "cube.off"}}}])
        words["simbody"] = MATERIAL["simbody"] | {"refine": 4}
        last = self.rows("simbody", words, pressed(-0.004, seconds=1.0))[-1]
        depth = RADIUS - last["pz"]
        foundation = MATERIAL["simbody"]["stiffness"] / MATERIAL["simbody"]["layer"] / 2
        self.assertAlmostEqual(last["cz"], last["fz"] + MASS * GRAVITY, delta=1e-4)
        self.assertAlmostEqual(last["cz"] / (math.pi * foundation * (RADIUS - depth) * depth ** 2), 1, delta=0.1)

    def test_a_mesh_takes_a_ball_alone(self):
        self.cube(0.01, 0)
        words = scene("simbody", fixed=[{"name": "base", "shape": {"mesh": {"file": "cube.off"}}}])
        words["tool"] |= {"shape": {"capsule": {"radius": 0.004, "length": 0.01}}}
        done = self.call("simbody", words, still(0.05, 0.01))
        self.assertEqual(done.returncode, 2)
        self.assertIn("scene.json: tool.shape: on a mesh Simbody takes a sphere alone", done.stderr)

    def test_a_mesh_that_is_not_closed_is_refused(self):
        (self.folder / "open.off").write_text("OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n")
        words = scene("simbody", fixed=[{"name": "base", "shape": {"mesh": {"file": "open.off"}}}])
        done = self.call("simbody", words, still(0.05, 0.01))
        self.assertEqual(done.returncode, 2)
        self.assertIn("open.off: Simbody refuses the mesh", done.stderr)

    def test_a_tool_that_leaves_the_face_of_a_wall_ends_the_run_with_1(self):
        words = scene("simbody", gravity=[0, 0, 0])
        words["fixed"] = [{"name": "base", "shape": {"box": {"size": [0.02, 0.02, 0.02]}}, "pose": {"p": [0, 0, -0.01]}}]
        done = self.call("simbody", words, pressed(0.01, speed=0.02))
        self.assertEqual(done.returncode, 1)
        self.assertIn("the tool leaves the face of a box at 1.", done.stderr)


class Recordings(unittest.TestCase):
    def setUp(self):
        try:
            import h5py  # noqa: F401
            import numpy  # noqa: F401
            import yaml  # noqa: F401
        except ImportError as error:
            self.skipTest(f"{error.name} is not installed")
        sys.path.insert(0, str(BENCH))
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))

    def test_gauss_newton_finds_the_parameters_of_a_curve(self):
        import identify
        import numpy as np
        times = np.linspace(0, 1, 50)
        curve = lambda p: p[0] * np.exp(-p[1] * times)  # noqa: E731
        found, left = identify.least_squares(lambda p: curve(p) - curve([3.0, 0.7]), [1.0, 2.0], steps=30)
        np.testing.assert_allclose(found, [3.0, 0.7], rtol=1e-4)
        self.assertLess(left, 1e-8)

    def test_an_overlay_gives_the_pair_what_was_identified(self):
        import identify
        import yaml
        bodies = yaml.safe_load(identify.overlay_of([1500, 3, 0.25]))["scene"]["bodies"]
        self.assertEqual(bodies, {name: {"material": {"stiffness": 3000, "damping": 3, "friction": 0.25}} for name in ("base", "tool")})

    def test_a_capsules_inertia_is_that_of_a_ball_where_it_has_no_length(self):
        import make_truth
        for moment in make_truth.inertia_of({"mass": 0.05, "capsule": {"radius": 0.004, "length": 1e-12}}):
            self.assertAlmostEqual(moment, 0.4 * 0.05 * 0.004 ** 2, delta=1e-15)

    def make(self, *words):
        return subprocess.run([sys.executable, BENCH / "make_truth.py", *words], capture_output=True, text=True, check=False)

    def test_a_recording_holds_the_force_on_the_device_at_1_kHz(self):
        import h5py
        import numpy as np
        if "TACTOR" not in os.environ:
            self.skipTest("TACTOR is not set")
        if not (PROGRAMS / "truth_mujoco").exists():
            self.skipTest("truth_mujoco is not built: the library is not installed")
        words = [GRAPHS / "ball_plane.yaml", "--engine", "mujoco", "--seeds", "2", "--first-seed", "3", "--duration", "1 s", "--out", self.folder]
        done = self.make(*words)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(sorted(file.name for file in self.folder.iterdir()), ["ball_plane_3.h5", "ball_plane_4.h5"])
        with h5py.File(self.folder / "ball_plane_3.h5") as file:
            data = file["streams/coupling.force/data"][()]
        np.testing.assert_array_equal(data["valid_ns"], np.arange(len(data)) * 1_000_000)
        self.assertEqual(len(data), 1000)
        self.assertGreater(data["force"][950][2], 0.5)  # it presses
        again = self.make(*words)
        self.assertEqual(again.returncode, 2)
        self.assertIn("is there already", again.stderr)
        self.assertEqual(self.make(*words, "--overwrite").returncode, 0)

    def test_a_graph_that_is_not_there_and_a_scene_of_two_moving_bodies_are_refused(self):
        if "TACTOR" not in os.environ or not (PROGRAMS / "truth_mujoco").exists():
            self.skipTest("TACTOR is not set, or truth_mujoco is not built")
        for graph, said in (("none.yaml", "none.yaml"), (GRAPHS.parent / "block_pushed/scene.yaml", "one body moves, found 2")):
            done = self.make(graph, "--engine", "mujoco", "--out", self.folder, "--duration", "0.1 s")
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn(said, done.stderr)


if __name__ == "__main__":
    unittest.main()
