"""Studies by the steps of a cluster, on this machine: the same tables as without, whatever happens to the tasks."""
import json
import os
import pathlib
import shutil
import signal
import subprocess
import time
import unittest

from harness import GRAPHS, ROOT, TACTOR, tactor
from study_crashes_test import CRASHING
from study_harness import FAULT_NODES, RECORDED, StudyTest

WALL = GRAPHS / "wall/scene.yaml"
METHODS = f"[{GRAPHS}/methods/hold.yaml, {GRAPHS}/methods/refit.yaml]"
SMALL = f"graphs: [{WALL}]\nmethods: {METHODS}\nseeds: 2\nduration: 5 s\n"
MANY = f"graphs: [{WALL}]\nmethods: [{GRAPHS}/methods/hold.yaml]\nseeds: 12\nduration: 2 s\nreference: none\n"
# Of which a task is met while it runs.
LONG = MANY.replace("2 s", "8 s")
# What depends on graph and seed alone.
TABLES = ("names", "runs", "metrics", "declared", "costs", "curves")


class ClusterTest(StudyTest):
    def cluster(self, text, out, *options, code=0, **more):
        return self.study(text, out, "--cluster", "local", *options, code=code, **more)

    def ask(self, out, *options, code=0):
        result = tactor("study", self.folder / out, *options, environment=self.environment)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr)
        return result

    def content(self, out):
        return {name: self.table(out, f"SELECT * FROM {name}") for name in TABLES}

    def assert_same(self, one, other):
        self.assertEqual(self.bytes_of(one), self.bytes_of(other))
        self.assertEqual(self.content(one), self.content(other))

    def shards(self, out, stage="runs", pattern="*.shard"):
        return sorted((self.folder / out / "cluster" / stage).glob(pattern))

    def task(self, out, submission, index=0, **more):
        return subprocess.Popen([TACTOR, "task", self.folder / out, str(submission), str(index)], text=True,
                                env=dict(os.environ, **self.environment), stdout=subprocess.PIPE, stderr=subprocess.PIPE, **more)

    def made(self, out, submission, index=0):
        """Exit code and standard error of a task."""
        process = self.task(out, submission, index)
        _, errors = process.communicate(timeout=120)
        return process.returncode, errors

    def merge(self, out, code=0):
        found, errors = self.made(out, self.submission(out, "merge"))
        self.assertEqual(found, code, errors)

    def submission(self, out, stage):
        files = sorted((self.folder / out / "cluster/jobs").glob("*.json"))
        return max(int(file.stem) for file in files if json.loads(file.read_text())["stage"] == stage)


