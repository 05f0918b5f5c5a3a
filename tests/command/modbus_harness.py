"""Live runs with an emulated Modbus motor: how they are started, watched and judged."""
import json
import os
import pathlib
import signal
import subprocess
import time
import unittest

from harness import PRESSED_WALL, ROOT, TACTOR, CommandTest, motor_log, needs_hdf5, needs_live

try:
    import h5py
    import numpy
except ImportError:
    h5py = None

EMULATOR = pathlib.Path(TACTOR).resolve().parent / "tactor-emulate-modbus"
PATIENCE = 150  # s, for what takes a few seconds on an idle machine
FORCE_MAX = 3.0  # N, of the gate: what hardware gets by default
# Late answers of a busy machine are not what these tests are about.
EASY = "link_timeout: 2 s, stale_after: 2 s, sample_age_max: 4 s, failure_timeout: 1 s, recovery_time: 0.2 s, stuck_after: 3 s"


@needs_live
@needs_hdf5
@unittest.skipIf(h5py is None, "h5py is not installed")
@unittest.skipUnless(EMULATOR.exists(), "this build has no Modbus")
class ModbusHarness(CommandTest):
    def setUp(self):
        super().setUp()
        text = (ROOT / "devices/modbus/profiles/iris_orca.yaml").read_text()
        text = text.replace("response_timeout: 25 ms", "response_timeout: 400 ms").replace("time: 150 ms", "time: 3 s")
        self.profile = self.write("orca.yaml", text)
        self.out = self.folder / "out"
        self.log = self.folder / "emulator.log"

    def emulate(self, *arguments, line=("--tcp", "0"), profile=None):
        self.emulator, address = self.emulate_modbus(profile or self.profile, *line, "--log", self.log, *arguments)
        return address

    def graph(self, connect, more=EASY, profile=None, duration="1 s", name="run.yaml"):
        device = f'type: modbus.actuator, profile: {profile or self.profile}, connect: "{connect}", origin: [0, 0, -50 mm], {more}'
        return self.write(name, PRESSED_WALL % {"device": device, "height": "2 mm", "duration": duration})

    def start(self, connect, duration="60 s", more=EASY, profile=None):
        graph = self.graph(connect, more, profile, duration)
        process = subprocess.Popen([TACTOR, "run", graph, "--no-dead-man", "--overwrite", "--out", self.out], stdout=subprocess.PIPE,
                                   stderr=subprocess.PIPE, text=True, env=dict(os.environ, **self.environment))
        self.addCleanup(lambda: process.poll() is None and process.kill())
        return process

    def log_rows(self):
        return motor_log(self.log)

    def until_driven(self, process, after=0):
        """Waits until the motor has been pushed with a force for a while, later than `after` (ns)."""
        def driven():
            pushed = 0
            for row in self.log_rows():
                pushed = pushed + 1 if row.force_N != 0 and row.time_ns > after else 0
                if pushed == 25:
                    return True
            return False
        self.wait_until(driven, process, "the motor was pushed", timeout=PATIENCE)

    def finish(self, process, code):
        try:
            self.stdout, stderr = process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            self.fail("the run does not end")
        self.assertEqual(process.returncode, code, self.stdout + stderr)
        self.summary = json.loads((self.out / "summary.json").read_text())
        return stderr

    def check_forces(self):
        """No force is beyond the limits, in the recording and at the motor, and both end at zero."""
        with h5py.File(self.out / "recording.h5") as file:
            force = file["streams/device.commanded/data"][...]["force"]
        norm = numpy.linalg.norm(force, axis=1)
        self.assertLessEqual(norm.max(), FORCE_MAX * (1 + 1e-9))
        self.assertEqual(norm[-1], 0)
        time.sleep(0.1)
        rows = self.log_rows()
        self.assertLessEqual(max(abs(row.force_N) for row in rows), FORCE_MAX + 0.001)
        self.assertEqual(rows[-1].force_N, 0)

    def end_early(self, process):
        process.send_signal(signal.SIGINT)
        return self.finish(process, 0)
