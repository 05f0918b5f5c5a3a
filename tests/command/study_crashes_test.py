"""Studies whose runs crash, hang or are killed: one command makes all others, and the bad ones are failed rows."""
import json
import os
import signal
import sqlite3
import subprocess
import unittest

from harness import TACTOR, tactor
from study_harness import FAULT_NODES, RECORDED, StudyTest, children, is_alive

# A node behind the coupling that ends the process where the study says; `judged`: the reference run has it too.
CRASHING = """extends: %(graph)s
nodes: {culprit: {type: fault.aborts, at: 100 s, lasts: 1 s}}
edges:
  - coupling.force -> culprit.in
  - culprit.out -> prediction.force
  - %(judged)s -> metrics.force
"""


class Crashes(StudyTest):
    """A run is done by a worker, which it may take with it: that costs the run, which is a row like other failures."""

    def setUp(self):
        super().setUp()
        self.environment["TACTOR_NODE_PATH"] = str(FAULT_NODES)

    def graph(self, judged="coupling.force"):
        return self.write("crashing.yaml", CRASHING % {"graph": RECORDED, "judged": judged})

    def methods(self, **methods):
        """A study whose methods are the culprit's parameters."""
        listed = "".join(f"  - {name}: {{nodes: {{culprit: {{{text}}}}}}}\n" for name, text in methods.items())
        return f"graphs: [{self.graph()}]\nmethods:\n{listed}seeds: 2\nduration: 0.6 s\n"

    def failures(self, out):
        """What became of each method: its status, and why; the same for both seeds."""
        rows = set(self.table(out, "SELECT configuration, status, message FROM runs NATURAL JOIN names"))
        self.assertEqual(len(rows), len({name for name, _, _ in rows}), rows)
        return {name: (status, message) for name, status, message in rows}

    def crashes(self, out):
        return json.loads(self.bytes_of(out, "study.json"))["runner"]["crashes"]

    def test_one_command_ends_with_every_good_run_and_every_bad_one_a_failed_row(self):
        text = self.methods(good="", aborts="at: 0.3 s", also_good="at: 200 s", overflows="at: 0.3 s, by: overflow",
                            is_killed="at: 0.3 s, by: kill", exits="at: 0.3 s, by: exit")
        result = self.study(text, "two", "--jobs", "2", code=1)
        self.assertEqual(self.failures("two"), {
            "good": ("done", ""), "also_good": ("done", ""), "aborts": ("failed", "ended by SIGABRT"),
            "overflows": ("failed", "ended by SIGSEGV"), "exits": ("failed", "ended with exit code 3"),
            "is_killed": ("failed", "killed (SIGKILL), perhaps for lack of memory")})
        self.assertIn("crashing overflows, seed 1002: ended by SIGSEGV", result.stderr)
        self.assertIn("crashing aborts, seed 1001: ended by SIGABRT; the others go on", result.stderr)
        self.assertNotIn("--resume", result.stderr)
        self.study(None, "one", "--jobs", "1", code=1)
        self.assertEqual(self.bytes_of("one"), self.bytes_of("two"))
        self.assertEqual(self.failures("one"), self.failures("two"))
        # Each of the eight ends a worker; once more where the worker had done others before.
        self.assertGreaterEqual(self.crashes("one"), 8)
        self.assertLessEqual(self.crashes("one"), 14)
        # Nothing is run again but what was killed: that may be otherwise now, and is not.
        self.study(None, "one", "--resume", "--jobs", "1", code=1)
        self.assertEqual(self.crashes("one"), 2)
        self.assertEqual(self.failures("one"), self.failures("two"))
        # Nobody knows how fast the machine was before a run that crashed, which is not 0.
        for line, times in zip(self.lines("one"), self.lines("one", "run_times.csv"), strict=True):
            self.assertEqual(times["control_us"] == "", line["status"] == "failed", times)
        for row in json.loads(self.bytes_of("one", "study.json"))["rows"]:
            self.assertEqual([time is None for time in row["control_us"]], [status == "failed" for status in row["status"]])

    def test_a_reference_run_that_crashes_fails_all_runs_that_need_it(self):
        graph = self.graph("culprit.out")
        for jobs in ("1", "2"):
            # Where the device stops has no part in the reference run.
            self.study(f"graphs: [{graph}]\nvary: {{culprit.at: [100 s, 0.3 s], device.force_max: [4 N, 6 N]}}\nseeds: 2\n"
                       "duration: 0.6 s\n", jobs, "--jobs", jobs, code=1)
            bad = ("failed", "the reference run that this run needs: ended by SIGABRT")
            self.assertEqual(self.failures(jobs), {
                f"culprit.at={at} device.force_max={force}": bad if at == "0.3 s" else ("done", "")
                for at in ("100 s", "0.3 s") for force in ("4 N", "6 N")})
            self.assertGreaterEqual(self.crashes(jobs), 2)  # one a seed
            self.environment["TACTOR_CACHE"] = str(self.folder / "another_cache")
        self.assertEqual(self.bytes_of("1"), self.bytes_of("2"))

    def test_a_case_that_crashes_where_it_is_planned_fails_with_all_its_runs(self):
        result = self.study(self.methods(good="", bad="by: planning", too="by: planning"), "out", code=1)
        bad = ("failed", "its planning: ended by SIGABRT")
        self.assertEqual(self.failures("out"), {"good": ("done", ""), "bad": bad, "too": bad})
        self.assertIn("the planning of crashing bad: ended by SIGABRT; the others go on", result.stderr)
        # The table of an earlier command is not taken for this one's.
        result = self.study(None, "out", code=2)
        self.assertIn("--resume continues them, --overwrite starts anew", result.stderr)
        self.study(None, "out", "--resume", code=1)
        self.assertEqual(json.loads(self.bytes_of("out", "study.json"))["runner"]["runs_found"], 6)

    def test_what_an_earlier_run_of_its_worker_may_have_broken_costs_no_run(self):
        once = self.folder / "once"
        self.study(self.methods(good="", bad=f"at: 0.3 s, once: '{once}'"), "out", "--jobs", "1")
        self.assertTrue(once.exists())
        self.assertEqual({status for status, _ in self.failures("out").values()}, {"done"})
        self.assertEqual(self.crashes("out"), 1)

    def test_workers_that_are_killed_cost_the_run_that_one_held_and_no_other(self):
        """From outside, in a study of twelve runs, of which one holds a worker."""
        held = self.folder / "held"
        held.write_text("")  # so that no run is held yet
        text = self.methods(good="", also="at: 200 s", held=f"at: 0.3 s, by: hang, once: '{held}'").replace("seeds: 2", "seeds: 4")
        self.study(text, "whole", "--jobs", "2")
        held.unlink()
        process = self.start("killed", "--jobs", "2")
        self.wait_until(lambda: self.table("killed", "SELECT count(*) FROM runs") == [(11,)], process, "all others were done")
        for worker in children(process.pid):
            os.kill(worker, signal.SIGKILL)
        process.communicate(timeout=300)
        whole = {tuple(row) for row in self.table("whole", "SELECT configuration, seed, status FROM runs NATURAL JOIN names")}
        rows = self.table("killed", "SELECT configuration, seed, status, message FROM runs NATURAL JOIN names")
        self.assertEqual(len(rows), 12)
        (failed,) = (row for row in rows if row[2] == "failed")
        self.assertEqual((failed[0], failed[3]), ("held", "killed (SIGKILL), perhaps for lack of memory"))
        self.assertEqual(whole - {row[:3] for row in rows}, {(*failed[:2], "done")})
        lines = {(line["method"], line["seed"]): line for line in self.lines("whole")}
        for line in self.lines("killed"):
            if line["status"] == "done":
                self.assertEqual(line, lines[line["method"], line["seed"]])
        # What was killed may end otherwise: with it the table is the other one.
        self.study(None, "killed", "--resume", "--jobs", "2")
        self.assertEqual(self.bytes_of("killed"), self.bytes_of("whole"))

    def test_no_worker_outlives_a_command_that_is_killed(self):
        self.write("study.yaml", self.methods(good="", also="at: 200 s", hangs="at: 0.3 s, by: hang"))
        process = self.start("out", "--jobs", "2")
        workers = children(process.pid)
        self.assertTrue(workers)
        process.kill()
        process.communicate()
        self.wait_for(lambda: not any(map(is_alive, workers)), "the workers ended", timeout=5)

    def test_a_run_that_takes_too_long_is_ended(self):
        text = self.methods(good="", hangs="at: 0.3 s, by: hang") + "run_timeout: 5 s\n"
        result = self.study(text.replace("seeds: 2", "seeds: 1"), "out", "--jobs", "2", code=1)
        why = "took longer than 5 s, the run_timeout"
        self.assertEqual(self.failures("out"), {"good": ("done", ""), "hangs": ("failed", why)})
        self.assertIn(f"crashing hangs, seed 1001: {why}; the others go on", result.stderr)
        self.assertIn("study.yaml:7:14: run_timeout: ", self.study(text.replace("5 s", "0 s"), "bad", code=2).stderr)

    def test_a_run_that_ends_too_late_has_failed_and_is_run_anew_with_more_time(self):
        text = self.methods(good="", also_good="at: 200 s")
        self.study(text + "run_timeout: 1 ms\n", "out", "--jobs", "2", code=1)
        rows = self.table("out", "SELECT status, message FROM runs")
        self.assertEqual(len(rows), 4)
        for status, message in rows:
            self.assertEqual(status, "failed")
            self.assertIn("took longer than 0.001 s, the run_timeout", message)
        self.study(text + "run_timeout: 300 s\n", "out", "--resume")
        self.study(text, "straight")
        self.assertEqual(self.bytes_of("out"), self.bytes_of("straight"))

    def test_who_insists_ends_a_run_that_hangs(self):
        self.write("study.yaml", self.methods(good="", hangs="at: 0.3 s, by: hang"))
        process = subprocess.Popen([TACTOR, "study", self.folder / "study.yaml", "--out", self.folder / "out", "--jobs", "1"],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, env=dict(os.environ, **self.environment))
        self.addCleanup(process.kill)

        def has_row():
            try:
                return self.table("out", "SELECT count(*) FROM runs")[0][0] == 1
            except sqlite3.OperationalError:  # not made yet
                return False

        self.wait_until(has_row, process, "the good run was made")
        process.send_signal(signal.SIGINT)
        with self.assertRaises(subprocess.TimeoutExpired):  # it waits for the run
            process.wait(2)
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1)
        self.assertIn("interrupted again, and killed; the runs that had finished are kept", errors.decode())
        self.assertEqual(self.table("out", "SELECT count(*) FROM runs"), [(1,)])

    def test_a_comparison_goes_on_too(self):
        good = self.graph()
        bad = self.write("bad.yaml", f"extends: {good}\nnodes: {{culprit: {{at: 0.3 s}}}}\n")
        result = tactor("compare", good, bad, "--seeds", "2", "--duration", "0.6", "--out", self.folder / "out",
                        environment=self.environment)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertIn("bad, seed 1: ended by SIGABRT", result.stderr)


if __name__ == "__main__":
    unittest.main()
