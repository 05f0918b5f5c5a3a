"""The command's verbs, outputs and exit codes."""
import csv
import json
import math
import os
import re
import signal
import subprocess
import time
import unittest
import xml.etree.ElementTree

import jsonschema
import yaml

from harness import (GRAPHS, HAS_MESHES, HAS_HDF5, HAS_LIVE, METRICS_OF_A_SMALL_GRAPH, TACTOR, VERSION, CommandTest,
                     every_verb, graph_files, graph_name, graph_verbs, needs_meshes, needs_devices, needs_hdf5, needs_live,
                     tactor)


class ExitCodes(CommandTest):
    def test_help_and_version_succeed_for_every_verb(self):
        self.assertRegex(self.run_ok("--version").stdout, rf"\A{re.escape(VERSION)} \(commit ([0-9a-f]{{12}}(, dirty)?|unknown)\)\n\Z")
        self.run_ok("--help")
        found = list(every_verb())
        self.assertGreater(len(found), 12)
        for verb in found:
            with self.subTest(verb=verb):
                self.assertGreater(len(self.run_ok(*verb, "--help").stdout), 60)

    def test_bad_input_is_exit_code_2_with_the_place(self):
        bad = self.write("bad.yaml", "clock: virtual\nduration: 3 kg\nnodes: {}\n")
        found = list(graph_verbs())
        self.assertGreater(len(found), 6)
        for verb, options in found:
            with self.subTest(verb=verb):
                result = tactor(*verb, bad, *options, cwd=self.folder)
                self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
                self.assertIn("bad.yaml:2:11", result.stderr)

    def test_wrong_options_are_exit_code_2(self):
        graph = GRAPHS / "duck/off.yaml"
        for arguments in ([], ["fly"], ["run"], ["run", graph, "--duration", "-1"], ["run", graph, "--seed", "x"],
                          ["run", graph, "--set", "collision.margni=3 mm"], ["run", graph, "--set", "nonsense"],
                          ["run", "no/such/file.yaml"], ["run", self.folder], ["nodes", "prediction.arr"],
                          ["compare", graph, "--seeds", "0"], ["graph", graph, "--format", "png"],
                          ["export", graph, "device.state"]):
            result = tactor(*arguments)
            self.assertEqual(result.returncode, 2, f"{arguments}: {result.stdout}{result.stderr}")
            self.assertGreater(len(result.stderr), 10)

    def test_the_nearest_name_is_offered(self):
        self.assertIn("prediction.ar", tactor("nodes", "prediction.arr").stderr)
        self.assertIn("encoder_step", tactor("check", GRAPHS / "duck/off.yaml", "--set",
                                             "device.encoder_stepp=1 um").stderr)

    def test_an_out_folder_that_cannot_be_made_is_bad_input(self):
        self.assertEqual(tactor("run", GRAPHS / "duck/off.yaml", "--out", "/proc/nowhere").returncode, 2)

    def test_a_run_that_is_too_short_to_be_judged_says_so(self):
        said = self.run_ok("run", GRAPHS / "wall/scene.yaml", "--duration", "0.1", "--out", self.folder / "short").stdout
        self.assertIn("judged nothing: the run was too short, 0.100 s; it is judged from 0.200 s on", " ".join(said.split()))
        self.assertNotIn(" - s", said)

    def test_a_whole_node_is_set(self):
        said = self.run_ok("check", "--explain", GRAPHS / "wall/scene.yaml", "--set", "prediction={type: prediction.kalman}").stdout
        self.assertIn("prediction.kalman", said)
        self.assertNotIn("prediction.hold", said)
        refused = tactor("check", GRAPHS / "wall/scene.yaml", "--set", "prediction=prediction.kalman")
        self.assertEqual(refused.returncode, 2)
        self.assertIn("node={type: ...} or node={python: FILE.py:Class}", " ".join(refused.stderr.split()))

    def test_a_check_tells_the_metrics_of_a_run(self):
        said = self.run_ok("check", "--metrics", GRAPHS / "wall/off.yaml").stdout
        self.assertIn("\n  delivered.force.rms_error_N (N; lower is better)\n", said)

    def live_graph(self):
        return self.write("real.yaml", self.judged_small_graph().read_text().replace("clock: virtual", "clock: real"))

    @needs_live
    def test_the_live_clock_runs_in_wall_time(self):
        summary = self.run_graph(self.live_graph())
        self.assertEqual(summary["clock"], "real")
        self.assertEqual(summary["duration_s"], 0.5)
        self.assertGreaterEqual(summary["wall_s"], 0.5)
        self.assertGreaterEqual(summary["device"]["ticks"] + summary["device"]["missed"], 500)

    @unittest.skipIf(HAS_LIVE, "this build has the live engine")
    def test_a_build_without_the_live_engine_says_what_it_lacks(self):
        result = tactor("run", self.live_graph(), cwd=self.folder)
        self.assertEqual(result.returncode, 2)
        self.assertIn("-DTACTOR_WITH_CAF=ON", result.stderr)

    def test_comparisons_refuse_the_live_clock(self):
        graph = self.live_graph()
        result = tactor("compare", self.judged_small_graph(), graph, "--out", self.folder / "cmp")
        self.assertEqual(result.returncode, 2)
        for text in ("real.yaml", "clock: real", "expected clock: virtual", "--set clock=virtual"):
            self.assertIn(text, result.stderr)
        self.assertFalse((self.folder / "cmp").exists())

    def test_a_folder_that_cannot_be_made_is_refused_before_anything_runs(self):
        graph = self.judged_small_graph()
        study = self.write("small.yaml", f"graphs: [{graph}]\nseeds: 1\n")
        for arguments in (("compare", graph, "--seeds", "1"), ("study", study)):
            result = tactor(*arguments, "--duration", "100000", "--out", "/proc/nowhere", timeout=60)
            self.assertEqual(result.returncode, 2, result.stderr)
            self.assertIn("--out /proc/nowhere: cannot make this folder", result.stderr)

    @needs_meshes
    def test_an_interrupt_ends_the_run_with_code_1_and_keeps_what_there_is(self):
        out = self.folder / "out"
        process = subprocess.Popen([TACTOR, "run", GRAPHS / "duck/off.yaml", "--duration", "100000", "--out", out],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   env=dict(os.environ, **self.environment))
        self.wait_until(out.is_dir, process, "the run had its folder")
        time.sleep(1)
        process.send_signal(signal.SIGINT)
        _, stderr = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, stderr)
        self.assertTrue(json.loads((out / "summary.json").read_text())["interrupted"])


