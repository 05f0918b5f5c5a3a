"""Seeded faults of an engine that pushes an emulated motor without a watchdog: the guard takes the force to zero.

Mutations that must fail here: a deadline of ten times fails `test_the_force_goes_to_zero_after_each_fault` by its median; a guard
that is not started fails it by the force that stays, as `test_without_a_guard_the_motor_keeps_its_force` shows.
"""
import os
import pathlib
import signal
import statistics
import time
import unittest

from guard_faults import DEADLINE_MS, LIMIT_N, PERIOD_MS, RAMP_MS, guard_of, inject, motor_log, seeded, start
from harness import TACTOR, CommandTest, needs_live, tactor

SEED, COUNT = 59, 12
BUSY_MS = 10  # a machine that is busy may be late by so much in half of the faults
EMULATOR = pathlib.Path(TACTOR).resolve().parent / "tactor-emulate-modbus"


@needs_live
@unittest.skipUnless(EMULATOR.exists(), "this build has no Modbus")
class Faults(CommandTest):
    def wait_until_gone(self, process):
        end = time.monotonic() + 30
        while pathlib.Path(f"/proc/{process}").exists():
            self.assertLess(time.monotonic(), end, "the guard of an engine that has gone does not end")
            time.sleep(0.01)

    def test_the_force_goes_to_zero_after_each_fault(self):
        times = []
        for number, (kind, wait) in enumerate(seeded(SEED, COUNT)):
            with self.subTest(kind=kind, number=number):
                engine, emulator, log = start(self, number)
                time.sleep(wait)
                zero, late, rows = inject(self, kind, engine, log)
                self.assertLess(zero, 250, "the force stays")
                self.assertLessEqual(max(abs(row.commanded_N) for row in rows), LIMIT_N + 0.001)
                times.append(zero - late)
                engine.send_signal(signal.SIGCONT)
                engine.kill()
                engine.wait()
                emulator.kill()
        # One fault may be late on a busy machine, and not most of them.
        self.assertEqual(len(times), COUNT)
        self.assertLess(statistics.median(times), DEADLINE_MS + RAMP_MS + PERIOD_MS + BUSY_MS)

    def test_a_guard_that_is_asked_to_end_lets_go_and_the_run_fails_with_the_devices_name(self):
        engine, _, log = start(self, 0)
        guard = guard_of(engine)
        os.kill(guard, signal.SIGTERM)
        _, stderr = engine.communicate(timeout=120)
        self.assertEqual(engine.returncode, 1, stderr)
        self.assertIn("device", stderr)
        self.assertEqual(motor_log(log)[-1].commanded_N, 0)

    def test_without_a_guard_the_motor_keeps_its_force(self):
        engine, _, log = start(self, 0, "off")
        self.assertIsNone(guard_of(engine))
        engine.kill()
        engine.wait()
        time.sleep(0.5)
        self.assertNotEqual(motor_log(log)[-1].commanded_N, 0)

    def test_a_word_that_is_no_choice_is_refused(self):
        graph = self.write("bad.yaml", "clock: real\nduration: 1 s\nscene: {bodies: {}}\nnodes:\n  device: {type: modbus.actuator, "
                           "profile: iris_orca, connect: \"tcp:127.0.0.1:9\", guard: never}\n")
        result = tactor("check", graph, environment=self.environment)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn("bad.yaml:5:", result.stderr)
        self.assertIn("guard", result.stderr)


if __name__ == "__main__":
    unittest.main()