class SameTable(ClusterTest):
    def test_a_study_with_warm_up_and_references(self):
        self.study(SMALL, "here")
        result = self.cluster(SMALL, "there", "--chunk", "1 s", "--wait")
        self.assert_same("here", "there")
        self.assertIn("No run was made twice", " ".join(result.stdout.split()))
        runner = json.loads(self.bytes_of("there", "study.json"))["runner"]
        self.assertEqual([runner["missing_runs"], runner["made_twice"]], [0, 0])
        self.assertGreater(runner["core_hours"], 0)
        self.assertIn("Where it ran", self.bytes_of("there", "report.html").decode())
        # Run times are in tables of their own, with where they were made.
        times = self.table("there", "SELECT run, node, processor, c_library, cpu_s FROM run_times")
        self.assertEqual([row[0] for row in times], list(range(4)))
        for _, node, processor, c_library, cpu_s in times:
            self.assertEqual(node, os.uname().nodename)
            self.assertIn("x86-64", processor)
            self.assertTrue(c_library.startswith("glibc 2."))
            self.assertGreater(cpu_s, 0)
        # The manifest names what the runs depend on, by hashes.
        manifest = json.loads(self.bytes_of("there", "cluster/manifest.json"))
        self.assertEqual(manifest["runs"], 4)
        self.assertEqual(len(manifest["cases"]), 2)
        self.assertIn("tactor", manifest["code"])
        self.assertTrue(any(name.startswith("libtactor") for name in manifest["code"]))

    def test_a_map_of_stability_with_refused_cells(self):
        study = (f"graphs: [{WALL}]\nvary: {{coupling.k_0: [100 N/m, -1 N/m], device.rate: [1 kHz, 500 Hz]}}\nseeds: 2\n"
                 "duration: 1 s\nreport: {kind: stability, worst: 1}\nreference: none\n")
        self.study(study, "here")
        self.cluster(study, "there", "--wait")
        self.assert_same("here", "there")
        statuses = [row[0] for row in self.table("there", "SELECT status FROM runs ORDER BY run")]
        self.assertEqual(statuses.count("refused"), 4)
        for name in ("study.json", "report.html", "stability_scene.svg"):
            self.assertEqual((self.folder / "here" / name).exists(), (self.folder / "there" / name).exists())

    def test_run_times_are_said_to_be_of_shared_nodes(self):
        study = SMALL + "timing: {repeats: 3, warm_up: 1}\nshort: {seeds: 1, duration: 5 s}\n"
        result = self.cluster(study, "there", "--short", "--wait")
        self.assertIn("shared with other programs; --exclusive asks for exclusive nodes", " ".join(result.stdout.split()))
        self.assertIn("Run times come from nodes that were shared", " ".join(result.stdout.split()))
        self.assertEqual(self.table("there", "SELECT run, count(*) FROM repeat_times GROUP BY run"), [(0, 3), (1, 3)])

    @unittest.skipUnless((FAULT_NODES / "libtactor_fault.so").exists(), "the nodes that crash are not built")
    def test_runs_that_crash_and_references_that_crash_are_the_same_rows(self):
        self.environment["TACTOR_NODE_PATH"] = str(FAULT_NODES)
        graph = self.write("crashing.yaml", CRASHING % {"graph": RECORDED, "judged": "culprit.out"})
        methods = {"good": "at: 100 s", "aborts": "at: 0.3 s", "is_killed": "at: 0.3 s, by: kill"}
        listed = "".join(f"  - {name}: {{nodes: {{culprit: {{{text}}}}}}}\n" for name, text in methods.items())
        study = f"graphs: [{graph}]\nmethods:\n{listed}seeds: 2\nduration: 0.6 s\n"
        self.study(study, "here", code=1)
        self.cluster(study, "there", "--wait", code=1)
        self.assert_same("here", "there")
        self.assertGreater(len({row for row in self.table("there", "SELECT status, message FROM runs")}), 1)


    def test_a_job_that_waits_runs_the_script_that_was_submitted(self):
        before = subprocess.Popen(["sleep", "600"])
        try:
            began = pathlib.Path(f"/proc/{before.pid}/stat").read_text().rsplit(") ")[1].split()[19]
            script, trace = self.write("job.sh", f"echo submitted $TACTOR_TASK >> '{self.folder}/trace'\n"), self.folder / "trace"
            systems = ROOT / "app/study/cluster/systems/local"
            job = subprocess.run(["sh", systems / "submit.sh", script, self.folder / "log", "0", "2", "2", f"{before.pid}-{began}"],
                                 capture_output=True, text=True, check=True).stdout.strip()
            status = subprocess.run(["sh", systems / "status.sh", job], capture_output=True, text=True, check=True)
            self.assertEqual(status.stdout, f"{job} waiting\n")
            self.write("other.sh", f"echo replaced >> '{trace}'\n").rename(script)
        finally:
            before.kill()
            before.wait()
        until = time.monotonic() + 60
        while time.monotonic() < until and not (trace.exists() and trace.read_text().count("\n") == 3):
            time.sleep(0.05)
        self.assertEqual(sorted(trace.read_text().splitlines()), [f"submitted {i}" for i in range(3)])

    def test_a_node_without_gnuplot_merges_and_says_that_charts_are_missing(self):
        programs = self.folder / "programs"
        programs.mkdir()
        for name in ("sh", "env", "cut", "seq", "xargs", "setsid", "dirname", "sleep"):
            (programs / name).symlink_to(shutil.which(name))
        self.environment["PATH"] = str(programs)
        study = SMALL + "report: work_precision\n"
        self.cluster(study, "there", "--seeds", "1", "--repeats", "1", "--wait")
        self.assertIn("No chart: gnuplot is not installed", self.bytes_of("there", "report.html").decode())
        self.assertFalse(list((self.folder / "there").glob("*.png")))
        self.assertEqual(len(self.lines("there")), 2)


