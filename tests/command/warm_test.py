"""Runs are judged where their nodes are warm, on one interval for all that is compared, and by a recording where that is asked for."""
import json
import unittest

import h5py
import numpy

from harness import GRAPHS, CommandTest, needs_hdf5, tactor
from study_harness import StudyTest

WALL = GRAPHS / "wall"
STREAMS = "record: [coupling.force, prediction.forecast, device.commanded, device.truth]\n"
SETTLE = 0.2  # s, the default of sink.metrics


def stream(recording, name):
    """Stamps in s (valid, produced) and the rows of a recorded stream."""
    with h5py.File(recording) as file:
        data = file[f"streams/{name}/data"][...]
    return data["valid_ns"] * 1e-9, data["produced_ns"] * 1e-9, data


def rms(vectors):
    return float(numpy.sqrt(numpy.mean(numpy.sum(vectors ** 2, axis=1))))


def one_step_error(recording, begin, end=numpy.inf):
    """RMS of what was predicted for the next result against that result, of forecasts stamped from `begin` on."""
    valid, _, force = stream(recording, "coupling.force")
    stamps, _, forecast = stream(recording, "prediction.forecast")
    errors = []
    for stamp, row in zip(stamps, forecast):
        later = numpy.searchsorted(valid, stamp, side="right")
        if begin <= stamp < end and later < len(valid):
            errors.append(row["predicted"][0]["force"] - force["force"][later])
    return rms(numpy.array(errors))


def finer_truth(test, recording, truth, more=0.0):
    """A recording of the force of this one, with two further values on the line between each two, and `more` in z."""
    head, *lines = [line.split(",") for line in test.run_ok("export", recording, "coupling.force").stdout.splitlines()]
    rows = [[float(cell) for cell in line] for line in lines]
    for row in rows:
        row[head.index("force_z [N]")] += more
    dense = [a if part == 0 else [x + (y - x) * part / 3 for x, y in zip(a, b)] for a, b in zip(rows, rows[1:]) for part in range(3)]
    text = [",".join([f"{valid:.9f}", f"{produced:.9f}", str(number), *map(repr, values)])
            for number, (valid, produced, _, *values) in enumerate([*dense, rows[-1]])]
    table = truth.with_suffix(".csv")
    table.write_text("\n".join([",".join(head), *text]) + "\n")
    test.run_ok("import", table, truth, "--type", "Wrench", "--stream", "coupling.force")
    return truth


