"""What a product needs of the command: a run without an end of its own, a log for programs, and a unit of systemd."""
import json
import os
import re
import shutil
import signal
import subprocess
import unittest

from harness import GRAPHS, ROOT, TACTOR, CommandTest, needs_live, tactor

STATION = f"""extends: {GRAPHS / 'wall/scene.yaml'}
clock: real
duration: until stopped
live: {{on_missing_privilege: warn, on_stall: recover}}
"""
KINDS = {"note", "started", "privilege", "running", "gate", "stalled", "missed_ticks", "dropped", "ended", "failed"}


class Product(CommandTest):
    def start(self, *arguments, **options):
        process = subprocess.Popen([TACTOR, "run", self.write("station.yaml", STATION), "--out", self.folder / "out", *arguments],
                                   stdin=subprocess.DEVNULL, text=True, env=dict(os.environ, **self.environment), **options)
        self.addCleanup(lambda: process.poll() is None and process.kill())
        return process

    @needs_live
    def test_a_run_until_stopped_ends_well_by_a_signal_and_its_log_is_of_json_lines(self):
        log = self.folder / "log"
        with open(log, "w", encoding="utf-8") as out:
            process = self.start("--log-json", "-", stdout=out, stderr=subprocess.PIPE)
        self.wait_until(lambda: '"the gate of device is engaged"' in log.read_text(), process, "the device engaged")
        process.send_signal(signal.SIGTERM)
        _, stderr = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 0, stderr)
        self.assertIn("report", stderr, "the summary goes elsewhere")
        events = [json.loads(line) for line in log.read_text().splitlines()]
        for event in events:
            self.assertEqual(list(event), ["time", "run_s", "level", "kind", "node", "message"])
            self.assertRegex(event["time"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z$")
            self.assertIn(event["kind"], KINDS)
        kinds = [event["kind"] for event in events if event["kind"] != "note"]
        self.assertEqual((kinds[0], kinds[-1]), ("started", "ended"))
        self.assertEqual({event["node"] for event in events if event["kind"] == "gate"}, {"device"})
        summary = json.loads((self.folder / "out/summary.json").read_text())
        self.assertIsNone(summary["planned_s"])
        self.assertFalse(summary["interrupted"])
        self.assertNotIn("reference_run", summary)
        self.assertNotIn("passive", summary.get("stability", {}))
        self.assertFalse((self.folder / "out/recording.h5").exists())

    def test_what_would_grow_with_the_run_is_refused(self):
        graph = self.write("station.yaml", STATION)
        for arguments, says in ((("--record-costs", self.folder / "costs"), r"station\.yaml:3:11: duration: .*--record-costs"),
                                (("--follow",), r"station\.yaml:3:11: duration: .*--follow"),
                                (("--set", "record=[device.commanded]"), r"record: expected no output with duration: until stopped"),
                                (("--set", "clock=virtual"), r"station\.yaml:3:11: duration: expected a time \(s\) with clock: virtual"),
                                (("--log-json", "/nowhere/at/all"), r"--log-json /nowhere/at/all: cannot write")):
            with self.subTest(arguments[0]):
                result = tactor("run", graph, "--out", self.folder / "out", *arguments, environment=self.environment)
                self.assertEqual(result.returncode, 2, result.stderr)
                self.assertRegex(result.stderr, says)

    def test_lines_for_the_journal_begin_with_their_level(self):
        path = self.folder / "journal"
        with open(path, "w", encoding="utf-8") as journal:
            status = os.fstat(journal.fileno())
            for stream in (f"{status.st_dev}:{status.st_ino}", f"{status.st_dev}:{status.st_ino + 1}"):
                subprocess.run([TACTOR, "check", self.folder / "none.yaml"], stderr=journal, check=False,
                               env=dict(os.environ, **self.environment, JOURNAL_STREAM=stream))
        first, second = path.read_text().splitlines()
        self.assertEqual(first, "<3>" + second)

    @unittest.skipUnless(shutil.which("systemd-analyze"), "this machine has no systemd-analyze")
    def test_systemd_takes_the_unit(self):
        text = (ROOT / "scripts/tactor@.service").read_text()
        self.assertEqual(len(re.findall("^ExecStart=tactor ", text, re.MULTILINE)), 1)
        unit = self.write("tactor@station.service", text.replace("ExecStart=tactor ", f"ExecStart={TACTOR} "))
        result = subprocess.run(["systemd-analyze", "verify", unit], capture_output=True, text=True, check=False)
        self.assertEqual((result.returncode, result.stdout + result.stderr), (0, ""))


if __name__ == "__main__":
    unittest.main()
