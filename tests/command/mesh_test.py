"""What a user sees of repaired, odd and refused meshes."""
import unittest

from harness import GRAPHS, CommandTest, needs_meshes, tactor

CORNERS = [(x, y, z) for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)]
QUADS = ["1 3 4 2", "5 6 8 7", "1 2 6 5", "3 7 8 4", "1 5 7 3", "2 4 8 6"]


def cube(edge, quads=None):
    """A cube as OBJ; its quads are counter-clockwise from outside."""
    points = "".join(f"v {x * edge / 2} {y * edge / 2} {z * edge / 2}\n" for x, y, z in CORNERS)
    return points + "".join(f"f {quad}\n" for quad in quads or QUADS)


@needs_meshes
class Meshes(CommandTest):
    def graph(self, obstacle):
        """A graph whose tool is a sound cube and whose obstacle, the body `bunny`, is this text in OBJ."""
        triangles = [f"{a} {b} {c}" for a, b, c, _ in map(str.split, QUADS)]
        triangles += [f"{a} {c} {d}" for a, _, c, d in map(str.split, QUADS)]
        self.write("tool.obj", cube(0.02, triangles))
        self.write("stone.obj", obstacle)
        return self.write("stones.yaml", f"extends: {GRAPHS}/bunny/off.yaml\nduration: 10 ms\nscene:\n  bodies:\n"
                                         "    bunny: {mesh: stone.obj}\n    tool: {mesh: tool.obj}\n")

    def test_repairs_are_told_once_on_standard_error_and_the_same_from_the_cache(self):
        graph = self.graph(cube(0.1, [QUADS[0][::-1], *QUADS[1:]]))
        line = (f"tactor: body 'bunny': {self.folder / 'stone.obj'}: repaired: 6 polygons were cut into triangles, "
                "1 face was turned round to look out of the material\n")
        for arguments in (("check", graph), ("check", graph), ("run", graph, "--out", self.folder / "out"),
                          ("compare", graph, graph, "--seeds", "1", "--out", self.folder / "compared")):
            # Beside it: the bodies are too far apart to touch.
            told = self.run_ok(*arguments).stderr.splitlines(keepends=True)
            self.assertEqual([text for text in told if "does not lead the tool" not in text], [line])
        self.assertEqual(len(list(self.cache_folder.glob("*.mesh"))), 2)

    def test_a_refused_mesh_is_bad_input_with_body_file_and_fault(self):
        graph = self.graph(cube(0.1, QUADS[1:]))
        for verb in ("check", "run", "compare"):
            result = tactor(verb, graph, cwd=self.folder, environment=self.environment)
            self.assertEqual(result.returncode, 2, result.stdout)
            self.assertIn(f"body 'bunny': {self.folder / 'stone.obj'}: the surface is not closed: 4 edges", result.stderr)
            self.assertNotIn("ok", result.stdout)
        self.assertFalse((self.folder / "out" / "stones" / "summary.json").exists())

    def test_a_broken_line_is_named(self):
        graph = self.graph(cube(0.1, [*QUADS[:5], "2 4 8 9"]))
        result = tactor("check", graph, environment=self.environment)
        self.assertEqual(result.returncode, 2)
        self.assertIn("stone.obj:14: expected an index from 1 to 8", result.stderr)

    def test_a_mesh_in_millimetres_is_refused_with_the_scale_to_write_and_accepted_with_it(self):
        graph = self.graph(cube(70.2))
        result = tactor("check", graph, environment=self.environment)
        self.assertEqual(result.returncode, 2)
        self.assertIn("is 70.2 m long; is it in mm? write scale: 0.001", result.stderr)
        result = self.run_ok("check", graph, "--set", "scene.bodies.bunny.scale=0.001")
        self.assertNotIn("long", result.stderr)
        result = self.run_ok("check", graph, "--set", "scene.bodies.bunny.scale=1")
        self.assertIn("warning: is 70.2 m long", result.stderr)
        # The resolved graph keeps what was said of the scale, and what was not.
        self.run_ok("run", graph, "--set", "scene.bodies.bunny.scale=0.001", "--out", self.folder / "out")
        self.assertEqual((self.folder / "out" / "graph.yaml").read_text().count("scale: "), 1)

    def test_a_cache_that_cannot_be_written_is_noted_and_the_run_goes_on(self):
        graph = self.graph(cube(0.1))
        file = self.write("file", "")
        result = self.run_ok("check", graph, environment={"TACTOR_CACHE": str(file)})
        self.assertEqual(result.stderr.count("the cache cannot be written"), 1)


if __name__ == "__main__":
    unittest.main()
