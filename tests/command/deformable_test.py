"""Scenes that deform: what is refused, and what is said of them, by the command."""
import unittest

from harness import GRAPHS, CommandTest, needs_meshes, tactor

SCENE = (GRAPHS / "gel_cube/scene.yaml").read_text()
BOX = "box: {size: [80 mm, 80 mm, 40 mm]}"
FIXED = "fixed: {behind: {p: [0, 0, -20 mm], n: [0, 0, 1]}}"
# A box of 40 mm without its top.
OPEN = """OFF
8 10 0
0 0 0\n0.04 0 0\n0.04 0.04 0\n0 0.04 0\n0 0 0.04\n0.04 0 0.04\n0.04 0.04 0.04\n0 0.04 0.04
3 0 2 1\n3 0 3 2\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7
"""
# A box of 40 mm with one corner pulled out through the opposite one.
CUTS_ITSELF = """OFF
8 12 0
0 0 0\n0.04 0 0\n0.04 0.04 0\n0 0.04 0\n0 0 0.04\n0.04 0 0.04\n-0.02 -0.02 -0.02\n0 0.04 0.04
3 0 2 1\n3 0 3 2\n3 0 1 5\n3 0 5 4\n3 1 2 6\n3 1 6 5\n3 2 3 7\n3 2 7 6\n3 3 0 4\n3 3 4 7\n3 4 5 6\n3 4 6 7
"""


@needs_meshes
class Deformable(CommandTest):
    def changed(self, *changes):
        """The shipped scene with texts replaced, each of which it has."""
        text = SCENE
        for before, after in changes:
            self.assertIn(before, text)
            text = text.replace(before, after)
        return self.write("scene.yaml", text)

    def refused(self, reason, *changes):
        result = tactor("check", self.changed(*changes))
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        self.assertIn(reason, result.stderr)

    def test_dynamics_of_rigid_bodies_refuses_a_scene_that_deforms(self):
        for kind in ("dynamics.rigid", "dynamics.translation"):
            with self.subTest(kind):
                self.refused(f"{kind} moves rigid bodies, and body 'gel' deforms; use dynamics.deformable",
                             ("type: dynamics.deformable", f"type: {kind}"))

    def test_a_step_of_rigid_bodies_in_the_tick_refuses_a_scene_that_deforms(self):
        result = tactor("check", GRAPHS / "gel_cube/scene.yaml", "--over", "direct")
        self.assertEqual(result.returncode, 2)
        self.assertIn("interpolation.direct steps rigid bodies, and body 'gel' deforms; use --over local", result.stderr)

    def test_the_cost_of_a_node_that_is_left_out_is_told(self):
        result = self.run_ok("check", "--explain", GRAPHS / "gel_cube/scene.yaml", "--set", "collision.cost={constant: 5 ms}")
        self.assertIn("its declared cost is left out too: give a cost to the node that does its work", " ".join(result.stdout.split()))

    def test_an_open_mesh_cannot_deform(self):
        self.write("open.off", OPEN)
        self.refused("open.off", (BOX, "mesh: open.off"))

    def test_a_surface_that_cuts_itself_is_refused_with_the_place_and_what_to_try(self):
        self.write("bow.off", CUTS_ITSELF)
        self.refused("the surface cuts itself", (BOX, "mesh: bow.off"))
        self.refused("or try `tactor mesh repair", (BOX, "mesh: bow.off"))

    def test_a_run_refuses_what_check_refuses_with_the_line(self):
        for reason, before, after in (("expected a file that exists", BOX, "mesh: nowhere.off"),
                                      ("did you mean \"young\"?", "young: 20 kPa", "youngs: 20 kPa"),
                                      ("expected a number from 0 to 0.495", "poisson: 0.45", "poisson: 0.5"),
                                      ("hold all its nodes", "p: [0, 0, -20 mm]", "p: [0, 0, 40 mm]"),
                                      ("contains no centroid of a tetrahedron", FIXED, FIXED + "\n      inclusions: "
                                       "{lump: {p: [1, 0, 0], radius: 5 mm, young: 200 kPa}}")):
            with self.subTest(reason):
                result = tactor("run", self.changed((before, after)), "--duration", "0.1", "--out", self.folder / "refused")
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertRegex(result.stderr, r"scene\.yaml:\d+:\d+: ")
                self.assertIn(reason, result.stderr)
                self.assertFalse((self.folder / "refused/summary.json").exists())

    def test_faces_of_a_name_that_the_mesh_does_not_have_are_refused(self):
        self.refused("it has no faces named 'bottom'", (FIXED, "fixed: {faces: bottom}"))

    def test_a_region_that_holds_nothing_is_refused_with_where_the_body_is(self):
        self.refused("holds no node of it; the body lies between", ("p: [0, 0, -20 mm]", "p: [0, 0, -30 mm]"))

    def test_a_scene_without_a_tool_is_refused(self):
        begin, end = SCENE.index("    tool:\n"), SCENE.index("\nnodes:")
        self.refused("nothing in the scene moves", (SCENE[begin:end], ""))

    def test_dynamics_of_deformable_bodies_needs_one(self):
        begin, end = SCENE.index("      young:"), SCENE.index("      material:")
        self.refused("dynamics.deformable needs a body with motion: deformable", (SCENE[begin:end], ""),
                     ("motion: deformable", "motion: static"))

    def test_a_body_that_nothing_holds_is_warned_of_where_it_has_weight_and_only_there(self):
        warning = "find no balance under their weight"
        weightless = self.run_ok("check", self.changed((FIXED, "drag: 0 1/s")))
        self.assertNotIn(warning, weightless.stderr)
        heavy = self.run_ok("check", self.changed((FIXED, "drag: 0 1/s"), ("gravity: [0, 0, 0]", "gravity: [0, 0, -9.81]")))
        self.assertIn(warning, heavy.stderr)
        self.assertIn("body 'gel' is held nowhere and falls: give it `fixed`", heavy.stderr)

    def test_a_body_softer_than_any_tissue_is_warned_of(self):
        for young, warned in (("20", True), ("20 kPa", False), ("0.1 kPa", False)):
            with self.subTest(young):
                text = self.run_ok("check", GRAPHS / "gel_cube/scene.yaml", "--set", f"scene.bodies.gel.young={young}").stderr
                self.assertEqual(f"young is {young} Pa, softer than any tissue" in text, warned)

    def test_check_tells_tetrahedra_solver_and_why_collision_is_left_out(self):
        result = self.run_ok("check", "--explain", GRAPHS / "gel_cube/scene.yaml")
        said = result.stdout + result.stderr
        self.assertRegex(said, r"body 'gel': \d+ tetrahedra, \d+ nodes")
        self.assertIn("solver auto is eigen, because there are fewer than 1,000 tetrahedra", said)
        self.assertIn("dynamics.deformable finds those contacts itself", " ".join(said.split()))


if __name__ == "__main__":
    unittest.main()