@needs_meshes
class Outputs(CommandTest):
    def test_a_run_leaves_its_files_and_the_promised_figures(self):
        summary = self.run_graph(GRAPHS / "peg_in_hole/refit.yaml", "--duration", "2.2", "--seed", "7")
        for name in ("summary.json", "graph.yaml", "report.html"):
            self.assertTrue((self.folder / "out" / name).exists(), name)
        self.assertEqual(summary["seed"], 7)
        self.assertEqual(summary["duration_s"], 2.2)
        for quantity, unit in (("force", "N"), ("torque", "Nm")):
            for key in (f"rms_error_{unit}", f"max_error_{unit}", "delay_ms", f"rms_d1_{unit}_per_ms",
                        f"rms_d2_{unit}_per_ms2", f"max_step_{unit}"):
                self.assertIn(key, summary["delivered"][quantity])
        self.assertIn("share_beyond_jnd", summary["delivered"]["force"])
        self.assertIn("rms_error_N", summary["one_step"]["force"])
        for key in ("rate_hz_min", "rate_hz_median", "rate_hz_max", "steps"):
            self.assertGreater(summary["physics"][key], 0)
        self.assertIn("median", summary["contacts"])
        for node in ("collision", "dynamics", "coupling", "prediction", "refit", "device"):
            self.assertGreater(summary["cost_us"][node]["p99"], 0)
        for key in ("graph", "wall_s", "cpu_s", "realtime_factor", "refits", "fallbacks", "drops", "left_out"):
            self.assertIn(key, summary)

    def test_the_resolved_graph_runs_to_the_same_figures(self):
        first = self.run_graph(GRAPHS / "duck/3_refit.yaml", "--duration", "1", out="a")
        second = self.run_graph(self.folder / "a" / "graph.yaml", out="b")
        self.assertEqual(first["delivered"], second["delivered"])
        self.assertEqual(first["physics"], second["physics"])

    def test_a_report_is_self_contained(self):
        self.run_graph(GRAPHS / "duck/off.yaml", "--duration", "1")
        page = (self.folder / "out" / "report.html").read_text()
        self.assertIn("<svg", page)
        for outside in ("http://cdn", "https://cdn", "<script src", "<link", "@import", "url(http"):
            self.assertNotIn(outside, page)

    def test_set_changes_the_answer(self):
        soft = self.run_graph(GRAPHS / "duck/off.yaml", "--duration", "2", "--set", "coupling.k_0=100 N/m",
                              "--set", "coupling.k_min=10 N/m", out="soft")
        hard = self.run_graph(GRAPHS / "duck/off.yaml", "--duration", "2", out="hard")
        self.assertLess(soft["reference"]["force"]["max_step_N"], hard["reference"]["force"]["max_step_N"])

    def test_compare_puts_error_and_run_time_side_by_side(self):
        out = self.folder / "cmp"
        compared = self.run_ok("compare", *(GRAPHS / f"duck/{m}.yaml" for m in ("off", "fixed", "refit")), "--seeds", "6",
                               "--duration", "5", "--out", out)
        result = json.loads((out / "compare.json").read_text())
        # How far the run times can be trusted is told everywhere.
        self.assertGreater(result["timing"]["control_us"], 0)
        self.assertEqual(result["timing"]["warning"] != "", result["timing"]["control_spread"] > 0.1)
        for text in (compared.stdout, (out / "report.html").read_text()):
            self.assertIn("A fixed computation before each run took", text)
            self.assertEqual("The machine was not quiet" in text, result["timing"]["warning"] != "")
        self.assertEqual([g["graph"] for g in result["graphs"]], ["duck_off", "duck_fixed", "duck_refit"])
        for graph in result["graphs"]:
            self.assertEqual(len(graph["metrics"]["delivered.force.rms_error_N"]["by_seed"]), 6)
            self.assertGreater(graph["metrics"]["cpu_ms_per_s"]["mean"], 0)
        self.assertIn("F", result["graphs"][1]["against"]["one_step_anova"])
        page = (out / "report.html").read_text()
        self.assertIn("run time", page)
        self.assertIn("<svg", page)

    def test_a_damaged_reference_cache_is_made_again(self):
        first = self.run_graph(GRAPHS / "duck/off.yaml", "--duration", "0.5")
        (file,) = self.cache_folder.glob("*.ref")
        data = bytearray(file.read_bytes())
        data[len(data) // 2] ^= 0xFF
        file.write_bytes(data)
        second = self.run_graph(GRAPHS / "duck/off.yaml", "--duration", "0.5")
        self.assertFalse(second["reference_run"]["cached"])
        self.assertEqual(first["delivered"], second["delivered"])
        self.assertTrue(self.run_graph(GRAPHS / "duck/off.yaml", "--duration", "0.5")["reference_run"]["cached"])

    def study(self, out, *options):
        """The parsed lines of the tables: errors with run times, and errors alone."""
        self.write("small_study.yaml", f"""
graphs: [{GRAPHS / "recorded/scene.yaml"}]
methods: [{GRAPHS / "methods/hold.yaml"}, {GRAPHS / "methods/burg.yaml"}]
vary: {{coupling.cost.constant: [0.01, 0.001]}}
seeds: 3
judge: whole
""")
        folder = self.folder / out
        self.run_ok("study", self.folder / "small_study.yaml", "--duration", "1.5", "--out", folder, *options)
        errors, times = (list(csv.DictReader((folder / name).read_text().splitlines())) for name in ("study.csv", "run_times.csv"))
        return [line | time for line, time in zip(errors, times)], errors

    def test_a_study_gives_a_line_a_run_the_same_by_any_number_of_jobs(self):
        lines, alone = self.study("one", "--jobs", "1")
        self.assertEqual(len(lines), 2 * 2 * 3)
        self.assertEqual([line["seed"] for line in lines[:3]], ["1001", "1002", "1003"])
        for line in lines:
            self.assertGreater(float(line["method_us_per_result"]), 0)
            self.assertGreater(float(line["delivered.force.rms_error_N"]), 0)
        self.assertEqual(alone, self.study("many", "--jobs", "4")[1])
        result = json.loads((self.folder / "many" / "study.json").read_text())
        self.assertEqual([row.get("method") for row in result["rows"]], ["hold", "hold", "burg", "burg"])
        by_row = [[float(line["delivered.force.rms_error_N"]) for line in lines[3 * row:3 * row + 3]] for row in range(4)]
        self.assertEqual(result["baseline"], {"method": "hold"})
        for i, (row, errors) in enumerate(zip(result["rows"], by_row)):
            # Against the hold of the same cost.
            logs = [math.log(mine / first) for mine, first in zip(errors, by_row[i % 2])]
            self.assertAlmostEqual(row["against"]["ratio"]["delivered_rms"]["ratio"], math.exp(sum(logs) / 3))
        page = (self.folder / "many" / "report.html").read_text()
        self.assertIn("burg coupling.cost.constant=0.001", page)

    def test_a_file_laid_over_a_graph_comes_before_set(self):
        over = GRAPHS / "methods/refit.yaml"
        self.run_graph(GRAPHS / "recorded/scene.yaml", "--over", over, "--set", "refit.window=77", "--duration", "0.4")
        resolved = (self.folder / "out" / "graph.yaml").read_text()
        self.assertIn("prediction.refit", resolved)
        self.assertIn("window: 77", resolved)
        self.assertNotIn("prediction.hold", resolved)
        missing = tactor("check", GRAPHS / "recorded/scene.yaml", "--over", self.folder / "none.yaml")
        self.assertEqual(missing.returncode, 2)
        self.assertIn("none.yaml: expected a graph file that exists; looked for ", missing.stderr)

    def test_a_bad_study_is_refused_before_anything_runs(self):
        study = self.write("bad_study.yaml", f"graphs: [{GRAPHS / 'recorded/scene.yaml'}]\nvary: {{refit.window: [3]}}\n")
        result = tactor("study", study, "--out", self.folder / "bad")
        self.assertEqual(result.returncode, 2)
        self.assertIn("refit: expected a node of the graph", result.stderr)
        study = self.write("bad_study.yaml", "graphs: [none.yaml]\n")
        result = tactor("study", study, "--out", self.folder / "bad")
        self.assertEqual(result.returncode, 2)
        self.assertIn("bad_study.yaml:1:10: graphs: expected a graph file that exists", result.stderr)
        self.assertFalse((self.folder / "bad").exists())

    def test_compare_says_once_that_a_reference_was_damaged(self):
        graphs = (GRAPHS / "duck/off.yaml", GRAPHS / "duck/fixed.yaml", "--seeds", "2", "--duration", "0.5")
        self.assertNotIn("damaged", self.run_ok("compare", *graphs, "--out", self.folder / "whole").stderr)
        files = sorted(self.cache_folder.glob("*.ref"))
        self.assertEqual(len(files), 2)
        files[0].write_bytes(files[0].read_bytes()[:-1])
        said = self.run_ok("compare", *graphs, "--out", self.folder / "damaged").stderr
        self.assertEqual(said.count(f"{files[0]}: the cached file is damaged"), 1)
        self.assertEqual(said.count("damaged"), 1)


class LeavingOut(CommandTest):
    def loaded(self, graph):
        result = self.run_ok("run", graph, "--out", self.folder / "out",
                             environment={**self.environment, "LD_DEBUG": "files"})
        return result.stderr

    def test_libraries_are_loaded_only_when_named(self):
        loaded = self.loaded(self.judged_small_graph())
        self.assertIn("libtactor_source.so", loaded)
        for library in ("libhdf5", "libtactor_record.so", "libtactor_collision.so", "libtactor_prediction.so",
                        "libgmp", "libcaf"):
            self.assertNotIn(library, loaded)

    @needs_hdf5
    def test_a_recording_loads_its_library(self):
        self.assertIn("libhdf5", self.loaded(self.judged_small_graph("record: [device.state]\n")))


class MissingParts(CommandTest):
    def assert_bad_input(self, *arguments, says):
        result = self.tactor(*arguments)
        self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
        for text in says:
            self.assertIn(text, result.stderr)

    def tactor(self, *arguments):
        return tactor(*arguments, environment=self.environment, cwd=self.folder)

    @unittest.skipIf(HAS_HDF5, "this build has HDF5")
    def test_a_build_without_hdf5_says_what_it_lacks(self):
        recorded = self.judged_small_graph("record: [device.state]\n")
        replayed = self.write("replayed.yaml", """
clock: virtual
duration: 1 s
scene: {bodies: {}}
nodes:
  recording: {type: source.recording, file: recording.h5, stream: device.state}
  device: {type: device.simulated}
  metrics: {type: sink.metrics}
edges:
  - recording.target -> device.target
""" + METRICS_OF_A_SMALL_GRAPH)
        self.write("recording.h5", "")
        for arguments in (["run", recorded], ["run", replayed], ["export", "recording.h5", "device.state"]):
            with self.subTest(arguments=arguments):
                self.assert_bad_input(*arguments, says=["no HDF5", "-DTACTOR_WITH_HDF5=ON"])

    def test_what_needs_neither_runs(self):
        self.run_graph(self.judged_small_graph())


class Drawing(CommandTest):
    @needs_meshes
    def test_diagrams_name_every_node(self):
        for form in ("mermaid", "dot", "svg"):
            text = self.run_ok("graph", GRAPHS / "bunny/refit.yaml", "--format", form).stdout
            for node in ("trajectory", "device", "collision", "dynamics", "coupling", "refit", "prediction",
                         "interpolation", "metrics"):
                self.assertIn(node, text)
            if form == "svg":
                xml.etree.ElementTree.fromstring(text)

    def test_nodes_are_listed_and_explained(self):
        listing = self.run_ok("nodes").stdout
        collision = ("collision.auto", "collision.exact", "collision.sdf", "collision.primitive", "collision.none") if HAS_MESHES else ()
        rbf = ("forcefield.rbf",) if HAS_MESHES else ()
        for name in ("source.trajectory", "source.recording", "device.simulated", *collision, *rbf, "dynamics.rigid",
                     "coupling.static", "coupling.dynamic", "coupling.adaptive", "prediction.ar",
                     "prediction.refit", "prediction.hold", "prediction.linear", "interpolation.bspline",
                     "interpolation.none", "interpolation.lowpass", "interpolation.linear", "forcefield.grid",
                     "sink.metrics"):
            self.assertIn(name, listing)
            help_text = self.run_ok("nodes", name).stdout
            self.assertTrue(help_text.startswith(name + ": "), help_text[:80])
            self.assertIn("outputs" if name != "sink.metrics" else "inputs", help_text)

    def test_a_default_that_is_as_in_another_node_is_told_as_that(self):
        for name in ("prediction.local", "interpolation.rollout", "interpolation.direct"):
            help_text = self.run_ok("nodes", name).stdout
            self.assertIn("  stick_velocity (m/s; default as in dynamics (0.0001 otherwise); > 0, <= 1)\n", help_text)
        self.assertIn("  margin (m; default as in collision (0.002 otherwise); >= 0, <= 0.1)\n", help_text)
        self.assertIn("  iterations (integer; default 20; >= 8, <= 200)\n", help_text)

    @needs_meshes
    @needs_devices
    def test_the_schema_accepts_the_shipped_graphs(self):
        validator = jsonschema.Draft202012Validator(json.loads(self.run_ok("schema").stdout))
        for graph in graph_files():
            with self.subTest(graph=graph_name(graph)):
                validator.validate(yaml.safe_load(graph.read_text()))

    def test_the_schema_refuses_a_wrong_graph(self):
        validator = jsonschema.Draft202012Validator(json.loads(self.run_ok("schema").stdout))
        with self.assertRaises(jsonschema.ValidationError):
            validator.validate({"clock": "sundial", "nodes": {}})


if __name__ == "__main__":
    unittest.main()
