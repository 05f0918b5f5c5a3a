"""Studies: the same table by any number of jobs, kept through kills and interrupts, and refused with the place of what is wrong."""
import json
import os
import pathlib
import signal
import sqlite3
import subprocess
import unittest

from harness import GRAPHS, HAS_HDF5, TACTOR, needs_meshes, needs_hdf5, tactor
from study_harness import FAULT_NODES, RECORDED, StudyTest, children, is_alive

MANY = f"""
graphs: [{RECORDED}]
methods: [{GRAPHS / "methods/hold.yaml"}, {GRAPHS / "methods/kalman.yaml"}]
vary: {{device.force_max: [4 N, 6 N, 8 N]}}
seeds: 24
duration: 1 s
"""


class Table(StudyTest):
    def test_any_number_of_jobs_gives_the_same_bytes(self):
        text = MANY.replace("seeds: 24", "seeds: 4")
        self.study(text, "one", "--jobs", "1")
        self.study(text, "three", "--jobs", "3")
        self.assertEqual(self.bytes_of("one"), self.bytes_of("three"))
        lines = self.lines("one")
        self.assertEqual(len(lines), 2 * 3 * 4)
        self.assertEqual({line["status"] for line in lines}, {"done"})
        for line, times in zip(lines, self.lines("one", "run_times.csv")):
            self.assertEqual([line[k] for k in ("method", "device.force_max", "seed")],
                             [times[k] for k in ("method", "device.force_max", "seed")])
            self.assertGreater(float(times["cpu_ms_per_s"]), 0)
            self.assertGreater(float(times["control_us"]), 0)
            self.assertNotIn("cpu_ms_per_s", line)

    @needs_meshes
    def test_any_number_of_jobs_gives_the_same_bytes_of_a_mesh_and_its_reference(self):
        # Two methods share the reference run of a seed; the cache begins empty, so that each number of jobs makes its own.
        text = (f"graphs: [{GRAPHS / 'duck/scene.yaml'}]\nmethods: [{GRAPHS / 'methods/hold.yaml'}, {GRAPHS / 'methods/blend.yaml'}]\n"
                "seeds: 2\nduration: 1.2 s\njudge: whole\n")
        for jobs in ("1", "2"):
            self.environment["TACTOR_CACHE"] = str(self.folder / f"cache{jobs}")
            self.study(text, jobs, "--jobs", jobs)
        self.assertEqual(self.bytes_of("1"), self.bytes_of("2"))
        lines = self.lines("1")
        self.assertEqual([(line["method"], line["seed"]) for line in lines],
                         [(method, seed) for method in ("hold", "blend") for seed in ("1001", "1002")])
        for line in lines:  # in contact, judged by a reference run, and not all alike
            self.assertGreater(float(line["contacts.max"]), 0)
            self.assertGreater(float(line["delivered.force.rms_error_N"]), 0)
        self.assertEqual(len({line["delivered.force.rms_error_N"] for line in lines}), 4)

    def test_a_killed_study_goes_on_with_nothing_lost_and_nothing_run_twice(self):
        (self.folder / "study.yaml").write_text(MANY)
        process = self.start("killed", "--jobs", "2")
        # As the kernel does where memory is short: the command goes on with another worker.
        os.kill(children(process.pid)[0], signal.SIGKILL)
        rows = len(self.table("killed", "SELECT run FROM runs"))
        self.wait_until(lambda: len(self.table("killed", "SELECT run FROM runs")) > rows + 3, process, "it had other runs")
        workers = children(process.pid)
        self.assertEqual(len(workers), 2)
        process.kill()
        process.communicate()
        self.wait_for(lambda: not any(map(is_alive, workers)), "what it had started ended with it")
        before = dict(self.table("killed", "SELECT run, cpu_s FROM run_times NATURAL JOIN runs WHERE status = 'done'"))
        self.assertLess(len(before), 144)
        result = self.study(None, "killed", code=2)
        self.assertIn("--resume continues them, --overwrite starts anew", result.stderr)
        self.study(None, "killed", "--resume")
        after = dict(self.table("killed", "SELECT run, cpu_s FROM run_times"))
        self.assertEqual(len(after), 144)
        # A run that were made again would have taken another time.
        self.assertEqual({run: after[run] for run in before}, before)
        engine = json.loads(self.bytes_of("killed", "study.json"))["runner"]
        self.assertEqual([engine["runs_found"], engine["runs"]], [len(before), 144 - len(before)])
        self.study(None, "whole")
        self.assertEqual(self.bytes_of("killed"), self.bytes_of("whole"))

    def test_an_interrupt_keeps_what_there_is(self):
        (self.folder / "study.yaml").write_text(MANY)
        process = self.start("out", "--jobs", "2")
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 1)
        self.assertRegex(stderr.decode(), r"interrupted: \d+ of 144 runs are kept in .*study.sqlite; .* --resume continues")
        kept = self.table("out", "SELECT count(*) FROM runs")[0][0]
        self.assertGreaterEqual(kept, 3)
        self.study(None, "out", "--resume")
        self.assertEqual(json.loads(self.bytes_of("out", "study.json"))["runner"]["runs_found"], kept)

    def test_an_interrupt_from_the_terminal_reaches_both_processes_and_is_told_once(self):
        (self.folder / "study.yaml").write_text(MANY)
        process = self.start("out", "--jobs", "2", start_new_session=True)
        os.killpg(process.pid, signal.SIGINT)
        _, stderr = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 1)
        self.assertEqual(stderr.decode().count("interrupted"), 1, stderr)

    def test_who_asks_the_process_of_the_runs_to_end_ends_the_study(self):
        (self.folder / "study.yaml").write_text(MANY)
        process = self.start("out", "--jobs", "2")
        os.kill(children(process.pid)[0], signal.SIGTERM)
        _, stderr = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 1)
        self.assertIn(b"--resume continues", stderr)

    def test_two_at_once_are_refused(self):
        (self.folder / "study.yaml").write_text(MANY)
        process = self.start("out", "--jobs", "1")
        result = self.study(None, "out", "--resume", code=2)
        self.assertIn("found another tactor writing it", result.stderr)
        process.kill()

    def test_what_has_changed_is_refused_by_name(self):
        graph = self.write("mine.yaml", f"extends: {RECORDED}\n")
        text = f"graphs: [{graph}]\nseeds: 2\nduration: 0.6 s\n"
        self.study(text, "out")
        first = self.bytes_of("out")
        self.assertIn("--overwrite starts anew", self.study(text, "out", code=2).stderr)
        self.study(text, "out", "--resume")
        self.assertEqual(self.bytes_of("out"), first)
        self.study("title: another\n" + text + "# more\n", "out", "--resume")  # runs the same runs
        self.assertEqual(json.loads(self.bytes_of("out", "study.json"))["runner"]["runs"], 0)
        for change, options, said in ((text + "timing: {repeats: 2}\n", (), "the study has changed since"),
                                      (text.replace("0.6", "0.5"), (), "the graph, or a file that it names, has changed since"),
                                      (text + "vary: {device.force_max: [4 N]}\n", (), "its runs are others"),
                                      (text, ("--seeds", "3"), "the options of the command line were different")):
            self.assertIn(said, self.study(change, "out", "--resume", *options, code=2).stderr)
        graph.write_text(f"extends: {RECORDED}\nnodes: {{device: {{force_max: 3 N}}}}\n")
        result = self.study(text, "out", "--resume", code=2)
        self.assertIn("the graph, or a file that it names, has changed since: mine as it is, seed 1001", result.stderr)
        self.study(text, "out", "--overwrite")

    def test_a_run_time_may_be_a_metric(self):
        text = f"graphs: [{RECORDED}]\nseeds: 2\nduration: 0.6 s\nmetrics: [delivered.force.rms_error_N, method_us_per_tick]\n"
        self.study(text, "out")
        self.assertNotIn("method_us_per_tick", self.lines("out")[0])
        self.assertGreater(float(self.lines("out", "run_times.csv")[0]["method_us_per_tick"]), 0)

    def test_repeats_are_medians_of_run_times_alone(self):
        self.study(f"graphs: [{RECORDED}]\nseeds: 2\nduration: 0.6 s\ntiming: {{repeats: 3, warm_up: 1}}\n", "out")
        for run in (0, 1):
            repeats = sorted(v for v, in self.table("out", f"SELECT cpu_s FROM repeat_times WHERE run = {run}"))
            self.assertEqual(len(repeats), 3)
            self.assertEqual(self.table("out", f"SELECT cpu_s FROM run_times WHERE run = {run}")[0][0], repeats[1])
        self.study(f"graphs: [{RECORDED}]\nseeds: 2\nduration: 0.6 s\n", "once")
        self.assertEqual(self.bytes_of("out"), self.bytes_of("once"))
        self.study(None, "asked", "--repeats", "4")
        self.assertEqual(self.table("asked", "SELECT run, count(*) FROM repeat_times GROUP BY run"), [(0, 4), (1, 4)])
        timing = json.loads(self.bytes_of("asked", "study.json"))["timing"]
        self.assertEqual((timing["repeats"], timing["warm_up"]), (4, 1))
        self.assertIn("the median of 4 repeats after 1 run that did not count", timing["text"])

    @needs_hdf5
    def test_the_table_is_there_as_hdf5(self):
        import h5py  # noqa: PLC0415
        self.study(f"title: mine\ngraphs: [{RECORDED}]\nvary: {{device.force_max: [4 N, 8 N]}}\nseeds: 2\nduration: 0.6 s\n", "out")
        lines = self.lines("out")
        with h5py.File(self.folder / "out" / "study.h5") as file:
            self.assertEqual(file.attrs["title"], "mine")
            self.assertEqual([v.decode() for v in file["device.force_max"]], ["4 N", "4 N", "8 N", "8 N"])
            self.assertEqual(list(file["delivered.force.rms_error_N"]),
                             [float(line["delivered.force.rms_error_N"]) for line in lines])
            self.assertTrue((file["cpu_ms_per_s"][...] > 0).all())
            attributes = file["delivered.force.rms_error_N"].attrs
            self.assertEqual((attributes["unit"], attributes["better"]), ("N", "lower"))


