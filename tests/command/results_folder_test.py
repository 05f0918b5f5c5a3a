"""Results are never replaced unasked, two commands never write to one folder, and a run that was ended early says so."""
import json
import os
import signal
import subprocess
import unittest

from harness import GRAPHS, TACTOR, CommandTest, Terminal, needs_meshes, needs_hdf5, tactor


class Results(CommandTest):
    def here(self, *arguments, code=0):
        result = tactor(*arguments, environment=self.environment, cwd=self.folder)
        self.assertEqual(result.returncode, code, f"{arguments}\n{result.stdout}{result.stderr}")
        return result

    def start(self, *arguments):
        process = subprocess.Popen([TACTOR, *map(str, arguments)], cwd=self.folder, stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, env=dict(os.environ, **self.environment))
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process


class Kept(Results):
    def test_a_second_run_of_a_graph_takes_the_next_number(self):
        graph = self.judged_small_graph()
        for seed in (1, 2, 3):
            self.here("run", graph, "--seed", seed)
        for folder, seed in (("judged", 1), ("judged_2", 2), ("judged_3", 3)):
            self.assertEqual(json.loads((self.folder / "out" / folder / "summary.json").read_text())["seed"], seed)

    def test_a_folder_that_is_named_is_not_written_over_unless_asked(self):
        graph = self.judged_small_graph()
        self.here("run", graph, "--out", "mine")
        before = (self.folder / "mine/summary.json").read_bytes()
        refused = self.here("run", graph, "--seed", "2", "--out", "mine", code=2)
        for text in ("--out mine: expected a folder without results, found summary.json", "--overwrite"):
            self.assertIn(text, refused.stderr)
        self.assertEqual((self.folder / "mine/summary.json").read_bytes(), before)
        self.here("run", graph, "--seed", "2", "--out", "mine", "--overwrite")
        self.assertEqual(json.loads((self.folder / "mine/summary.json").read_text())["seed"], 2)

    @needs_hdf5
    def test_nothing_of_the_results_that_were_replaced_is_left(self):
        recorded = self.write("recorded.yaml", self.judged_small_graph().read_text() + "record: [device.state]\n")
        self.here("run", recorded, "--out", "mine")
        (self.folder / "mine/notes.txt").write_text("the user's own")
        self.assertTrue((self.folder / "mine/recording.h5").exists())
        self.here("run", self.judged_small_graph(), "--out", "mine", "--overwrite")
        self.assertFalse((self.folder / "mine/recording.h5").exists())
        self.assertTrue((self.folder / "mine/notes.txt").exists())

    @needs_hdf5
    def test_a_run_that_is_refused_loses_no_results(self):
        graph = self.judged_small_graph()
        recorded = self.write("recorded.yaml", graph.read_text() + "record: [device.state]\n")
        self.here("run", recorded, "--out", "mine")
        before = {path.name: path.read_bytes() for path in (self.folder / "mine").iterdir()}
        self.assertIn("recording.h5", before)
        self.here("run", graph, "--set", "metrics.rest=1000 s", "--out", "mine", "--overwrite", code=2)
        self.assertEqual({path.name: path.read_bytes() for path in (self.folder / "mine").iterdir()}, before)

    def test_a_run_that_is_refused_while_loading_makes_no_folder(self):
        self.here("run", self.judged_small_graph(), "--set", "metrics.rset=1", "--out", "never", code=2)
        self.assertFalse((self.folder / "never").exists())

    def test_a_graph_of_the_user_is_not_replaced_by_that_of_the_results(self):
        own = self.judged_small_graph().rename(self.folder / "graph.yaml")
        text = own.read_text()
        refused = self.here("run", own, "--out", ".", code=2)
        self.assertIn("expected a folder without results, found graph.yaml", refused.stderr)
        refused = self.here("run", own, "--out", ".", "--overwrite", code=2)
        self.assertIn("which the results would replace", refused.stderr)
        self.assertEqual(own.read_text(), text)

    def test_files_of_the_user_with_names_that_a_run_writes_stay_where_no_run_has_left_results(self):
        mine = self.folder / "mine"
        (mine / "costs").mkdir(parents=True)
        (mine / "costs/budget.txt").write_text("the user's own")
        self.here("run", self.judged_small_graph(), "--out", "mine", "--overwrite")
        self.assertEqual((mine / "costs/budget.txt").read_text(), "the user's own")

    def test_a_folder_with_files_of_the_user_is_no_obstacle(self):
        (self.folder / "mine").mkdir()
        (self.folder / "mine/notes.txt").write_text("")
        self.here("run", self.judged_small_graph(), "--out", "mine")

    def test_comparisons_follow_the_same_rule(self):
        command = ["compare", GRAPHS / "recorded/scene.yaml", "--seeds", "2", "--duration", "0.3 s"]
        self.here(*command)
        self.here(*command)
        self.assertTrue((self.folder / "out/compare/compare.json").exists())
        self.assertTrue((self.folder / "out/compare_2/compare.json").exists())
        self.assertIn("--overwrite", self.here(*command, "--out", "out/compare", code=2).stderr)
        self.here(*command, "--out", "out/compare", "--overwrite")
        self.here(*command, "--overwrite")
        self.assertFalse((self.folder / "out/compare_3").exists())

    def test_a_run_and_a_study_do_not_share_a_folder(self):
        graph = self.judged_small_graph()
        study = self.write("study.yaml", f"graphs: [{graph}]\nseeds: 1\n")
        self.here("study", study, "--out", "study")
        self.assertIn("the runs of a study", self.here("run", graph, "--out", "study", "--overwrite", code=2).stderr)
        self.here("run", graph, "--out", "run")
        self.assertIn("summary.json of another command", self.here("study", study, "--out", "run", code=2).stderr)

    @needs_meshes
    def test_lean_graphs_follow_the_same_rule(self):
        (self.folder / "out").mkdir()
        (self.folder / "mine.yaml").write_text("")
        command = ["lean", GRAPHS / "duck/off.yaml", "--budget", "2 N", "--duration", "0.3 s", "--repeats", "1"]
        refused = self.here(*command, "--out", "mine.yaml", code=2)
        self.assertIn("expected files that are not there yet, found mine.yaml; --overwrite replaces it", refused.stderr)
        # Its tables lie beside the graph.
        (self.folder / "notes.md").write_text("the user's own")
        refused = self.here(*command, "--out", "notes.yaml", code=2)
        self.assertIn("found notes.md", refused.stderr)
        self.assertEqual((self.folder / "notes.md").read_text(), "the user's own")


