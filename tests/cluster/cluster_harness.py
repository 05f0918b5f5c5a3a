"""Tests on a Slurm of their own, which the tests of a class share."""
import pathlib
import shutil
import tempfile
import time
import unittest

from slurm import SlurmCluster, unavailable

UNAVAILABLE = unavailable()
# Tells where and how often a task ran; the output file is shared by the runs of a task that is queued again.
TOLD = ("--open-mode=append", "--requeue")
TELLS = 'echo "on $SLURMD_NODENAME restarts ${SLURM_RESTART_COUNT:-0}"\n'


@unittest.skipIf(UNAVAILABLE is not None, UNAVAILABLE)
class ClusterTest(unittest.TestCase):
    OPTIONS = {}  # of the cluster

    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="tactor-slurm-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder, ignore_errors=True)
        cls.cluster = cls.enterClassContext(SlurmCluster(cls.folder / "slurm", **cls.OPTIONS))

    def submit(self, name, script, *options):
        """The id of a job whose tasks write into `name_0` and so on, or `name` where it is no array."""
        output = name + ("_%a" if any(option.startswith("--array") for option in options) else "")
        return self.cluster.submit(*TOLD, f"--output={self.folder / output}", *options, script=script)

    def output(self, name):
        return (self.folder / name).read_text()

    def states(self, job):
        """{id: state} of a job or of the tasks of an array."""
        return {name: task.state for name, task in self.cluster.queue("-j", job).items()}

    def wait_for(self, condition, what, timeout=120):
        end = time.monotonic() + timeout
        while not condition():
            self.assertLess(time.monotonic(), end, f"{timeout} s have gone by before {what}: {self.cluster.queue()}")
            time.sleep(0.1)

    def wait_states(self, job, *wanted):
        """Waits until all states of a job are among these."""
        self.wait_for(lambda: set(self.states(job).values()) <= set(wanted), f"job {job} was {' or '.join(wanted)}")
