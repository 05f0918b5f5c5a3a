"""`tactor mesh` and `tactor new graph`: what they make is judged by computations of the test's own, and by running it."""
import json
import math
import os
import pathlib
import re
import shutil
import sys
import unittest

from harness import LIBRARIES, ROOT, CommandTest, needs_meshes, tactor

sys.path[:0] = [str(ROOT / "bench/meshes"), str(ROOT / "graphs/transfer")]
import broken  # noqa: E402
import make  # noqa: E402
import measure  # noqa: E402
from shapes import ball, box, write_off  # noqa: E402

BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
REFUSED = ROOT / "bench/meshes/refused.txt"
SCENES = ROOT / "bench/meshes/scenes.txt"


def volume(file):
    """By the divergence theorem, from the file."""
    points, triangles, _ = measure.read_off(file)
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return float((a * measure.numpy.cross(b, c)).sum() / 6)


@needs_meshes
class Mesh(CommandTest):
    def made(self, name, of=REFUSED):
        return make.make(of, self.folder / "made", BUILD, {name})[name]

    def refused(self, *words):
        result = tactor(*words, environment=self.environment, cwd=self.folder)
        self.assertEqual(result.returncode, 2, result.stdout)
        return result.stderr

    def test_the_lists_are_of_a_hundred_different_meshes(self):
        for file in (REFUSED, SCENES):
            names = make.names(file)
            self.assertEqual((len(names), len(set(names))), (100, 100))

    def test_a_repaired_mesh_passes_the_check_and_moved_no_further_than_it_says(self):
        for name in ("archive/bull.off", "broken/torus_hole.off", "broken/ball_holes.off", "broken/block_slit.off", "broken/ball_gaps.off",
                     "broken/blob_crack.off", "broken/torus_fins.off", "broken/ball_stray.off", "broken/block_t_junctions.off",
                     "broken/torus_folds.off", "broken/ball_overlap.off", "broken/ball_touch.off", "broken/block_touch.off", "broken/blob_mixed.off"):
            with self.subTest(mesh=name):
                file, out = self.made(name), self.folder / "out.off"
                before = self.refused("mesh", "check", file, "--scale", "1")
                told = json.loads(self.run_ok("mesh", "repair", file, "--out", out, "--overwrite", "--json").stdout)
                self.run_ok("mesh", "check", out, "--scale", "1")
                self.assertTrue(told["changes"])
                there, back = measure.check_moved(file, out, told, 400)
                slack = 1e-9 * told["diagonal"]
                self.assertLessEqual(there, told["old_to_new"] + slack, before)
                self.assertLessEqual(back, told["new_to_old"] + slack)
                self.assertLessEqual(told["moved_of_diagonal"], 0.01)
                self.assertAlmostEqual(volume(out) / told["volume_after"], 1, places=9)

    def test_the_volume_of_a_broken_shape_comes_back(self):
        for shape, share in (("ball", 0.01), ("torus", 0.01), ("block", 0.001)):
            whole = self.folder / f"{shape}.off"
            write_off(broken.SOURCES[shape](), whole)
            for fault in ("hole", "fins", "stray", "gaps", "t_junctions"):
                with self.subTest(shape=shape, fault=fault):
                    out = self.folder / "out.off"
                    self.run_ok("mesh", "repair", self.made(f"broken/{shape}_{fault}.off"), "--out", out, "--overwrite")
                    self.assertAlmostEqual(volume(out) / volume(whole), 1, delta=share)

    def test_overlapping_balls_become_their_union(self):
        # Two balls of radius r at a distance d: the lens that both have in common counts once.
        r, d = 0.05, 0.06
        mesh = broken.joined(ball(r, 64), broken.moved(ball(r, 64), (d, 0, 0)))
        file, out = self.folder / "two.off", self.folder / "one.off"
        write_off(mesh, file)
        told = json.loads(self.run_ok("mesh", "repair", file, "--out", out, "--json").stdout)
        lens = math.pi * (4 * r + d) * (2 * r - d) ** 2 / 12
        self.assertAlmostEqual(volume(out) / (2 * 4 / 3 * math.pi * r**3 - lens), 1, delta=0.01)
        # Of each ball a cap of the height r - d / 2 lies inside the other.
        self.assertAlmostEqual(told["inside_share"], (r - d / 2) / (2 * r), delta=0.01)

    def test_bodies_that_overlap_are_counted_and_only_what_lies_inside_is_left_out(self):
        # Two pairs of cubes; a quarter of three sides of each lies inside the other.
        cube, far = box(0.1, 0.1, 0.1), (1.0, 0.0, 0.0)
        pair = broken.joined(cube, broken.moved(cube, (0.05, 0.05, 0.05)))
        file, out = self.folder / "four.off", self.folder / "two.off"
        write_off(broken.joined(pair, broken.moved(pair, far)), file)
        told = json.loads(self.run_ok("mesh", "repair", file, "--out", out, "--json").stdout)
        self.assertEqual(told["changes"], ["4 bodies that overlapped were united to 2"])
        self.assertAlmostEqual(volume(out) / (2 * (2 - 1 / 8) * 1e-3), 1, places=9)
        self.assertAlmostEqual(told["inside_share"], 1 / 8, delta=0.005)
        self.assertEqual(len(told["inside_faces"]), 24)
        self.assertEqual(told["removed_faces"], [])
        self.assertLessEqual(told["old_to_new"], 1.001e-4 * told["diagonal"])
        said = self.run_ok("mesh", "repair", file, "--out", out, "--overwrite").stdout
        self.assertRegex(said, r"but for the part that lies inside now, 1[23]\S* % of its area")

    def test_check_says_what_a_graph_says(self):
        file = self.made("broken/ball_hole.off")
        graph = self.write("g.yaml", f"format: 2\nextends: {ROOT}/graphs/wall/scene.yaml\nscene: {{bodies: {{wall: {{plane: ~, mesh: {file}}}}}}}\n")
        said = self.refused("mesh", "check", file).strip()
        self.assertIn(said, self.refused("check", graph))
        self.assertTrue(said.endswith(f"; or try `tactor mesh repair {file} --out ball_hole_repaired.off`"), said)
        told = json.loads(tactor("mesh", "check", file, "--json", environment=self.environment).stdout)
        self.assertEqual((told["accepted"], told["refusal"]), (False, said))
        # So does the size.
        file = self.made("sound/ball_in_mm.off", SCENES)
        told = json.loads(self.run_ok("mesh", "check", file, "--json", "--unit", "cm").stdout)
        self.assertEqual((told["accepted"], told["scale"]), (True, 0.01))

    def test_a_mesh_in_mm_is_read_as_new_graph_reads_it(self):
        file = self.made("sound/ball_in_mm.off", SCENES)
        self.assertIn("a graph takes it with scale: 0.001 (80 units long, taken as mm;", " ".join(self.run_ok("mesh", "check", file).stdout.split()))
        self.assertIn("with scale: 0.001", self.run_ok("mesh", "info", file).stdout)
        for word, scale in (("--unit", "mm"), ("--scale", "0.001")):
            said = self.run_ok("mesh", "check", file, word, scale).stdout
            self.assertIn("with scale: 0.001", said)
            self.assertNotIn("taken as", said)
        self.assertIn("is 80 m long with its scale, which is unusual", " ".join(self.run_ok("mesh", "check", file, "--unit", "m").stdout.split()))
        self.assertIn("--unit", self.refused("mesh", "check", file, "--unit", "feet"))
        self.assertIn("excludes", self.refused("mesh", "check", file, "--unit", "mm", "--scale", "0.001"))
        # Neither in m nor in mm of a size that one touches.
        write_off(box(11.0, 11.0, 11.0), self.folder / "odd.off")
        self.assertIn("is 11 m long; is it in mm? write scale: 0.001, or mesh check --unit mm", self.refused("mesh", "check", self.folder / "odd.off"))

    def test_holes_are_filled_up_to_a_stated_width_and_sheets_are_not(self):
        file, out = self.made("broken/ball_hole.off"), self.folder / "out.off"
        # A cube of 100 without its lid, which two triangles fill.
        self.assertIn("the widest 100 wide (57.7", self.refused("mesh", "repair", self.made("archive/open_cube.off"), "--out", out, "--max-hole", "50 %"))
        self.assertIn("1 hole is wider than --max-hole 0.001, the widest 0.0", self.refused("mesh", "repair", file, "--out", out, "--max-hole", "0.001"))
        self.assertFalse(out.exists())
        self.run_ok("mesh", "repair", file, "--out", out, "--max-hole", "30 %")
        sheet = self.made("archive/patch-13.off")
        self.assertRegex(self.refused("mesh", "repair", sheet, "--out", self.folder / "s.off"), "wider than --max-hole|open sheet")

    def test_a_wrap_closes_what_nothing_else_does(self):
        out = self.folder / "out.off"
        file = self.made("archive/patch-13.off")
        self.refused("mesh", "repair", file, "--out", out)
        told = json.loads(self.run_ok("mesh", "repair", file, "--out", out, "--wrap", "--json").stdout)
        self.run_ok("mesh", "check", out, "--scale", "0.001")
        there, back = measure.check_moved(file, out, told, 300)
        self.assertLessEqual(there, told["old_to_new"])
        self.assertLessEqual(back, told["new_to_old"])

    def test_decimation_keeps_a_solid_and_tells_how_far_it_moved(self):
        whole, out = self.folder / "whole.off", self.folder / "out.off"
        write_off(ball(0.05, 64), whole)
        told = json.loads(self.run_ok("mesh", "decimate", whole, "--faces", "501", "--out", out, "--json").stdout)
        self.assertEqual(told["faces"], 500)
        self.run_ok("mesh", "check", out)
        there, back = measure.check_moved(whole, out, {**told, "removed_faces": [], "filled_faces": []})
        self.assertLessEqual(there, told["old_to_new"])
        self.assertLessEqual(back, told["new_to_old"])
        self.assertGreater(there, 0.5 * told["old_to_new"])
        self.assertIn("fewer than the 90000 asked for", self.refused("mesh", "decimate", whole, "--faces", "90000", "--out", self.folder / "x.off"))

    def test_info_measures_a_ball(self):
        file = self.folder / "ball.off"
        write_off(ball(0.05, 192), file)
        told = json.loads(self.run_ok("mesh", "info", file, "--json").stdout)
        mass = 1000 * 4 / 3 * math.pi * 0.05**3
        self.assertTrue(told["closed"])
        self.assertEqual(told["pieces"], 1)
        self.assertAlmostEqual(told["area"] / (4 * math.pi * 0.05**2), 1, delta=1e-3)
        self.assertAlmostEqual(told["mass_at_1000"] / mass, 1, delta=1e-3)
        self.assertAlmostEqual(told["inertia_at_1000"][1][1] / (0.4 * mass * 0.05**2), 1, delta=2e-3)
        self.assertIn("a graph takes it", self.run_ok("mesh", "info", file).stdout)

    def test_every_format_reads_back_as_the_same_mesh(self):
        file = self.made("broken/torus_hole.off")
        first = None
        for ending in ("off", "obj", "ply", "stl"):
            out = self.folder / f"out.{ending}"
            self.run_ok("mesh", "repair", file, "--out", out)
            told = json.loads(self.run_ok("mesh", "info", out, "--json").stdout)
            self.assertEqual(told["format"], ending.upper())
            same = (told["faces"], told["volume"], told["area"])
            first = first or same
            self.assertEqual(same[0], first[0])
            self.assertAlmostEqual(same[1] / first[1], 1, places=12)
            self.assertAlmostEqual(same[2] / first[2], 1, places=12)

    def test_nothing_is_written_over_and_bad_words_are_bad_input(self):
        file, out = self.made("broken/ball_hole.off"), self.write("there.off", "mine")
        self.assertIn("--overwrite replaces it", self.refused("mesh", "repair", file, "--out", out))
        self.assertEqual(out.read_text(), "mine")
        self.assertIn("a file other than the mesh itself", self.refused("mesh", "repair", file, "--out", file, "--overwrite"))
        self.assertIn("the ending .off, .obj, .stl or .ply", self.refused("mesh", "repair", file, "--out", self.folder / "x.txt"))
        self.assertIn("--max-hole", self.refused("mesh", "repair", file, "--out", self.folder / "x.off", "--max-hole", "wide"))
        self.assertIn("a file that exists", self.refused("mesh", "check", "none.off"))
        self.assertIn("expected", self.refused("mesh", "repair", self.write("bad.off", "OFF\n3 1"), "--out", self.folder / "x.off"))
        self.assertIn("one element vertex and one element face", self.refused("mesh", "repair", self.write("p.ply", POINTS), "--out", self.folder / "x.off"))