class Alone(Results):
    def long_run(self, *arguments):
        process = self.start("run", self.judged_small_graph(), "--duration", "100000", *arguments)
        return process

    def test_two_runs_into_one_folder_do_not_both_go_on(self):
        first = self.long_run("--out", "mine")
        self.wait_until((self.folder / "mine/.tactor.lock").exists, first, "the run had its folder")
        second = self.here("run", self.judged_small_graph(), "--out", "mine", code=2)
        self.assertIn("mine: expected a folder that no other program writes, found another tactor writing it", second.stderr)
        third = self.here("run", self.judged_small_graph(), "--out", "mine", "--overwrite", code=2)
        self.assertIn("another tactor", third.stderr)
        first.kill()
        first.communicate()
        # The lock goes with the process.
        self.here("run", self.judged_small_graph(), "--out", "mine")

    def test_two_runs_of_one_graph_get_a_folder_each(self):
        first = self.long_run()
        self.wait_until((self.folder / "out/judged/.tactor.lock").exists, first, "the run had its folder")
        self.here("run", self.judged_small_graph())
        self.assertTrue((self.folder / "out/judged_2/summary.json").exists())
        self.assertFalse((self.folder / "out/judged/summary.json").exists())


class Interrupted(Results):
    def test_an_interrupted_virtual_run_says_so_everywhere(self):
        process = self.start("run", self.judged_small_graph(), "--duration", "100000 s", "--out", "mine")
        self.wait_until((self.folder / "mine").is_dir, process, "the run had its folder")
        self.wait_until(lambda: self.is_running(process), process, "it had run for a while")
        process.send_signal(signal.SIGINT)
        stdout, stderr = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, stderr)
        summary = json.loads((self.folder / "mine/summary.json").read_text())
        self.assertTrue(summary["interrupted"])
        self.assertEqual(summary["planned_s"], 100000)
        self.assertLess(summary["duration_s"], 100000)
        said = r"interrupted after [\d.e+]+ s of (100000|1\.00e\+05) s"
        self.assertRegex(stdout, said)
        self.assertRegex((self.folder / "mine/report.html").read_text(), said)

    @needs_meshes
    def test_a_whole_run_whose_reference_run_is_interrupted_is_told_as_such(self):
        run = Terminal("run", GRAPHS / "wall/refit.yaml", "--duration", "20 s", "--out", self.folder / "mine",
                       environment=self.environment)
        run.expect("reference run")
        run.type("\x03")
        self.assertEqual(run.finish(), 1, run.text)
        self.assertIn("its reference run was interrupted, so there are no errors", " ".join(run.text.split()))
        summary = json.loads((self.folder / "mine/summary.json").read_text())
        self.assertEqual((summary["interrupted"], summary["reference_interrupted"]), (False, True))
        self.assertEqual(summary["duration_s"], 20)

    @staticmethod
    def is_running(process):
        with open(f"/proc/{process.pid}/stat", encoding="ascii") as file:
            fields = file.read().rpartition(")")[2].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK") > 0.3


if __name__ == "__main__":
    unittest.main()
