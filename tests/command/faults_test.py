"""Live runs in which something goes wrong: whatever it is, the force stays within its limits and comes down to zero."""
import fcntl
import json
import os
import pathlib
import pty
import resource
import select
import shutil
import signal
import subprocess
import termios
import time
import unittest

from harness import GRAPHS, TACTOR, CachedTest, give_privileges_up, needs_meshes, needs_hdf5, needs_live, tactor

try:
    import h5py
    import numpy
except ImportError:
    h5py = None

FAULT_NODES = pathlib.Path(os.environ.get("TACTOR_BUILD", pathlib.Path(TACTOR).resolve().parents[1])) / "tests/nodes"
TIMEOUT = 90  # s, for a run of a few seconds on a machine with much else to do
# The limits of devices unless a graph says otherwise.
FORCE_MAX, TORQUE_MAX, FORCE_SLEW, TORQUE_SLEW, PERIOD = 8.0, 0.3, 2000.0, 40.0, 1e-3
RAMP_DOWN = 0.1
DISENGAGED, RAMPING, ENGAGED, FAULT = range(4)
NONE, NOT_FINITE, OVERSPEED, READ_FAILED = range(4)
STALE, NOT_PERMITTED = 7, 8
# The duck's tool is in contact from 0.7 s on. Nothing is judged, so no reference run is waited for.
# Physics runs as fast as it can, so that there is more to go wrong.
DUCK = f"""extends: {GRAPHS / 'duck/live.yaml'}
duration: 3 s
live: {{impose_cost: false%s}}
nodes: {{metrics: ~}}
record: [device.state, device.commanded, device.safety, coupling.force]
"""
STALL = """nodes:
  metrics: ~
  stall: {type: fault.stall, at: 1.2 s, %s, lane: thread, thread: physics}
edges:
  - dynamics.state -> stall.in
  - stall.out -> coupling.state
"""
THROWS = """nodes:
  metrics: ~
  culprit: {type: fault.throws, at: 1.2 s, lasts: 1 s}
edges:
  - coupling.force -> culprit.in
  - culprit.out -> refit.force
"""
NOT_FINITE_FORECAST = """nodes:
  metrics: ~
  culprit: {type: fault.not_finite, at: 1.2 s, lasts: 0.2 s}
edges:
  - prediction.forecast -> culprit.in
  - culprit.out -> interpolation.forecast
"""
DEVICE = """nodes:
  metrics: ~
  device: {type: fault.device, failure_timeout: 0.5 s, %s}
"""


def duck(extra="", live=""):
    """The duck's graph; `extra` may have nodes of its own, `live` the keys of that section."""
    text = DUCK % (f", {live}" if live else "")
    return (text if "nodes:" not in extra else text.replace("nodes: {metrics: ~}\n", "")) + extra


class Recording:
    """What a run recorded of its device."""

    def __init__(self, path, **options):
        with h5py.File(path, **options) as file:
            self.complete = bool(file.attrs["complete"])
            commanded = file["streams/device.commanded/data"][...]
            safety = file["streams/device.safety/data"][...]
        rows = min(len(commanded), len(safety))  # of a run that was cut off, one may have a message more
        commanded, safety = commanded[:rows], safety[:rows]
        assert (commanded["valid_ns"] == safety["valid_ns"]).all()
        self.ns = commanded["valid_ns"]
        self.t = self.ns * 1e-9
        self.force, self.torque = commanded["force"], commanded["torque"]
        self.norm = numpy.linalg.norm(self.force, axis=1)
        self.engagement, self.cause = safety["engagement"], safety["cause"]
        self.let_go = numpy.diff(self.ns) * 1e-9 > 2.5 * PERIOD  # between a tick and the next

    def first(self, condition, after=0.0):
        """The first tick where the condition holds."""
        found = numpy.flatnonzero(condition & (self.t >= after))
        assert len(found) > 0, "no tick is so"
        return found[0]


