"""A reference that follows a live run: its figures in the summary, and what it refuses."""
import unittest

from harness import GRAPHS, CommandTest, needs_live, tactor

WALL = f"extends: {GRAPHS / 'wall/refit.yaml'}\nclock: real\n"


@needs_live
class Follow(CommandTest):
    def test_the_figures_of_the_follower_agree_with_those_of_the_run_afterwards(self):
        summary = self.run_graph(self.write("wall.yaml", WALL), "--duration", "4 s", "--follow")
        follow, delivered = summary["follow"], summary["delivered"]["force"]
        self.assertEqual((follow["skips"], follow["dropped"]), (0, 0))
        self.assertGreater(follow["compared_s"], 3)
        # One physics steps 1,000 times a second, the other 10,000 times.
        self.assertLess(abs(follow["rms_error_N"] / delivered["rms_error_N"] - 1), 0.15)
        self.assertNotIn("follow", self.run_graph(self.write("wall.yaml", WALL), "--duration", "0.5 s", out="plain"))

    def test_what_cannot_be_followed_is_refused_and_loses_no_earlier_results(self):
        graph = self.write("wall.yaml", WALL)
        self.run_graph(graph, "--duration", "0.5 s", out="out")
        kept = {file.name: file.read_bytes() for file in (self.folder / "out").iterdir()}
        unjudged = self.write("unjudged.yaml", WALL + "nodes: {metrics: ~}\nrecord: [coupling.force]\n")
        for graph, options, reason in ((unjudged, (), "no reference can follow this run"),
                                       (graph, ("--set", "clock=virtual"), "--follow: expected a graph with clock: real")):
            with self.subTest(reason):
                result = tactor("run", graph, "--follow", "--overwrite", "--out", self.folder / "out", *options)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertIn(reason, result.stderr)
                self.assertEqual({file.name: file.read_bytes() for file in (self.folder / "out").iterdir()}, kept)


if __name__ == "__main__":
    unittest.main()
