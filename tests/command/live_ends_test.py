"""Live runs end: with many nodes, without the threads that they ask for, and before they have begun."""
import json
import os
import pathlib
import resource
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from harness import GRAPHS, IS_SANITIZED, LIBRARIES, TACTOR, CommandTest, needs_meshes, needs_hdf5, needs_live

try:
    import h5py
    import numpy
except ImportError:
    h5py = None

IN_TIME = 20 if IS_SANITIZED else 5  # s, from the end of a run to the end of the command, on a busy machine
NODES = 200
A_USER = 54321  # who has no process
HAS_MODBUS = (LIBRARIES / "tactor/libtactor_modbus.so").exists()
WALL = f"""extends: {GRAPHS / 'wall/refit.yaml'}
clock: real
live: {{on_missing_privilege: warn}}
"""
DEVICES = "record: [device.commanded, device.safety"


def once(names):
    """The names of refused threads; under a sanitizer, which has threads of its own, each once."""
    return list(dict.fromkeys(names)) if IS_SANITIZED else names


def wall_with(nodes):
    """The live wall with so many nodes more, all of them recorded."""
    names = [f"hold_{i}" for i in range(nodes)]
    # Under a sanitizer 200 nodes are late, which is not what is tested.
    wall = WALL.replace("live: {", "live: {stall_timeout: 20 s, ") if IS_SANITIZED else WALL
    return (wall + "nodes:\n  metrics: ~\n" + "".join(f"  {name}: {{type: prediction.hold}}\n" for name in names) + "edges:\n" +
            "".join(f"  - coupling.force -> {name}.force\n" for name in names) +
            DEVICES + "".join(f", {name}.forecast" for name in names) + "]\n")


@needs_live
@needs_meshes
@needs_hdf5
@unittest.skipIf(h5py is None, "h5py is not installed")
class ManyNodes(CommandTest):
    def start(self, *arguments):
        process = subprocess.Popen([TACTOR, "run", self.write("many.yaml", wall_with(NODES)), "--out",
                                    self.folder / "out", *arguments], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE,
                                   text=True, env=dict(os.environ, **self.environment))
        self.addCleanup(lambda: process.poll() is None and process.kill())
        return process

    def check_end(self, process, patience):
        """Ends in time, with results, a whole recording, and zero force at last; the summary."""
        begin = time.monotonic()
        try:
            _, stderr = process.communicate(timeout=90)
        except subprocess.TimeoutExpired:
            self.fail("the run does not end")
        self.assertEqual(process.returncode, 0, stderr)
        self.assertLess(time.monotonic() - begin, patience)
        summary = json.loads((self.folder / "out/summary.json").read_text())
        with h5py.File(self.folder / "out/recording.h5") as file:
            self.assertTrue(file.attrs["complete"])
            commanded = file["streams/device.commanded/data"][...]
            self.assertEqual(len(file["streams"]), NODES + 6)  # with steps, ticks, sets, stop
            self.assertGreater(len(file[f"streams/hold_{NODES - 1}.forecast/data"]), 0)
        self.assertEqual(numpy.linalg.norm(commanded["force"][-1]), 0.0)
        # Down to the last tick, which is no sooner than the end of what is judged.
        self.assertGreaterEqual(commanded["valid_ns"][-1] * 1e-9, summary["duration_s"] - 2e-3)
        return summary

    def test_a_live_graph_of_two_hundred_nodes_ends_with_its_results_and_zero_force(self):
        summary = self.check_end(self.start("--duration", "1.5"), 90)
        self.assertEqual(summary["duration_s"], 1.5)
        self.assertLess(summary["wall_s"], 1.5 + IN_TIME)

    def test_a_live_graph_of_two_hundred_nodes_ends_when_it_is_asked_to(self):
        process = self.start("--duration", "1000")
        recording = self.folder / "out/recording.h5"
        self.wait_until(recording.exists, process, "the run began")
        length = recording.stat().st_size
        self.wait_until(lambda: recording.stat().st_size > length, process, "something was recorded")
        process.send_signal(signal.SIGTERM)
        self.assertTrue(self.check_end(process, IN_TIME + 1)["interrupted"])  # a second for the report


def as_a_user(threads):
    """In the child: another user, who may have so many threads in all."""
    def become():
        resource.setrlimit(resource.RLIMIT_NPROC, (threads, threads))
        os.setgroups([])
        os.setgid(A_USER)
        os.setuid(A_USER)
    return become