class Designs(StudyTest):
    def test_a_hypercube_a_swap_and_a_range_run(self):
        self.study(f"""
graphs: [{RECORDED}]
methods: [{{inline: {{nodes: {{prediction: {{type: prediction.kalman}}, interpolation: {{type: interpolation.linear}}}}}}}}]
vary:
  device.force_max: {{from: 2 N, to: 8 N, count: 2}}
  show: {{swap: {{as_is: {{title: one}}, soft: {{nodes: {{device: {{force_slew: 500 N/s}}}}}}}}}}
design: {{latin_hypercube: {{samples: 6, seed: 1}}}}
seeds: 1
duration: 0.6 s
""", "out")
        lines = self.lines("out")
        self.assertEqual(len(lines), 6)
        forces = sorted(float(line["device.force_max"].removesuffix(" N")) for line in lines)
        for i, force in enumerate(forces):  # one in each slice of 1 N
            self.assertTrue(2 + i <= force < 3 + i, forces)
        self.assertEqual(sorted(line["show"] for line in lines), ["as_is"] * 3 + ["soft"] * 3)
        self.assertEqual({line["method"] for line in lines}, {"inline"})

    def test_another_graph_can_be_the_reference(self):
        # A lever of half the length makes the recorded torque twice the force.
        text = f"graphs: [{RECORDED}]\nseeds: 1\nduration: 1 s\n"
        self.study(text, "own")
        self.study(text + "reference: {over: [{double: {nodes: {recording: {columns: {force.x: Fe_Nm / 0.0375 m}}}}}]}\n", "other")
        own, other = (float(self.lines(out)[0]["reference.force.rms_N"]) for out in ("own", "other"))
        self.assertAlmostEqual(other / own, 2, places=6)