class WithoutCgal(CommandTest):
    """A copy of the command's library beside which the plugin does not lie."""

    def setUp(self):
        super().setUp()
        library = self.folder / "lib"
        library.mkdir()
        for file in LIBRARIES.glob("libtactor.so*"):
            shutil.copy(file, library, follow_symlinks=False)
        self.environment["LD_LIBRARY_PATH"] = str(library)

    def test_what_needs_the_plugin_says_so_and_a_scene_takes_the_mesh_as_it_is(self):
        mesh, out = self.folder / "box.off", self.folder / "out.off"
        write_off(box(0.1, 0.06, 0.04), mesh)
        for words in (("check",), ("info",), ("repair", "--out", out), ("decimate", "--faces", "8", "--out", out)):
            result = tactor("mesh", words[0], mesh, *words[1:], environment=self.environment)
            self.assertEqual(result.returncode, 2, result.stdout)
            self.assertIn(f"tactor mesh {words[0]} needs the plugin tactor_cgal (package tactor-cgal", result.stderr)
            self.assertFalse(out.exists())
        said = self.run_ok("new", "graph", "taken", "--mesh", mesh, "--in", self.folder).stderr
        self.assertIn("it was neither checked nor repaired, because the plugin tactor_cgal is not installed", said)

    @needs_meshes
    def test_without_the_plugin_of_meshing_a_scene_checks_its_mesh_and_repairs_ask_for_it(self):
        plugins = self.folder / "lib/tactor/plugins"
        plugins.mkdir(parents=True)
        shutil.copy(LIBRARIES / "tactor/plugins/libtactor_cgal.so", plugins)
        mesh, out = self.folder / "box.off", self.folder / "out.off"
        write_off(box(0.1, 0.06, 0.04), mesh)
        self.assertIn("ok, a graph takes it", self.run_ok("mesh", "check", mesh).stdout)
        for words in (("repair",), ("decimate", "--faces", "8")):
            result = tactor("mesh", words[0], mesh, *words[1:], "--out", out, environment=self.environment)
            self.assertEqual(result.returncode, 2, result.stdout)
            self.assertIn("needs the plugin tactor_meshing (package tactor-cgal, or a build of the target tactor_meshing",
                          result.stderr.replace("\n", " "))
            self.assertFalse(out.exists())
        self.assertEqual(self.run_ok("new", "graph", "taken", "--mesh", mesh, "--in", self.folder).stderr, "")