@needs_meshes
@needs_hdf5
@unittest.skipIf(h5py is None, "h5py is not installed")
class FaultRun(CachedTest):
    def setUp(self):
        super().setUp()
        self.environment["TACTOR_NODE_PATH"] = str(FAULT_NODES)
        self.out = self.folder / "out"

    def read_while_running(self):
        """Times in s and sizes in N of the forces that are on the disk."""
        try:
            with h5py.File(self.out / "recording.h5", swmr=True) as file:
                data = file["streams/device.commanded/data"][...]
        except (OSError, KeyError, RuntimeError):  # not begun, or just being begun
            return numpy.zeros(1), numpy.zeros(1)
        return data["valid_ns"] * 1e-9, numpy.linalg.norm(data["force"], axis=1)

    def start(self, graph, *arguments, **options):
        """The command, started."""
        process = subprocess.Popen([TACTOR, "run", self.write("fault.yaml", graph), "--out", self.out, *arguments],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                   env=dict(os.environ, **self.environment), **options)
        self.addCleanup(lambda: process.poll() is None and process.kill())
        return process

    def finish(self, process, code):
        """Waits for its end, which must be with this exit code; what it said on standard error."""
        try:
            self.stdout, stderr = process.communicate(timeout=TIMEOUT)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            self.fail("the run does not end")
        self.assertEqual(process.returncode, code, self.stdout + stderr)
        return stderr

    def run_fault(self, graph, code, *arguments, **options):
        """Runs the graph to its end; standard error."""
        return self.finish(self.start(graph, *arguments, **options), code)

    def results(self, clock="real"):
        """The summary; the other results must be there too."""
        self.assertIn(f"clock: {clock}", (self.out / "graph.yaml").read_text())
        self.assertIn("</html>", (self.out / "report.html").read_text())
        return json.loads((self.out / "summary.json").read_text())

    def recording(self, complete=True, at_rest=True, in_contact=True, **options):
        """The recording, whose force has kept its limits at every tick, and is zero at the end."""
        recorded = Recording(self.out / "recording.h5", **options)
        self.assertEqual(recorded.complete, complete)
        self.assertGreater(len(recorded.t), 1)
        self.assertTrue(numpy.isfinite(recorded.force).all() and numpy.isfinite(recorded.torque).all())
        steps = numpy.diff(recorded.ns)
        self.assertTrue((steps > 0).all())
        elapsed = numpy.minimum(steps * 1e-9, 2 * PERIOD)  # a longer gap allows no longer a step
        for vector, most, slew in ((recorded.force, FORCE_MAX, FORCE_SLEW), (recorded.torque, TORQUE_MAX, TORQUE_SLEW)):
            self.assertLessEqual(numpy.linalg.norm(vector, axis=1).max(), most * (1 + 1e-9))
            # A device that comes later than that has let go meanwhile.
            before = numpy.where(recorded.let_go[:, None], 0, vector[:-1])
            change = numpy.linalg.norm(vector[1:] - before, axis=1)
            self.assertTrue((change <= slew * elapsed * (1 + 1e-9)).all(), (change / elapsed).max())
        # Without permission, without a fresh force and in a fault, zero follows in its time.
        quiet = (recorded.engagement == DISENGAGED)
        self.assertTrue((recorded.norm[quiet] == 0).all())
        if in_contact:
            self.assertGreater(recorded.norm.max(), 0.2, "the tool was not in contact, so nothing was tried")
        if at_rest:
            self.assertEqual(recorded.norm[-1], 0.0)
        return recorded

    def assert_zero_in_time(self, recorded, begin, limit):
        """Zero is commanded at the ticks from `limit` s after tick `begin` on, until the wrench ramps in again."""
        late = numpy.flatnonzero(recorded.t >= recorded.t[begin] + limit + 2 * PERIOD)
        # A run may have ended before that, at rest.
        self.assertEqual(recorded.norm[late[0] if len(late) > 0 else -1], 0.0)

    def assert_ramped_down(self, recorded, cause):
        """The last ramp takes the force down to zero for this cause; where the device has let go in it, at once."""
        ramp = (recorded.engagement == RAMPING) & (recorded.cause == cause)
        begin = recorded.first(ramp)
        if not recorded.let_go[begin - 1:numpy.flatnonzero(ramp)[-1]].any():
            self.assertGreater(recorded.norm[begin], 0)
            self.assertGreater(numpy.count_nonzero(ramp & (recorded.norm > 0)), 10)
        self.assert_zero_in_time(recorded, begin, RAMP_DOWN)


