"""The transfer scenes: those that lie in the graphs are the draw they say, every kind of any draw is a graph, and its figures are those of its seed."""
import filecmp
import functools
import pathlib
import subprocess
import sys
import tempfile
import unittest

from harness import GRAPHS, CommandTest

SCENES = GRAPHS / "transfer"


def draw(folder, seed):
    subprocess.run([sys.executable, "-B", SCENES / "make.py", folder, "--seed", str(seed), "--meshes", folder / "meshes"], check=True)
    return sorted(folder.glob("*.yaml"))


@functools.cache
def drawn(seed):
    """Made once, for all tests."""
    kept = tempfile.TemporaryDirectory()
    unittest.addModuleCleanup(kept.cleanup)
    return draw(pathlib.Path(kept.name), seed)


class Transfer(CommandTest):
    def test_the_scenes_that_lie_here_are_draw_1(self):
        self.assertGreaterEqual(len(drawn(1)), 24)
        lying = sorted(p for p in SCENES.glob("*.yaml") if p.name != "base.yaml")
        self.assertEqual([p.name for p in drawn(1)], [p.name for p in lying], "write them again: graphs/transfer/make.py graphs/transfer")
        for ours, theirs in zip(lying, drawn(1)):
            a, b = ([line for line in p.read_text().splitlines() if not line.startswith("extends:")] for p in (ours, theirs))
            self.assertEqual(a, b, ours.name)

    def test_a_draw_depends_on_its_seed_alone(self):
        with tempfile.TemporaryDirectory() as folder:
            again = draw(pathlib.Path(folder), 4711)
            self.assertTrue(all(filecmp.cmp(x, y, shallow=False) for x, y in zip(drawn(4711), again, strict=True)))
        self.assertFalse(any(filecmp.cmp(x, y, shallow=False) for x, y in zip(drawn(4711), drawn(1))))

    def test_every_kind_of_a_new_draw_is_a_graph(self):
        # With coarse cells, which decide nothing of this and take seconds of each mesh otherwise.
        done = self.run_ok("check", *drawn(4711), "--over", "local", "--set", "collision={type: collision.sdf, resolution: 16}",
                           environment=self.environment | {"TACTOR_MESH_PATH": str(drawn(4711)[0].parent / "meshes")})
        # Slow scenes state the bound that they need.
        self.assertNotIn("physics may take", done.stderr)


if __name__ == "__main__":
    unittest.main()
