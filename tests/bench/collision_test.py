"""A short run of collision_bench: the contenders agree on what touches, and the metrics are whole. No time is judged.

collision_test.py PROGRAM MESH_FOLDER
"""
import json
import math
import subprocess
import sys
import unittest

PROGRAM, MESHES = sys.argv[1:3]
SAMPLES = 28


def numbers(value, path=""):
    """Every number in a tree, with its place."""
    if isinstance(value, dict):
        for key, inner in value.items():
            yield from numbers(inner, f"{path}.{key}")
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from numbers(inner, f"{path}[{i}]")
    elif isinstance(value, (int, float)) and not isinstance(value, bool):
        yield path, value


class Collision(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        said = subprocess.run([PROGRAM, "--meshes", MESHES, "--scene", "bunny", "--scene", "peg", "--scene", "duck",
                               "--scene", "physics", "--scene", "dynamics", "--samples", str(SAMPLES), "--no-cold", "--no-grids", "--no-realtime"], check=True, capture_output=True, text=True)
        cls.scenes = json.loads(said.stdout)["scenes"]

    def contenders(self, *scenes):
        for scene in scenes:
            for row in self.scenes[scene]["contenders"]:
                with self.subTest(scene=scene, contender=row["name"]):
                    yield row

    def test_every_number_is_finite(self):
        for place, value in numbers(self.scenes):
            self.assertTrue(math.isfinite(value), place)

    def test_the_path_is_what_it_says(self):
        path = self.scenes["bunny"]["path"]
        self.assertEqual(path["samples"], SAMPLES)
        # Seven samples a period of the profile, so none stands at its top.
        self.assertAlmostEqual(path["deepest_mm"]["max"], 1 - math.cos(2 * math.pi * 3 / 7), delta=1e-5)
        self.assertGreater(path["samples_inside"]["max"], 20)

    def test_all_see_what_is_deep(self):
        for row in self.contenders("bunny", "peg"):
            self.assertEqual(row["touches_unseen"], 0)
            self.assertGreater(row["touching"], 0)

    def test_none_sees_anything_where_bodies_are_apart(self):
        for row in self.contenders("bunny", "peg"):
            self.assertTrue(row["nothing_apart"])

    def test_none_gives_what_is_not_finite(self):
        for row in self.contenders("bunny", "peg"):
            self.assertEqual(row.get("not_finite", 0), 0)

    def test_ours_is_the_reference(self):
        for row in self.contenders("bunny"):
            if row["name"].startswith("tactor") or row["name"] == "floor":
                self.assertEqual(row["missed"]["missed"], 0)
                self.assertLess(row["depth_error_um"]["max"], 1e-6)
                self.assertLess(row["normal_error_deg"]["p99"], 1e-3)
                self.assertAlmostEqual(row["deepest_ratio"]["p1"], 1, delta=1e-9)

    def test_the_same_samples_are_inside_as_in_the_reference(self):
        for row in self.contenders("bunny"):
            if row["name"] in ("tactor", "tactor, 1 mm margin", "tactor, exact", "floor", "CGAL"):
                self.assertGreater(row["samples"]["of"], 20)
                self.assertEqual((row["samples"]["left_out"], row["samples"]["made_up"]), (0, 0))
            elif "collision.sdf" in row["name"]:
                # It leaves out what is beyond its number of contacts, and makes up none.
                self.assertEqual(row["samples"]["made_up"], 0)
                self.assertLess(row["samples"]["left_out"], row["samples"]["of"])
            else:
                self.assertNotIn("samples", row)

    def test_the_parts_of_a_physics_step_add_up(self):
        for row in self.scenes["physics"]["margins"]:
            us, contacts = row["us"], row["contacts"]
            parts = sum(us[part]["mean"] for part in ("collision", "dynamics", "coupling"))
            self.assertAlmostEqual(us["whole step"]["mean"], parts, delta=1e-6 * parts)
            self.assertGreater(contacts["with_force"]["max"], 20)
            self.assertGreater(row["force_N"]["max"], 0.5)
            self.assertLessEqual(contacts["sent"]["max"], 128)
            self.assertGreater(contacts["found"]["max"], contacts["penetrating"]["max"])

    def test_dynamics_works_on_the_contacts_it_is_timed_with(self):
        for row in self.scenes["dynamics"]["contacts"]:
            self.assertGreaterEqual(row["with_force"]["median"], 0.5 * row["contacts"])
            self.assertLessEqual(row["with_force"]["max"], row["contacts"])

    def test_samples_miss_no_more_depth_than_their_spacing(self):
        shells = [row for row in self.scenes["peg"]["sampling"] if row["spacing_mm"] is not None]
        self.assertEqual(len(shells), 2)
        for row in shells:
            self.assertLessEqual(row["missed_mm"]["max"], row["spacing_mm"])

    def test_closest_points_agree(self):
        for where in ("beside", "far"):
            for row in self.scenes["duck"][where]:
                with self.subTest(where=where, contender=row["name"]):
                    # A micrometre is single precision's share; FCL's point is a triangle of 10 nm.
                    self.assertLess(row["error_um"]["max"], 1)
                    self.assertEqual(row.get("wrong_sign", 0), 0)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