@needs_live
class Physics(FaultRun):
    def test_a_stall_is_ramped_out_and_in_where_the_graph_recovers(self):
        self.run_fault(duck(STALL % "lasts: 0.6 s", "on_stall: recover, stall_timeout: 0.2 s"), 0)
        recorded = self.recording()
        stale = recorded.first(recorded.cause == STALE, after=1.2)
        self.assert_zero_in_time(recorded, stale, RAMP_DOWN)
        ramps_in = (recorded.engagement == RAMPING) & (recorded.cause == NONE)
        back = numpy.flatnonzero(ramps_in[1:] & ~ramps_in[:-1])[-1] + 1
        self.assertGreater(back, stale)
        self.assertEqual(recorded.norm[back - 1], 0.0)
        self.assertGreaterEqual(recorded.t[back], 1.2 + 0.6 - 0.01)
        engaged = recorded.first(recorded.engagement == ENGAGED, after=recorded.t[back])
        self.assertGreaterEqual(recorded.t[engaged] - recorded.t[back], 0.1 - 2 * PERIOD)
        self.assertGreater(recorded.norm[engaged:].max(), 0.2)
        summary = self.results()
        self.assertNotIn("failure", summary)
        self.assertGreaterEqual(summary["device"]["stale"], 1)

    def test_a_stall_ends_the_run_with_the_name_of_the_node_where_the_graph_stops(self):
        stderr = self.run_fault(duck(STALL % "lasts: 0.6 s", "stall_timeout: 0.3 s"), 1)
        self.assertRegex(stderr, r"node stall \(fault\.stall\) has stalled.*stall_timeout")
        recorded = self.recording()
        self.assertLess(recorded.t[-1], 2.9)
        stale = recorded.first(recorded.cause == STALE, after=1.2)
        self.assert_zero_in_time(recorded, stale, RAMP_DOWN)
        self.assertIn("stall", self.results()["failure"])

    def test_a_step_without_end_ends_the_process_with_everything_recorded(self):
        process = self.start(duck(STALL % "lasts: 1000 s, computes: true"))
        stderr = self.finish(process, 1)
        self.assertRegex(stderr, r"node stall \(fault\.stall\) has stalled")
        recorded = self.recording()
        stale = recorded.first(recorded.cause == STALE, after=1.2)
        self.assert_zero_in_time(recorded, stale, RAMP_DOWN)
        summary = self.results()
        self.assertIn("stall", summary["failure"])
        # The run ended at the stall, and everything up to there has been recorded.
        self.assertGreater(recorded.t[-1], summary["duration_s"] - PERIOD)
        self.assertGreater(summary["device"]["ticks"], 100)

    def test_a_step_that_has_not_come_back_at_the_end_is_named_even_where_the_graph_recovers(self):
        stderr = self.run_fault(duck(STALL % "lasts: 1000 s", "on_stall: recover, stall_timeout: 0.2 s"), 1,
                                "--duration", "2")
        self.assertIn("node stall (fault.stall) does not come back from its step", stderr)
        self.recording()
        summary = self.results()
        self.assertEqual(summary["duration_s"], 2)
        self.assertGreater(summary["cost_us"]["coupling"]["steps"], 100)


@needs_live
class Pipeline(FaultRun):
    def test_forces_that_are_not_finite_never_reach_the_device(self):
        self.run_fault(duck(NOT_FINITE_FORECAST), 0)
        recorded = self.recording()
        wrong = recorded.first(recorded.cause == NOT_FINITE, after=1.2)
        self.assertEqual(recorded.engagement[wrong], FAULT)
        self.assert_zero_in_time(recorded, wrong, FORCE_MAX / FORCE_SLEW)
        # The pipeline keeps nothing of it, so the force comes back when the gate has recovered.
        engaged = recorded.first(recorded.engagement == ENGAGED, after=1.4)
        self.assertGreaterEqual(recorded.t[engaged], recorded.t[wrong] + 0.5)
        self.assertGreater(recorded.norm[engaged:].max(), 0.2)
        summary = self.results()
        self.assertGreaterEqual(summary["device"]["rejected_forces"], 1)
        self.assertNotIn("failure", summary)

    def test_a_node_that_throws_ends_the_run_with_its_name_and_its_words(self):
        stderr = self.run_fault(duck(THROWS), 1)
        self.assertRegex(stderr, r"node culprit failed at 1\.\d+ s: it broke on purpose")
        recorded = self.recording()
        self.assert_ramped_down(recorded, NOT_PERMITTED)
        self.assertIn("it broke on purpose", self.results()["failure"])
        self.assertIn("it broke on purpose", (self.out / "report.html").read_text())


