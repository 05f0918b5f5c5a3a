"""A Slurm of two virtual nodes: what the tests of studies on a cluster rely on."""
import pathlib
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from cluster_harness import TELLS, UNAVAILABLE, ClusterTest
from slurm import SlurmCluster, processes

TRAPS = "trap 'echo got TERM; exit 3' TERM\necho ready\nwhile :; do sleep 0.1; done\n"
# Starts a cluster with a task, says so and waits.
STARTS = """
import signal, sys, time
sys.path.insert(0, {here!r})
signal.signal(signal.SIGINT, signal.default_int_handler)  # a command in the background ignores it
from slurm import SlurmCluster
with SlurmCluster({folder!r}) as cluster:
    cluster.submit("--output=/dev/null", script="sleep 1000")
    cluster.wait_for(lambda: cluster.queue()["1"].state == "RUNNING", "the task ran")
    print("started", flush=True)
    time.sleep(1000)
"""


class Jobs(ClusterTest):
    OPTIONS = {"array_size": 10, "kill_wait_s": 2}

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        # Slurm looks at time limits every 30 s: this one begins before the other tests, and is looked at last.
        cls.limited = cls.cluster.submit("--time=1", "--signal=B:TERM@57", f"--output={cls.folder / 'limited'}",
                                         "--job-name=limited", script="date +%s\n" + TRAPS)

    def test_zz_sigterm_comes_before_the_time_limit(self):
        self.wait_states(self.limited, "FAILED")  # and not TIMEOUT
        begin, _, told = self.output("limited").partition("\n")
        self.assertIn("got TERM", told)
        self.assertLess(time.time() - int(begin), 300)
        self.assertIn("ExitCode=3:0", self.cluster.run("scontrol", "show", "job", "-o", self.limited).stdout)

    def test_an_array_runs_on_both_nodes_which_tasks_can_tell(self):
        job = self.submit("spread", TELLS + 'touch "$TMPDIR/$SLURM_ARRAY_TASK_ID"; sleep 1', "--array=0-7")
        self.wait_states(job, "COMPLETED")
        nodes = set()
        for i in range(8):
            name = self.output(f"spread_{i}").split()[1]
            nodes.add(name)
            self.assertTrue((self.cluster.scratch(self.cluster.names.index(name)) / str(i)).exists())
            self.assertEqual(self.cluster.queue("-j", job)[f"{job}_{i}"].node, name)
        self.assertEqual(nodes, {"node0", "node1"})

    def test_a_job_follows_an_array_that_ends_or_only_one_that_succeeds(self):
        bad = self.submit("bad", "sleep 1; echo end; exit $((SLURM_ARRAY_TASK_ID == 1))", "--array=0-2")
        good = self.submit("good", "sleep 1; echo end", "--array=0-2")
        after = {f"{kind}-{job}": self.submit(f"{kind}-{job}", f"cat {self.folder / name}_?", f"--dependency={kind}:{job}",
                                              "--kill-on-invalid-dep=yes")
                 for kind, name, job in (("afterany", "bad", bad), ("afterok", "bad", bad), ("afterok", "good", good))}
        for name, job in after.items():
            if name == f"afterok-{bad}":
                self.wait_states(job, "CANCELLED")
                self.assertFalse((self.folder / name).exists())
            else:
                self.wait_states(job, "COMPLETED")
                self.assertEqual(self.output(name), "end\n" * 3)
        self.assertEqual(self.states(bad), {f"{bad}_0": "COMPLETED", f"{bad}_1": "FAILED", f"{bad}_2": "COMPLETED"})

    def test_an_array_beyond_the_limit_is_refused(self):
        self.submit("fits", "true", "--array=9")
        with self.assertRaisesRegex(RuntimeError, "Batch job submission failed: Invalid job array specification"):
            self.submit("too_large", "true", "--array=10")

    def test_a_cancelled_task_gets_sigterm_then_sigkill(self):
        asked = self.submit("asked", TRAPS)
        stays = self.submit("stays", TRAPS.replace("; exit 3", ""))
        self.wait_for(lambda: all((self.folder / name).exists() and "ready" in self.output(name) for name in ("asked", "stays")),
                      "both ran")
        self.cluster.run("scancel", asked, stays)
        for job, code in ((asked, "3:0"), (stays, "0:9")):
            self.wait_states(job, "CANCELLED")
            self.assertIn(f"ExitCode={code}", self.cluster.run("scontrol", "show", "job", "-o", job).stdout)
        self.assertIn("got TERM", self.output("asked"))
        self.assertIn("got TERM", self.output("stays"))

    def test_tasks_go_on_where_the_daemon_of_their_node_ends_and_comes_back(self):
        job = self.submit("alone", TELLS + "sleep 4; echo end", "--nodelist=node1")
        # A task is called running before there is a process of it.
        self.wait_for(lambda: "sleep" in self.cluster.processes_of_node(1).values(), "the task began")
        self.cluster.kill_slurmd(1)
        self.assertIn("slurmstepd", self.cluster.processes_of_node(1).values())
        self.assertNotIn("slurmd", self.cluster.processes_of_node(1).values())
        self.cluster.start_slurmd(1)
        self.wait_states(job, "COMPLETED")
        self.assertEqual(self.output("alone"), "on node1 restarts 0\nend\n")

    def test_tasks_go_on_where_the_controller_ends_and_comes_back(self):
        job = self.submit("on", TELLS + "sleep 3; echo end", "--array=0-1")
        self.wait_states(job, "RUNNING")
        for how in (signal.SIGTERM, signal.SIGKILL):
            self.cluster.stop_controller(how)
            self.assertIn("is DOWN", self.cluster.run("scontrol", "ping", check=False).stdout)
            self.cluster.start_controller()
        self.wait_states(job, "COMPLETED")
        for i in range(2):
            self.assertRegex(self.output(f"on_{i}"), r"\Aon node\d restarts 0\nend\n\Z")


