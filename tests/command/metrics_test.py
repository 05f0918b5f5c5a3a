"""What metrics mean is frozen: another definition needs another version, which the page and every table name."""
import json
import pathlib
import re
import unittest

from harness import GRAPHS, ROOT, CommandTest, tactor

FROZEN = pathlib.Path(__file__).parent / "metric_definitions.txt"


def declared():
    """A line a metric that judges a run: name, unit, which is better, and what it is."""
    text = tactor("nodes", "sink.metrics").stdout.partition("\nmetrics\n")[2]
    rows = re.findall(r"^  (\S+) \(([^;)]*)(?:; (lower|higher|near zero) is better)?\)\n      (.*)$", text, re.MULTILINE)
    return [" | ".join((name, unit.replace("number", ""), better, meaning)) for name, unit, better, meaning in rows]


class Definitions(CommandTest):
    def version(self):
        graph = self.judged_small_graph()
        return self.run_graph(graph)["metric_definitions"]

    def test_they_are_those_of_their_version(self):
        version, *frozen = FROZEN.read_text().splitlines()
        self.assertEqual(version, f"version {self.version()}")
        self.assertEqual(declared(), frozen, f"the definition of a metric has changed: raise `metric_definitions`, write what is new "
                         f"to docs/reference/metrics.md, and the version and these lines to {FROZEN.name}")
        self.assertGreater(len(frozen), 40)

    def test_the_page_is_of_that_version(self):
        page = (ROOT / "docs/reference/metrics.md").read_text()
        self.assertIn(f"**Version {self.version()} of the definitions.**", page)

    def test_every_table_names_it(self):
        version = self.version()
        said = f"metrics by version {version} of their definitions"
        wall = GRAPHS / "wall"
        out = self.folder / "compare"
        shown = self.run_ok("compare", wall / "off.yaml", wall / "fixed.yaml", "--seeds", "2", "--duration", "0.5", "--out", out)
        self.assertIn(said, shown.stdout)
        self.assertIn(said, (out / "report.html").read_text())
        self.assertEqual(json.loads((out / "compare.json").read_text())["metric_definitions"], version)
        study = self.write("study.yaml", f"graphs: [{wall / 'scene.yaml'}]\nmethods: [{GRAPHS / 'methods/hold.yaml'}]\nseeds: 2\nduration: 0.5 s\n")
        out = self.folder / "study"
        shown = self.run_ok("study", study, "--out", out)
        self.assertIn(said, shown.stdout)
        self.assertIn(said, (out / "report.html").read_text())
        self.assertEqual(json.loads((out / "study.json").read_text())["metric_definitions"], version)


if __name__ == "__main__":
    unittest.main()