class Failures(StudyTest):
    def bad(self, text, *said):
        result = self.study(text, "bad", code=2)
        for one in said:
            self.assertIn(one, result.stderr)
        self.assertFalse((self.folder / "bad" / "study.sqlite").exists())

    def test_what_a_graph_does_not_have_is_refused_at_its_place_in_the_study(self):
        graph = f"graphs: [{RECORDED}]\n"
        self.bad(graph + "vary: {devise.force_max: [3]}\n", "study.yaml:2:27: ", "devise: expected a node of the graph",
                 'did you mean "device"')
        self.bad(graph + "vary:\n  device.force_maks: [3, 4]\n", "study.yaml:3:23: ", 'did you mean "force_max"')
        self.bad(graph + "vary:\n  device.force_max: [3, -4 N]\n", "study.yaml:3:25: ", "device.force_max: expected a force")
        self.bad(graph + "set: {device.force_max: 3 m}\n", "study.yaml:2:7: ", "device.force_max: expected a force")
        self.bad(graph + "methods: [{mine: {nodes: {device: {typo: 3}}}}]\n", "study.yaml:2:36: ", "nodes.device.typo: expected a parameter")

    @needs_meshes
    def test_a_study_points_at_its_own_value(self):
        (self.folder / "bad.off").write_text("OFF\n4 4 0\n0 0 0\nnonsense 0 0\n0 0.01 0\n0 0 0.01\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n")
        result = self.study(f"graphs: [{GRAPHS / 'duck/off.yaml'}]\nseeds: 1\nset:\n  scene.bodies.duck.mesh: bad.off\n", "bad", code=2)
        self.assertRegex(result.stderr, r"(?m)^(.*/)?study\.yaml:4:")
        self.assertIn("bad.off:4", result.stderr)

    def test_bad_files_are_refused_with_their_place(self):
        graph = f"graphs: [{RECORDED}]\n"
        self.bad(graph + "sedes: 3\n", "study.yaml:2:1: study.sedes", 'did you mean "seeds"?')
        self.bad(graph + "vary: {device.force_max: []}\n", "study.yaml:2:26: vary.device.force_max", "an empty list")
        self.bad(graph + "vary: {device.force_max: {from: 0 N, to: 3 N, count: 3, scale: log}}\n", "study.yaml:2:33: ",
                 "cannot begin at, or go through, 0")
        self.bad(graph + "vary: {device.force_max: [1]}\ndesign: {grid: {}, latin_hypercube: {samples: 3}}\n",
                 "study.yaml:3:9: design", "found grid, latin_hypercube together")
        self.bad(graph + "seeds: [1, 2\n", "study.yaml:")
        result = self.study(graph, "bad", "--short", code=2)
        self.assertIn("expected the key short, which --short asks for", result.stderr)
        result = self.study(graph, "bad", "--resume", "--overwrite", code=2)
        self.assertIn("--resume", result.stderr)

    def test_bounds_and_missing_references_are_checked(self):
        graph = f"graphs: [{RECORDED}]\nmethods: [{GRAPHS / 'methods/hold.yaml'}]\n"
        self.bad(graph + "report: {kind: work_precision, bounds: [hodl]}\n", "study.yaml:3:41: ",
                 "report.bounds: expected a method of the study, found hodl", 'did you mean "hold"?')
        self.bad(graph + "report: {kind: stability, bounds: [hold]}\n", "report.bounds: expected with kind: work_precision alone")
        self.bad(graph + "reference: none\nreport: work_precision\n", "study.yaml:3:12: ", "reference: none: expected a report other than")
        self.bad(graph + "reference: nobody\n", "study.yaml:3:12: ", "own, none")

    def test_a_metric_that_no_run_reports_is_refused_before_the_first(self):
        graph = f"graphs: [{RECORDED}]\nseeds: 1\nduration: 0.6 s\n"
        self.bad(graph + "metrics: [delivered.force.rms_eror_N]\n", "study.yaml:4:11: metrics: expected a metric that a run",
                 'found delivered.force.rms_eror_N; did you mean "delivered.force.rms_error_N"?')
        self.bad(graph + "metrics: [drops, delivered.torque.rms_error_Nm]\n", "study.yaml:4:18: ",
                 "delivered.torque.rms_error_Nm, which no run reports: the scene is translation-only")
        self.bad(graph + "metrics: [rollout.ticks]\n", "no graph has a node of the type interpolation.external or interpolation.mujoco or interpolation.rollout")
        self.bad(graph + "reference: none\nmetrics: [delivered.force.delay_ms]\n", "study.yaml:5:11: ", "no reference run is made")
        self.bad(graph + "report: {kind: work_precision, error: physics.force.rms_eror_N}\n", "study.yaml:4:39: report.error: ",
                 'did you mean "physics.force.rms_error_N"?')
        self.bad(graph + "report: {kind: work_precision, error: physics.steps}\n", "for which neither lower nor higher is better")
        self.assertFalse((self.folder / "bad" / "study.sqlite").exists())

    def test_a_metric_of_some_configurations_alone_is_shown(self):
        refit = GRAPHS / "methods/refit.yaml"
        text = f"graphs: [{RECORDED}]\nmethods: [{GRAPHS / 'methods/hold.yaml'}, {refit}]\nseeds: 1\nduration: 0.6 s\njudge: whole\nmetrics: [refit.unstable, delivered.force.rms_error_N]\n"
        self.study(text, "out")
        hold, other = self.lines("out")
        self.assertEqual(hold["refit.unstable"], "")
        self.assertGreaterEqual(float(other["refit.unstable"]), 0)
        self.bad(text.replace(f", {refit}", ""), "refit.unstable, which no run reports: no graph has a node of the type prediction.refit")

    def test_units_and_directions_are_those_that_the_nodes_declare(self):
        self.study(f"graphs: [{RECORDED}]\nseeds: 1\nduration: 0.6 s\nmetrics: [delivered.force.rms_d2_N_per_ms2, physics.steps]\n", "out")
        metrics = json.loads(self.bytes_of("out", "study.json"))["rows"][0]["metrics"]
        for name, unit, better in (("delivered.force.rms_d2_N_per_ms2", "N/ms^2", "lower"), ("physics.steps", "1", "neither"),
                                   ("cpu_ms_per_s", "ms/s", "lower"), ("cost_us.prediction.median", "us", "lower")):
            self.assertEqual((metrics[name]["unit"], metrics[name]["better"]), (unit, better), name)
        declared = dict((name, (unit, better)) for name, unit, better in self.table("out", "SELECT name, unit, better FROM declared"))
        self.assertEqual(declared["delivered.force.delay_ms"], ("ms", "near zero"))
        page = self.bytes_of("out", "report.html").decode()
        self.assertIn('title="RMS second difference, N/ms²; lower is better">', page)
        self.assertIn("delivered.force.rms_d2_N_per_ms2 ↓</abbr></th>", page.replace("<wbr>", ""))
        self.assertIn('title="physics results">physics.<wbr>steps</abbr></th>', page)

    def test_a_metric_that_did_not_come_up_is_told(self):
        result = self.study(f"graphs: [{RECORDED}]\nseeds: 1\nduration: 0.6 s\nmetrics: [device.causes.dead_man, drops]\n", "out")
        self.assertIn("device.causes.dead_man: no run reported it; it is missing where it never came up", result.stderr)


