"""One owner a device, devices that are not there, and the question before a force: what a user is told and when."""
import json
import os
import pathlib
import pty
import re
import signal
import subprocess
import time
import unittest

from harness import IS_SANITIZED, PATIENCE, ROOT, TACTOR, CommandTest, Terminal, give_privileges_up, motor_log, needs_live, tactor, without_privileges

EMULATOR = pathlib.Path(TACTOR).resolve().parent / "tactor-emulate-modbus"
GRAPH = """clock: real
duration: %s
live: {on_missing_privilege: warn, on_stall: recover}
scene: {bodies: {}}
nodes:
  device: {type: modbus.actuator, profile: %s, connect: "%s", link_timeout: 2 s, stale_after: 2 s, stuck_after: 0}
record: [device.state]
"""


@needs_live
@unittest.skipUnless(EMULATOR.exists(), "this build has no Modbus")
class Devices(CommandTest):
    def setUp(self):
        super().setUp()
        text = (ROOT / "devices/modbus/profiles/iris_orca.yaml").read_text()
        text = text.replace("response_timeout: 25 ms", "response_timeout: 400 ms").replace("time: 150 ms", "time: 5 s")
        self.profile = self.write("orca.yaml", text)
        self.log = self.folder / "emulator.log"

    def graph(self, address, name="device.yaml", duration="60 s"):
        return self.write(name, GRAPH % (duration, self.profile, address))

    def start(self, graph, out):
        process = subprocess.Popen([TACTOR, "run", graph, "--no-dead-man", "--out", self.folder / out], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, env=dict(os.environ, **self.environment))
        self.addCleanup(lambda: process.poll() is None and process.kill())
        return process

    def until_commanded(self, process):
        """Waits until the motor has been given commands for a while."""
        def commanded():
            rows = motor_log(self.log)
            return bool(rows) and rows[-1].commands > 20
        self.wait_until(commanded, process, "the motor was given commands", timeout=PATIENCE)

    def second_is_refused(self, line, other_name):
        _, address = self.emulate_modbus(self.profile, *line, "--log", self.log)
        first = self.start(self.graph(address, "first.yaml"), "first")
        self.until_commanded(first)
        second = tactor("run", self.graph(other_name(address), "second.yaml"), "--no-dead-man", "--out", self.folder / "second",
                        environment=self.environment)
        self.assertEqual(second.returncode, 1, second.stdout + second.stderr)
        self.assertEqual(second.stdout, "")
        # One line, which says who has it.
        self.assertRegex(without_privileges(second.stderr), rf"\Atactor: node device failed at 0.000000 s: cannot be reached: .*in use by process {first.pid} "
                                        rf"\({re.escape(TACTOR)} run .*first.yaml.*\).*\n\Z")
        # The first one has not noticed.
        first.send_signal(signal.SIGINT)
        _, stderr = first.communicate(timeout=PATIENCE)
        self.assertEqual(first.returncode, 0, stderr)
        errors = json.loads((self.folder / "first/summary.json").read_text())["device"]["link"]
        self.assertEqual(errors["reconnects"], 0)
        self.assertFalse(any(errors.get("errors", {}).values()), errors)
        return address

    def test_the_second_run_at_an_address_is_told_who_has_it(self):
        self.second_is_refused(("--tcp", "0"), lambda address: address.replace("127.0.0.1", "0.0.0.0"))

    def test_the_second_run_on_a_serial_line_is_told_who_has_it(self):
        link = self.folder / "adapter"
        self.second_is_refused(("--pty", "--no-line-delay", "--link", link),
                               lambda address: "rtu:" + str(link.resolve()))

    def test_a_run_that_was_killed_leaves_the_device_to_the_next(self):
        for line in (("--tcp", "0"), ("--pty", "--no-line-delay")):
            with self.subTest(line=line[0]):
                self.log.unlink(missing_ok=True)
                _, address = self.emulate_modbus(self.profile, *line, "--log", self.log)
                first = self.start(self.graph(address), "first" + line[0])
                self.until_commanded(first)
                first.kill()
                first.communicate()
                self.run_ok("run", self.graph(address, duration="0.3 s"), "--no-dead-man", "--out", self.folder / ("second" + line[0]))

    def test_a_device_that_is_not_there_is_told_in_one_line_within_two_seconds(self):
        for connect, why in (("tcp:127.0.0.1:9", "no connection: Connection refused"),
                             ("tcp:no.such.host.invalid:502", "the host no.such.host.invalid cannot be found; check its name and the network"),
                             ("rtu:/dev/ttyUSB99", "no connection: No such file or directory")):
            with self.subTest(connect=connect):
                began = time.monotonic()
                out = self.folder / ("out_" + connect[4:9].replace("/", "_"))
                result = tactor("run", self.graph(connect), "--no-dead-man", "--out", out, environment=self.environment)
                took = time.monotonic() - began
                self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
                self.assertEqual(result.stdout, "")
                self.assertEqual(without_privileges(result.stderr), f"tactor: node device failed at 0.000000 s: cannot be reached: orca at {connect}, unit 1: {why}\n")
                self.assertEqual([path.name for path in out.iterdir()], [".tactor.lock"])
                if not IS_SANITIZED:
                    self.assertLess(took, 2)

    def test_a_port_on_which_nobody_answers_is_told_in_one_line(self):
        master, slave = pty.openpty()
        self.addCleanup(os.close, master)
        self.addCleanup(os.close, slave)
        result = tactor("run", self.graph("rtu:" + os.ttyname(slave)), "--no-dead-man", "--out", self.folder / "out", environment=self.environment)
        self.assertEqual(result.returncode, 1, result.stdout + result.stderr)
        self.assertRegex(without_privileges(result.stderr), r"\Atactor: node device failed at 0.000000 s: cannot be reached: .* no whole answer within 400 ms .*\n\Z")

    def test_a_run_without_a_dead_man_button_is_refused_where_nobody_can_be_asked(self):
        graph = self.graph("tcp:127.0.0.1:9")
        line = next(n for n, text in enumerate(graph.read_text().splitlines(), 1) if text.startswith("  device:"))
        result = tactor("run", graph, "--out", self.folder / "out", environment=self.environment)
        self.assertEqual((result.returncode, result.stdout), (2, ""), result.stderr)
        self.assertRegex(result.stderr, rf"\A{graph}:{line}:3: nodes\.device: expected a dead-man button, because modbus\.actuator "
                                        r"drives hardware, found none: .*--no-dead-man.*dead_man_button: 0\n\Z")
        # A graph that says so itself goes on, up to the motor that is not there.
        for more in ((), ("--set", "device.dead_man_button=0")):
            result = tactor("run", graph, *(more or ("--no-dead-man",)), "--out", self.folder / "out", environment=self.environment)
            self.assertEqual(result.returncode, 1, result.stderr)
            self.assertIn("cannot be reached", result.stderr)

    def test_a_person_at_the_terminal_is_asked_once_before_a_run_without_a_dead_man_button(self):
        for answer, code, says in (("n", 2, "expected a dead-man button"), ("y", 1, "cannot be reached")):
            with self.subTest(answer=answer):
                terminal = Terminal("run", self.graph("tcp:127.0.0.1:9"), "--out", self.folder / answer)
                terminal.expect("No button stops the force of device (modbus.actuator) when you let go. Run all the same? [y/N] ")
                self.assertNotIn("cannot be reached", terminal.text)
                terminal.type(answer + "\n")
                self.assertEqual(terminal.finish(), code, terminal.text)
                self.assertIn(says, terminal.text)
                self.assertEqual(terminal.text.count("[y/N]"), 1)

    def test_what_the_system_refuses_is_said_in_a_line_at_the_start(self):
        _, address = self.emulate_modbus(self.profile, "--tcp", "0")
        graph = self.graph(address, duration="0.3 s")
        result = subprocess.run([TACTOR, "run", graph, "--no-dead-man", "--out", self.folder / "out"], capture_output=True, text=True,
                                env=dict(os.environ, **self.environment), timeout=PATIENCE, check=False, preexec_fn=give_privileges_up)
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = [line for line in result.stderr.splitlines() if line.startswith("tactor: the system refuses real-time privileges (")]
        self.assertEqual(len(lines), 1, result.stderr)
        self.assertRegex(lines[0], r"SCHED_FIFO.*: while other programs work, ticks come late by milliseconds; .*docs/howto/real_time\.md$")
        self.assertIn("real time degraded", result.stdout)

    def trial(self):
        _, address = self.emulate_modbus(self.profile, "--tcp", "0", "--log", self.log)
        return Terminal("device", "test", self.graph(address), "--seconds", "0.5")

    def pushed(self):
        return max(abs(row.commanded_N) for row in motor_log(self.log))

    def test_ctrl_c_at_the_question_gives_no_force(self):
        terminal = self.trial()
        terminal.expect("[y/N] ")
        terminal.type("\x03")
        code = terminal.finish()
        self.assertEqual(code, 0, terminal.text)
        self.assertIn("no force was given", terminal.text)
        self.assertNotIn("no position", terminal.text)
        self.assertEqual(self.pushed(), 0)

    def test_a_line_that_was_typed_before_the_question_is_no_answer_to_it(self):
        terminal = self.trial()
        terminal.expect("its position, without a force")
        terminal.type("y\n")
        terminal.expect("[y/N] ")
        terminal.type("n\n")
        code = terminal.finish()
        self.assertEqual(code, 0, terminal.text)
        self.assertIn("no force was given", terminal.text)
        self.assertEqual(self.pushed(), 0)

    def test_ctrl_c_while_the_device_is_watched_asks_nothing(self):
        terminal = self.trial()
        terminal.expect("position")
        terminal.type("\x03")
        code = terminal.finish()
        self.assertEqual(code, 0, terminal.text)
        self.assertNotIn("[y/N]", terminal.text)
        self.assertNotIn("no position", terminal.text)
        self.assertEqual(self.pushed(), 0)


