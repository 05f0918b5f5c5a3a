"""A study on a Slurm of two nodes: the table that this machine makes alone, and what --status and --cancel say meanwhile."""
import json
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "command"))
from cluster_harness import ClusterTest  # noqa: E402
from harness import GRAPHS, TACTOR  # noqa: E402

STUDY = f"""graphs: [{GRAPHS}/wall/scene.yaml, {GRAPHS}/block_pushed/scene.yaml]
methods: [{GRAPHS}/methods/hold.yaml, {GRAPHS}/methods/refit.yaml]
seeds: 3
duration: 6 s
"""


class Studies(ClusterTest):
    """Arrays are cut at 8 tasks here, as at 1,001 elsewhere."""

    OPTIONS = {"array_size": 8}

    def setUp(self):
        super().setUp()
        self.environment = {"TACTOR_CACHE": str(self.folder / "cache")}
        self.file = self.folder / "study.yaml"
        self.file.write_text(STUDY)

    def tactor(self, *words, code=0):
        result = self.cluster.run(TACTOR, *words, check=False, timeout=300, env=self.environment)
        self.assertEqual(result.returncode, code, result.stdout + result.stderr + self.logs())
        return result.stdout

    def logs(self):
        return "".join(f"{log}:\n{log.read_text()}" for log in self.folder.glob("*/cluster/jobs/*.log"))

    def csv(self, out):
        return (self.folder / out / "study.csv").read_bytes()

    def test_the_table_is_the_one_of_this_machine(self):
        self.tactor("study", self.file, "--out", self.folder / "alone")
        said = self.tactor("study", self.file, "--out", self.folder / "slurm_study", "--cluster", "slurm", "--chunk", "0.2 s",
                           "--partition", "main", "--sbatch-option", "--comment=a study", "--wait")
        self.assertEqual(self.csv("slurm_study"), self.csv("alone"))
        self.assertIn("No run was made twice", " ".join(said.split()))
        runner = json.loads((self.folder / "slurm_study/study.json").read_text())["runner"]
        self.assertEqual(runner["missing_runs"], 0)
        # More tasks than an array may have, so there is more than one array of a stage.
        stages = [json.loads(file.read_text()) for file in (self.folder / "slurm_study/cluster/jobs").glob("*.json")]
        self.assertLessEqual(max(len(stage["chunks"]) for stage in stages), 8)
        # Both nodes had a part in it, each by its own name.
        self.assertIn("node0, node1", " ".join(runner["where"]))
        self.assertIn("Comment=a study", self.cluster.run("scontrol", "show", "job", stages[-1]["job"]).stdout)
        self.assertIn("done", self.tactor("study", self.folder / "slurm_study", "--status"))

    def test_cancelled_and_resumed(self):
        self.tactor("study", self.file, "--out", self.folder / "here")
        out = self.folder / "there"
        said = self.tactor("study", self.file, "--out", out, "--cluster", "slurm", "--chunk", "0.5 s")
        self.assertIn("--status shows its progress", said)
        status = self.tactor("study", out, "--status")
        self.assertRegex(status, r"merge +1 +0 +0 +1")
        self.cluster.wait_for(lambda: list((out / "cluster/references").glob("*.shard")), "a task had ended")
        self.assertIn("cancelled jobs", self.tactor("study", out, "--cancel"))
        self.cluster.wait_idle()
        self.assertIn("--resume runs what is missing", self.tactor("study", out, "--status"))
        self.assertFalse((out / "study.csv").exists())
        self.tactor("study", out, "--resume", "--wait")
        self.assertEqual(self.csv("there"), self.csv("here"))

    def test_held_tasks_are_told_and_a_percent_in_the_folder_is_no_placeholder(self):
        out = self.folder / "50 %j"
        self.cluster.run("scontrol", "update", "PartitionName=main", "State=DOWN")
        try:
            self.tactor("study", self.file, "--out", out, "--cluster", "slurm", "--chunk", "10 s", "--seeds", "1")
            job = json.loads((out / "cluster/jobs/0000.json").read_text())["job"]
            self.assertNotIn("held", self.tactor("study", out, "--status"))
            self.cluster.run("scontrol", "hold", job)
            status = self.tactor("study", out, "--status")
            self.assertIn(f"Slurm holds tasks of jobs {job}:", status)
            self.cluster.run("scontrol", "release", job)
            self.assertNotIn("held", self.tactor("study", out, "--status"))
        finally:
            self.cluster.run("scontrol", "update", "PartitionName=main", "State=UP")
        self.tactor("study", out, "--wait")
        self.assertTrue((out / "cluster/jobs/0000.sh.log").exists())

    def test_what_slurm_refuses_is_told_and_nothing_is_left_there(self):
        result = self.cluster.run(TACTOR, "study", self.file, "--out", self.folder / "out", "--cluster", "slurm", "--partition",
                                  "nowhere", check=False, env=self.environment)
        self.assertEqual(result.returncode, 1)
        self.assertIn("Invalid partition name specified", result.stderr)
        self.assertEqual(self.cluster.run("squeue", "--noheader").stdout, "")


if __name__ == "__main__":
    unittest.main()