@needs_live
@needs_meshes
@unittest.skipUnless(os.geteuid() == 0, "only root can run a command as a user with no other process")
class RefusedThreads(CommandTest):
    def setUp(self):
        super().setUp()
        self.folder.chmod(0o755)
        self.home = self.folder / "home"
        self.home.mkdir()
        os.chown(self.home, A_USER, A_USER)
        self.environment = {"TACTOR_CACHE": str(self.home / "cache"), "HOME": str(self.home)}
        try:
            works = subprocess.run([TACTOR, "--version"], preexec_fn=as_a_user(64), capture_output=True, check=False,
                                   env=dict(os.environ, **self.environment)).returncode == 0
        except OSError:
            works = False
        if not works:
            self.skipTest("another user may not run this build")

    def run_with(self, threads, *arguments):
        """The command of a user who may have so many threads, in a time that no hang has."""
        return subprocess.run([TACTOR, *map(str, arguments)], preexec_fn=as_a_user(threads), capture_output=True,
                              text=True, env=dict(os.environ, **self.environment), timeout=60, check=False,
                              cwd=self.home)

    def refused(self, *arguments, most):
        """Runs the command with 1, 2, ... threads until it has enough; the names of the refused ones, in turn."""
        names = []
        for threads in range(1, most):
            result = self.run_with(threads, *arguments)
            if result.returncode == 0:
                return once(names)
            self.assertEqual(result.returncode, 1, result.stderr)
            self.assertRegex(result.stderr, rf"may have {threads} threads and processes in all \(ulimit -u\)")
            names.append(result.stderr.split("cannot start the ")[1].split(":")[0])
        self.fail(f"{most} threads are not enough: {names}")

    def test_a_live_run_that_is_refused_any_of_its_threads_ends_and_names_the_limit(self):
        graph = self.write("wall.yaml", WALL.replace("live: {", "live: {pool: {workers: 2}, "))
        names = self.refused("run", graph, "--duration", "0.1", "--out", "out", "--overwrite", most=12)
        self.assertEqual(names, ["thread trial", "thread pool", "thread physics", "thread device", "thread timer"])

    def test_a_live_run_that_asks_for_every_privilege_names_the_limit_too(self):
        graph = self.write("wall.yaml", WALL.replace("warn", "fail"))
        self.assertIn("cannot start the thread trial", self.run_with(1, "run", graph, "--out", "out").stderr)

    def test_a_comparison_that_is_refused_a_worker_ends_and_names_the_limit(self):
        names = self.refused("compare", GRAPHS / "wall/off.yaml", GRAPHS / "wall/refit.yaml", "--seeds", "2",
                             "--duration", "0.1", "--judge", "whole", "--jobs", "3", "--out", "out", "--overwrite", most=12)
        self.assertEqual(set(names), {"process of the study"})

    @unittest.skipUnless(HAS_MODBUS, "this build has no Modbus")
    def test_a_link_to_a_device_that_is_refused_its_thread_ends_the_run_and_names_the_limit(self):
        result = self.run_with(1, "device", "test", GRAPHS / "bunny/orca.yaml")
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr, r"cannot start the thread \S+: ")


@needs_live
@needs_meshes
class BeforeTheFirstTick(CommandTest):
    def test_a_live_run_that_is_interrupted_as_it_starts_ends_well_and_leaves_a_report(self):
        graph = self.write("wall.yaml", WALL)
        for wait in (0.02, 0.03, 0.04, 0.06, 0.1, 0.3):
            with self.subTest(wait):
                out = pathlib.Path(tempfile.mkdtemp(dir=self.folder))
                process = subprocess.Popen([TACTOR, "run", graph, "--out", out],
                                           stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                           env=dict(os.environ, **self.environment))
                time.sleep(wait)
                process.send_signal(signal.SIGINT)
                _, stderr = process.communicate(timeout=60)
                if process.returncode == -signal.SIGINT:
                    continue  # the program had not begun
                self.assertEqual(process.returncode, 0, stderr)
                self.assertIn("</html>", (out / "report.html").read_text())
                summary = json.loads((out / "summary.json").read_text())
                self.assertTrue(summary["interrupted"])
                self.assertGreaterEqual(summary["duration_s"], 0)
                shutil.rmtree(out)

    def test_runs_of_no_length_end_well_under_both_clocks(self):
        for clock in ("virtual", "real"):
            for duration in ("1e-9", "0.001", "0.0021"):
                with self.subTest(clock=clock, duration=duration):
                    self.run_ok("run", GRAPHS / "wall/refit.yaml", "--set", f"clock={clock}", "--duration", duration,
                                "--out", self.folder / "out", "--overwrite")
                    self.assertIn("</html>", (self.folder / "out/report.html").read_text())


if __name__ == "__main__":
    unittest.main()
