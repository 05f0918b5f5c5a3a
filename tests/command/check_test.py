"""Every shipped graph is checked. This makes the cells and tetrahedra of their meshes, which the other tests then find."""
import unittest

from harness import CommandTest, graph_files, needs_meshes


@needs_meshes
class ShippedGraphs(CommandTest):
    def test_every_graph_checks(self):
        graphs = graph_files()
        self.assertGreater(len(graphs), 20)
        self.run_ok("check", *graphs)


if __name__ == "__main__":
    unittest.main()