@needs_live
class Device(FaultRun):
    def test_one_failed_reading_is_a_fault_that_is_recovered_from(self):
        self.run_fault(duck(DEVICE % "at: 1.2 s, lasts: 0 s"), 0)
        recorded = self.recording()
        fault = recorded.first(recorded.cause == READ_FAILED)
        self.assert_zero_in_time(recorded, fault, FORCE_MAX / FORCE_SLEW)
        engaged = recorded.first(recorded.engagement == ENGAGED, after=recorded.t[fault])
        self.assertGreaterEqual(recorded.t[engaged] - recorded.t[fault], 0.5)  # the gate's time of recovery
        summary = self.results()
        self.assertEqual(summary["device"]["causes"]["read_failed"], 1)
        self.assertNotIn("failure", summary)

    def test_readings_that_fail_for_good_end_the_run_with_the_name_of_the_device(self):
        stderr = self.run_fault(duck(DEVICE % "at: 1.2 s, lasts: 1000 s"), 1)
        self.assertRegex(stderr, r"device device could not be read for 0\.\d+ s: its cable is out on purpose")
        recorded = self.recording()
        fault = recorded.first(recorded.cause == READ_FAILED)
        self.assert_zero_in_time(recorded, fault, FORCE_MAX / FORCE_SLEW)
        self.assertTrue((recorded.norm[recorded.t > recorded.t[fault] + 0.01] == 0).all())
        self.assertIn("device", self.results()["failure"])

    def test_a_handle_that_jumps_is_braked_and_then_left_alone(self):
        self.run_fault(duck(DEVICE % "fault: jumps, at: 1.2 s, lasts: 0.3 s"), 0)
        recorded = self.recording()
        fault = recorded.first(recorded.cause == OVERSPEED, after=1.2)
        self.assert_zero_in_time(recorded, fault, 0.05 + 2 * FORCE_MAX / FORCE_SLEW)
        self.assertGreaterEqual(self.results()["device"]["causes"]["overspeed"], 1)

    def test_a_reading_that_comes_back_late_is_followed_by_no_step_of_force(self):
        self.run_fault(duck(DEVICE % "fault: blocks, at: 1.2 s, lasts: 0.7 s",
                            "on_stall: recover, stall_timeout: 0.2 s"), 0)
        recorded = self.recording()
        gap = numpy.argmax(numpy.diff(recorded.ns))
        self.assertGreater(recorded.ns[gap + 1] - recorded.ns[gap], 600_000_000)
        summary = self.results()
        self.assertGreaterEqual(summary["device"]["missed"], 600)
        self.assertGreaterEqual(summary["device"]["causes"]["time_gap"], 1)
        self.assertNotIn("failure", summary)

    def test_a_reading_that_never_comes_back_ends_the_process(self):
        stderr = self.run_fault(duck(DEVICE % "fault: blocks, at: 1.2 s, lasts: 1000 s"), 1)
        self.assertRegex(stderr, r"node device \(fault\.device\) has stalled")
        # Who blocks the loop keeps the gate from it, so the last force stays: hardware must have a watchdog for this.
        recorded = self.recording(at_rest=False)
        self.assertLess(recorded.t[-1], 1.3)
        self.assertIn("device", self.results()["failure"])