# A node behind the coupling that fails from then on.
BREAKING = """extends: %(graph)s
nodes: {culprit: {type: fault.throws, at: %(at)s, lasts: 1 s}}
edges:
  - coupling.force -> culprit.in
  - culprit.out -> prediction.force
  - coupling.force -> metrics.force
"""


class Comparisons(StudyTest):
    """`tactor compare` shows the runs that are done beside those that failed."""

    def setUp(self):
        super().setUp()
        self.environment["TACTOR_NODE_PATH"] = str(FAULT_NODES)
        self.broken = self.write("broken.yaml", BREAKING % {"graph": RECORDED, "at": "0.3 s"})
        self.whole = self.write("whole.yaml", BREAKING % {"graph": RECORDED, "at": "100 s"})

    def compare(self, *graphs, code=1, options=()):
        out = self.folder / "compared"
        result = tactor("compare", *graphs, "--seeds", "2", "--duration", "0.6", "--overwrite", "--out", out, *options, environment=self.environment)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result, json.loads((out / "compare.json").read_text()), (out / "report.html").read_text()

    def test_a_graph_that_fails_leaves_the_others_their_figures(self):
        for graphs in ((self.whole, self.broken), (self.broken, self.whole)):
            with self.subTest(first=graphs[0].name):
                result, found, page = self.compare(*graphs)
                for seed in (1, 2):
                    self.assertRegex(result.stderr, rf"broken, seed {seed}: .*it broke on purpose")
                self.assertNotIn("whole", result.stderr)
                rows = {row["graph"]: row for row in found["graphs"]}
                self.assertEqual([rows[g]["seeds_done"] for g in ("whole", "broken")], [2, 0])
                self.assertEqual(rows["broken"]["status"], ["failed", "failed"])
                self.assertEqual([failure["seed"] for failure in rows["broken"]["failures"]], [1, 2])
                self.assertIn("it broke on purpose", rows["broken"]["failures"][0]["message"])
                self.assertGreater(rows["whole"]["metrics"]["delivered.force.rms_error_N"]["mean"], 0)
                self.assertIsNone(rows["broken"]["metrics"]["delivered.force.rms_error_N"]["mean"])
                self.assertIn("0 of 2 seeds", result.stdout)
                for text in ("Runs that failed", "broken, seed 2", "it broke on purpose", "0 of 2 seeds", "<svg"):
                    self.assertIn(text, page)

    def test_a_comparison_of_which_nothing_is_done_still_says_so_everywhere(self):
        result, found, page = self.compare(self.broken)
        self.assertIn("0 of 2 seeds", result.stdout)
        self.assertNotRegex(result.stdout, r"\n[ ]*\n[ ]*\n")  # no empty lines where run times are told of
        self.assertNotIn("<p></p>", page)
        self.assertEqual([found["timing"][key] for key in ("text", "control_us", "control_spread")], ["", None, None])
        self.assertEqual(found["graphs"][0]["seeds_done"], 0)
        self.assertIn("it broke on purpose", page)

    def test_where_all_is_well_nothing_of_it_is_said(self):
        result, found, page = self.compare(self.whole, RECORDED, code=0)
        self.assertEqual(found["graphs"][0]["failures"], [])
        for text in (result.stdout, page):
            self.assertNotRegex(text, r"\b[01] of 2 seeds")
            self.assertNotIn("failed", text)
            self.assertIn("Run times are CPU times of a single run each", text)
        self.assertIsNone(found["timing"]["spread_worst"])

    def test_every_command_takes_as_many_repeats_and_its_help_says_how_many(self):
        for verb, more in (("compare", ()), ("study", ()), ("lean", ("--budget", "1")), ("explain", ())):
            with self.subTest(verb=verb):
                said = tactor(verb, "--help").stdout
                self.assertRegex(said, r"--repeats COUNT in \[1 - 100\]")
                self.assertNotEqual(tactor(verb, self.folder / "none.yaml", *more, "--repeats", 101).returncode, 0)
                self.assertIn("--repeats: expected a whole number from 1 to 100, found 101", tactor(verb, self.whole, *more, "--repeats", 101).stderr)
                self.assertNotIn("--repeats", tactor(verb, self.folder / "none.yaml", *more, "--repeats", 100).stderr)

    def test_repeats_tell_how_far_they_spread(self):
        _, found, page = self.compare(RECORDED, code=0, options=("--repeats", "3"))
        timing = found["timing"]
        spreads = found["graphs"][0]["spread_of_repeats"]
        self.assertEqual(timing["spread_worst"], max(spreads))
        self.assertIn("the median of 3 repeats after 1 run that did not count", page)
        # Any run that is off is told by the name of its row.
        self.assertEqual(max(spreads) > 0.1, "spread by more than 10 %: recorded" in timing["warning"])


