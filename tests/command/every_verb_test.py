"""What one verb takes the others take, over the shipped graphs."""
import json
import re
import unittest

from harness import GRAPHS, CachedTest, few_tetrahedra, needs_meshes, tactor

# What a verb may refuse although `run` takes the graph, and the words that say why.
REFUSALS = {
    # The trials here are shorter than any window.
    "lean": "found a device in closed loop|no node reports the error|no error can be told|is not warm after",
}


@needs_meshes
class EveryVerb(CachedTest):
    """What one verb takes the others take, and none crashes. Cheap verbs take every file, dear ones graphs that have every
    type of node between them."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        cls.files = sorted(file for file in GRAPHS.glob("**/*.yaml") if file.parent.name not in ("studies", "textures", "costs"))
        cls.checked = {file: cls.tell("check", file) for file in cls.files}
        cls.taken = [file for file in cls.files if cls.checked[file].returncode == 0]
        cls.drawn = {file: cls.tell("graph", file) for file in cls.files}
        cls.types = {file: set(re.findall(r'<br/>([a-z_]+\.[a-z_]+)"\]', cls.drawn[file].stdout)) for file in cls.taken}

    @classmethod
    def tell(cls, *arguments):
        return tactor(*arguments, environment={"TACTOR_CACHE": str(cls.cache)})

    def covering(self):
        """A few of the graphs, which have every type of node that any of them has."""
        left = set().union(*self.types.values())
        while left:
            best = max(self.types, key=lambda file: (len(self.types[file] & left), -len(self.types[file]), str(file)))
            left -= self.types[best]
            yield best

    def takes(self, verb, graph, *arguments):
        """Whether it takes the graph, which it may refuse with a reason and must not crash on; the reason."""
        done = self.tell(verb, graph, *arguments)
        self.assertIn(done.returncode, (0, 2), f"{verb} {graph} ended with {done.returncode}:\n{done.stdout}\n{done.stderr}")
        return done.returncode == 0, done.stderr

    def test_check_and_graph_take_the_same_files_and_refuse_the_others_by_their_place(self):
        self.assertGreater(len(self.files), 180)
        self.assertGreater(len(self.taken), 90)
        self.assertEqual(len(self.files), len(set(self.files)))
        for file in self.files:
            with self.subTest(graph=str(file.relative_to(GRAPHS))):
                checked, drawn = self.checked[file], self.drawn[file]
                self.assertIn(checked.returncode, (0, 2), checked.stderr)
                self.assertEqual(drawn.returncode, checked.returncode, drawn.stderr)
                if checked.returncode == 2:
                    self.assertIn(file.name, checked.stderr)

    def test_the_dear_verbs_take_graphs_that_have_every_type_of_node(self):
        graphs = list(self.covering())
        self.assertGreater(len(graphs), 10)
        for graph in graphs:
            short = ("--duration", "30 ms", "--set", "clock=virtual", *few_tetrahedra(graph))
            with self.subTest(graph=str(graph.relative_to(GRAPHS))):
                again = self.write("again.yaml", f"extends: {graph}\n")
                taken, why = self.takes("run", graph, *short, "--out", self.folder / "run", "--overwrite")
                others = {
                    "explain": ("--repeats", "1"),
                    "lean": ("--budget", "1000", "--seeds", "1", "--repeats", "1", "--out", self.folder / "lean.yaml", "--overwrite"),
                    "compare": (again, "--seeds", "1", "--judge", "whole", "--out", self.folder / "compare", "--overwrite"),
                }
                for verb, more in others.items():
                    also, refused = self.takes(verb, graph, *more, *short)
                    if taken and not also:
                        self.assertRegex(refused, REFUSALS.get(verb, "$^"), verb)
                if not taken:
                    self.assertRegex(why, "expected|drives hardware")

    def test_explain_follows_a_run_whose_nodes_set_parameters_of_others(self):
        """A trial of the simulated experiment: the first setting comes after 6 s, the next after 12 s."""
        found = json.loads(self.run_ok("explain", GRAPHS / "experiments/simulated.yaml", "--duration", "13 s", "--repeats", "1", "--json").stdout)
        nodes = {node["node"]: node for node in found["nodes"]}
        self.assertGreater(nodes["protocol"]["steps"], 2000)
        self.assertTrue(all(node["steps"] > 0 for node in nodes.values()), nodes)


if __name__ == "__main__":
    unittest.main()