@needs_live
class Process(FaultRun):
    def start_in_contact(self, *arguments):
        """A run with a force on its device."""
        shutil.rmtree(self.out, ignore_errors=True)
        process = self.start(duck(), *arguments)
        self.wait_until(lambda: (self.read_while_running()[1] > 0.2).any(), process, "the tool was in contact",
                        timeout=TIMEOUT)
        return process

    def test_a_signal_to_end_ramps_the_force_to_zero_and_is_no_failure(self):
        for name, signals in (("SIGINT", [signal.SIGINT]), ("SIGTERM", [signal.SIGTERM]), ("SIGHUP", [signal.SIGHUP]),
                              ("Ctrl-Z", [signal.SIGTSTP]), ("Ctrl-\\", [signal.SIGQUIT]),
                              ("twice", [signal.SIGINT, signal.SIGINT])):
            with self.subTest(name):
                process = self.start_in_contact("--duration", "1000")
                for number in signals:
                    process.send_signal(number)
                    time.sleep(0.12)
                self.assertEqual(self.finish(process, 0), "")
                recorded = self.recording()
                self.assert_ramped_down(recorded, NOT_PERMITTED)
                summary = self.results()
                self.assertTrue(summary["interrupted"])
                self.assertGreater(recorded.t[-1], summary["duration_s"] - PERIOD)

    def test_a_terminal_that_is_closed_ends_the_run_like_a_signal(self):
        master, terminal = pty.openpty()

        def own_the_terminal():
            os.setsid()
            fcntl.ioctl(0, termios.TIOCSCTTY, 0)

        process = subprocess.Popen([TACTOR, "run", self.write("fault.yaml", duck()), "--duration", "1000", "--out",
                                    self.out], stdin=terminal, stdout=terminal, stderr=terminal,
                                   preexec_fn=own_the_terminal, env=dict(os.environ, **self.environment))
        self.addCleanup(lambda: process.poll() is None and process.kill())
        os.close(terminal)
        seen = bytearray()

        def drained():
            while select.select([master], [], [], 0)[0]:
                seen.extend(os.read(master, 65536))
            return (self.read_while_running()[1] > 0.2).any()

        self.wait_until(drained, process, "the tool was in contact", timeout=TIMEOUT)
        os.close(master)
        # There is nowhere left to print the summary to, which is an error; the files are there.
        self.assertEqual(process.wait(timeout=TIMEOUT), 1)
        self.assertIn(b"wake-up p50", seen)
        self.assert_ramped_down(self.recording(), NOT_PERMITTED)
        self.assertTrue(self.results()["interrupted"])

    def test_a_process_that_was_stopped_goes_on_without_a_step_of_force(self):
        process = self.start_in_contact("--duration", "5")
        process.send_signal(signal.SIGSTOP)
        time.sleep(1)
        process.send_signal(signal.SIGCONT)
        self.finish(process, 0)
        recorded = self.recording()
        gap = numpy.argmax(numpy.diff(recorded.ns))
        self.assertGreater(recorded.ns[gap + 1] - recorded.ns[gap], 900_000_000)
        engaged = recorded.first(recorded.engagement == ENGAGED, after=recorded.t[gap + 1])
        self.assertGreater(recorded.norm[engaged:].max(), 0.2)
        summary = self.results()
        self.assertGreaterEqual(summary["device"]["missed"], 900)
        self.assertEqual(summary["duration_s"], 5)

    def test_a_killed_run_leaves_a_recording_up_to_a_second_before(self):
        process = self.start_in_contact("--duration", "1000")
        begin, mark = self.read_while_running()[0][-1], time.monotonic()
        self.wait_until(lambda: self.read_while_running()[0][-1] > begin + 1, process, "a second of recording")
        # What the disk lacks of the time that has passed.
        behind = time.monotonic() - mark - (self.read_while_running()[0][-1] - begin)
        process.kill()
        process.wait(timeout=TIMEOUT)
        self.assertLess(behind, 5.0)  # half a second where the machine keeps up
        for repaired in (False, True):
            if repaired:
                self.run_ok("repair", self.out / "recording.h5")
            recorded = self.recording(complete=False, at_rest=False, **({} if repaired else {"swmr": True}))
            self.assertGreater(recorded.t[-1], begin + 1)


def limit_files(size):
    """In the child: no file may grow beyond `size` bytes."""
    return lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