@unittest.skipUnless(EMULATOR.exists(), "this build has no Modbus")
class Profiles(CommandTest):
    def test_a_profile_that_does_not_exist_lists_those_that_do(self):
        result = tactor("emulate", "modbus", "iris_ocra", "--tcp", "0")
        self.assertEqual(result.returncode, 2)
        self.assertRegex(result.stderr, r'^iris_ocra: expected a profile that exists; looked for .*/modbus/iris_ocra\.yaml.* holds '
                                        r'.*iris_orca\.yaml, .*robotiq_2f.*; did you mean "iris_orca\.yaml"\?')
        graph = self.write("graph.yaml", GRAPH % ("1 s", "modbus/iris_ocra.yaml", "tcp:127.0.0.1:9"))
        result = tactor("check", graph)
        self.assertEqual(result.returncode, 2)
        self.assertRegex(result.stderr, rf"^{graph}:\d+:\d+: nodes\.device\.profile: expected a profile that exists, found modbus/iris_ocra\.yaml")
        self.assertIn('did you mean "iris_orca.yaml"?', result.stderr)
        self.assertIn("robotiq_2f.yaml", result.stderr)

    def test_what_is_wrong_with_a_profile_is_told_at_its_own_line(self):
        text = (ROOT / "devices/modbus/profiles/iris_orca.yaml").read_text()
        line = text[:text.index("fence: {")].count("\n") + 1
        profile = self.write("orca.yaml", text.replace("fence: {address: 342, count: 3}", "fence: {address: 342, count: 2}"))
        result = tactor("check", self.write("graph.yaml", GRAPH % ("1 s", profile, "tcp:127.0.0.1:9")))
        self.assertEqual(result.returncode, 2)
        self.assertRegex(result.stderr, rf"\A{profile}:{line}:\d+: fence: expected ")
        line = text[:text.index("watchdog: {register")].count("\n") + 1
        profile = self.write("quick.yaml", text.replace("time: 150 ms", "time: 60 ms"))
        result = tactor("check", self.write("graph.yaml", GRAPH % ("1 s", profile, "rtu:/dev/null")))
        self.assertEqual(result.returncode, 2)
        self.assertRegex(result.stderr, rf"\A{profile}:{line}:\d+: the watchdog of quick: expected ")


if __name__ == "__main__":
    unittest.main()
