"""What each signal does to a live run: whatever can be handled ramps the force to zero, and a pipe that nobody reads ends
the printing alone."""
import os
import signal
import subprocess
import time
import unittest

from faults_test import NOT_PERMITTED, TIMEOUT, FaultRun, duck
from harness import LEFT_TO_THE_COMMAND, TACTOR, needs_live

# By number, because Python has no names for all of them.
STACK_FAULT = 16
ENDS = {"HUP": signal.SIGHUP, "INT": signal.SIGINT, "QUIT": signal.SIGQUIT, "TERM": signal.SIGTERM, "TSTP": signal.SIGTSTP,
        "USR1": signal.SIGUSR1, "USR2": signal.SIGUSR2, "ALRM": signal.SIGALRM, "VTALRM": signal.SIGVTALRM,
        "PROF": signal.SIGPROF, "IO": signal.SIGIO, "PWR": signal.SIGPWR, "STKFLT": STACK_FAULT, "XCPU": signal.SIGXCPU,
        "RTMIN": signal.SIGRTMIN, "RTMIN+7": signal.SIGRTMIN + 7, "RTMAX": signal.SIGRTMAX}
# Sent by a process; a crash of the run's own is another matter.
ENDS_IF_SENT = {"SEGV": signal.SIGSEGV, "ABRT": signal.SIGABRT, "BUS": signal.SIGBUS, "FPE": signal.SIGFPE,
                "ILL": signal.SIGILL, "TRAP": signal.SIGTRAP, "SYS": signal.SIGSYS}
PASSES = {"PIPE": signal.SIGPIPE, "XFSZ": signal.SIGXFSZ, "TTIN": signal.SIGTTIN, "TTOU": signal.SIGTTOU,
          "CHLD": signal.SIGCHLD, "URG": signal.SIGURG, "WINCH": signal.SIGWINCH, "CONT": signal.SIGCONT}
CANNOT_BE_HANDLED = {signal.SIGKILL, signal.SIGSTOP}


@needs_live
class Signals(FaultRun):
    sanitizer_options = LEFT_TO_THE_COMMAND

    def start_in_contact(self, *arguments, **options):
        subprocess.run(["rm", "-rf", self.out], check=True)
        process = self.start(duck(), *arguments, **options)
        self.wait_until(lambda: (self.read_while_running()[1] > 0.2).any(), process, "the tool was in contact",
                        timeout=TIMEOUT)
        return process

    def test_the_table_has_every_signal(self):
        known = set(ENDS.values()) | set(ENDS_IF_SENT.values()) | set(PASSES.values()) | CANNOT_BE_HANDLED
        between = set(range(signal.SIGRTMIN, signal.SIGRTMAX + 1))
        self.assertEqual(set(signal.valid_signals()) - known - between, set())

    def test_each_signal_that_can_be_handled_ramps_the_force_to_zero(self):
        tried = 0
        for name, number in {**ENDS, **ENDS_IF_SENT}.items():
            with self.subTest(name):
                process = self.start_in_contact("--duration", "1000")
                process.send_signal(number)
                self.finish(process, 0)
                recorded = self.recording()
                self.assert_ramped_down(recorded, NOT_PERMITTED)
                self.assertTrue(self.results()["interrupted"])
                tried += 1
        self.assertEqual(tried, 24)

    def test_signals_that_are_no_reason_to_end_are_none(self):
        process = self.start_in_contact("--duration", "4")
        for number in PASSES.values():
            process.send_signal(number)
            time.sleep(0.02)
        self.finish(process, 0)
        self.recording()
        self.assertFalse(self.results()["interrupted"])
        self.assertEqual(self.results()["duration_s"], 4)

    def test_a_reader_that_goes_ends_the_printing_alone(self):
        for closed in ("stdout", "stderr", "both"):
            with self.subTest(closed):
                process = self.start_in_contact("--duration", "3")
                for stream in ("stdout", "stderr"):
                    if closed in (stream, "both"):
                        getattr(process, stream).close()
                code = process.wait(timeout=TIMEOUT)
                for stream in (process.stdout, process.stderr):
                    stream.close()
                # The summary has nowhere to go, which the exit code says; the files are there.
                self.assertEqual(code, 0 if closed == "stderr" else 1)
                self.recording()
                self.assertEqual(self.results()["duration_s"], 3)
                self.assertFalse(self.results()["interrupted"])

    def test_head_ends_neither_the_run_nor_the_ramp(self):
        subprocess.run(["rm", "-rf", self.out], check=True)
        graph = self.write("fault.yaml", duck())
        command = f"'{TACTOR}' run '{graph}' --duration 3 --out '{self.out}' 2>&1 | head -n 1; exit ${{PIPESTATUS[0]}}"
        result = subprocess.run(["bash", "-c", command], env=dict(os.environ, **self.environment), capture_output=True,
                                timeout=TIMEOUT, check=False)
        self.assertIn(result.returncode, (0, 1))  # head may have read all that there was
        self.recording()
        self.assertEqual(self.results()["duration_s"], 3)

    def test_a_crash_of_the_run_is_a_crash(self):
        # abort comes to the process by itself, and must not look like a wish to end.
        throws = duck("nodes:\n  metrics: ~\n  culprit: {type: fault.aborts, at: 1.2 s, lasts: 10 s}\nedges:\n"
                      "  - coupling.force -> culprit.in\n  - culprit.out -> refit.force\n")
        process = self.start(throws, "--duration", "1000")
        process.communicate(timeout=TIMEOUT)
        self.assertEqual(process.returncode, -signal.SIGABRT)


if __name__ == "__main__":
    unittest.main()