class TasksThatEnd(ClusterTest):
    def test_cancelled_and_resumed(self):
        self.study(LONG, "here")
        self.cluster(LONG, "there", "--chunk", "0.2 s", "--jobs", "1")
        self.wait_for(lambda: self.shards("there"), "a task had ended")
        self.assertIn("stage", self.ask("there", "--status").stdout)
        self.assertIn("finished results are kept", self.ask("there", "--cancel").stdout)
        done = len(self.shards("there"))
        self.wait_for(lambda: "--resume runs what is missing" in self.ask("there", "--status").stdout, "all tasks had ended")
        self.ask("there", "--resume", "--wait")
        self.assertGreaterEqual(len(self.shards("there")), done)
        self.assert_same("here", "there")
        self.assertFalse(list((self.folder / "there/cluster/runs").glob("*.part")))

    def test_a_task_that_is_told_to_end_keeps_what_it_has_and_the_next_goes_on(self):
        self.study(LONG, "here")
        self.cluster(LONG, "there", "--chunk", "600 s", "--wait")
        runs = self.submission("there", "runs")
        shard, = self.shards("there")
        shard.unlink()
        (self.folder / "scratch").mkdir()
        self.environment["TMPDIR"] = str(self.folder / "scratch")
        process = self.task("there", runs)
        sizes = set()

        def has_records():
            sizes.update(file.stat().st_size for file in (self.folder / "scratch").rglob("*.shard"))
            return len(sizes - {0}) > 2

        self.wait_for(has_records, "its shard had grown by two records")
        process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 1, errors)
        part, = self.shards("there", pattern="*.part")
        kept = int(errors.split(" of 12 are kept")[0].split()[-1])
        self.assertIn("it was asked to end", errors)
        self.assertGreater(kept, 0)
        self.assertLess(kept, 12)
        # It made the rest alone: what was kept has the times of the first try.
        before = part.read_bytes()
        self.assertEqual(self.made("there", runs)[0], 0)
        shard, = self.shards("there")
        first = before[:len(before) // 2]
        self.assertEqual(shard.read_bytes()[:len(first)], first)
        self.assertFalse(self.shards("there", pattern="*.part"))
        self.merge("there")
        self.assert_same("here", "there")

    def test_a_task_that_is_told_to_end_while_it_looks_for_warmth_keeps_nothing_half_done(self):
        self.study(SMALL, "here")
        self.cluster(SMALL, "there", "--chunk", "600 s", "--wait")
        folder = self.folder / "there/cluster"
        for stage in ("warm", "references"):
            number = self.submission("there", stage)
            self.shards("there", stage)[0].unlink()
            for file in (*folder.glob("cache/*"), *folder.glob("runs/*"), folder / "intervals.bin"):
                file.unlink(missing_ok=True)
            ended = 0
            for delay in (0.1, 0.15, 0.2, 0.3, 0.4):
                # The task alone is told, as Slurm does before the time limit; its worker is not.
                process = self.task("there", number)
                time.sleep(delay)
                process.send_signal(signal.SIGTERM)
                process.communicate(timeout=60)
                ended += process.returncode == 1
            self.assertGreater(ended, 0)
            self.assertEqual(self.made("there", number)[0], 0)
            self.ask("there", "--resume", "--wait")
            self.assert_same("here", "there")

    def test_a_killed_task_is_missed_and_made_by_resume(self):
        self.study(LONG, "here")
        self.cluster(LONG, "there", "--chunk", "600 s")
        self.wait_for(lambda: self.tasks_of("there", "runs"), "its runs had begun")
        for pid in self.tasks_of("there", "runs"):
            os.kill(pid, signal.SIGKILL)
        result = self.ask("there", "--wait", code=1)
        self.assertIn("12 of 12 runs are missing, in 1 tasks; cluster/jobs/*.log tells why, and --resume runs them", " ".join(result.stdout.split()))
        self.assertEqual(self.table("there", "SELECT count(*) FROM runs"), [(0,)])
        self.ask("there", "--resume", "--wait")
        self.assert_same("here", "there")

    def tasks_of(self, out, stage):
        try:
            number = self.submission(out, stage)
        except ValueError:
            return []
        found = []
        for folder in pathlib.Path("/proc").iterdir():
            if not folder.name.isdigit():
                continue
            try:
                words = (folder / "cmdline").read_bytes().split(b"\0")
                if words[1:4] == [b"task", os.fsencode(self.folder / out), str(number).encode()]:
                    found.append(int(folder.name))
            except OSError:
                continue
        return found

    def test_a_task_that_runs_twice_at_once_counts_once(self):
        self.cluster(LONG, "there", "--chunk", "600 s", "--wait")
        before = self.content("there")
        shard, = self.shards("there")
        shard.unlink()
        processes = [self.task("there", self.submission("there", "runs")) for _ in range(2)]
        for process in processes:
            process.communicate(timeout=120)
            self.assertEqual(process.returncode, 0)
        self.assertEqual(len(self.shards("there", pattern="*.twin-*")), 1)
        self.merge("there")
        self.assertEqual(self.content("there"), before)
        runner = json.loads(self.bytes_of("there", "study.json"))["runner"]
        self.assertEqual([runner["made_twice"], runner["unlike_twice"], runner["missing_runs"]], [12, [], 0])

    def test_a_damaged_shard_is_told_and_made_anew(self):
        self.cluster(MANY, "there", "--chunk", "600 s", "--wait")
        before = self.content("there")
        shard, = self.shards("there")
        data = bytearray(shard.read_bytes())
        data[len(data) // 2] ^= 1
        shard.write_bytes(data)
        self.merge("there", code=1)
        runner = json.loads(self.bytes_of("there", "study.json"))["runner"]
        self.assertTrue(0 < runner["missing_runs"] < 12)
        self.assertIn("are damaged", self.bytes_of("there", "report.html").decode())
        self.ask("there", "--resume", "--wait")
        self.assertEqual(self.content("there"), before)

    def test_a_shard_of_another_task_is_told_and_the_right_one_made(self):
        self.cluster(MANY, "there", "--chunk", "0.1 s", "--wait")
        before = self.content("there")
        first, second = self.shards("there")[:2]
        first.write_bytes(second.read_bytes())
        self.merge("there", code=1)
        self.assertIn("it is of another task or study", self.bytes_of("there", "report.html").decode())
        self.ask("there", "--resume", "--wait")
        self.assertEqual(self.content("there"), before)

    def test_a_node_without_room_on_its_disk_writes_beside_the_shards(self):
        self.cluster(MANY, "there", "--chunk", "600 s", "--wait")
        before = self.content("there")
        for place in ("/proc", "/nowhere"):  # where nobody can write, and what no machine has
            self.shards("there")[0].unlink()
            (self.folder / "there/study.sqlite").unlink()
            self.environment["TMPDIR"] = place
            code, errors = self.made("there", self.submission("there", "runs"))
            self.assertEqual(code, 0, errors)
            self.assertIn("no room for a shard of this task", errors)
            code, errors = self.made("there", self.submission("there", "merge"))
            self.assertEqual(code, 0, errors)
            self.assertIn("the table is made below", errors)
            self.assertEqual(self.content("there"), before)
            self.assertFalse(list((self.folder / "there/cluster").rglob("scratch*")))


class Refused(ClusterTest):
    def test_a_graph_that_has_changed_since(self):
        graph = self.folder / "mine.yaml"
        graph.write_text(f"extends: {WALL}\nduration: 2 s\n")
        study = "graphs: [mine.yaml]\nseeds: 2\nreference: none\njudge: whole\n"
        self.cluster(study, "there", "--wait")
        self.shards("there")[0].unlink()
        graph.write_text(f"extends: {WALL}\nduration: 3 s\n")
        code, errors = self.made("there", self.submission("there", "runs"))
        self.assertEqual(code, 2)
        self.assertIn("mine as it is: the graph, or a file that it names, has changed since the study was submitted", errors)
        self.assertFalse(self.shards("there"))

    def test_what_the_command_line_cannot_mean(self):
        def refused(*words):
            result = tactor("study", *words, environment=self.environment)
            self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
            return result.stderr

        (self.folder / "study.yaml").write_text(MANY)
        file = self.folder / "study.yaml"
        self.assertIn("local.yaml", refused(file, "--cluster", "nowhere"))
        self.assertIn("expected --cluster, or a study that was handed to a cluster", refused(file, "--status"))
        self.assertIn("expected --cluster, or a study that was handed to a cluster", refused(file, "--partition", "x"))
        self.assertIn("--chunk", refused(file, "--cluster", "local", "--chunk", "soon"))
        self.cluster(None, "there", "--wait")
        self.assertIn("expected no study there yet", refused(file, "--out", self.folder / "there", "--cluster", "local"))
        self.assertIn("expected no study there yet, found one that was handed to a cluster", refused(file, "--out", self.folder / "there"))
        self.assertIn("since this is a study on a cluster", refused(self.folder / "there"))
        self.assertIn("expected no option that changes the study", refused(self.folder / "there", "--resume", "--seeds", "3"))
        self.assertIn("found other options", refused(file, "--out", self.folder / "there", "--resume", "--seeds", "3"))
        self.assertIn("found the folder of a study", refused(self.folder / "there", "--cluster", "local"))
        self.assertIn("expected no --cluster", refused(file, "--out", self.folder / "there", "--cluster", "local", "--resume"))
        self.assertEqual(self.made("there", 99)[0], 2)
        code, errors = self.made("there", 0, 99)
        self.assertEqual(code, 2)
        self.assertIn("expected an index below", errors)
        self.cluster(None, "there", "--overwrite", "--wait")

    def test_an_overwrite_that_is_refused_loses_nothing(self):
        self.cluster(MANY, "there", "--wait")
        before = self.content("there")
        for more in (("--cluster", "local"), ()):
            result = self.study(None, "there", *more, "--overwrite", "--set", "dynamics.no_such=1", code=2)
            self.assertIn("no_such", result.stderr)
            self.assertEqual(self.content("there"), before)
            self.assertIn("done", self.ask("there", "--status").stdout)
        # What is begun anew here is no study on a cluster any more.
        self.study(None, "there", "--overwrite")
        self.assertEqual(self.content("there"), before)
        self.assertIn("expected --cluster, or a study", tactor("study", self.folder / "there", "--status").stderr)

    def test_a_cluster_that_refuses(self):
        file = self.folder / "full.yaml"
        file.write_text("submit: [sh, -c, 'echo the queue is full >&2; exit 1', '{script}']\nstatus: ['true']\ncancel: ['true']\n"
                        "index: I\nstates: {waiting: [Q], running: [R]}\n")
        result = self.study(MANY, "there", "--cluster", str(file), code=1)
        self.assertIn("has failed: the queue is full", result.stderr)
        file.write_text(file.read_text().replace("submit: [sh", "submit: [no_such_scheduler"))
        result = self.study(MANY, "there", "--cluster", str(file), "--overwrite", code=1)
        self.assertIn("is it installed here?", result.stderr)

    def test_an_overwrite_that_the_cluster_refuses_leaves_the_earlier_study(self):
        file = self.folder / "full.yaml"
        file.write_text("submit: [sh, -c, 'echo the queue is full >&2; exit 1', '{script}']\nstatus: ['true']\ncancel: ['true']\n"
                        "index: I\nstates: {waiting: [Q], running: [R]}\n")
        self.cluster(MANY, "there", "--wait")
        self.study(MANY, "here")
        for out in ("there", "here"):
            before = self.content(out)
            result = self.study(MANY, out, "--cluster", str(file), "--overwrite", "--seeds", "3", code=1)
            self.assertIn("the queue is full", result.stderr)
            self.assertEqual(self.content(out), before)
        self.assertIn("done", self.ask("there", "--status").stdout)
        # The study of this machine alone is still one.
        self.study(MANY, "here", "--resume")
        self.assertFalse((self.folder / "there/cluster/earlier").exists())

    def test_tasks_that_are_held_are_told(self):
        file = self.folder / "holds.yaml"
        file.write_text("submit: [sh, -c, 'basename \"$0\" .sh', '{script}']\nstatus: [sh, -c, 'echo 0000 0 H; echo 0000 1 Q']\ncancel: ['true']\n"
                        "index: I\nstates: {waiting: [Q], running: [R], held: [H]}\n")
        self.study(MANY, "there", "--cluster", str(file))
        said = self.ask("there", "--status").stdout
        self.assertRegex(said, r"runs .* 1 held")
        self.assertIn("holds tasks of jobs 0000: they begin when someone releases them", " ".join(said.split()))

    def test_a_study_that_is_never_warm_is_refused_by_the_step_that_finds_it(self):
        study = SMALL.replace("duration: 5 s", "duration: 2 s")
        here = self.study(study, "here", code=2)
        there = self.cluster(study, "there", "--wait", code=2)
        self.assertIn(here.stderr.strip().splitlines()[-1], there.stderr)


if __name__ == "__main__":
    unittest.main()
