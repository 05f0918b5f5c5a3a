"""Live runs with an emulated Modbus actuator, and what goes wrong on the way to it: the force stays within its limits, goes
down to zero, and the report names the device."""
import json
import os
import subprocess
import time
import unittest

from harness import GRAPHS, ROOT, TACTOR, check_loop, tactor
from modbus_harness import EASY, PATIENCE, ModbusHarness

try:
    import h5py
    import numpy
except ImportError:
    h5py = None

# Faults are over before the run gives up, but not before the gate has let go.
FAULTY = ("link_timeout: 0.3 s, stale_after: 2 s, sample_age_max: 4 s, failure_timeout: 20 s, recovery_time: 0.2 s, "
          "stuck_after: 0 s")
FAULT, READ_FAILED = 3, 3  # as recorded: an engagement and a cause


class ModbusRun(ModbusHarness):
    def fails_by(self, fault, says, more=EASY, **options):
        """The fault comes when the motor is being pushed, and ends the run with a message that names the device."""
        process = self.start(self.emulate("--fault", fault, **options), more=more)
        stderr = self.finish(process, 1)
        self.assertIn("orca at ", stderr)
        self.assertRegex(stderr, says)
        self.check_forces()
        self.assertGreater(max(abs(row.force_N) for row in self.log_rows()), 0, "the motor was never pushed")
        self.assertEqual(self.summary["failure"].count("orca at "), 1)

    def test_the_motor_is_pushed_and_shut_down_in_the_end(self):
        for line in (("--tcp", "0"), ("--pty", "--baud", "115200")):
            with self.subTest(line=line[0]):
                self.log.unlink(missing_ok=True)
                # A baud rate of its own, as on a motor that was set to it.
                more = EASY + (", baud: 115200" if line[0] == "--pty" else "")
                process = self.start(self.emulate(line=line), more=more)
                self.until_driven(process)
                self.end_early(process)
                self.check_forces()
                device = self.summary["device"]
                self.assertGreater(device["link"]["cycles"], 5)
                self.assertEqual(device["link"]["reconnects"], 0)
                self.assertGreater(device["link"]["age_us"]["p99"], 0)
                self.assertGreater(device["velocity_cutoff_Hz"], 1)
                check_loop(self, device)
                self.emulator.kill()

    def test_the_line_counts_what_the_motor_gave(self):
        """Physics is 50 ms away, so that a held force gives energy; with a bound on the line the motor gives no more than is allowed."""
        for line in (("--tcp", "0"), ("--pty",)):
            for bounds in (False, True):
                with self.subTest(line=line[0], bounds=bounds):
                    self.log.unlink(missing_ok=True)
                    graph = self.graph(self.emulate(line=line), EASY + f", energy_bound: {str(bounds).lower()}", duration="4 s")
                    self.run_ok("run", graph, "--over", GRAPHS / "passivity/delay_50ms.yaml", "--no-dead-man", "--overwrite", "--out", self.out)
                    self.emulator.kill()
                    counted = json.loads((self.out / "summary.json").read_text())["device"]["line"]
                    # By the steps of the motor itself.
                    given = max(row.given_J for row in self.log_rows())
                    self.assertLess(abs(counted["energy_generated_J"] - given), 0.05 * given + 1e-5)
                    (self.assertLessEqual if bounds else self.assertGreater)(given, counted["energy_allowed_J"])

    def test_a_silent_motor(self):
        self.fails_by("silent@driven+0.2", "could not be read|no whole answer")

    def test_a_motor_whose_answers_drip(self):
        self.fails_by("dribble@driven+0.2:0.3", "could not be read|no whole answer")

    def test_wrong_check_sums(self):
        self.fails_by("crc@driven+0.2", "wrong check sum|could not be read", line=("--pty", "--no-line-delay"))

    def test_exceptions(self):
        self.fails_by("exception@driven+0.2", "exception 4")

    def test_another_device(self):
        self.fails_by("another@driven+0.2", "another device answers: expected major_version")

    def test_a_position_that_has_jumped_is_not_believed_again(self):
        self.fails_by("jump@driven+0.2:0.1", "the encoder of axis 1 jumped from")
        self.assertEqual(self.summary["device"]["jumps"], 1)

    def test_an_encoder_that_stands_still_under_a_force(self):
        # A fifth of the motor's 20 N is more than this wall gives, so what counts as driven is set by a weaker motor.
        # Its hand stays on the wall, with a force of about 1.5 N, and trembles by a millimetre.
        text = self.profile.read_text().replace("effort_max: 20 N", "effort_max: 2 N")
        self.profile.write_text(text.replace("rest: 50 mm, swing: 30 mm, swing_rate: 0.4 Hz",
                                             "rest: 40 mm, swing: 1 mm, swing_rate: 1 Hz"))
        self.fails_by("stuck@driven+0.6", "it is stuck", more=EASY.replace("stuck_after: 3 s", "stuck_after: 0.3 s"))

    def test_a_fault_of_the_motor(self):
        self.fails_by("status@driven+0.2:6", "the device reports: bit 6 of errors")
        self.assertGreater(self.summary["device"]["link"]["errors"]["device_fault"], 0)

    def test_a_reset_is_survived_and_counted(self):
        process = self.start(self.emulate())
        self.until_driven(process)
        self.emulator.stdin.write("fault reset\n")
        self.emulator.stdin.flush()
        self.assertEqual(self.emulator.stdout.readline(), "injected reset\n")
        # What is commanded half a second from now on came over a new connection.
        self.until_driven(process, after=time.monotonic_ns() + 5e8)
        self.end_early(process)
        self.check_forces()
        self.assertGreaterEqual(self.summary["device"]["link"]["reconnects"], 1)
        self.assertGreaterEqual(self.summary["device"]["link"]["errors"]["reset"], 1)
        self.assertTrue(any("orca at tcp:127.0.0.1" in remark for remark in self.summary["remarks"]), self.summary)

    def kill_while_driven(self, profile, more=EASY):
        """Whether the run was killed while the motor had a force; on a busy machine a short watchdog may run out before."""
        self.log.unlink(missing_ok=True)
        process = self.start(self.emulate(profile=profile), profile=profile, more=more + ", guard: off")
        end = time.monotonic() + PATIENCE
        pushed = False
        while not pushed and process.poll() is None and time.monotonic() < end:
            time.sleep(0.02)
            rows = self.log_rows()
            pushed = len(rows) > 25 and all(row.force_N != 0 for row in rows[-25:])
        process.kill()
        process.communicate()
        while pushed and not self.log_rows()[-1].expired:
            self.assertLess(time.monotonic(), end + PATIENCE, "the watchdog does not run out")
            time.sleep(0.05)
        self.emulator.kill()
        self.emulator.communicate()
        rows = self.log_rows()
        return pushed and any(row.force_N != 0 for row in rows if row.commands == rows[-1].commands)

    def check_watchdog(self, time_s):
        """By the motor's own clock: the force lasts as long as its watchdog says after the last command, and not longer."""
        step = 0.5e-3  # s, of the emulated motor
        rows = self.log_rows()
        last = max(row.commands for row in rows)
        after = [row for row in rows if row.commands == last]
        before = [row for row in rows if row.commands < last][-1]
        # The last command came between these two rows.
        driven = [row for row in after if row.force_N != 0]
        dead = [row for row in after if row.force_N == 0]
        self.assertTrue(driven and dead)
        self.assertLessEqual((driven[-1].time_ns - after[0].time_ns) * 1e-9, time_s + step)
        self.assertGreaterEqual((dead[0].time_ns - before.time_ns) * 1e-9, time_s)
        self.assertTrue(all(row.force_N == 0 for row in after if row.time_ns >= dead[0].time_ns))
        self.assertTrue(all(row.expired for row in dead))
        # The registers still hold the force: nobody but the watchdog has taken it away.
        self.assertNotEqual(after[-1].commanded_N, 0)

    def test_when_the_program_is_killed_the_motors_own_watchdog_lets_go(self):
        profile = self.write("orca_quick.yaml", self.pressing().read_text().replace("time: 60 s", "time: 1 s"))
        self.assertTrue(any(self.kill_while_driven(profile) for _ in range(5)), "never killed while the motor was pushed")
        self.check_watchdog(1.0)

    def test_when_the_program_is_killed_the_motor_lets_go_within_its_shipped_time(self):
        text = self.pressing().read_text().replace("time: 60 s", "time: 150 ms")
        shipped = (ROOT / "devices/modbus/profiles/iris_orca.yaml").read_text()
        self.assertIn("watchdog: {register: comms_timeout, time: 150 ms}", shipped)
        self.assertIn("watchdog: {register: comms_timeout, time: 150 ms}", text)
        profile = self.write("orca_shipped.yaml", text)
        self.assertTrue(any(self.kill_while_driven(profile) for _ in range(20)), "never killed while the motor was pushed")
        self.check_watchdog(0.15)

    def pressing(self):
        """A motor whose hand stays on the wall, with a force of about 1.5 N, and which waits long for commands."""
        text = self.profile.read_text().replace("rest: 50 mm, swing: 30 mm, swing_rate: 0.4 Hz",
                                                "rest: 40 mm, swing: 1 mm, swing_rate: 1 Hz").replace("time: 3 s", "time: 60 s")
        self.assertIn("rest: 40 mm, swing: 1 mm", text)
        return self.write("orca.yaml", text.replace("response_timeout: 400 ms", "response_timeout: 200 ms"))

    def tell(self, line, answer):
        self.emulator.stdin.write(line + "\n")
        self.emulator.stdin.flush()
        self.assertEqual(self.emulator.stdout.readline(), answer + "\n")

    def faults_one_after_another(self, line, faults, more=""):
        """Each fault lasts for a second of the motor's clock, and the next one comes when the motor is driven again."""
        process = self.start(self.emulate(line=line), more=FAULTY + more, profile=self.pressing())
        self.until_driven(process)
        for fault in faults:
            began = time.monotonic_ns()
            self.tell("fault " + fault, "injected " + fault)
            self.wait_until(lambda: self.log_rows()[-1].time_ns > began + 1e9, process, "a second was over", timeout=PATIENCE)
            self.tell("clear", "cleared")
            self.until_driven_again(process, began)
        return process

    def until_driven_again(self, process, began):
        """Waits until the motor has had no force at some time after `began` (ns), and then one for a while."""
        def again():
            rows = [row for row in self.log_rows() if row.time_ns > began]
            first = next((i for i, row in enumerate(rows) if row.force_N == 0), len(rows))
            return any(all(row.force_N != 0 for row in rows[i:i + 25]) for i in range(first, len(rows) - 25))
        self.wait_until(again, process, "the force was taken away and came back", timeout=PATIENCE)

    def check_faults(self, counted, output, least):
        """The gate let go for want of samples at least so often, and what is told says what was wrong with which device."""
        with h5py.File(self.out / "recording.h5") as file:
            safety = file["streams/device.safety/data"][...]
            force = file["streams/device.commanded/data"][...]["force"]
        faulty = (safety["engagement"] == FAULT) & (safety["cause"] == READ_FAILED)
        began = numpy.flatnonzero(faulty[1:] & ~faulty[:-1]) + 1
        self.assertGreaterEqual(len(began), least)
        for first in began:
            until = first + numpy.flatnonzero(~numpy.append(faulty[first:], False))[0]
            if until <= min(len(faulty), len(force)) - 1:
                # It comes back by its ramp, from zero.
                self.assertEqual(numpy.abs(force[until - 5]).max(), 0)
        errors = self.summary["device"]["link"]["errors"]
        for kind in counted:
            self.assertGreater(errors.get(kind, 0), 0, errors)
        self.assertTrue(any("orca at " in remark for remark in self.summary["remarks"]), self.summary["remarks"])
        self.assertIn("orca at ", output)

    def test_faults_over_tcp_take_the_force_away_and_it_comes_back(self):
        process = self.faults_one_after_another(("--tcp", "0"), ("slow:0.5", "late:1.2", "slave", "exception"))
        stderr = self.end_early(process)
        self.check_forces()
        self.check_faults(("timeout", "protocol", "exception"), self.stdout + stderr, least=4)

    def test_faults_on_a_serial_line_take_the_force_away_and_it_comes_back(self):
        process = self.faults_one_after_another(
            ("--pty", "--no-line-delay"), ("slow:0.5", "late:1.2", "slave", "crc", "exception"), ", baud: 115200")
        stderr = self.end_early(process)
        self.check_forces()
        self.check_faults(("timeout", "protocol", "crc", "exception"), self.stdout + stderr, least=5)

    def test_a_serial_adapter_that_is_pulled(self):
        process = self.start(self.emulate("--fault", "unplug@driven+0.2", line=("--pty", "--no-line-delay")))
        stderr = self.finish(process, 1)
        self.assertRegex(stderr, r"orca at rtu:/dev/pts/\d+, unit 1")
        # Nobody can tell the motor any more; its own watchdog is what takes the force away.
        end = time.monotonic() + PATIENCE
        while not self.log_rows()[-1].expired:
            self.assertLess(time.monotonic(), end, "the watchdog does not run out")
            time.sleep(0.05)
        self.check_forces()
        self.assertGreater(max(abs(row.force_N) for row in self.log_rows()), 0, "the motor was never pushed")
        errors = self.summary["device"]["link"]["errors"]
        self.assertGreater(errors.get("reset", 0) + errors.get("disconnected", 0), 0, errors)

    def test_a_serial_adapter_that_is_plugged_in_again_is_used_again(self):
        link = self.folder / "adapter"
        process = self.start(self.emulate(line=("--pty", "--no-line-delay", "--link", link)), profile=self.pressing(),
                             more=FAULTY + ", baud: 115200")
        self.until_driven(process)
        self.tell("fault unplug", "injected unplug")
        self.wait_until(lambda: not os.path.lexists(link), process, "the adapter was pulled", timeout=PATIENCE)
        pulled = time.monotonic_ns()
        self.tell("clear", "cleared")
        self.until_driven_again(process, pulled)
        self.end_early(process)
        self.check_forces()
        self.assertGreaterEqual(self.summary["device"]["link"]["reconnects"], 1)
        self.assertTrue(any(f"orca at rtu:{link}" in remark for remark in self.summary["remarks"]), self.summary["remarks"])

    def test_nobody_at_the_address(self):
        process = self.start("tcp:127.0.0.1:9", more="connect_timeout: 0.3 s, failure_timeout: 0.3 s")
        stdout, stderr = process.communicate(timeout=PATIENCE)
        self.assertEqual((process.returncode, stdout), (1, ""))
        self.assertIn("orca at tcp:127.0.0.1:9, unit 1: no connection", stderr)

    def test_bad_requests_are_refused_before_anything_moves(self):
        def refused(text, more="", connect="rtu:/dev/null", profile=None):
            graph = self.graph(connect, more or EASY, profile, name="bad.yaml")
            for verb in ("check", "run"):
                result = tactor(verb, graph, environment=self.environment, cwd=self.folder)
                self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
                self.assertRegex(result.stderr, text)
        refused(r"bad.yaml:\d+:\d+: node device: link_rate: expected what the line of orca can carry, at most \d+\.\d+ Hz; "
                r"a cycle takes .* ms at 19200 baud .*, found 900 Hz", more=EASY + ", link_rate: 900 Hz")
        quick = self.write("quick.yaml", self.profile.read_text().replace("time: 3 s", "time: 60 ms"))
        refused(r"quick.yaml:\d+:\d+: the watchdog of quick: expected a time of at least two cycles of the line, "
                r"67\.\d+ ms at 29\.\d+ Hz, found 60 ms, .* the line carries at most 31\.\d+ Hz \(a cycle takes .* at 19200 baud",
                profile=quick)
        refused("node device: connect: expected tcp:HOST:PORT or rtu:PATH", connect="udp:1")
        broken = self.write("broken.yaml", self.profile.read_text().replace("address: 342, type", "address: 70000, type"))
        refused(r"broken.yaml:\d+:\d+: registers.position.address: expected a whole number", profile=broken)
        graph = self.graph("tcp:a:1")
        result = tactor("check", self.write("virtual.yaml", graph.read_text().replace("clock: real", "clock: virtual")), environment=self.environment)
        self.assertEqual(result.returncode, 2)
        self.assertIn("expected clock: real, because modbus.actuator drives hardware", result.stderr)

    def test_a_motor_without_a_watchdog_is_told_by_check_and_run(self):
        profile = self.write("forgetful.yaml", (ROOT / "devices/modbus/profiles/oriental_az.yaml").read_text())
        warning = "tactor: forgetful: its profile names no watchdog: if its guard (tactor-guard, not this program) is killed"
        graph = self.graph("tcp:127.0.0.1:9", "connect_timeout: 0.3 s, failure_timeout: 0.3 s", profile)
        check = self.run_ok("check", graph)
        self.assertEqual(check.stderr.count(warning), 1, check.stderr)
        self.assertIn("an emergency stop", check.stderr)
        run = tactor("run", graph, "--no-dead-man", "--overwrite", "--out", self.out, environment=self.environment)
        self.assertEqual(run.stderr.count(warning), 1, run.stderr)
        # The other motor has one, and nothing is said.
        self.assertNotIn("watchdog", self.run_ok("check", self.graph("tcp:127.0.0.1:9")).stderr)

    def test_the_shipped_graph_runs_against_its_emulator(self):
        connect = self.emulate()
        process = subprocess.Popen([TACTOR, "run", GRAPHS / "bunny/orca.yaml", "--no-dead-man", "--overwrite", "--out", self.out, "--duration", "120",
                                    "--set", f"device.profile={self.profile}", "--set", f"device.connect={connect}",
                                    "--set", "device.link_timeout=2s", "--set", "device.stale_after=2s",
                                    "--set", "device.sample_age_max=4s"],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                   env=dict(os.environ, **self.environment))
        self.addCleanup(lambda: process.poll() is None and process.kill())
        self.until_driven(process)
        self.end_early(process)
        self.check_forces()


if __name__ == "__main__":
    unittest.main()
