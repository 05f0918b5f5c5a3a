"""Faults of an engine beside an emulated motor with a guard, and what the motor's own log says of them."""
import os
import pathlib
import random
import signal
import subprocess
import time

from harness import PRESSED_WALL, ROOT, TACTOR, motor_log

KINDS = ("kill", "stop", "stop_continue", "segv")
DEADLINE_MS = 2
RAMP_MS = 3
PERIOD_MS = 1  # of the line
LIMIT_N = 3  # of the gate, what hardware gets by default
# Late answers of a busy machine are not what these faults are about.
EASY = "link_timeout: 2 s, stale_after: 2 s, sample_age_max: 4 s, failure_timeout: 2 s, recovery_time: 0.2 s, stuck_after: 0"


def forgetful_profile():
    """The shipped linear motor without its watchdog: nothing but the guard makes it let go."""
    lines = (ROOT / "devices/modbus/profiles/iris_orca.yaml").read_text().replace("response_timeout: 25 ms", "response_timeout: 400 ms")
    return "".join(line for line in lines.splitlines(keepends=True) if not line.startswith("watchdog:"))


def start(test, number, guard="auto"):
    """An emulator with its log, and a run that pushes its motor; the graph says what `guard` is."""
    folder = test.folder / f"fault{number}"
    folder.mkdir()
    profile, log = folder / "motor.yaml", folder / "motor.log"
    profile.write_text(forgetful_profile())
    emulator, address = test.emulate_modbus(profile, "--tcp", "0", "--log", log)
    device = f'type: modbus.actuator, profile: {profile}, connect: "{address}", origin: [0, 0, -50 mm], guard: {guard}, {EASY}'
    graph = folder / "run.yaml"
    graph.write_text(PRESSED_WALL % {"device": device, "height": "2 mm", "duration": "60 s"})
    engine = subprocess.Popen([TACTOR, "run", graph, "--no-dead-man", "--overwrite", "--out", folder / "out"], stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, text=True, env=dict(os.environ, **test.environment))

    def end():
        if engine.poll() is None:
            engine.send_signal(signal.SIGCONT)
            engine.kill()
        engine.communicate()
    test.addCleanup(end)

    def driven():
        return sum(row.force_N != 0 for row in motor_log(log)[-50:]) > 25
    test.wait_until(driven, engine, "the motor was pushed", timeout=150)
    return engine, emulator, log


def guard_of(engine):
    """The process of the guard that works for this engine."""
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if len(words) > 1 and words[0].endswith(b"/tactor-guard") and words[1] == str(engine.pid).encode():
            return int(process.name)
    return None


def until_zero_ms(rows, fault_ns, end_ns):
    """From the fault to the first row from which on the motor is commanded zero, until `end_ns`; ms."""
    late = [row.time_ns for row in rows if fault_ns <= row.time_ns < end_ns and row.commanded_N != 0]
    return (late[-1] - fault_ns) / 1e6 if late else 0.0


def most_gap_ms(rows, begin_ns, end_ns):
    """The longest time between two rows: so late the emulator itself was."""
    times = [row.time_ns for row in rows if begin_ns <= row.time_ns < end_ns]
    return max((b - a) / 1e6 for a, b in zip(times, times[1:])) if len(times) > 1 else 0.0


def inject(test, kind, engine, log):
    """Makes the fault and looks at the motor for 0.3 s: (ms until zero, ms that the emulator was late, all rows)."""
    guard = guard_of(engine)
    test.assertIsNotNone(guard, "no guard runs beside the engine")
    fault_ns = time.monotonic_ns()
    engine.send_signal({"kill": signal.SIGKILL, "segv": signal.SIGSEGV}.get(kind, signal.SIGSTOP))
    time.sleep(0.3)
    end_ns = time.monotonic_ns()
    if kind == "stop_continue":
        engine.send_signal(signal.SIGCONT)
        time.sleep(0.05)
        after_ns = time.monotonic_ns()
        # What it still knew is refused: it engages anew, which takes a recovery and a ramp.
        test.assertFalse([row for row in motor_log(log) if end_ns <= row.time_ns < after_ns and row.commanded_N != 0])
    time.sleep(0.1)
    rows = motor_log(log)
    late = most_gap_ms(rows, fault_ns - 20_000_000, end_ns)
    if kind in ("kill", "segv"):
        test.wait_until_gone(guard)
    return until_zero_ms(rows, fault_ns, end_ns), late, rows


def seeded(seed, count):
    """(kind, seconds of pushing before it) of each fault."""
    chance = random.Random(seed)
    return [(chance.choice(KINDS), chance.uniform(0, 0.2)) for _ in range(count)]
