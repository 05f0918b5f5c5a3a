"""A Slurm of two virtual nodes, one of which loses power: its tasks are queued again and run once more. 40 s."""
import time
import unittest

from cluster_harness import TELLS, ClusterTest

SECONDS = 8  # of a task; Slurm takes tasks of 7 s for lost where their node has booted anew
TASK = TELLS + f"sleep {SECONDS}; echo end\n"


class Power(ClusterTest):
    OPTIONS = {"node_timeout_s": 3}

    def begin(self, name, *options):
        """A task on each processor of both nodes; those on node 0."""
        job = self.submit(name, TASK, "--array=0-3", *options)
        self.wait_states(job, "RUNNING")
        lost = [task for task, (_, _, node) in self.cluster.queue("-j", job).items() if node == "node0"]
        self.assertEqual(len(lost), 2)
        return job, lost

    def check(self, name, job, lost, nodes):
        """Lost tasks began twice and ended once, on `nodes` at last; all others ran once."""
        for task in self.cluster.queue("-j", job):
            output = self.output(f"{name}_{task.partition('_')[2]}")
            again = f"on node0 restarts 0\non ({nodes}) restarts 1\nend\n"
            self.assertRegex(output, rf"\A{again if task in lost else f'on node1 restarts 0{chr(10)}end{chr(10)}'}\Z")

    def test_tasks_of_a_node_that_stays_off_run_again_on_another(self):
        job, lost = self.begin("off")
        after = self.submit("after", "true", f"--dependency=afterok:{job}")
        self.wait_for(lambda: "sleep" in self.cluster.processes_of_node(0).values(), "the tasks began")
        begin = time.monotonic()
        self.cluster.kill_node(0)
        self.assertEqual(self.cluster.processes_of_node(0), {})
        self.wait_for(lambda: self.cluster.node_states()["node0"] == "down*", "the node was down")
        down = time.monotonic() - begin
        self.wait_for(lambda: all(self.states(job)[task] == "RUNNING" for task in lost), "the lost tasks ran again")
        print(f"after the node lost power, it was down after {down:.0f} s; its tasks ran again after {time.monotonic() - begin:.0f} s")
        self.wait_states(job, "COMPLETED")
        self.check("off", job, lost, "node1")
        self.wait_states(after, "COMPLETED")
        self.cluster.start_slurmd(0)

    def test_tasks_of_a_node_that_boots_anew_run_again(self):
        job, lost = self.begin("boots")
        time.sleep(SECONDS - 1)  # nearly done
        begin = time.monotonic()
        self.cluster.kill_node(0)
        self.cluster.start_slurmd(0)
        self.wait_for(lambda: all(self.states(job)[task] == "PENDING" for task in lost), "the lost tasks were queued again")
        self.wait_for(lambda: all(self.states(job)[task] == "RUNNING" for task in lost), "the lost tasks ran again")
        print(f"after the node booted anew, its tasks ran again after {time.monotonic() - begin:.0f} s")
        self.wait_states(job, "COMPLETED")
        self.check("boots", job, lost, "node0|node1")


if __name__ == "__main__":
    unittest.main()
