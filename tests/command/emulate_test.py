"""An emulator in the background of an interactive shell, as the pages start it: it serves whatever is typed there."""
import os
import pathlib
import pty
import re
import select
import signal
import socket
import struct
import time
import unittest

from harness import TACTOR, CommandTest, tactor

EMULATOR = pathlib.Path(TACTOR).resolve().parent / "tactor-emulate-modbus"
PATIENCE = 120  # s, for what takes a moment on an idle machine


class Shell:
    """bash with job control on a pseudo-terminal of its own."""

    def __init__(self):
        self.pid, self.terminal = pty.fork()
        if self.pid == 0:
            os.environ["PS1"] = "$ "
            os.execv("/bin/bash", ["bash", "--norc", "--noprofile", "-i"])
        self.text = ""

    def type(self, line):
        os.write(self.terminal, (line + "\n").encode())

    def expect(self, pattern):
        """Reads until the pattern has come; the match. What came before is gone afterwards."""
        end = time.monotonic() + PATIENCE
        while not (match := re.search(pattern, self.text)):
            if not select.select([self.terminal], [], [], max(0, end - time.monotonic()))[0]:
                raise AssertionError(f"{pattern} does not come:\n{self.text}")
            self.text += os.read(self.terminal, 4096).decode(errors="replace")
        self.text = self.text[match.end():]
        return match

    def close(self, emulator):
        for process in (emulator, self.pid):
            try:
                if process:
                    os.kill(process, signal.SIGKILL)
            except ProcessLookupError:
                pass
        os.waitpid(self.pid, 0)
        os.close(self.terminal)


@unittest.skipUnless(EMULATOR.exists(), "this build has no Modbus")
class Background(CommandTest):
    def setUp(self):
        super().setUp()
        self.pid = 0
        self.shell = Shell()
        self.addCleanup(lambda: self.shell.close(self.pid))

    def position(self, port):
        """Two words at 342, by a Modbus frame written here."""
        with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE) as line:
            line.sendall(struct.pack(">HHHBBHH", 1, 0, 6, 1, 3, 342, 2))
            answer = b""
            while len(answer) < 13:
                answer += line.recv(64)
        low, high = struct.unpack(">HH", answer[9:13])
        return high * 65536 + low

    def state(self):
        return pathlib.Path(f"/proc/{self.pid}/stat").read_text().rsplit(")", 1)[1].split()[0]

    def wait_for(self, condition, what):
        end = time.monotonic() + PATIENCE
        while not condition():
            self.assertLess(time.monotonic(), end, what)
            time.sleep(0.02)

    def start(self, log):
        self.shell.type(f"{TACTOR} emulate modbus iris_orca --tcp 0 --log {log} &")
        port = int(self.shell.expect(r"ready tcp:127\.0\.0\.1:(\d+)").group(1))
        # The quotes keep the echo of what is typed from being the answer.
        self.shell.type('echo "pi""d="$! .')
        self.pid = int(self.shell.expect(r"pid=(\d+) \.").group(1))
        return port

    def test_what_is_typed_at_the_shell_does_not_stop_it(self):
        log = self.folder / "log"
        port = self.start(log)
        for _ in range(3):
            self.shell.type("")
            self.shell.type('echo "typ""ed"')
            self.shell.expect("typed")
        # It has gone round its loop since, and moves.
        lines = len(log.read_text().splitlines())
        self.wait_for(lambda: len(log.read_text().splitlines()) > lines + 200, "the emulated motor stands still")
        self.assertNotEqual(self.state(), "T")
        self.assertTrue(0 < self.position(port) < 150_000)

    def test_a_terminal_that_stops_the_output_of_the_background_does_not_stop_it(self):
        self.shell.type("stty tostop")
        port = self.start(self.folder / "log")
        self.shell.type("")
        self.assertTrue(0 < self.position(port) < 150_000)
        self.assertNotEqual(self.state(), "T")

    def test_it_obeys_in_the_foreground_and_after_it_has_come_back(self):
        port = self.start(self.folder / "log")
        self.shell.type("")
        self.shell.type("fg")
        self.shell.expect("emulate modbus")
        self.shell.type("fault jump:0.5")
        self.shell.expect("injected jump:0.5")
        self.wait_for(lambda: self.position(port) > 500_000, "the encoder does not jump")
        os.write(self.shell.terminal, b"\x1a")  # control-Z, with which the user stops it
        self.shell.expect("Stopped")
        self.shell.type("bg")
        self.shell.type("")
        self.wait_for(lambda: self.state() != "T", "it does not go on")
        self.assertGreater(self.position(port), 500_000)
        self.shell.type("kill %1; wait")
        self.wait_for(lambda: not pathlib.Path(f"/proc/{self.pid}").exists(), "it does not end")
        self.pid = 0

    def test_a_client_that_never_reads_does_not_keep_it_from_ending(self):
        emulator, address = self.emulate_modbus("iris_orca", "--tcp", "0")
        with socket.create_connection(("127.0.0.1", int(address.rsplit(":", 1)[1])), timeout=PATIENCE) as line:
            line.setblocking(False)
            requests = struct.pack(">HHHBBHH", 1, 0, 6, 1, 3, 342, 3) * 1000
            refused = 0
            while refused < 50:
                try:
                    line.send(requests)
                except BlockingIOError:
                    refused += 1
                    time.sleep(0.01)
                except OSError:  # it has ended this connection
                    break
            self.assertTrue(0 < self.position(int(address.rsplit(":", 1)[1])) < 150_000)
            emulator.send_signal(signal.SIGTERM)
            self.assertEqual(emulator.wait(PATIENCE), 0)

    def test_a_file_in_the_place_of_a_link_stays(self):
        file = self.write("thesis.tex", "years of work")
        result = tactor("emulate", "modbus", "iris_orca", "--pty", "--link", file)
        self.assertEqual(result.returncode, 2)
        self.assertIn(f"--link {file}: expected a name that is free, or a symbolic link, found a file", result.stderr)
        self.assertEqual(file.read_text(), "years of work")


if __name__ == "__main__":
    unittest.main()