@needs_live
class FullDisk(FaultRun):
    def run_into_the_end_of_the_disk(self, code=1, **options):
        """A device that keeps a log elsewhere, because the recording ends before the ramp to zero."""
        log = self.folder / "forces.txt"
        stderr = self.run_fault(duck(DEVICE % f"at: 1000 s, log: {log}"), code, "--duration", "60", **options)
        self.assertIn(f"writing the recording {self.out / 'recording.h5'} failed", stderr)
        forces = numpy.loadtxt(log)
        self.assertTrue(numpy.isfinite(forces).all())
        norm = numpy.linalg.norm(forces[:, 1:], axis=1)
        self.assertGreater(norm.max(), 0.2)
        self.assertLessEqual(norm.max(), FORCE_MAX)
        change = numpy.linalg.norm(numpy.diff(forces[:, 1:], axis=0), axis=1)
        elapsed = numpy.minimum(numpy.diff(forces[:, 0]) * 1e-9, 2 * PERIOD)
        self.assertTrue((change <= FORCE_SLEW * elapsed * (1 + 1e-9)).all())
        self.assertEqual(norm[-1], 0.0)
        self.assertLess(forces[-1, 0] * 1e-9, 59.0, "the run went on without its recording")
        # Plainly readable, up to the last flush, half a second before where the machine keeps up.
        recorded = self.recording(complete=False, at_rest=False)
        self.assertGreater(recorded.t[-1], forces[-1, 0] * 1e-9 - 5.0)

    def test_a_file_that_may_not_grow_ends_the_run_with_its_path(self):
        self.run_into_the_end_of_the_disk(preexec_fn=limit_files(2_500_000))
        self.assertIn("recording.h5", self.results()["failure"])

    def test_a_disk_that_is_full_ends_the_run_with_the_path(self):
        self.out.mkdir()
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=2500k", "none", self.out], capture_output=True,
                                 check=False)
        if mounted.returncode != 0:
            self.skipTest("no file system may be mounted here")
        self.addCleanup(subprocess.run, ["umount", self.out], check=True)
        self.run_into_the_end_of_the_disk()


@needs_live
class Replay(FaultRun):
    def check_replay(self, live):
        """Every stream of the recording and of its replay, to the byte."""
        self.run_ok("replay", live, "--out", self.folder / "replay")
        with h5py.File(live) as a, h5py.File(self.folder / "replay/recording.h5") as b:
            self.assertEqual(sorted(a["streams"]), sorted(b["streams"]))
            for stream in a["streams"]:
                ran, again = (file["streams"][stream]["data"][...] for file in (a, b))
                self.assertEqual(ran.tobytes(), again.tobytes(), stream)
            self.assertGreater(len(a["streams/steps/data"]), 1000)
            self.assertEqual(len(a["streams/stop/data"]), 1)

    def test_a_replay_is_the_same_run_whatever_the_lane_of_the_device(self):
        for lane in ("realtime", "pool"):
            with self.subTest(lane=lane):
                graph = self.write("live.yaml", duck(f"nodes:\n  metrics: ~\n  device: {{lane: {lane}}}\n").replace(
                    "record: [", "record: [dynamics.state, prediction.forecast, interpolation.segment, "))
                self.run_graph(graph, "--duration", "2", out=f"live_{lane}")
                self.check_replay(self.folder / f"live_{lane}/recording.h5")
                shutil.rmtree(self.folder / "replay")

    def test_a_run_that_was_ended_early_is_replayed_up_to_there(self):
        process = self.start(duck(), "--duration", "1000")
        self.wait_until(lambda: self.read_while_running()[0].max(initial=0) > 1, process, "a second was run")
        process.send_signal(signal.SIGINT)
        self.finish(process, 0)
        self.check_replay(self.out / "recording.h5")

    def test_what_cannot_be_made_again_is_refused_with_the_reason(self):
        virtual = self.write("virtual.yaml", duck().replace("clock: real", "clock: virtual"))
        self.run_graph(virtual, "--duration", "0.1", "--set", "clock=virtual", out="virtual")
        graph = self.write("live.yaml", duck())
        self.run_graph(graph, "--duration", "0.2", out="live")
        recording = self.folder / "live/recording.h5"

        def change(name, make):
            path = self.folder / name
            shutil.copy(recording, path)
            with h5py.File(path, "r+") as file:
                make(file)
            return path

        def cut(file, stream, rows):
            kept = file[f"streams/{stream}/data"][...][rows]
            del file[f"streams/{stream}/data"]
            file.create_dataset(f"streams/{stream}/data", data=kept, maxshape=(None,), chunks=True)

        for path, reason in (
                (self.folder / "virtual/recording.h5", "comes from a run under the virtual clock"),
                (self.folder / "nowhere.h5", "there is no recording"),
                (graph, "is not an HDF5 file"),
                (change("torn.h5", lambda file: file.attrs.modify("complete", 0)), "its run ended without closing it"),
                (change("lost.h5", lambda file: cut(file, "steps", slice(100, None))), "some steps of node .* were lost"),
                (change("without.h5", lambda file: file["streams"].pop("steps")), "steps"),
        ):
            with self.subTest(path.name):
                result = tactor("replay", path, "--out", self.folder / "refused")
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertRegex(result.stderr, reason)
                self.assertFalse((self.folder / "refused/recording.h5").exists())


