"""Live runs with emulated USB devices, and what goes wrong on the way to them: the force stays within its limits, goes down to
zero, and what is told names the device."""
import csv
import json
import os
import pathlib
import subprocess
import unittest

from harness import GRAPHS, PRESSED_WALL, ROOT, TACTOR, CommandTest, check_loop, needs_meshes, needs_hdf5, needs_live, tactor

try:
    import h5py
    import numpy
except ImportError:
    h5py = None

EMULATOR = pathlib.Path(TACTOR).resolve().parent / "tactor-emulate-usb"
PATIENCE = 150  # s, for what takes a few seconds on an idle machine
FORCE_MAX, FORCE_SLEW, PERIOD = 5.0, 2000.0, 1e-3
ENGAGED = 2
PRESSED = "    - [0 s, 0, 0, -25 mm]\n    - [1000 s, 0, 0, -25 mm]\n"
POLHEM = "polhem (USB 1234:0006)"
EASY = "force_max: 5 N, link_timeout: 2 s, stale_after: 2 s, sample_age_max: 4 s, recovery_time: 0.2 s"


@needs_live
@needs_hdf5
@needs_meshes
@unittest.skipIf(h5py is None, "h5py is not installed")
@unittest.skipUnless(EMULATOR.exists(), "this build has no USB")
class UsbRun(CommandTest):
    def setUp(self):
        super().setUp()
        self.environment["XDG_RUNTIME_DIR"] = str(self.folder)
        self.out = self.folder / "out"
        self.trace = self.folder / "trace.csv"

    def profile(self, *changes):
        """The Polhem's profile with a long patience for a busy machine, a hand that goes down and stays there, and parts of its
        text replaced."""
        text = (ROOT / "devices/usb/profiles/polhem.yaml").read_text()
        path = text[text.index("    - [0 s, 0, 0, 20 mm]"):]
        for old, new in (("report_timeout: 50 ms", "report_timeout: 400 ms"), (path, PRESSED), *changes):
            self.assertIn(old, text)
            text = text.replace(old, new)
        return self.write("polhem.yaml", text)

    def graph(self, device, duration="8 s", more="failure_timeout: 1 s, stuck_after: 0 s"):
        return self.write("graph.yaml", PRESSED_WALL % {"device": f"{device}, {EASY}, {more}", "height": "50 mm",
                                                        "duration": duration})

    def polhem(self, profile, **options):
        return self.graph(f"type: usb.device, profile: {profile}, origin: [0, 0, 10 mm]", **options)

    def emulate(self, device, *arguments, command, code):
        """Runs a command beside an emulated device; it must end with this code. Its standard error."""
        result = subprocess.run([EMULATOR, device, "--trace", self.trace, *arguments, "--", *map(str, command)],
                                capture_output=True, text=True, env=dict(os.environ, **self.environment), timeout=PATIENCE,
                                check=False)
        self.assertEqual(result.returncode, code, result.stdout[-4000:] + result.stderr)
        return result.stderr

    def run_emulated(self, device, graph, *arguments, code=0):
        return self.emulate(device, *arguments, command=(TACTOR, "run", graph, "--overwrite", "--out", self.out), code=code)

    def summary(self):
        return json.loads((self.out / "summary.json").read_text())["device"]

    def efforts(self):
        """What the emulated motors held, a row a frame: efforts and faults."""
        with open(self.trace, newline="") as file:
            rows = [[float(row[f"effort_{i}"]) for i in (1, 2, 3)] + [float(row["faults"])] for row in csv.DictReader(file)]
        return numpy.array(rows).reshape(-1, 4)

    def recorded(self, pressed=True):
        """Times, commanded forces by norm and engagement; the limits were kept at every tick, and it ends with zero."""
        with h5py.File(self.out / "recording.h5") as file:
            commanded = file["streams/device.commanded/data"][...]
            safety = file["streams/device.safety/data"][...]
        rows = min(len(commanded), len(safety))
        commanded, safety = commanded[:rows], safety[:rows]
        force = commanded["force"]
        norm = numpy.linalg.norm(force, axis=1)
        self.assertTrue(numpy.isfinite(norm).all())
        self.assertLessEqual(norm.max(), FORCE_MAX * (1 + 1e-9))
        elapsed = numpy.minimum(numpy.diff(commanded["valid_ns"]) * 1e-9, 2 * PERIOD)
        change = numpy.linalg.norm(numpy.diff(force, axis=0), axis=1)
        self.assertTrue((change <= FORCE_SLEW * elapsed * (1 + 1e-9)).all())
        self.assertEqual(norm[-1], 0)
        if pressed:
            self.assertGreater(norm.max(), 0.1)
        return commanded["valid_ns"] * 1e-9, norm, safety["engagement"]

    def test_the_wall_is_felt_and_the_motors_rest_at_the_end(self):
        self.run_emulated("polhem", self.polhem(self.profile()))
        self.recorded()
        efforts = self.efforts()
        self.assertGreater(abs(efforts[:, :3]).max(), 0.01)
        self.assertTrue((efforts[-1, :3] == 0).all())
        device = self.summary()
        self.assertGreater(device["link"]["cycles"], 100)
        self.assertEqual(device["link"]["reconnects"], 0)
        self.assertEqual(device["jumps"], 0)
        check_loop(self, device)

    def test_the_line_counts_what_the_motors_gave(self):
        """Physics is 50 ms away, so that a held force gives energy; with a bound on the line the motors give no more than is allowed."""
        for guard, bounds in (("off", False), ("off", True), ("on", True)):
            with self.subTest(guard=guard, bounds=bounds):
                self.trace.unlink(missing_ok=True)
                graph = self.polhem("polhem", more=f"failure_timeout: 1 s, stuck_after: 0 s, energy_bound: {str(bounds).lower()}, guard: {guard}")
                self.emulate("polhem", code=0, command=(TACTOR, "run", graph, "--over", GRAPHS / "passivity/delay_50ms.yaml",
                                                        "--overwrite", "--out", self.out))
                counted = self.summary()["line"]
                with open(self.trace, newline="") as file:  # by the steps of the arm itself
                    given = max(float(row["given"]) for row in csv.DictReader(file))
                # Beside a guard the count may be above what the motors gave (50 uJ were seen), and never below.
                self.assertLess(given - counted["energy_generated_J"], 0.05 * given + 1e-5)
                if guard == "off":
                    self.assertLess(counted["energy_generated_J"] - given, 0.05 * given + 1e-5)
                (self.assertLessEqual if bounds else self.assertGreater)(given, counted["energy_allowed_J"])

    def test_the_shipped_graphs_run_beside_their_emulators(self):
        for device, extra in (("polhem", ()), ("falcon", ("--firmware",))):
            with self.subTest(device):
                self.emulate(device, *extra, code=0, command=(
                    TACTOR, "run", GRAPHS / f"duck/{device}.yaml", "--duration", "2", "--overwrite", "--out", self.out))
                self.assertGreater(self.summary()["link"]["cycles"], 10)
                self.recorded(pressed=False)

    def test_without_a_calibration_nothing_begins(self):
        error = self.run_emulated("polhem", self.polhem("polhem"), "--uncalibrated", code=2)
        self.assertIn(POLHEM, error)
        self.assertIn("tactor device calibrate", error)
        self.assertTrue((self.efforts()[:, :3] == 0).all())

    def test_a_calibration_is_made_once_and_lost_with_the_power(self):
        graph = self.polhem(self.profile(), duration="1 s")
        if "calibrate" not in tactor("device", "--help").stdout:
            self.skipTest("this build has no command for devices")
        run = f"{TACTOR} run {graph} --out {self.out}"
        self.emulate("polhem", "--uncalibrated", code=0, command=(
            "sh", "-c", f"{TACTOR} device calibrate {graph} --yes && {run}"))
        self.assertEqual(self.summary()["link"]["reconnects"], 0)
        # The same kind of device, plugged in since: the record of the first is still there, and is not for this one.
        error = self.run_emulated("polhem", graph, "--uncalibrated", code=2)
        self.assertIn("tactor device calibrate", error)

    def test_a_pulled_cable_ends_the_force_and_the_run(self):
        error = self.run_emulated("polhem", self.polhem(self.profile(), duration="30 s"), "--fault", "unplug@driven+3",
                                  code=1)
        self.assertIn(POLHEM, error)
        self.recorded()
        self.assertTrue((self.efforts()[-1, :3] == 0).all())

    def test_a_lost_zero_is_not_used_after_the_cable_was_put_back(self):
        error = self.run_emulated("polhem", self.polhem(self.profile(), duration="30 s"), "--fault", "unplug@driven+3",
                                  "--fault", "replug@+0.1", code=1)
        self.assertIn(POLHEM, error)
        self.assertIn("calibrate", error)
        self.assertEqual(self.summary()["link"]["reconnects"], 0)
        self.recorded()

    def test_a_falcon_that_was_plugged_in_again_is_homed_and_engages_anew(self):
        firmware = self.write("image.bin", "x" * 3000)
        graph = self.graph(f"type: falcon.device, firmware: {firmware}, origin: [0, 0, -115 mm]", duration="25 s",
                           more="failure_timeout: 60 s, stuck_after: 0 s")
        self.run_emulated("falcon", graph, "--fault", "unplug@driven+0.5", "--fault", "replug@+0.2")
        t, norm, engagement = self.recorded()
        self.assertGreaterEqual(self.summary()["link"]["reconnects"], 1)
        first = numpy.flatnonzero(engagement == ENGAGED)[0]
        out = first + numpy.flatnonzero(engagement[first:] != ENGAGED)[0]
        again = out + numpy.flatnonzero(engagement[out:] == ENGAGED)[0]
        # In between it was at zero, for longer than the device takes to find its own.
        self.assertEqual(norm[out:again].min(), 0)
        self.assertGreater(t[again] - t[out], 0.2)
        self.assertTrue((self.efforts()[-1, :3] == 0).all())

    def fails(self, fault, says, *changes, more="failure_timeout: 1 s, stuck_after: 0 s"):
        """The device is driven, something goes wrong and stays so: the run ends, and says so of the device."""
        profile = self.profile(*changes)
        error = self.run_emulated(str(profile), self.polhem(profile, duration="30 s", more=more), "--fault", fault, code=1)
        self.assertIn(POLHEM, error)
        self.assertIn(says, error)
        t, norm, _ = self.recorded()
        efforts = self.efforts()
        self.assertTrue((efforts[-1, :3] == 0).all())
        # In the last half second of the run, long after the fault, no motor got anything.
        self.assertTrue((norm[t > t[-1] - 0.4] == 0).all())

    def test_a_silent_device_ends_the_run(self):
        self.fails("silent@driven+3", "no report")

    def test_short_reports_end_the_run(self):
        self.fails("short@driven+3", "a report of 7 bytes, expected 14")

    def test_long_reports_end_the_run(self):
        self.fails("long@driven+3", "a report of 21 bytes, expected 14")

    def test_a_position_that_has_jumped_is_not_believed_however_often_it_repeats(self):
        self.fails("jump@driven+3", "jumped")

    def test_an_encoder_that_stands_still_under_a_force_is_stuck(self):
        # Weak motors, of whose torque the wall takes more than a fifth.
        self.fails("stuck@driven+3", "stuck", ("limit: 1999", "limit: 60"),
                   more="failure_timeout: 1 s, stuck_after: 0.5 s")

    def test_a_fault_that_the_device_reports_is_told_in_its_words(self):
        self.fails("status@driven+3", "a motor that is too hot",
                   ("buttons:", "faults:\n  - {field: info, bit: 3, meaning: a motor that is too hot}\nbuttons:"))

    def test_another_device_under_the_same_numbers_gets_nothing(self):
        profile = self.profile(("calibration: the base straight ahead, the upper link upright, the lower link level\n", ""))
        error = self.run_emulated(str(profile), self.polhem(profile, more="connect_timeout: 1 s, failure_timeout: 0.5 s"),
                                  "--wrong-device", code=1)
        self.assertIn(POLHEM, error)
        self.assertIn("another device", error)
        self.assertTrue((self.efforts()[:, :3] == 0).all())

    def test_a_file_in_the_place_of_the_control_is_refused(self):
        file = self.write("thesis.tex", "years of work")
        error = self.emulate("polhem", "--control", file, command=("true",), code=2)
        self.assertIn(f"--control {file}: expected a name that is free, or a FIFO", error)
        self.assertEqual(file.read_text(), "years of work")

    def test_a_firmware_that_can_be_none_is_refused_before_anything_begins(self):
        short = self.write("short.bin", "x" * 100)
        for firmware, says in ((short, "found 100"), (self.folder / "none.bin", "expected a file that exists")):
            graph = self.graph(f"type: falcon.device, firmware: {firmware}")
            error = self.run_emulated("falcon", graph, code=2)
            self.assertIn(firmware.name, error)
            self.assertIn(says, error)
        error = self.run_emulated("falcon", self.graph("type: falcon.device"), code=2)
        self.assertIn("it has no firmware", error)
        self.assertTrue((self.efforts()[:, :3] == 0).all())

    def test_a_broken_profile_is_refused_with_its_place(self):
        profile = self.profile(("rate: 1 kHz", "rate: 1 mm"))
        result = tactor("check", self.polhem(profile))
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn(f"{profile}:9:9: usb.rate: expected a rate (Hz)", result.stderr)
        result = tactor("check", self.polhem("polhen"))
        self.assertEqual(result.returncode, 2)
        self.assertIn("did you mean \"polhem.yaml\"", result.stderr)

    def test_the_emulator_says_what_it_takes(self):
        for arguments, says in ((("polhem",), "a command"), (("polhen", "--", "true"), "did you mean"),
                                (("polhem", "--fault", "jmp@1", "--", "true"), "expected one of unplug"),
                                (("polhem", "--fault"), "expected a value"), (("--bad",), "--bad")):
            result = subprocess.run([EMULATOR, *arguments], capture_output=True, text=True, timeout=PATIENCE, check=False)
            self.assertEqual(result.returncode, 2, arguments)
            self.assertIn(says, result.stderr)
        result = subprocess.run([EMULATOR, "falcon", "--", "sh", "-c", "exit 7"], timeout=PATIENCE, check=False)
        self.assertEqual(result.returncode, 7)

    def test_the_program_that_attaches_to_the_kernel_says_what_it_takes(self):
        program = EMULATOR.with_name("tactor-attach-usb")
        for arguments, says in (((), "the name of a profile"), (("polhen",), "did you mean"), (("--bad",), "--bad"),
                                (("polhem", "--fault", "jmp@1"), "expected one of unplug"),
                                (("polhem", "--fault", "replug@1"), "start the program again"),
                                (("polhem", "--trace"), "expected a value"),
                                (("polhem", "--trace", self.folder / "none/trace.csv"), "cannot be written")):
            result = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=PATIENCE, check=False)
            self.assertEqual(result.returncode, 2, arguments)
            self.assertIn(says, result.stderr)


if __name__ == "__main__":
    unittest.main()