@unittest.skipIf(UNAVAILABLE is not None, UNAVAILABLE)
class Ends(unittest.TestCase):
    """No process of a cluster outlives its block, nor the process that started it."""

    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory(prefix="tactor-slurm-")))

    def wait_for(self, condition, what):
        end = time.monotonic() + 60
        while not condition():
            self.assertLess(time.monotonic(), end, f"60 s have gone by before {what}")
            time.sleep(0.05)

    def left(self, name):
        return processes(SlurmCluster(self.folder / name).is_ours)

    def test_two_clusters_run_beside_each_other_and_end_with_their_blocks_on_errors_too(self):
        with self.assertRaises(ZeroDivisionError), SlurmCluster(self.folder / "one") as one, SlurmCluster(self.folder / "two") as two:
            for cluster in (one, two):
                cluster.submit("--output=/dev/null", "--array=0-3", script="sleep 1000 & sleep 1000")
            for cluster in (one, two):
                cluster.wait_for(lambda: {task.state for task in cluster.queue().values()} == {"RUNNING"}, "the tasks ran")
                for i in range(2):
                    cluster.wait_for(lambda: list(cluster.processes_of_node(i).values()).count("sleep") == 4, "the tasks began")
            one.close()
            self.assertEqual(self.left("one"), {})
            self.assertEqual({task.state for task in two.queue().values()}, {"RUNNING"})
            raise ZeroDivisionError
        self.assertEqual(self.left("two"), {})

    def test_a_cluster_ends_with_the_process_that_started_it(self):
        here = str(pathlib.Path(__file__).parent)
        for how in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            process = subprocess.Popen([sys.executable, "-c", STARTS.format(here=here, folder=str(self.folder / how.name))],
                                       stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
            self.addCleanup(process.communicate)
            self.addCleanup(process.kill)
            self.assertEqual(process.stdout.readline(), "started\n")
            self.wait_for(lambda: "sleep" in self.left(how.name).values(), "the task began")
            self.assertLessEqual({"munged", "slurmctld", "slurmd", "slurmstepd", "sleep"}, set(self.left(how.name).values()))
            process.send_signal(how)
            process.wait(60)
            self.wait_for(lambda: not self.left(how.name), "all had ended")

    def test_a_folder_that_slurm_cannot_use_is_refused(self):
        for name in ("a folder", "long" * 20):
            with self.assertRaisesRegex(ValueError, "a folder without spaces and of at most 60 bytes"):
                SlurmCluster(self.folder / name)


if __name__ == "__main__":
    unittest.main()