@needs_hdf5
class OneRun(CommandTest):
    def judged(self, text, *options):
        graph = self.write("graph.yaml", f"extends: {WALL / 'refit.yaml'}\n{STREAMS}{text}")
        return self.run_graph(graph, "--duration", "6", *options), self.folder / "out/recording.h5"

    def test_it_is_judged_from_when_the_window_is_full(self):
        summary, recording = self.judged("nodes: {refit: {window: 100}}\n")
        # 100 differences need 101 results; the predictor has the coefficients with that one or the next.
        _, produced, _ = stream(recording, "coupling.force")
        warm = summary["warm_from_s"]
        self.assertGreaterEqual(warm, produced[100] - 1e-9)
        self.assertLessEqual(warm, produced[101] + 1e-9)
        self.assertEqual(summary["warm"]["all"], True)
        begin = summary["judged"]["from_s"]
        self.assertAlmostEqual(begin, warm + SETTLE, places=9)
        # The metrics are those of the rest alone, by a computation of its own.
        self.assertAlmostEqual(summary["one_step"]["force"]["rms_error_N"], one_step_error(recording, begin), places=9)
        cold = summary["cold_start"]["one_step"]["force"]["rms_error_N"]
        self.assertAlmostEqual(cold, one_step_error(recording, SETTLE, warm), places=9)
        self.assertNotAlmostEqual(cold, summary["one_step"]["force"]["rms_error_N"], places=4)

    def test_what_is_warm_from_the_start_is_judged_from_the_start(self):
        graph = self.write("graph.yaml", f"extends: {WALL / 'fixed.yaml'}\n")
        summary = self.run_graph(graph, "--duration", "2")
        self.assertEqual(summary["warm_from_s"], 0)
        self.assertAlmostEqual(summary["judged"]["from_s"], SETTLE)
        self.assertNotIn("cold_start", summary)

    def test_a_run_that_is_never_warm_says_that_its_metrics_are_of_the_cold_start(self):
        graph = self.write("graph.yaml", f"extends: {WALL / 'refit.yaml'}\n")
        result = tactor("run", graph, "--duration", "1", "--out", self.folder / "out", environment=self.environment)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("was never warm", result.stdout)
        summary = json.loads((self.folder / "out/summary.json").read_text())
        self.assertEqual(summary["warm"]["all"], False)
        self.assertEqual(summary["warm"]["last"], "refit")
        self.assertNotIn("warm_from_s", summary)

    def test_a_recording_judges_a_run(self):
        _, recording = self.judged("nodes: {refit: {window: 50}}\n")
        # Truth: what this run was told, a quarter of a newton off. The error of physics at its own stamps is that then.
        truth = finer_truth(self, recording, self.folder / "truth.h5", 0.25)
        (self.folder / "out").rename(self.folder / "first")
        coarse, _ = self.judged("nodes: {refit: {window: 50}}\n", "--reference", self.folder / "first/recording.h5")
        self.assertIn("the recording is no finer than the run: coupling.force comes at ", coarse["reference_too_coarse"])
        self.assertNotIn("rms_error_N", coarse["delivered"]["force"])
        summary, _ = self.judged("nodes: {refit: {window: 50}}\n", "--reference", truth)
        self.assertAlmostEqual(summary["physics"]["force"]["rms_error_N"], 0.25, places=9)
        self.assertNotIn("reference_run", summary)

    def refused(self, truth, *expected):
        graph = self.write("graph.yaml", f"extends: {WALL / 'fixed.yaml'}\n")
        result = tactor("run", graph, "--duration", "2", "--reference", truth, "--out", self.folder / "refused",
                        environment=self.environment)
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        for text in expected:
            self.assertIn(text, result.stderr)
        self.assertFalse((self.folder / "refused/summary.json").exists())

    def test_a_recording_that_cannot_judge_is_refused_before_the_run(self):
        self.refused(self.folder / "none.h5", "none.h5")
        _, recording = self.judged("nodes: {refit: {window: 50}}\n")
        heads = self.run_ok("export", recording, "coupling.force").stdout.splitlines()[0]
        columns = heads.split(",")

        def made(name, rows, type_="Wrench", of="coupling.force", head=heads):
            self.write(f"{name}.csv", "\n".join([head, *rows]) + "\n")
            self.run_ok("import", self.folder / f"{name}.csv", self.folder / f"{name}.h5", "--type", type_, "--stream", of)
            return self.folder / f"{name}.h5"

        def row(t, force="0"):
            values = {"valid": t, "produced": t}
            return ",".join(str(next((v for k, v in values.items() if c.startswith(k)), 0 if "N" not in c else force)) for c in columns)

        def rows(until):
            return [row(i * 10_000_000 if "ns" in columns[0] else round(i * 0.01, 2)) for i in range(int(until * 100) + 1)]

        self.refused(made("other", rows(2), of="dynamics.force"), "other.h5", "coupling.force")
        self.refused(made("short", rows(1)), "short.h5", "up to the end of the run, 2 s", "1 s")
        self.refused(made("late", rows(2)[50:]), "late.h5", "from the beginning of the run", "0.5 s")
        self.refused(made("gap", rows(2)[:80] + rows(2)[120:]), "gap.h5", "found none from 0.79 s to 1.2 s")
        whole = made("whole", rows(2))
        closed = self.write("closed.yaml", f"extends: {WALL / 'closed_loop.yaml'}\n")
        result = tactor("run", closed, "--duration", "2", "--reference", whole, "--out", self.folder / "refused", environment=self.environment)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("closed loop", result.stderr)
        back = rows(2)
        back[50], back[51] = back[51], back[50]
        self.refused(made("back", back), "back.h5", "increasing times", "message 51")
        heads_of_state = self.run_ok("export", recording, "device.truth").stdout.splitlines()
        self.refused(made("type", heads_of_state[1:], "DeviceState", head=heads_of_state[0]), "type.h5", "Wrench", "DeviceState")