POINTS = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n"


@needs_meshes
class NewGraph(CommandTest):
    def new(self, name, *words, code=0):
        result = tactor("new", "graph", name, "--in", self.folder, *words, environment=self.environment)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result

    def touches(self, graph, duration="6 s"):  # the motion once
        summary = self.run_graph(graph, "--duration", duration)
        self.assertGreater(summary["contacts"]["max"], 0)
        # The hand presses 3 mm or less into a spring of 354 N/m, and 8 N is the coupling's limit.
        self.assertGreater(summary["reference"]["force"]["rms_N"], 0.02)
        self.assertLess(summary["reference"]["force"]["rms_N"], 2)
        if "deformable" not in summary:
            self.assertLess(summary["dynamics_energy_generated_max_J"], 1e-3)
        return summary

    def test_scenes_around_meshes_of_all_sorts_touch_them(self):
        for number, name in enumerate(("sound/needle.stl", "sound/ball_of_a_hair.off", "sound/far_from_the_origin.off", "archive/star.off",
                                       "sound/inside_out.off", "broken/torus_gaps.off")):
            with self.subTest(mesh=name):
                mesh = make.make(SCENES, self.folder / "made", BUILD, {name})[name]
                said = self.new(f"s{number}", "--mesh", mesh)
                self.assertIn(f"tactor run {self.folder}/s{number}/scene.yaml", said.stdout)
                mesh.unlink()  # the scene has a copy
                self.touches(self.folder / f"s{number}/scene.yaml")
                if name.startswith("broken"):
                    self.assertIn("so it was repaired", said.stderr)

    def test_a_method_by_name_and_a_box_without_a_mesh(self):
        self.new("box", "--method", "refit")
        summary = self.touches(self.folder / "box/refit.yaml")
        self.assertGreater(summary["refits"], 0)
        text = (self.folder / "box/scene.yaml").read_text()
        self.assertIn("box: {size: [100 mm, 60 mm, 40 mm]}", text)

    def test_a_body_that_deforms_is_pressed_and_pushes_back(self):
        for number, name in enumerate(("box", "sound/ball_of_a_hair.off", "archive/star.off")):
            with self.subTest(mesh=name):
                mesh = ()
                if name != "box":
                    mesh = ("--mesh", make.make(SCENES, self.folder / "made", BUILD, {name})[name])
                self.new(f"soft{number}", *mesh, "--young", "20 kPa", "--method", "local")
                summary = self.touches(self.folder / f"soft{number}/local.yaml", "2.5 s")
                self.assertIn("deformable", summary)
                self.assertLess(summary["delivered"]["force"]["rms_error_N"], summary["reference"]["force"]["rms_N"])
        self.assertIn("expected a value in Pa from 100 to 1e+09", self.new("x", "--young", "0 Pa", code=2).stderr)

    def test_a_mesh_far_from_the_origin_is_brought_back(self):
        # 1e5 body lengths, and a place that six digits do not tell.
        mesh = self.folder / "far.off"
        write_off(broken.moved(box(0.1, 0.1, 0.1), (10000.123, -0.25, 0.0)), mesh)
        self.new("far", "--mesh", mesh)
        self.assertIn("pose: {p: [-10000123 mm, 250 mm, 0 mm]}", (self.folder / "far/scene.yaml").read_text())
        self.touches(self.folder / "far/scene.yaml")

    def test_what_fills_holes_is_told(self):
        vertices, faces = box(0.1, 0.1, 0.1)
        mesh = self.folder / "open.off"
        write_off((vertices, faces[2:]), mesh)
        said = self.new("open", "--mesh", mesh).stderr
        # A sixth of the new surface is the lid.
        self.assertIn("the widest 0.1 wide (57.74 % of the diagonal)", said)
        self.assertIn("but for the 2 faces that fill holes, 16.7 % of its area,", said)
        self.assertIn("(+20 %)", said)
        self.assertIn("ignores the faces that fill holes", said)
        self.assertIn("17 % of its surface fills holes", (self.folder / "open/scene.yaml").read_text())

    def test_the_size_is_chosen_and_told(self):
        mesh = make.make(SCENES, self.folder / "made", BUILD, {"sound/ball_in_mm.off"})["sound/ball_in_mm.off"]
        self.assertIn("taken as mm", self.new("mm", "--mesh", mesh).stderr)
        self.assertIn("scale: 0.001 ", (self.folder / "mm/scene.yaml").read_text())
        self.assertIn("scaled to 40 mm", self.new("small", "--mesh", mesh, "--size", "40 mm").stderr)
        self.assertIn("scale: 0.0005 ", (self.folder / "small/scene.yaml").read_text())
        self.new("cm", "--mesh", mesh, "--unit", "cm")
        self.assertIn("scale: 0.01 ", (self.folder / "cm/scene.yaml").read_text())

    def test_the_next_steps_name_a_view_of_several_methods(self):
        said = self.new("mine", "--method", "local").stdout
        found = re.search(r"tactor view (\S+) (--over side_by_side)", said)
        self.assertTrue(found, said)
        self.run_ok("check", self.folder / "mine" / pathlib.Path(found[1]).name, *found[2].split())

    def test_what_cannot_be_used_is_refused_and_nothing_is_written(self):
        sheet = make.make(REFUSED, self.folder / "made", BUILD, {"archive/patch-13.off"})["archive/patch-13.off"]
        said = self.new("sheet", "--mesh", sheet, code=2).stderr
        self.assertIn("the surface is not closed: 54 edges", said)
        self.assertIn("try `tactor mesh repair", said)
        self.assertFalse((self.folder / "sheet").exists())
        self.assertIn("found '../x'", self.new("../x", code=2).stderr)
        self.assertIn('did you mean', self.new("x", "--method", "refitt", code=2).stderr)
        self.new("x")
        self.assertIn("--overwrite replaces it", self.new("x", code=2).stderr)
        self.new("x", "--overwrite")


if __name__ == "__main__":
    unittest.main()
