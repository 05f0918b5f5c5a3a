"""Studies on a Slurm of two virtual nodes that breaks: in the end each has the table that this machine makes alone. 20 minutes.

Each case starts a study, breaks something in the middle of a task, lets Slurm and --resume go on, and looks that nothing is lost and
nothing is counted twice.
"""
import contextlib
import functools
import json
import os
import pathlib
import shutil
import signal
import sqlite3
import struct
import subprocess
import sys
import tempfile
import time
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "command"))
from cluster_harness import UNAVAILABLE, ClusterTest  # noqa: E402
from harness import GRAPHS, TACTOR  # noqa: E402
from slurm import SlurmCluster  # noqa: E402

RUNS = 24
# A run of LONG takes 1 s, so that there is something to lose in the middle of a task.
STUDY = """graphs: [%s/wall/scene.yaml]
methods: [%s/methods/hold.yaml]
reference: none
judge: whole
seeds: %d
duration: %s
"""
LONG = STUDY % (GRAPHS, GRAPHS, RUNS, "100 s")
LONGER = STUDY % (GRAPHS, GRAPHS, RUNS, "200 s")  # as one task it takes longer than Slurm takes to find that a node is lost
SHORT = STUDY % (GRAPHS, GRAPHS, RUNS, "20 s")
OTHER = STUDY % (GRAPHS, GRAPHS, RUNS, "10 s")
TASKS = ("--chunk", "6 s")  # of LONG: four or so
ONE_TASK = ("--chunk", "500 s")
MANY_TASKS = ("--chunk", "0.5 s")  # of SHORT: eight or so
TABLES = ("names", "runs", "metrics", "declared", "costs", "curves")  # what depends on graph and seed alone
SECONDS_TO_TELL = 20  # that --wait may take to find that all has ended
ARRAY, SLOTS = 40, 4  # of the measurement at the end


def content(out):
    """The bytes of study.csv, and the tables that depend on graph and seed alone."""
    with contextlib.closing(sqlite3.connect(f"file:{out / 'study.sqlite'}?mode=ro", uri=True)) as db:
        return (out / "study.csv").read_bytes(), {name: db.execute(f"SELECT * FROM {name}").fetchall() for name in TABLES}