class OneInterval(StudyTest):
    STUDY = f"""
graphs: [{WALL / 'scene.yaml'}]
methods: [{GRAPHS / 'methods/hold.yaml'}, {GRAPHS / 'methods/fixed.yaml'}, {GRAPHS / 'methods/refit.yaml'}]
seeds: 3
duration: 5.5 s
"""

    def test_all_methods_are_judged_from_when_the_last_of_them_is_warm(self):
        self.study(self.STUDY, "one")
        study = json.loads((self.folder / "one/study.json").read_text())
        lines = self.lines("one")
        begins = {float(line["judged.from_s"]) for line in lines}
        self.assertEqual(len(begins), 1)
        begin = begins.pop()
        warm = [float(line["warm_from_s"]) for line in lines if line["method"] == "refit"]
        self.assertEqual(len(warm), 3)
        # Rounded up to a tenth of a second.
        self.assertGreaterEqual(begin - SETTLE, max(warm))
        self.assertLess(begin - SETTLE, max(warm) + 0.1)
        for row in study["rows"]:
            self.assertAlmostEqual(row["judged"]["from_s"], begin)
        self.assertIn("refit", study["rows"][0]["judged"]["last_warm"])
        self.assertGreaterEqual(study["metric_definitions"], 2)
        # As many one-step errors of each method count.
        self.assertGreater(study["rows"][2]["metrics"]["one_step.force.rms_error_N"]["mean"], 0)

    def test_the_whole_is_judged_where_that_is_asked_for(self):
        self.study(self.STUDY, "whole", "--judge", "whole", "--seeds", "1")
        self.assertEqual({float(line["judged.from_s"]) for line in self.lines("whole")}, {SETTLE})
        self.assertIn("metrics from the start of the runs, including their cold start", (self.folder / "whole/report.html").read_text())
        self.study(self.STUDY + "judge: whole\n", "said", "--seeds", "1")
        self.assertEqual({float(line["judged.from_s"]) for line in self.lines("said")}, {SETTLE})
        result = self.study(self.STUDY + "judge: most\n", "wrong", code=2)
        self.assertIn("judge: expected", result.stderr)

    def test_runs_in_which_a_method_is_never_warm_are_refused(self):
        # The setting in which refit is fixed coefficients all the time: F = 0.
        result = self.study(self.STUDY, "cold", "--duration", "1.2", code=2)
        for text in ("refit", "is not warm when the run ends, after 1.2 s", "its window is full", "judge: whole"):
            self.assertIn(text, result.stderr)
        self.assertFalse((self.folder / "cold/study.sqlite").exists())
        result = self.study(self.STUDY, "late", "--duration", "4", code=2)
        self.assertIn("expected at least 1 s of the run", result.stderr)

    def test_what_is_compared_side_by_side_shares_its_interval_too(self):
        out = self.folder / "compare"
        self.run_ok("compare", WALL / "off.yaml", WALL / "refit.yaml", "--seeds", "2", "--duration", "5.5", "--out", out)
        rows = json.loads((out / "compare.json").read_text())["graphs"]
        self.assertEqual(len({row["judged"]["from_s"] for row in rows}), 1)
        self.assertGreater(rows[0]["judged"]["from_s"], 3)
        result = tactor("compare", WALL / "off.yaml", WALL / "refit.yaml", "--seeds", "2", "--duration", "1", "--out",
                        self.folder / "refused", environment=self.environment)
        self.assertEqual(result.returncode, 2)
        self.assertIn("is not warm", result.stderr)

    def test_a_table_judged_on_another_interval_is_not_gone_on_with(self):
        self.study(self.STUDY, "table", "--seeds", "1")
        self.study(None, "table", "--seeds", "1", "--resume")
        result = self.study(None, "table", "--seeds", "1", "--resume", "--judge", "whole", code=2)
        self.assertIn("study.sqlite", result.stderr)

    @needs_hdf5
    def test_recordings_judge_the_runs_of_a_study_by_graph_and_seed(self):
        text = self.STUDY.replace("seeds: 3", "seeds: 2") + "reference: {recording: 'truth/{graph}_{seed}.h5'}\n"
        result = self.study(text, "missing", code=2)
        self.assertIn("truth/wall_1001.h5", result.stderr)
        (self.folder / "truth").mkdir()
        for seed in (1001, 1002):
            graph = self.write("truth.yaml", f"extends: {WALL / 'fixed.yaml'}\nrecord: [coupling.force]\n")
            self.run_ok("run", graph, "--duration", "5.5", "--seed", seed, "--out", self.folder / f"run{seed}")
            finer_truth(self, self.folder / f"run{seed}/recording.h5", self.folder / f"truth/wall_{seed}.h5")
        # Every seed's is looked at before the first run.
        (self.folder / "truth/wall_1002.h5").rename(self.folder / "other.h5")
        self.assertIn("truth/wall_1002.h5", self.study(text, "missing", code=2).stderr)
        self.assertFalse((self.folder / "missing/study.sqlite").exists())
        (self.folder / "other.h5").rename(self.folder / "truth/wall_1002.h5")
        self.study(text, "judged")
        # Another recording of the same name makes other runs.
        saved = (self.folder / "truth/wall_1002.h5").read_bytes()
        (self.folder / "truth/wall_1002.h5").write_bytes((self.folder / "truth/wall_1001.h5").read_bytes())
        self.study(None, "judged", "--resume", code=2)
        (self.folder / "truth/wall_1002.h5").write_bytes(saved)
        for line in self.lines("judged"):
            # Physics is its own truth: the open loop gives it the same motion.
            self.assertLess(float(line["physics.force.rms_error_N"]), 1e-12)
            self.assertGreater(float(line["delivered.force.rms_error_N"]), 0)
        study = json.loads((self.folder / "judged/study.json").read_text())
        self.assertTrue(study["reference_recording"].endswith("truth/{graph}_{seed}.h5"))
        result = self.study(text.replace("recording:", "set: {}, recording:"), "both", code=2)
        self.assertIn("reference.recording: expected no other key", result.stderr)


if __name__ == "__main__":
    unittest.main()