@needs_meshes
class Reports(StudyTest):
    def test_a_point_that_lacks_a_seed_is_drawn_and_marked(self):
        text = (f"graphs: [{GRAPHS / 'wall/scene.yaml'}, {RECORDED}]\nmethods: [{GRAPHS / 'methods/hold.yaml'}, {GRAPHS / 'methods/kalman.yaml'}]\n"
                "seeds: 3\nduration: 1.2 s\nreport: work_precision\ntiming: {repeats: 1, warm_up: 0}\n")
        self.study(text, "out")
        whole = json.loads(self.bytes_of("out", "study.json"))["work_precision"]["graphs"]
        # The second seed of the wall by hold, which the table then has as failed.
        with sqlite3.connect(self.folder / "out" / "study.sqlite") as db:
            (run,), = db.execute("SELECT run FROM names WHERE graph = 'wall' AND configuration = 'hold' AND seed = 1002")
            db.execute("UPDATE runs SET status = 'failed', message = 'it broke' WHERE run = ?", (run,))
            for table in ("metrics", "costs", "step_times", "repeat_times"):
                db.execute(f"DELETE FROM {table} WHERE run = ?", (run,))
        result = self.study(None, "out", "--resume", code=1)
        self.assertIn("wall hold, seed 1002: it broke", result.stderr)
        self.assertIn("2 of 3 seeds", result.stdout)
        found = json.loads(self.bytes_of("out", "study.json"))["work_precision"]["graphs"]
        error = {(g["graph"], p["curve"]): p for g in found for p in g["points"]}
        values = [float(line["delivered.force.rms_error_N"]) for line in self.lines("out")
                  if (line["graph"], line["method"], line["status"]) == ("wall", "hold", "done")]
        self.assertEqual(len(values), 2)
        self.assertAlmostEqual(error["wall", "hold"]["error"]["centre"], (values[0] * values[1]) ** 0.5)
        for name in ("wall", "all 2 graphs"):
            self.assertEqual(error[name, "hold"]["seeds_done"], 2)
            self.assertFalse(error[name, "hold"]["front_run"] or error[name, "hold"]["front_tick"])
            self.assertTrue(error[name, "kalman"]["front_run"])
        self.assertEqual(error["recorded", "hold"]["error"], {p["curve"]: p for p in whole[1]["points"]}["hold"]["error"])
        self.assertIn("incomplete: seeds failed", self.bytes_of("out", "work_precision_wall.svg").decode())
        self.assertNotIn("incomplete", self.bytes_of("out", "work_precision_recorded.svg").decode())

    def test_an_output_to_record_that_a_graph_lacks_is_refused_before_anything_runs(self):
        result = self.study(f"""graphs: [{GRAPHS / "wall/closed_loop.yaml"}]
vary: {{collision.margin: [1 mm, 2 mm], coupling.k_t: [100 N/m, -3 N/m]}}
seeds: 1
report:
  kind: stability
  record: [dynamics.state, dynamics.stat, devise.state]
""", "out", code=2)
        for text in ("study.yaml:6:28: report.record: dynamics", 'did you mean "state"?', "study.yaml:6:43: report.record: there is no node",
                     'did you mean "device"?', "in wall_closed_loop"):
            self.assertIn(text, result.stderr)
        self.assertFalse((self.folder / "out").exists())

    @needs_hdf5
    def test_an_interrupt_while_the_worst_are_recorded_keeps_the_table(self):
        stiffness = ", ".join(f"{k} N/m" for k in range(100, 500, 50))
        (self.folder / "study.yaml").write_text(f"""
graphs: [{GRAPHS / "wall/closed_loop.yaml"}]
set: {{device.loop: open, metrics.rest: 0.5 s}}
vary:
  collision.cost.constant: [20 ms, 40 ms]
  coupling.k_t: [{stiffness}]
reference: none
seeds: 1
duration: 10 s
report: {{kind: stability, worst: 100}}
""")
        out = self.folder / "out"
        process = subprocess.Popen([TACTOR, "study", self.folder / "study.yaml", "--out", out], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, env=dict(os.environ, **self.environment))
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        self.wait_until((out / "worst").is_dir, process, "it recorded the worst cells")
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 1, stderr)
        self.assertRegex(stderr.decode(), r"interrupted: 16 of 16 runs are kept in .*study.sqlite; .* --resume continues")
        recorded = list((out / "worst").iterdir())
        self.assertLess(len(recorded), 16)
        for folder in recorded:  # what was under way leaves nothing
            self.assertTrue((folder / "report.html").exists(), folder)
        (self.folder / "study.yaml").write_text((self.folder / "study.yaml").read_text().replace("worst: 100", "worst: 1"))
        self.study(None, "out", "--resume")
        self.assertEqual(json.loads(self.bytes_of("out", "study.json"))["runner"]["runs"], 0)
        self.assertEqual(len(list((out / "worst").iterdir())), 1)

    def test_a_work_precision_study_leaves_its_pictures_and_tables(self):
        result = self.study(f"""
graphs: [{GRAPHS / "wall/scene.yaml"}, {RECORDED}]
methods: [{GRAPHS / "methods/hold.yaml"}, {GRAPHS / "methods/kalman.yaml"}]
seeds: 2
duration: 1.2 s
report: work_precision
timing: {{repeats: 2, warm_up: 0}}
""", "out")
        self.assertIn("all 2 graphs", result.stdout)
        for name in ("wall", "recorded", "all_2_graphs"):
            self.assertTrue(self.bytes_of("out", f"work_precision_{name}.svg").startswith(b"<svg"))
            self.assertTrue(self.bytes_of("out", f"work_precision_{name}.png").startswith(b"\x89PNG"))
        page = self.bytes_of("out", "report.html").decode()
        for text in ("<svg", "kalman", "A fixed computation before each run", "CPU ms per simulated second"):
            self.assertIn(text, page)
        for outside in ("http://cdn", "https://cdn", "<script src", "<link", "@import", "url(http"):
            self.assertNotIn(outside, page)
        json_points = json.loads(self.bytes_of("out", "study.json"))["work_precision"]["graphs"][0]["points"]
        # The points are those of the table: of the first graph and method, the geometric mean of two seeds.
        errors = [float(line["delivered.force.rms_error_N"]) for line in self.lines("out")[:2]]
        self.assertAlmostEqual(json_points[0]["error"]["centre"], (errors[0] * errors[1]) ** 0.5)
        self.assertTrue(any(p["front_run"] for p in json_points))

    def test_a_map_tells_cells_of_every_kind_and_records_the_worst(self):
        result = self.study(f"""
graphs: [{GRAPHS / "wall/closed_loop.yaml"}]
set: {{device.loop: open, metrics.rest: 0.5 s}}
vary:
  collision.cost.constant: [2 ms, 40 ms]
  coupling.k_t: [100 N/m, -3 N/m]
reference: none
seeds: 1
duration: 2.5 s
report: {{kind: stability, worst: 1}}
""", "out")
        self.assertNotIn("delivered.force.rms_error_N", self.lines("out")[0])
        (stability,) = json.loads(self.bytes_of("out", "study.json"))["stability"]["maps"]
        cells = {(c["x"], c["y"]): c for c in stability["cells"]}
        self.assertEqual(len(cells), 4)
        self.assertEqual(cells["2 ms", "100 N/m"]["verdict"], "stable")
        # A force that is 40 ms late gives back on the way out what was never put in on the way in.
        self.assertEqual(cells["40 ms", "100 N/m"]["verdict"], "energy")
        self.assertGreater(cells["40 ms", "100 N/m"]["passivity_violation_J"], 1e-3)
        self.assertEqual(cells["2 ms", "-3 N/m"]["verdict"], "refused")
        self.assertIn("coupling.k_t: expected", cells["2 ms", "-3 N/m"]["reason"])
        self.assertIn("energy growth", result.stdout)
        worst = self.folder / "out" / cells["40 ms", "100 N/m"]["recording"]
        self.assertTrue((worst / "graph.yaml").exists())
        self.assertEqual(HAS_HDF5, (worst / "recording.h5").exists())
        self.assertTrue(self.bytes_of("out", "stability_wall_closed_loop.png").startswith(b"\x89PNG"))
        # Neither value of the study is the graph's own.
        self.assertIsNone(stability["own"])
        self.study(f"""
graphs: [{GRAPHS / "wall/closed_loop.yaml"}]
vary:
  collision.margin: [1 mm, 2 mm]
  coupling: {{swap: {{own: {{nodes: {{}}}}, soft: {{nodes: {{coupling: {{k_t: 100 N/m}}}}}}}}}}
reference: none
seeds: 1
duration: 1 s
report: {{kind: stability, worst: 0}}
""", "own")
        (own,) = json.loads(self.bytes_of("own", "study.json"))["stability"]["maps"]
        self.assertEqual([own["own"]["x"], own["own"]["y"]], ["2 mm", "own"])
        self.assertEqual(own["own"]["verdict"], own["cells"][1]["verdict"])
        # A map in which nothing could run is a bad study.
        refused = self.study(f"""
graphs: [{GRAPHS / "wall/closed_loop.yaml"}]
vary: {{coupling.kt: [1, 2], device.rate: [1000, 2000]}}
report: stability
""", "none", code=2)
        self.assertIn('did you mean "k_t"?', refused.stderr)


if __name__ == "__main__":
    unittest.main()
