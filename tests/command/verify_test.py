"""Results say what they were made from, and `tactor verify` makes them again and compares to the byte."""
import contextlib
import hashlib
import json
import os
import pathlib
import shutil
import sqlite3
import subprocess
import unittest

from harness import (HAS_HDF5, LIBRARIES, ROOT, VERSION, CommandTest, built, needs_hdf5, needs_live, tactor)

TETRAHEDRON = "OFF\n4 4 0\n0 0 0\n0.01 0 0\n0 0.01 0\n0 0 0.01\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 0 3 2\n"
MESH = "scene: {bodies: {stone: {mesh: stone.off, pose: {p: [1, 0, 0]}}}}\n"
RECORD = "record: [device.state, device.commanded]\n"


class Verify(CommandTest):
    def setUp(self):
        super().setUp()
        self.out = self.folder / "out"

    def graph(self):
        """A graph that extends another and names a mesh."""
        self.judged_small_graph()
        self.mesh = self.write("stone.off", TETRAHEDRON)
        return self.write("mine.yaml", "extends: judged.yaml\n" + MESH + (RECORD if HAS_HDF5 else ""))

    def made(self, *arguments, **options):
        return self.run_graph(self.graph(), *arguments, **options)["provenance"]

    def verify(self, code, result=None, environment=None):
        said = tactor("verify", result or self.out, environment={**self.environment, **(environment or {})})
        self.assertEqual(said.returncode, code, f"{said.stdout}\n{said.stderr}")
        return said.stdout if code != 2 else said.stderr

    def change(self, work):
        """Changes what summary.json says."""
        file = self.out / "summary.json"
        summary = json.loads(file.read_text())
        work(summary)
        file.write_text(json.dumps(summary))

    def test_a_run_is_made_again_to_the_byte_with_all_that_the_command_line_said(self):
        self.made("--set", "device.force_max=2 N", "--seed", "7", "--duration", "0.3 s")
        for result in (self.out, self.out / "summary.json"):
            said = self.verify(0, result)
            self.assertIn("The run is the same, to the byte", said)
            self.assertNotIn("differs", said)
            if HAS_HDF5:
                self.assertRegex(said, r"data sets +2 of 2 equal")
            self.assertRegex(said, r"metrics +([1-9]\d+) of \1 equal")

    def test_a_result_tells_when_where_and_from_which_files_it_was_made(self):
        made = self.made()
        for name in ("mine.yaml", "judged.yaml", "stone.off"):
            (one,) = (file for file in made["files"] if pathlib.Path(file["file"]).name == name)
            self.assertEqual(one["sha256"], hashlib.sha256((self.folder / name).read_bytes()).hexdigest())
        self.assertEqual([file["of"] for file in made["files"]], ["graph", "graph", "scene.stone"])
        self.assertRegex(made["date"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ$")
        self.assertEqual((made["host"], made["version"]), (os.environ.get("SLURMD_NODENAME") or os.uname().nodename, VERSION))
        libraries = {pathlib.Path(one["file"]).name: one for one in made["libraries"]}
        for begin in ("tactor", "libtactor.so", "libtactor_source.so", "libc.so", "libstdc++.so"):
            (one,) = (libraries[name] for name in libraries if name == begin or name.startswith(begin + "."))
            self.assertEqual(one["sha256"], hashlib.sha256(pathlib.Path(one["file"]).read_bytes()).hexdigest())
        self.assertTrue(made["compiler"] and "-W" not in made["flags"])
        report = (self.out / "report.html").read_text()
        self.assertIn("Provenance", report)
        self.assertIn(made["commit"], report)
        # The second run takes the hashes of libraries from the cache.
        self.assertEqual(self.made()["libraries"], made["libraries"])

    @unittest.skipUnless((ROOT / ".git").exists() and built("../CMakeCache.txt"), "no build of a clone")
    def test_the_commit_is_that_of_the_clone(self):
        head = subprocess.run(["git", "-C", ROOT, "rev-parse", "HEAD"], capture_output=True, text=True, check=False)
        if head.returncode != 0:
            self.skipTest("git refuses the clone")
        log = subprocess.run(["git", "-C", ROOT, "log", "--format=%H"], capture_output=True, text=True, check=True).stdout.split()
        made = self.made()
        self.assertIn(made["commit"], log)  # a later commit needs no new build
        self.assertIn(f"(commit {made['commit'][:12]}{', dirty' if made['dirty'] else ''})", self.run_ok("--version").stdout)

    @needs_hdf5
    def test_a_recording_carries_the_same(self):
        import h5py
        made = self.made()
        with h5py.File(self.out / "recording.h5") as file:
            text = file.attrs["provenance"]
            self.assertEqual(json.loads(text.decode() if isinstance(text, bytes) else text), made)

    def test_a_mesh_that_has_changed_by_a_byte_is_named(self):
        self.made()
        self.mesh.write_text(TETRAHEDRON.replace("0 0 0.01\n", "0 0 0.02\n"))
        # Nothing touches it, so the run stays the same.
        said = self.verify(0)
        self.assertRegex(said, rf"files +differs: {self.mesh} \(scene\.stone\)")
        self.mesh.unlink()
        self.assertIn(f"{self.mesh} (scene.stone) is missing", self.verify(2))

    def test_a_graph_that_has_changed_is_named_and_the_run_is_made_from_what_the_results_hold(self):
        self.made()
        file = self.folder / "judged.yaml"
        file.write_text(file.read_text().replace("10 mm", "11 mm"))
        self.assertRegex(self.verify(0), rf"differs: {file} \(graph\)")
        file.unlink()
        self.assertRegex(self.verify(0), rf"missing: {file} \(graph\)")

    def test_a_library_that_has_changed_is_named(self):
        nodes = self.folder / "nodes"
        nodes.mkdir()
        library = nodes / "libtactor_sink.so"
        shutil.copy(LIBRARIES / "tactor/libtactor_sink.so", library)
        environment = {**self.environment, "TACTOR_NODE_PATH": str(nodes), "LD_LIBRARY_PATH": str(LIBRARIES)}
        self.made(environment=environment)
        with library.open("ab") as file:
            file.write(b"\0")
        said = self.verify(0, environment=environment)
        self.assertRegex(said, rf"libraries +differs: {library}")

    @needs_hdf5
    def test_another_result_is_told_with_the_first_difference(self):
        self.made()
        (self.out / "graph.yaml").write_text((self.out / "graph.yaml").read_text().replace("0.01", "0.011"))
        said = self.verify(1)
        self.assertRegex(said, r"differs +data set device\.state: row \d+, at [\d.e-]+ s: \w+")
        self.assertIn("The run is another one now", said)
        self.assertIn("graph.yaml is not the graph that was recorded", said)
        self.change(lambda summary: summary["edges"]["device.commanded -> metrics.force"].update(delivered=12))
        self.assertRegex(self.verify(1), r"metric edges\.device\.commanded -> metrics\.force\.delivered: 12, now \d+")

    def test_definitions_and_commits_of_another_version_are_told(self):
        def work(summary):
            summary["metric_definitions"] -= 1
            summary["provenance"]["commit"] = "0" * 40
        self.made()
        self.change(work)
        said = self.verify(0)
        self.assertRegex(said, r"metrics have version \d+ of their definitions, now \d+")
        self.assertRegex(said, r"commit +0{40}\S*.*, now ")

    def test_a_study_tells_the_same_in_its_table_and_its_page(self):
        study = self.write("some.yaml", f"graphs: [{self.graph()}]\nvary: {{device.force_max: [4 N, 6 N]}}\nseeds: 1\n"
                                        "duration: 0.1 s\n")
        self.run_ok("study", study, "--out", self.out)
        made = json.loads((self.out / "study.json").read_text())["provenance"]
        names = [pathlib.Path(one["file"]).name for one in made["files"]]
        self.assertEqual((names[0], sorted(names[1:])), ("some.yaml", ["judged.yaml", "mine.yaml", "stone.off"]))
        self.assertIn("libtactor_source.so", [pathlib.Path(one["file"]).name for one in made["libraries"]])
        with contextlib.closing(sqlite3.connect(self.out / "study.sqlite")) as db:
            ((text,),) = db.execute("SELECT value FROM identity WHERE key GLOB 'provenance *'").fetchall()
        self.assertEqual(json.loads(text), made)
        self.assertIn(made["commit"], (self.out / "report.html").read_text())
        self.assertIn("found a table of many", self.verify(2))

    def test_what_cannot_be_made_again_says_why(self):
        self.made()
        (self.out / "graph.yaml").unlink()
        self.assertIn("its graph.yaml is missing", self.verify(2))
        for key, says in (("interrupted", "somebody ended it early"), ("reference_interrupted", "somebody ended it early")):
            self.change(lambda summary, key=key: summary.update({key: True}))
            self.assertIn(says, self.verify(2))
            self.change(lambda summary, key=key: summary.update({key: False}))
        self.change(lambda summary: summary.update(failure="x"))
        self.assertIn("it failed before its end", self.verify(2))
        self.change(lambda summary: summary["provenance"].pop("files"))
        self.assertIn("expected the provenance of a result", self.verify(2))
        self.change(lambda summary: summary.pop("provenance"))
        self.assertIn("expected a summary that tells its provenance", self.verify(2))
        (self.out / "summary.json").write_text("[1")
        self.assertIn("expected the summary of a run", self.verify(2))
        self.assertIn("expected the results of a run, which have a summary.json, found none", self.verify(2, self.folder))

    @needs_live
    def test_a_live_run_is_refused(self):
        self.made("--set", "clock=real", "--set", "live.on_missing_privilege=warn", "--duration", "0.2 s")
        self.assertIn("it was live, and what its devices and threads did happened once; `tactor replay`", self.verify(2))


if __name__ == "__main__":
    unittest.main()
