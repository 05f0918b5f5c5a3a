"""Nodes in Python beside a device: what the user is told, what becomes of a node that would end the process, and what a child
that a node forks has of the device."""
import json
import os
import re
import signal
import subprocess
import textwrap
import unittest

from harness import LEFT_TO_THE_COMMAND, PRESSED_WALL, TACTOR, tactor
from modbus_harness import EASY, PATIENCE, ModbusHarness

NODE = """
import multiprocessing, os, signal, subprocess, sys, threading, time
import tactor


class Watch(tactor.Node):
    \"\"\"Looks at the device, and does something once it has been pushed for a while.\"\"\"
    device = tactor.Input("DeviceState", trigger=True, doc="the handle")
    begun = None

    def step(self, step):
        if self.begun is None:
            self.begun = step.now
        if step.now - self.begun < 1.0 or self.begun < 0:
            return
        self.begun = -1
        self.act(step)

    def act(self, step):
%s
"""
WARNING = r"run\.yaml:\d+:\d+: node watch is in Python and runs in the process that drives device: if its code crashes"


class PythonBesideHardware(ModbusHarness):
    # The interpreter keeps its objects to the end of the process.
    sanitizer_options = (*LEFT_TO_THE_COMMAND, "detect_leaks=0")

    def watched(self, connect, act, duration="60 s", guard="auto"):
        self.write("watch.py", NODE % textwrap.indent(textwrap.dedent(act), " " * 8))
        text = PRESSED_WALL % {"device": f'type: modbus.actuator, profile: {self.profile}, connect: "{connect}", '
                                         f'origin: [0, 0, -50 mm], guard: {guard}, {EASY}', "height": "2 mm", "duration": duration}
        self.assertEqual(text.count("edges:\n"), 1, text)
        return self.write("run.yaml", text.replace("edges:\n", "  watch: {python: \"watch.py:Watch\"}\nedges:\n"
                                                               "  - device.state -> watch.device\n"))

    def run_watched(self, act, line=("--tcp", "0"), duration="60 s", guard="auto"):
        """The process of a run whose node does this after a second."""
        self.log.unlink(missing_ok=True)
        self.new_results()
        graph = self.watched(self.emulate(line=line), act, duration, guard)
        process = subprocess.Popen([TACTOR, "run", graph, "--no-dead-man", "--overwrite", "--out", self.out], stdin=subprocess.DEVNULL,
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
                                   env=dict(os.environ, **self.environment))
        self.addCleanup(lambda: process.poll() is None and process.kill())
        return process

    def test_check_and_run_warn_where_a_node_in_python_stands_beside_hardware(self):
        graph = self.watched("tcp:127.0.0.1:9", "pass")
        checked = self.run_ok("check", graph)
        self.assertEqual(len(re.findall(WARNING, checked.stderr)), 1, checked.stderr)
        self.assertIn("docs/trust/safety.md", checked.stderr)
        run = tactor("run", graph, "--no-dead-man", "--overwrite", "--out", self.out, "--set", "device.connect_timeout=0.3s",
                     environment=self.environment)
        self.assertEqual(len(re.findall(WARNING, run.stderr)), 1, run.stderr)
        # Neither without such a node, nor beside a device that is computed.
        self.assertNotIn("in Python", self.run_ok("check", self.graph("tcp:127.0.0.1:9")).stderr)
        simulated = self.write("simulated.yaml", textwrap.dedent("""\
            format: 2
            clock: real
            duration: 1 s
            scene: {bodies: {}}
            nodes:
              hand: {type: source.trajectory, points: [{t: 0 s}, {t: 1 s}]}
              device: {type: device.simulated}
              watch: {python: "watch.py:Watch"}
            edges: [hand.target -> device.target, device.state -> watch.device]
            record: [device.state]
            """))
        self.assertNotIn("in Python", self.run_ok("check", simulated).stderr)

    def test_what_would_end_the_process_is_the_failure_of_the_node(self):
        members = {
            "os._exit(0)": ("os._exit(0)", "SystemExit: os._exit in the code of a node"),
            "os._exit(3) under another name": ("import posix; posix._exit(3)", "os._exit in the code of a node"),
            "a swallowed os._exit": ("\ntry:\n    os._exit(0)\nexcept BaseException:\n    pass",
                                     "os._exit in the code of a node"),
            "os.abort": ("os.abort()", "SystemExit: os.abort in the code of a node"),
            "os.execv": ("os.execv('/bin/true', ['true'])", "SystemExit: os.execv in the code of a node"),
            "os.execlp": ("os.execlp('true', 'true')", "in the code of a node"),
            "sys.exit": ("sys.exit(0)", "SystemExit: 0"),
            "exit": ("raise SystemExit", "SystemExit"),
            "KeyboardInterrupt": ("raise KeyboardInterrupt", "KeyboardInterrupt"),
            "an exception": ("1 / 0", "ZeroDivisionError"),
            "a thread of the node": ("t = threading.Thread(target=os._exit, args=(0,)); t.start(); t.join()",
                                     "os._exit in the code of a node"),
            "endless recursion": ("f = lambda: f(); f()", "RecursionError"),
        }
        for name, (act, says) in members.items():
            with self.subTest(name):
                stderr = self.finish(self.run_watched(act), 1)
                self.assertIn("node watch failed at", stderr)
                self.assertIn(says, stderr)
                self.assertIn("node watch failed", self.summary["failure"])
                self.check_forces()
                self.assertGreater(max(abs(row.force_N) for row in self.log_rows()), 0, "the motor was never pushed")
                self.emulator.kill()

    def test_a_signal_that_a_node_sends_to_its_process_ramps_down_like_any(self):
        for name in ("SIGTERM", "SIGUSR1", "SIGABRT", "SIGSEGV"):
            with self.subTest(name):
                self.finish(self.run_watched(f"os.kill(os.getpid(), signal.{name})"), 0)
                self.assertTrue(self.summary["interrupted"])
                self.check_forces()
                self.emulator.kill()

    def test_what_nothing_can_catch_ends_the_process_and_the_motor_lets_go_by_itself(self):
        """As docs/trust/safety.md says: nothing commands zero, and the watchdog of the motor does it."""
        self.shorten_watchdog()
        for act, code in (("import ctypes; ctypes.string_at(0)", -signal.SIGSEGV),
                          ("import ctypes; ctypes.CDLL(None)._exit(0)", 0),
                          ("os.kill(os.getpid(), signal.SIGKILL)", -signal.SIGKILL)):
            with self.subTest(act):
                process = self.run_watched(act)
                process.communicate(timeout=PATIENCE)
                self.assertEqual(process.returncode, code)
                self.until_let_go()
                self.emulator.kill()

    def shorten_watchdog(self):
        self.profile.write_text(self.profile.read_text().replace("time: 3 s", "time: 1 s"))

    def until_let_go(self):
        self.wait_until(lambda: self.log_rows()[-1].expired, self.emulator, "the watchdog ran out", timeout=PATIENCE)
        self.assertEqual(self.log_rows()[-1].force_N, 0)

    def children_have(self, make_child, line, guard):
        """What a child that the node makes so has of the device: the parent is killed, and the child lives on."""
        act = f"""
            import json
            file = {str(self.folder / "told")!r}
            def fds():
                found = {{}}
                for n in os.listdir("/proc/self/fd"):
                    try:
                        found[n] = os.readlink("/proc/self/fd/" + n)
                    except OSError:
                        pass
                return found
            def child():
                with open(file + ".new", "w") as out:
                    json.dump([os.getpid(), fds()], out)
                os.rename(file + ".new", file)
                time.sleep(600)
            with open({str(self.folder / "parent")!r}, "w") as out:
                json.dump([os.getpid(), fds()], out)
            {make_child}
            """
        told = self.folder / "told"
        told.unlink(missing_ok=True)
        process = self.run_watched(act, line=line, guard=guard)
        self.wait_until(told.exists, process, "the child told", timeout=PATIENCE)
        pid, has = json.loads(told.read_text())
        self.addCleanup(lambda: os.path.exists(f"/proc/{pid}") and os.kill(pid, signal.SIGKILL))
        _, parent = json.loads((self.folder / "parent").read_text())
        return process, pid, parent, has

    def test_a_child_of_a_node_has_nothing_of_the_device_and_the_motor_sees_the_end_of_its_parent(self):
        makers = {"os.fork": "pid = os.fork()\n            if pid == 0: child()",
                  "multiprocessing": "multiprocessing.get_context('fork').Process(target=child, daemon=True).start()",
                  "ctypes fork": "import ctypes\n            pid = ctypes.PyDLL(None).fork()\n            if pid == 0: child()"}
        self.shorten_watchdog()
        for line, guard in ((("--tcp", "0"), "off"), (("--pty", "--no-line-delay"), "off"), (("--tcp", "0"), "on")):
            # The guard has the line of its own program, whoever makes children of the engine.
            for name, maker in list(makers.items())[:1 if guard == "on" else None]:
                with self.subTest(line=line[0], guard=guard, maker=name):
                    process, child, parent, has = self.children_have(maker, line, guard)
                    shown = lambda fds: {to for to in fds.values() if to.startswith(("socket:", "/dev/pts", "/dev/bus"))}
                    self.assertEqual(bool(shown(parent)), guard == "off", "the parent has a line where no guard has it")
                    self.assertEqual(shown(has), set())
                    # The run goes on, and the motor sees its end although the child lives.
                    before = len(self.log_rows())
                    self.wait_until(lambda: len(self.log_rows()) > before + 20, process, "the run went on", timeout=PATIENCE)
                    connections = connections_of(self.emulator.pid)
                    process.kill()
                    os.waitid(os.P_PID, process.pid, os.WEXITED | os.WNOWAIT)
                    self.assertTrue(os.path.exists(f"/proc/{child}"), "the child lives on")
                    if line[0] == "--tcp":
                        self.wait_until(lambda: connections_of(self.emulator.pid) < connections, self.emulator,
                                        "the motor saw the end of the connection", timeout=PATIENCE)
                    # The device is free for the next one.
                    self.until_let_go()
                    again = self.start_again()
                    self.until_driven(again, after=self.log_rows()[-1].time_ns)
                    self.end_early(again)
                    os.kill(child, signal.SIGKILL)
                    self.emulator.kill()

    def new_results(self):
        """A folder of its own, because a child that lives on has the lock of its parent's."""
        self.runs = getattr(self, "runs", 0) + 1
        self.out = self.folder / f"out_{self.runs}"

    def start_again(self):
        self.new_results()
        graph = self.graph(self.address, EASY)
        process = subprocess.Popen([TACTOR, "run", graph, "--no-dead-man", "--overwrite", "--out", self.out], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, env=dict(os.environ, **self.environment))
        self.addCleanup(lambda: process.poll() is None and process.kill())
        return process

    def emulate(self, *arguments, **options):
        self.address = super().emulate(*arguments, **options)
        return self.address

    def test_a_child_that_comes_back_from_the_step_ends_there(self):
        act = f"""
            pid = os.fork()
            if pid == 0:
                return
            self.child = pid
            _, status = os.waitpid(pid, 0)
            open({str(self.folder / "status")!r}, "w").write(str(os.waitstatus_to_exitcode(status)))
            """
        process = self.run_watched(act)
        status = self.folder / "status"
        self.wait_until(lambda: status.exists() and status.read_text(), process, "the child ended", timeout=PATIENCE)
        self.assertEqual(status.read_text(), "0")
        self.end_early(process)
        self.check_forces()


def connections_of(pid):
    """How many connections a process has open."""
    folder = f"/proc/{pid}/fd"
    return sum(os.readlink(f"{folder}/{n}").startswith("socket:") for n in os.listdir(folder) if os.path.lexists(f"{folder}/{n}"))

if __name__ == "__main__":
    unittest.main()
