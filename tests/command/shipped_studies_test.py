"""Every shipped study runs in short."""
import csv
import json
import unittest

import yaml

from harness import GRAPHS, graph_files, graph_name, needs_meshes
from study_harness import StudyTest


def clock_of(graph):
    """The clock of a graph file, or of what it extends."""
    content = yaml.safe_load(graph.read_text())
    if "clock" in content:
        return content["clock"]
    extended = content.get("extends", [])
    found = [clock_of(graph.parent / file) for file in ([extended] if isinstance(extended, str) else extended)]
    return next((clock for clock in reversed(found) if clock), None)


@needs_meshes
class Shipped(StudyTest):
    def test_every_shipped_graph_is_among_those_that_are_judged(self):
        study = yaml.safe_load((GRAPHS / "studies/stability_shipped.yaml").read_text())
        wanted = {graph_name(graph) for graph in graph_files() if clock_of(graph) != "real"}
        self.assertGreater(len(wanted), 50)
        self.assertEqual({graph_name(GRAPHS / "studies" / graph) for graph in study["graphs"]}, wanted)

    def test_every_study_runs_in_short(self):
        studies = sorted((GRAPHS / "studies").glob("*.yaml"))
        self.assertGreater(len(studies), 10)
        for study in studies:
            with self.subTest(study=study.name):
                self.assertIn("short", yaml.safe_load(study.read_text()))
                out = self.folder / study.stem
                self.run_ok("study", study, "--short", "--out", out)
                lines = list(csv.DictReader((out / "study.csv").read_text().splitlines()))
                self.assertGreaterEqual(len(lines), 2)
                self.assertEqual({line["status"] for line in lines}, {"done"})
                self.assertIn("<table", (out / "report.html").read_text())
                for line in lines:  # nothing that is shipped becomes NaN or infinite, nor is refused
                    if study.stem == "stability_shipped":
                        self.assertLess(float(line["stability.verdict"]), 4)
                maps = json.loads((out / "study.json").read_text()).get("stability", {}).get("maps", [])
                if study.stem.startswith("stability_scenes"):
                    self.assertEqual([m["graph"] for m in maps], ["duck", "duck_closed_loop", "bunny", "peg_in_hole"])
                    self.assertEqual([m["own"]["verdict"] for m in maps], ["stable"] * 4)


if __name__ == "__main__":
    unittest.main()