class VirtualClock(FaultRun):
    """Nothing moves here, but what there is must be left all the same."""

    def virtual(self, text):
        return text.replace("duration: 3 s", "duration: 3 s\nclock: virtual")

    def test_a_node_that_throws_leaves_the_results_up_to_there(self):
        stderr = self.run_fault(self.virtual(duck(THROWS)), 1)
        self.assertRegex(stderr, r"node culprit failed at 1\.2\d+ s: it broke on purpose")
        summary = self.results("virtual")
        self.assertIn("it broke on purpose", summary["failure"])
        self.assertAlmostEqual(summary["duration_s"], 1.2, delta=0.05)
        self.assertGreater(summary["cost_us"]["device"]["steps"], 1000)
        self.assertGreater(Recording(self.out / "recording.h5").t[-1], 1.15)

    def test_a_comparison_with_such_a_node_fails(self):
        graph = self.write("fault.yaml", self.virtual(duck(THROWS)))
        result = tactor("compare", graph, "--seeds", "1", "--judge", "whole", "--out", self.out, environment=self.environment)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr, "fault, seed 1: .*it broke on purpose")
        study = self.write("study.yaml", f"graphs: [{graph}]\nset: {{culprit.lasts: 1 s}}\n"
                                         "vary: {duration: [0.5 s, 1.5 s]}\nseeds: 1\nfirst_seed: 3\njudge: whole\n")
        result = tactor("study", study, "--out", self.folder / "study", environment=self.environment)
        self.assertEqual(result.returncode, 1, result.stderr)
        self.assertRegex(result.stderr, r"fault duration=1\.5 s, seed 3: .*it broke on purpose")

    def test_a_file_that_may_not_grow_leaves_the_results_up_to_there(self):
        stderr = self.run_fault(self.virtual(duck()), 1, preexec_fn=limit_files(600_000))
        self.assertIn(f"writing the recording {self.out / 'recording.h5'} failed", stderr)
        self.assertIn("recording.h5", self.results("virtual")["failure"])
        self.assertGreater(len(Recording(self.out / "recording.h5").t), 100)


@needs_live
class Privileges(FaultRun):
    def test_without_privileges_a_run_says_so_and_goes_on_where_the_graph_warns(self):
        self.run_fault(duck(live="on_missing_privilege: warn"), 0, "--duration", "1", preexec_fn=give_privileges_up)
        self.recording(in_contact=False)  # on a busy machine such a run may hardly get to tick
        missing = " ".join(self.results()["missing_privileges"])
        for text in (missing, self.stdout, (self.out / "report.html").read_text()):
            self.assertIn("SCHED_FIFO", text)
            self.assertIn("refused", text)
        self.assertIn("to fix it", missing)
        self.assertIn("real time degraded", self.stdout)

    def test_without_privileges_nothing_moves_where_the_graph_fails(self):
        stderr = self.run_fault(duck(live="on_missing_privilege: fail"), 1, preexec_fn=give_privileges_up)
        for text in ("fault.yaml", "on_missing_privilege is fail", "SCHED_FIFO", "refused", "to fix it"):
            self.assertIn(text, stderr)
        self.assertFalse((self.out / "summary.json").exists())


if __name__ == "__main__":
    unittest.main()
