"""A run in which no force reached the device says so, with the reason: at the command, with a device of hardware and without."""
import json
import unittest

from harness import GRAPHS, CommandTest, tactor
from modbus_harness import EASY, ModbusHarness

WALL = GRAPHS / "wall/refit.yaml"


class OnAMotor(ModbusHarness):
    def with_buttons(self, count):
        """The motor's profile with so many buttons, none of which is ever held."""
        text = self.profile.read_text()
        buttons = "".join(f"  - {{register: errors, bit: {bit}}}\n" for bit in range(1, 1 + count))
        return self.write(f"orca_{count}.yaml", text + ("buttons:\n" + buttons if count else ""))

    def run_to_its_end(self, more, profile):
        process = self.start(self.emulate(profile=profile), "3 s", f"{EASY}, {more}", profile)
        self.finish(process, 0)

    def test_a_button_that_was_never_held_is_the_verdict(self):
        self.run_to_its_end("dead_man_button: 1", self.with_buttons(1))
        self.assertRegex(self.stdout, r"verdict +done, 3 s; no force: button 1 was never held\n")
        self.assertEqual(self.summary["no_force"][0]["reason"], "dead_man")
        self.assertEqual(self.summary["no_force"][0]["device"], "device")
        self.assertGreater(self.summary["no_force"][0]["count"], 1000)
        self.assertIn("no force: button 1 was never held", (self.out / "report.html").read_text())
        self.assertEqual({row.force_N for row in self.log_rows()}, {0.0}, "the motor was pushed")

    def test_a_motor_that_was_pushed_is_told_of_no_want_of_force(self):
        self.run_to_its_end("dead_man_button: 0", self.with_buttons(1))
        self.assertNotIn("no force", self.stdout)
        self.assertNotIn("no_force", self.summary)
        self.assertTrue(any(row.force_N != 0 for row in self.log_rows()))

    def test_a_button_that_the_profile_lacks_is_refused_by_check(self):
        for count, button, says in ((0, 1, "expected 0, because the device has no buttons, found 1"),
                                    (1, 2, "expected a button of the device, 1 to 1, or 0 for none, found 2"),
                                    (4, 5, "expected a button of the device, 1 to 4, or 0 for none, found 5"),
                                    (4, -1, "-1"), (4, 32, "32"), (4, 4, ""), (1, 0, "")):
            with self.subTest(count=count, button=button):
                graph = self.graph("tcp:127.0.0.1:9", f"{EASY}, dead_man_button: {button}", self.with_buttons(count))
                result = tactor("check", graph, environment=self.environment)
                self.assertEqual(result.returncode, 2 if says else 0, result.stderr)
                self.assertIn(says, result.stderr)
                if says:
                    self.assertRegex(result.stderr, r"run\.yaml:\d+:\d+: ")
                    self.assertIn("dead_man_button", result.stderr)


class OnASimulatedDevice(CommandTest):
    def told(self, *settings):
        words = [word for setting in settings for word in ("--set", setting)]
        out = self.folder / "out"
        result = self.run_ok("run", WALL, "--duration", "1 s", *words, "--overwrite", "--out", out)
        return result.stdout, json.loads((out / "summary.json").read_text())

    def test_a_largest_force_of_zero_is_the_verdict(self):
        stdout, summary = self.told("device.force_max=0 N")
        self.assertRegex(" ".join(stdout.split()), r"done, 1 s; no force: the largest force is 0 N at (\d+) of \1 ticks")
        self.assertEqual(summary["no_force"][0]["reason"], "no_room")
        self.assertEqual(summary["stability"]["verdict_name"], "no_force")

    def test_a_tool_that_touches_nothing_is_told_as_that(self):
        stdout, summary = self.told("trajectory.points=[{t: 0 s, z: 40 mm}, {t: 1 s, z: 40 mm}]")
        self.assertNotIn("refused", stdout)
        self.assertNotIn("held", stdout)
        self.assertIn(summary.get("no_force", [{"reason": "no_contact"}])[0]["reason"], ("no_contact", "not_asked"))
        self.assertEqual(summary["stability"]["verdict_name"], "stable")

    def test_a_study_names_the_rows_without_a_force(self):
        study = self.write("study.yaml", f"graphs: [{WALL}]\nseeds: 2\nduration: 1 s\njudge: whole\nvary: {{device.force_max: [0 N, 3 N]}}\n")
        result = self.run_ok("study", study, "--out", self.folder / "study")
        says = r"force_max=0 N: no force: the largest force is 0 N at \d+ of \d+ ticks that asked for one, in 2 of 2 runs"
        told = json.loads((self.folder / "study/study.json").read_text())["warnings"]
        self.assertEqual(len([warning for warning in told if "no force" in warning]), 1, told)
        self.assertRegex(" ".join(result.stdout.split()), says)
        self.assertRegex((self.folder / "study/report.html").read_text(), says)

    def test_it_has_no_buttons(self):
        result = tactor("check", WALL, "--set", "device.dead_man_button=1", environment=self.environment)
        self.assertEqual(result.returncode, 2)
        self.assertIn("dead_man_button: expected 0, because the device has no buttons, found 1", result.stderr)


if __name__ == "__main__":
    unittest.main()
