"""The verbs `devices`, `device` and `emulate`, and the devices' section of `doctor`."""
import json
import pathlib
import re
import subprocess
import unittest

from harness import GRAPHS, LIBRARIES, ROOT, TACTOR, CommandTest, motor_log, needs_meshes, needs_live, tactor

KINDS = [kind for kind in ("modbus", "usb") if (LIBRARIES / f"tactor/libtactor_{kind}.so").exists()]
EMULATOR = pathlib.Path(TACTOR).resolve().parent / "tactor-emulate-modbus"
GRAPH = """clock: real
duration: 1 s
scene: {bodies: {}}
nodes:
  device: {type: modbus.actuator, profile: %s, connect: "%s", link_timeout: 2 s, stale_after: 2 s, stuck_after: 0}
record: [device.state]
"""


class Devices(CommandTest):
    def test_attached_devices_are_listed(self):
        text = self.run_ok("devices").stdout
        self.assertTrue(text)
        for line in text.splitlines():
            self.assertTrue(line.startswith("  ") or line == "no device is attached that Tactor recognises", line)

    def test_doctor_tells_whether_devices_can_be_reached(self):
        diagnosis = json.loads(self.run_ok("doctor", "--json", "--seconds", "0.1").stdout)
        self.assertEqual([finding["id"] for finding in diagnosis["devices"]], ["ports", "serial_group", "udev_rule"])
        for finding in diagnosis["devices"]:
            self.assertEqual(bool(finding["remedy"]), finding["grade"] != "ok", finding)
        self.assertIn("Devices", self.run_ok("doctor", "--seconds", "0.1").stdout)

    def test_an_emulator_that_is_not_there_is_told(self):
        result = tactor("emulate", "modbsu")
        self.assertEqual(result.returncode, 2)
        programs = pathlib.Path(TACTOR).resolve().parent.glob("tactor-emulate-*")
        kinds = ", ".join(sorted(program.name.removeprefix("tactor-emulate-") for program in programs))
        self.assertIn(f"emulate: expected one of {kinds}, found modbsu" if kinds else "this build has no emulators", result.stderr)

    def test_a_broken_profile_is_told_in_a_line_and_the_others_are_listed(self):
        whole = self.run_ok("devices")
        self.assertEqual(whole.stderr, "")
        for kind in KINDS:
            with self.subTest(kind=kind):
                (self.folder / kind).mkdir()
                broken = self.write(f"{kind}/broken.yaml", "title: [1]\nline: {baud: x}\n")
                result = self.run_ok("devices", environment={"TACTOR_PROFILE_PATH": str(self.folder)})
                self.assertRegex(result.stderr, rf"\Atactor: {broken}:\d+:\d+: .* \(and \d+ more\)\n\Z")
                self.assertEqual(result.stdout, whole.stdout)
                broken.unlink()

    def test_a_graph_without_hardware_has_nothing_to_try(self):
        for verb in ("test", "calibrate"):
            result = tactor("device", verb, self.judged_small_graph())
            self.assertEqual(result.returncode, 2)
            self.assertIn("expected a node that drives hardware, found none", result.stderr)