@functools.cache
def made_here(text):
    """What this machine makes of a study alone."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        (folder / "study.yaml").write_text(text)
        subprocess.run([TACTOR, "study", folder / "study.yaml", "--out", folder / "out"], check=True, capture_output=True,
                       env=dict(os.environ, TACTOR_CACHE=str(folder / "cache")))
        return content(folder / "out")


def records(shard):
    """The records of a shard or a part of one, as bytes that hold the run times too; what is not whole is left out."""
    try:
        data = pathlib.Path(shard).read_bytes()
    except OSError:
        return []
    found = []
    while len(data) >= 40 and len(data) >= 40 + (size := struct.unpack_from("<Q", data)[0]):
        if data[40] == 1:
            found.append(data[40:40 + size])
        data = data[40 + size:]
    return found


class FaultTest(ClusterTest):
    OPTIONS = {"cpus": 1, "node_timeout_s": 3}

    def setUp(self):
        super().setUp()
        self.environment = {"TACTOR_CACHE": str(self.folder / "cache")}
        self.out = self.folder / self._testMethodName[len("test_"):][:40]
        begin = time.monotonic()
        self.addCleanup(lambda: print(f"{self._testMethodName[len('test_'):].replace('_', ' ')}: {time.monotonic() - begin:.0f} s",
                                      flush=True))
        self.addCleanup(self.cluster.wait_idle, 120)  # for the next case
        self.addCleanup(self.end_jobs)

    def end_jobs(self):
        for job in {name.partition("_")[0] for name, task in self.cluster.queue().items() if task.state in ("PENDING", "RUNNING")}:
            self.cluster.run("scancel", job, check=False)

    def file(self, text):
        file = self.folder / "study.yaml"
        file.write_text(text)
        return file

    def tactor(self, *words, code=0):
        """What the command prints, on one line."""
        result = self.cluster.run(TACTOR, *words, check=False, timeout=400, env=self.environment)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr + self.logs())
        return " ".join((result.stdout + result.stderr).split())

    def logs(self):
        return "".join(f"{log}:\n{log.read_text()}" for log in self.out.glob("cluster/jobs/*.log"))

    def hand_over(self, text, *options):
        self.tactor("study", self.file(text), "--out", self.out, "--cluster", "slurm", *options)

    def ask(self, *options, code=0):
        return self.tactor("study", self.out, *options, code=code)

    def started(self, *words):
        """A command in the background."""
        process = subprocess.Popen([TACTOR, *map(str, words)], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   env=self.cluster.environment(self.environment))
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        return process

    def submissions(self, stage):
        """(number, job) of each that was handed over, the last one last."""
        found = []
        for file in sorted(self.out.glob("cluster/jobs/*.json")):
            one = json.loads(file.read_text())
            if one["stage"] == stage and one["job"]:
                found.append((int(file.stem), one["job"]))
        return found

    def job(self, stage="runs"):
        return self.submissions(stage)[-1][1]

    def processes(self, stage="runs"):
        """The tasks of a stage that run, not what they have forked: {pid: index}."""
        found = {}
        numbers = {str(number) for number, _ in self.submissions(stage)}
        for folder in pathlib.Path("/proc").iterdir():
            if folder.name.isdigit():
                with contextlib.suppress(OSError):
                    words = (folder / "cmdline").read_bytes().decode().split("\0")
                    if words[1:3] == ["task", str(self.out)] and words[3] in numbers:
                        found[int(folder.name)] = int(words[4])
        parents = {pid: int(pathlib.Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1]) for pid in found
                   if pathlib.Path(f"/proc/{pid}").exists()}
        return {pid: index for pid, index in found.items() if pid in parents and parents[pid] not in found}

    def made_on(self, i):
        """How many runs the task of a node has made so far."""
        return max((len(records(file)) for file in self.cluster.scratch(i).glob("tactor-*/chunk.shard")), default=0)

    def wait_middle(self, *nodes):
        """Waits until the tasks of these nodes have made two runs and more."""
        for i in nodes or (0, 1):
            self.wait_for(lambda i=i: self.made_on(i) >= 2, f"the task of node {i} had made two runs")

    def is_done_on(self, i):
        """Whether the task of a node has made all its runs, and stands before the last step: to store them."""
        end = struct.pack("<Q", 1)  # of the last frame, before its hash and its only byte
        return any(file.read_bytes()[-41:-33] == end for file in self.cluster.scratch(i).glob("tactor-*/chunk.shard"))

    def node_of_the_task(self):
        """Which node makes the only task, once that is in its middle."""
        self.wait_for(lambda: self.made_on(0) >= 2 or self.made_on(1) >= 2, "the task had made two runs")
        return 0 if self.made_on(0) >= 2 else 1

    def shards(self, pattern="*.shard"):
        return sorted(self.out.glob(f"cluster/runs/{pattern}"))

    def parts(self):
        """{file: records} of what tasks have left that ended early."""
        return {file.with_suffix(""): records(file) for file in self.shards("*.shard.part")}

    def assert_kept(self, parts):
        """What had been kept was not made anew, which would have given other run times."""
        self.assertTrue(parts)
        for shard, kept in parts.items():
            self.assertTrue(0 < len(kept) < RUNS, f"{shard} keeps {len(kept)}")
            self.assertEqual(records(shard)[:len(kept)], kept, shard)
        print(f"  {sum(map(len, parts.values()))} runs of {len(parts)} tasks were kept", flush=True)

    def runner(self):
        return json.loads((self.out / "study.json").read_text())["runner"]

    def assert_whole(self, text, twice=0):
        """The study is that of this machine alone. `twice`: how many runs two tasks made to their ends."""
        csv, tables = content(self.out)
        self.assertEqual(len(tables["runs"]), RUNS)
        self.assertEqual(csv, made_here(text)[0])
        self.assertEqual(tables, made_here(text)[1])
        runner = self.runner()
        self.assertEqual([runner["missing_runs"], runner["missing_tasks"], runner["unlike_twice"], runner["left_out_runs"]], [0, [], [], 0])
        self.assertEqual(runner["made_twice"], twice)
        self.assertEqual(self.shards("scratch-*"), [])
        self.assertIn(" done", self.ask("--status"))

    def assert_missing(self, text, at_least=1):
        """Some runs are missing, those that are there are right, and all of this is told; returns how many are missing."""
        runner = self.runner()
        missing = runner["missing_runs"]
        self.assertTrue(at_least <= missing <= RUNS, runner)
        self.assertEqual(runner["made_twice"], 0)
        _, tables = content(self.out)
        self.assertEqual(len(tables["runs"]), RUNS - missing)
        self.assertLessEqual(set(tables["runs"]), set(made_here(text)[1]["runs"]))
        return missing

    def wait_told(self, waiting, code):
        """Waits for the end of a --wait in the background, which must come seconds after that of all tasks; what it says."""
        self.cluster.wait_idle(300)
        begin = time.monotonic()
        said, errors = waiting.communicate(timeout=120)
        seconds = time.monotonic() - begin
        said = " ".join((said + errors).split())
        self.assertEqual(waiting.returncode, code, said)
        self.assertLess(seconds, SECONDS_TO_TELL)
        print(f"  --wait ended {seconds:.0f} s after the last task", flush=True)
        return said


class Nodes(FaultTest):
    def test_a_node_loses_power_and_stays_off(self):
        self.hand_over(LONG, *TASKS)
        self.wait_middle()
        self.cluster.kill_node(0)
        self.addCleanup(self.cluster.start_slurmd, 0)
        self.ask("--wait")
        self.assert_whole(LONG)
        self.assertEqual(len(self.runner()["missing_tasks"]), 0)

    def test_a_node_loses_power_and_comes_back(self):
        self.hand_over(LONG, *TASKS)
        self.wait_middle()
        time.sleep(5)  # a task that is younger is not missed when the node is back
        self.cluster.kill_node(0)
        self.cluster.start_slurmd(0)
        self.ask("--wait")
        self.assert_whole(LONG)

    def test_the_daemon_of_a_node_ends_and_comes_back_while_its_task_goes_on(self):
        self.hand_over(LONG, *TASKS)
        self.wait_middle()
        self.cluster.kill_slurmd(0)
        time.sleep(2)
        self.cluster.start_slurmd(0)
        self.ask("--wait")
        self.assert_whole(LONG)

    def test_a_task_whose_node_is_taken_for_lost_goes_on_and_is_made_a_second_time(self):
        self.hand_over(LONGER, *ONE_TASK)
        node = self.node_of_the_task()
        first = set(self.processes())
        self.cluster.kill_slurmd(node)
        self.addCleanup(self.cluster.start_slurmd, node)
        self.wait_for(lambda: len(self.processes()) == 2, "the task ran twice")
        self.assertLess(first, set(self.processes()))
        print("  two processes made the task at once", flush=True)
        self.ask("--wait")
        self.assertEqual(len(self.shards("*.twin-*")), 1)
        self.assert_whole(LONGER, twice=RUNS)

    def test_a_task_that_someone_starts_by_hand_beside_that_of_slurm(self):
        self.hand_over(LONG, *TASKS)
        self.wait_middle()
        number, _ = self.submissions("runs")[-1]
        by_hand = self.started("task", self.out, number, next(iter(self.processes().values())))
        said = by_hand.communicate(timeout=300)
        self.assertEqual(by_hand.returncode, 0, said)
        self.ask("--wait")
        self.ask("--resume", "--wait")  # a twin that came after the merge is compared too
        twin, = self.shards("*.twin-*")
        self.assert_whole(LONG, twice=len(records(twin)))

    def test_a_running_task_is_queued_again(self):
        self.hand_over(LONG, *TASKS)
        self.wait_middle()
        task, = (name for name, task in self.cluster.queue("-j", self.job()).items() if task.node == "node0")
        self.cluster.run("scontrol", "requeue", task)
        self.wait_for(self.parts, "the task had kept what it had")
        parts = self.parts()
        self.ask("--wait")
        self.assert_whole(LONG)
        self.assert_kept(parts)

    def test_one_running_task_of_an_array_is_cancelled(self):
        self.hand_over(LONG, *TASKS)
        waiting = self.started("study", self.out, "--wait")
        self.wait_middle()
        task, = (name for name, task in self.cluster.queue("-j", self.job()).items() if task.node == "node0")
        self.cluster.run("scancel", task)
        said = self.wait_told(waiting, 1)
        parts = self.parts()
        missing = self.assert_missing(LONG)
        self.assertRegex(said, f"{missing} of {RUNS} runs are missing, in 1 tasks; .*--resume runs them")
        self.ask("--resume", "--wait")
        self.assert_whole(LONG)
        self.assert_kept(parts)

    def test_a_task_is_told_before_its_time_limit(self):
        # Two minutes before its time is up, so at the first look after its begin.
        self.hand_over(LONGER, *ONE_TASK, "--time", "2 min")
        waiting = self.started("study", self.out, "--wait")
        said = self.wait_told(waiting, 1)
        self.assertIn("it was asked to end", self.logs())
        parts = self.parts()
        missing = self.assert_missing(LONGER)
        self.assertEqual(missing, RUNS - sum(map(len, parts.values())))
        self.assertRegex(said, f"{missing} of {RUNS} runs are missing, in 1 tasks; .*--resume runs them")
        self.ask("--resume", "--wait", "--time", "20 min")
        self.assert_whole(LONGER)
        self.assert_kept(parts)

    def test_tasks_are_killed_without_a_word(self):
        self.hand_over(LONG, *TASKS)
        waiting = self.started("study", self.out, "--wait")
        self.wait_middle()
        for pid in self.processes():
            os.kill(pid, signal.SIGKILL)
        said = self.wait_told(waiting, 1)
        missing = self.assert_missing(LONG)
        self.assertRegex(said, f"{missing} of {RUNS} runs are missing, in 2 tasks; .*--resume runs them")
        self.ask("--resume", "--wait")
        self.assert_whole(LONG)


class Controller(FaultTest):
    def end_and_start(self, how):
        """The controller ends while tasks run and wait, and comes back."""
        self.cluster.stop_controller(how)
        try:
            time.sleep(12)  # so long that squeue gives up
        finally:
            self.cluster.start_controller()

    def begin(self):
        """A command that waits for a study in the background, whose tasks run and wait."""
        self.hand_over(LONG, *TASKS)
        waiting = self.started("study", self.out, "--wait")
        self.wait_middle()
        return waiting

    def wait_idle_and_release(self):
        """Waits until nothing waits or runs. Slurm holds a task that a node refuses because it still runs it; its user must release it."""
        def is_idle():
            queue = self.cluster.queue()
            for name, task in queue.items():
                if task.reason == "launch failed requeued held":
                    print(f"  {name} was held: {task.reason}", flush=True)
                    self.cluster.run("scontrol", "release", name)
            return not {"PENDING", "RUNNING", "COMPLETING", "CONFIGURING"} & {task.state for task in queue.values()}

        self.wait_for(is_idle, "all tasks had ended", timeout=300)

    def made_twice(self):
        return sum(len(records(twin)) for twin in self.shards("*.twin-*"))

    def test_the_controller_ends_in_order(self):
        waiting = self.begin()
        self.end_and_start(signal.SIGTERM)
        self.wait_told(waiting, 0)
        self.assert_whole(LONG)

    def test_the_controller_is_killed(self):
        waiting = self.begin()
        time.sleep(6)  # it saves what it knows every 5 s
        self.end_and_start(signal.SIGKILL)
        self.wait_idle_and_release()
        self.wait_told(waiting, 0)
        # What it had started since it saved last, it starts again.
        self.assert_whole(LONG, twice=self.made_twice())

    def test_the_controller_is_killed_before_it_has_saved_the_jobs(self):
        self.hand_over(LONG, *TASKS)
        self.wait_for(self.processes, "a task ran")
        self.end_and_start(signal.SIGKILL)
        lost = [job for job in (self.job(), self.job("merge")) if job not in {name.partition("_")[0] for name in self.cluster.queue()}]
        print(f"  {len(lost)} of 2 jobs were lost", flush=True)
        self.wait_for(lambda: not self.processes(), "all tasks had ended that the controller knew nothing of")
        self.wait_idle_and_release()
        if lost:
            self.assertIn("--resume runs what is missing", self.ask("--wait", code=1))
            self.ask("--resume")
        self.ask("--wait")
        self.assert_whole(LONG, twice=self.made_twice())


class Disks(FaultTest):
    def mount(self, folder, size):
        """A disk of this size (of mount -o size=) at `folder` until the end of the case."""
        folder.mkdir(exist_ok=True)
        result = subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", folder], capture_output=True, text=True,
                                check=False)
        if result.returncode != 0:
            self.skipTest(f"mount is not permitted here: {result.stderr.strip()}")
        self.addCleanup(subprocess.run, ["umount", "--lazy", folder], check=True)

    @contextlib.contextmanager
    def full(self, *folders):
        """Fills the disks of these folders to the last byte for the block."""
        files = [folder / "full" for folder in folders]
        for file in files:
            subprocess.run(["dd", "if=/dev/zero", f"of={file}", "bs=4k"], stderr=subprocess.DEVNULL, check=False)
        try:
            yield
        finally:
            for file in files:
                file.unlink()

    def test_both_nodes_have_no_room_from_the_begin(self):
        for i in range(2):
            self.mount(self.cluster.scratch(i), "64k")
        self.hand_over(LONG, *TASKS)
        self.ask("--wait")
        self.assertIn("no room for a shard of this task", self.logs())
        self.assert_whole(LONG)

    def test_a_node_without_its_temporary_folder(self):
        for i in range(2):
            self.addCleanup(self.cluster.scratch(i).mkdir, exist_ok=True)
            shutil.rmtree(self.cluster.scratch(i))
        self.hand_over(SHORT, *MANY_TASKS)
        self.ask("--wait")
        self.assert_whole(SHORT)

    def test_the_disk_of_a_node_is_full_in_the_middle_of_a_task(self):
        self.mount(self.cluster.scratch(0), "4m")
        self.hand_over(LONG, *ONE_TASK, "--sbatch-option", "--nodelist=node0")
        self.wait_middle(0)
        with self.full(self.cluster.scratch(0)):
            self.ask("--wait")
        self.assertIn("No space left on device", self.logs())
        self.assertIn("no room for a shard of this task", self.logs())
        self.assert_whole(LONG)

    def test_the_disk_of_a_node_is_smaller_than_a_shard(self):
        self.mount(self.cluster.scratch(0), "2m")
        self.hand_over(LONG, *ONE_TASK, "--sbatch-option", "--nodelist=node0")
        self.ask("--wait")
        self.assertGreater(self.shards()[0].stat().st_size, 2 << 20)
        self.assert_whole(LONG)

    def test_the_disk_that_all_share_is_full_for_a_moment(self):
        self.mount(self.out, "32m")
        self.hand_over(LONG, *TASKS)
        waiting = self.started("study", self.out, "--wait")
        self.wait_middle()
        with self.full(self.out):
            self.wait_for(lambda: all(self.is_done_on(i) for i in range(2)) or not self.processes(), "the tasks had made their runs")
            waiting_tasks = self.processes()
            time.sleep(5)  # meanwhile they cannot store them
            self.assertTrue(waiting_tasks)
            self.assertEqual(self.processes(), waiting_tasks)
        said = self.wait_told(waiting, 0)
        self.assertIn("No run was made twice", said)
        self.assert_whole(LONG)


class Shards(FaultTest):
    def spoil(self, shards, foreign):
        """Spoils one shard after the other, each in another way."""
        data = shards[0].read_bytes()
        shards[0].write_bytes(data[:len(data) // 2])
        data = bytearray(shards[1].read_bytes())
        data[len(data) // 2] ^= 4
        shards[1].write_bytes(data)
        shards[2].write_bytes(b"")
        shards[3].write_bytes(bytes(len(shards[3].read_bytes())))
        shutil.copy(foreign, shards[4])
        shutil.copy(shards[-1], shards[5])  # of another task of this study

    def test_shards_are_spoilt_before_the_merge(self):
        self.hand_over(OTHER, *MANY_TASKS)
        self.ask("--wait")
        foreign = self.folder / "foreign.shard"
        shutil.copy(self.shards()[0], foreign)
        self.out = self.folder / "spoilt"
        self.hand_over(SHORT, "--chunk", "0.3 s")
        self.cluster.run("scontrol", "hold", self.job("merge"))
        self.wait_states(self.job(), "COMPLETED")
        shards = self.shards()
        self.assertGreaterEqual(len(shards), 7)
        self.spoil(shards, foreign)
        whole = {shard: records(shard) for shard in shards[6:]}
        kept = len(records(shards[0]) + records(shards[1])[:1])
        self.cluster.run("scontrol", "release", self.job("merge"))
        said = self.ask("--wait", code=1)
        self.assertRegex(said, "in 6 tasks; .*--resume runs them")
        self.assertIn("damaged", said)
        missing = self.assert_missing(SHORT, 6)
        self.assertGreaterEqual(kept, 1)
        self.ask("--resume", "--wait")
        self.assert_whole(SHORT)
        for shard, made in whole.items():
            self.assertEqual(records(shard), made)
        print(f"  {missing} runs were missing for 6 spoilt shards", flush=True)

    def test_the_merge_is_killed_in_its_middle(self):
        self.hand_over(SHORT, *MANY_TASKS)
        interrupted = 0
        # A merge of few runs is quick, so it is tried more than once.
        for attempt, seen in enumerate(("cluster/table.txt", "study.sqlite", "study.csv") * 4):
            for name in ("study.sqlite", "study.csv"):
                (self.out / name).unlink(missing_ok=True)
            if attempt > 0:
                self.ask("--resume")
            self.wait_for(lambda: (self.out / seen).exists(), f"{seen} was there")
            killed = self.processes("merge")
            for pid in killed:
                with contextlib.suppress(ProcessLookupError):
                    os.kill(pid, signal.SIGKILL)
            self.cluster.wait_idle()
            if (self.out / "cluster/merged.json").exists():
                print(f"  the merge had ended before it was killed at {seen}", flush=True)
                continue
            print(f"  the merge was killed at {seen}", flush=True)
            interrupted += 1
            self.assertIn("its tasks have ended, and the merge has not made its table", self.ask("--wait", code=1))
        self.assertGreater(interrupted, 0)
        self.ask("--resume", "--wait")
        self.assert_whole(SHORT)

    def test_a_node_loses_power_during_the_merge(self):
        self.hand_over(SHORT, *MANY_TASKS)
        self.wait_for(lambda: (self.out / "cluster/table.txt").exists() and self.processes("merge"), "the merge had begun")
        for pid in self.processes("merge"):
            os.kill(pid, signal.SIGSTOP)  # so that it does not end before
        node = int(self.cluster.queue("-j", self.job("merge"))[self.job("merge") + "_0"].node[-1])
        self.cluster.kill_node(node)
        self.addCleanup(self.cluster.start_slurmd, node)
        self.ask("--wait")
        self.assert_whole(SHORT)


class Commands(FaultTest):
    def test_resumed_twice(self):
        self.hand_over(LONG, *TASKS)
        self.wait_middle()
        self.assertIn("expected a study of which nothing runs", self.ask("--resume", code=2))
        self.assertIn("cancelled jobs", self.ask("--cancel"))
        self.cluster.wait_idle()
        parts = self.parts()
        both = [self.started("study", self.out, "--resume") for _ in range(2)]
        said = [process.communicate(timeout=120) for process in both]
        self.assertEqual(sorted(process.returncode for process in both), [0, 2], said)
        self.assertEqual(len(self.submissions("merge")), 2)
        self.ask("--wait")
        self.assert_whole(LONG)
        self.assert_kept(parts)
        before = {shard: shard.read_bytes() for shard in self.shards()}
        self.ask("--resume", "--wait")  # of a study that is done: the report alone
        self.assertEqual({shard: shard.read_bytes() for shard in self.shards()}, before)
        self.assert_whole(LONG)

    def test_cancelled_and_resumed_again_and_again(self):
        self.hand_over(LONG, *TASKS)
        kept = {}
        for _ in range(2):
            self.wait_middle()
            self.assertIn("cancelled jobs", self.ask("--cancel"))
            self.cluster.wait_idle()
            self.assertIn("--resume runs what is missing", self.ask("--status"))
            kept.update(self.parts())
            self.ask("--resume")
        self.ask("--wait")
        self.assert_whole(LONG)
        self.assert_kept(kept)

    def test_two_commands_at_once_in_one_folder(self):
        file = self.file(SHORT)
        both = [self.started("study", file, "--out", self.out, "--cluster", "slurm", *MANY_TASKS, "--wait") for _ in range(2)]
        said = [process.communicate(timeout=300) for process in both]
        self.assertEqual(sorted(process.returncode for process in both), [0, 2], said)
        refused = next(errors for process, (_, errors) in zip(both, said) if process.returncode == 2)
        self.assertRegex(" ".join(refused.split()), "found another tactor at it|expected no study there yet")
        self.assertEqual(len(self.submissions("merge")), 1)
        self.assert_whole(SHORT)


def seconds_a_task():
    """What Slurm takes for a task and slot, s, where the task does nothing."""
    with (tempfile.TemporaryDirectory(prefix="tactor-slurm-") as folder,
          SlurmCluster(pathlib.Path(folder) / "slurm", cpus=SLOTS // 2) as cluster):
        begin = time.monotonic()
        cluster.submit("--output=/dev/null", f"--array=0-{ARRAY - 1}", script="true")
        cluster.wait_idle()
        return (time.monotonic() - begin) * SLOTS / ARRAY


def main():
    """Runs the cases that the command line names, then measures Slurm; the exit code."""
    tests = unittest.main(module=sys.modules[__name__], exit=False)
    if UNAVAILABLE is None:
        print(f"Slurm takes {seconds_a_task():.2f} s of a slot for a task beside what the task does ({ARRAY} tasks of `true` on "
              f"{SLOTS} slots): bench/cluster_overhead.py --slurm takes it")
    return 0 if tests.result.wasSuccessful() else 1


if __name__ == "__main__":
    sys.exit(main())
