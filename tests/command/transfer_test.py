"""The transfer scenes: those that lie in the graphs are the draw they say, every kind of any draw is a graph, and its figures are those of its seed."""
import filecmp
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
TACTOR = pathlib.Path(os.environ.get("TACTOR", ROOT / "build/release/bin/tactor")).resolve()
SCENES = ROOT / "graphs/transfer"


def draw(folder, seed):
    subprocess.run([sys.executable, "-B", SCENES / "make.py", folder, "--seed", str(seed), "--meshes", folder / "meshes"], check=True)
    return sorted(folder.glob("*.yaml"))


class Transfer(unittest.TestCase):
    def setUp(self):
        kept = tempfile.TemporaryDirectory()
        self.addCleanup(kept.cleanup)
        self.folder = pathlib.Path(kept.name)

    def tactor(self, *arguments, **environment):
        return subprocess.run([TACTOR, *arguments], capture_output=True, text=True, check=False, env={**os.environ, **environment})

    def test_the_scenes_that_lie_here_are_draw_1(self):
        drawn = draw(self.folder, 1)
        self.assertGreaterEqual(len(drawn), 24)
        lying = sorted(p for p in SCENES.glob("*.yaml") if p.name != "base.yaml")
        self.assertEqual([p.name for p in drawn], [p.name for p in lying], "write them again: graphs/transfer/make.py graphs/transfer")
        for ours, theirs in zip(lying, drawn):
            a, b = ([line for line in p.read_text().splitlines() if not line.startswith("extends:")] for p in (ours, theirs))
            self.assertEqual(a, b, ours.name)

    def test_a_draw_depends_on_its_seed_alone(self):
        (self.folder / "a").mkdir(), (self.folder / "b").mkdir(), (self.folder / "c").mkdir()
        a, b, c = (draw(self.folder / name, seed) for name, seed in (("a", 7), ("b", 7), ("c", 8)))
        self.assertTrue(all(filecmp.cmp(x, y, shallow=False) for x, y in zip(a, b)))
        self.assertFalse(any(filecmp.cmp(x, y, shallow=False) for x, y in zip(a, c)))

    def test_every_kind_of_a_new_draw_is_a_graph(self):
        for graph in draw(self.folder, 4711):
            with self.subTest(graph.stem):
                done = self.tactor("check", str(graph), "--over", "local", TACTOR_MESH_PATH=str(self.folder / "meshes"))
                self.assertEqual(done.returncode, 0, done.stderr)
                # Slow scenes state the bound that they need.
                self.assertNotIn("physics may take", done.stderr)


if __name__ == "__main__":
    unittest.main()