@unittest.skipUnless(EMULATOR.exists(), "this build has no Modbus")
class Emulated(CommandTest):
    def setUp(self):
        super().setUp()
        text = (ROOT / "devices/modbus/profiles/iris_orca.yaml").read_text()
        text = text.replace("response_timeout: 25 ms", "response_timeout: 400 ms").replace("time: 150 ms", "time: 5 s")
        self.profile = self.write("orca.yaml", text)

    def graph(self, *arguments, profile=None):
        profile = profile or self.profile
        _, address = self.emulate_modbus(profile, "--tcp", "0", *arguments)
        self.assertTrue(address.startswith("tcp:127.0.0.1:"), address)
        return self.write("device.yaml", GRAPH % (profile, address))

    def answer(self, *arguments, text=""):
        return subprocess.run([TACTOR, *map(str, arguments)], input=text, capture_output=True, text=True, timeout=300,
                              check=False)

    @needs_live
    def test_a_device_is_tried_with_small_forces_on_confirmation(self):
        graph = self.graph()
        log = self.folder / "none"
        result = self.answer("device", "test", graph, "--seconds", "0.5", text="n\n")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("position", result.stdout)
        self.assertIn("Apply up to 1 N", result.stdout)
        self.assertIn("no force was given", result.stdout)
        self.assertFalse(log.exists())
        # A line whose answers come later than the profile lets them has failed.
        ages_ms = [float(age) for age in re.findall(r"age of a sample p99 ([\d.]+) ms", result.stdout)]
        self.assertTrue(ages_ms and all(0 < age < 400 for age in ages_ms), result.stdout)
        result = self.answer("device", "test", graph, "--seconds", "0.5", "--yes")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn("moved by up to 1 N", result.stdout)

    @needs_live
    def test_forces_of_a_trial_stay_small_and_end_at_zero(self):
        forces = self.forces_of_trial("stuck_after: 0", "0.5", "--force", "0.5", "--yes")
        # One axis along z of the scene: it gets the third pair of forces alone.
        self.assertLessEqual(max(map(abs, forces)), 0.5 + 1e-9)
        self.assertGreater(max(forces), 0.1)
        self.assertLess(min(forces), -0.1)
        self.assertEqual(forces[-1], 0)

    @needs_live
    def test_the_brake_of_the_gate_pushes_no_harder_than_the_trial(self):
        # The emulated hand is faster than this now and then, so that the gate brakes, by default with up to 3 N.
        limits = "stuck_after: 0, speed_max: 0.03 m/s, recovery_time: 10 ms, engage_time: 20 ms"
        self.assertEqual(set(self.forces_of_trial(limits, "1.5", text="n\n")), {0})
        self.assertLessEqual(max(map(abs, self.forces_of_trial(limits, "0.5", "--force", "0.5", "--yes"))), 0.5 + 1e-9)

    @needs_live
    def test_the_force_of_a_trial_is_at_the_hand_whatever_the_scene_makes_of_a_newton(self):
        for scale in (0.1, 5):
            with self.subTest(scale=scale):
                forces = self.forces_of_trial(f"stuck_after: 0, force_scale: {scale}", "0.5", "--force", "0.5", "--yes")
                self.assertLessEqual(max(map(abs, forces)), 0.5 + 1e-9)
                self.assertGreater(max(forces), 0.1)

    def forces_of_trial(self, parameters, seconds, *arguments, text=""):
        """All that the emulator was told in a trial of a device with these parameters, N."""
        log = self.folder / f"log_{len(list(self.folder.glob('log_*')))}"
        graph = self.graph("--log", log)
        graph.write_text(graph.read_text().replace("stuck_after: 0", parameters))
        result = self.answer("device", "test", graph, "--seconds", seconds, *arguments, text=text)
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        return [row.force_N for row in motor_log(log)]

    @needs_live
    def test_a_device_without_a_watchdog_is_told_before_the_force_is_confirmed(self):
        text = (ROOT / "devices/modbus/profiles/oriental_az.yaml").read_text()
        graph = self.graph(profile=self.write("az.yaml", text.replace("response_timeout: 30 ms", "response_timeout: 400 ms")))
        result = self.answer("device", "test", graph, "--seconds", "0.5", text="n\n")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        warning = result.stdout.find("Note: az: its profile names no watchdog")
        self.assertTrue(0 < warning < result.stdout.find("Apply up to 1 N"), result.stdout)
        self.assertNotIn("watchdog", self.answer("device", "test", self.graph(), "--seconds", "0.5", text="n\n").stdout)

    def test_a_device_is_calibrated(self):
        graph = self.graph()
        result = self.answer("device", "calibrate", graph, text="n\n")
        self.assertIn("nothing done", result.stdout)
        result = self.answer("device", "calibrate", graph, "--yes")
        self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
        self.assertIn(": calibrated", result.stdout)

    def test_a_bad_emulator_call_is_bad_input(self):
        for arguments in (["--tcp", "x"], ["--pty", "--tcp", "1"], ["--pty", "--fault", "slient@1"], ["--nonsense"], []):
            result = tactor("emulate", "modbus", self.profile, *arguments)
            self.assertEqual(result.returncode, 2, arguments)
        self.assertIn("fault: expected KIND", tactor("emulate", "modbus", self.profile, "--pty", "--fault", "slient").stderr)
        result = tactor("emulate", "modbus", "--help")
        self.assertEqual(result.returncode, 0)
        self.assertIn("--pty", result.stdout)

    @needs_meshes
    def test_the_shipped_graph_is_good(self):
        self.assertIn("ok", self.run_ok("check", GRAPHS / "bunny/orca.yaml").stdout)


if __name__ == "__main__":
    unittest.main()
