"""The flight file of a live run that goes wrong names the fault, the node and the time, and nothing else is needed to see them."""
import csv
import importlib.machinery
import importlib.util
import io
import json
import pathlib
import random
import signal
import subprocess
import tempfile
import time
import unittest

from harness import IS_SANITIZED, ROOT, TACTOR, CommandTest, needs_hdf5, needs_live, tactor

spec = importlib.util.spec_from_loader("flight_faults", importlib.machinery.SourceFileLoader("flight_faults", str(ROOT / "scripts/flight_faults")))
flight_faults = importlib.util.module_from_spec(spec)
spec.loader.exec_module(flight_faults)

# One of each kind; the script has more.
TRIED = ("throws", "stalls", "not_finite", "segv", "device_fails", "jumps", "killed", "stopped", "motor_silent", "motor_unplugged")


@needs_live
@needs_hdf5
class Flight(CommandTest):
    def setUp(self):
        super().setUp()
        shared = tempfile.TemporaryDirectory(dir="/dev/shm")
        self.addCleanup(shared.cleanup)
        self.shared = pathlib.Path(shared.name)
        self.environment.update(XDG_RUNTIME_DIR=str(self.shared), TACTOR_NODE_PATH=str(flight_faults.FAULT_NODES))

    def test_the_first_line_names_fault_node_and_time(self):
        dice = random.Random(1)
        for name in TRIED:
            fault, at = flight_faults.FAULTS[name], round(dice.uniform(0.9, 1.3), 3)
            # A sanitizer takes the signal of a crash for itself.
            if not flight_faults.can_run(fault) or (IS_SANITIZED and name == "segv"):
                continue
            with self.subTest(fault=name), tempfile.TemporaryDirectory(dir=self.folder) as folder:
                file, at = flight_faults.break_a_run(fault, at, pathlib.Path(folder), self.shared)
                self.assertEqual(flight_faults.names_it(fault, at, flight_faults.head_of(file)), "")

    def write_graph(self, live="flight: keep"):
        text = flight_faults.graph_of(flight_faults.Fault((), ""), 0).replace("flight: keep", live)
        return self.write("wall.yaml", text.replace("duration: 2.5 s", "duration: 0.6 s"))

    def test_a_kept_file_is_shown_as_text_json_csv_and_page(self):
        self.run_ok("run", self.write_graph(), "--out", self.folder / "out")
        file = self.folder / "out/flight.ring"
        self.assertEqual(list(flight_faults.flight_files(self.shared)), [], "the file has been moved beside the results")
        text = self.run_ok("flight", self.folder / "out").stdout
        self.assertIn("the run ended well", text)
        self.assertRegex(text, r"ticks of device round")
        page, copy = self.folder / "page.html", self.folder / "copy.ring"
        lines = self.run_ok("flight", file, "--json", "--html", page, "--save", copy).stdout.splitlines()
        head, rows = json.loads(lines[0]), [json.loads(line) for line in lines[1:]]
        self.assertEqual(copy.read_bytes(), file.read_bytes())
        self.assertIn("device.force", page.read_text())
        self.assertEqual(head["torn"], 0)
        self.assertEqual(head["graph"], "wall")
        ticks = [row for row in rows if row["kind"] == "device"]
        self.assertGreater(len(ticks), 100)
        self.assertEqual([row["time_s"] for row in rows], sorted(row["time_s"] for row in rows))
        # What the file has of the device is what the recording would have: z comes down from 6 mm.
        heights = [tick["p_WD"][2] for tick in ticks]
        self.assertEqual([None in tick["p_WD"] for tick in ticks], [tick["sample_age"] is None for tick in ticks])
        self.assertAlmostEqual(next(z for z in heights if z is not None), 6e-3, delta=1e-3)
        self.assertLess(heights[-1], 5e-3)
        table = list(csv.reader(io.StringIO(self.run_ok("flight", file, "--csv").stdout)))
        self.assertEqual(len(table) - 1, len(rows))
        self.assertEqual({len(row) for row in table}, {len(table[0])})

    def test_a_good_run_leaves_no_file_where_none_is_asked_for(self):
        for live in ("flight: auto", "flight: off"):
            self.run_ok("run", self.write_graph(live), "--out", self.folder / "out", "--overwrite")
            self.assertFalse((self.folder / "out/flight.ring").exists())
            self.assertEqual(list(flight_faults.flight_files(self.shared)), [])

    def test_a_run_that_goes_on_is_looked_at_by_its_process_and_a_killed_one_without_a_name(self):
        graph = self.write("wall.yaml", self.write_graph().read_text().replace("duration: 0.6 s", "duration: 1000 s"))
        process = subprocess.Popen([TACTOR, "run", graph, "--out", self.folder / "out"], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   env={**flight_faults.os.environ, **self.environment})
        self.addCleanup(lambda: process.poll() is None and process.kill())

        def is_told():
            return "the run goes on" in tactor("flight", "--of", process.pid, environment=self.environment).stdout
        self.wait_until(is_told, process, "its flight file was there")
        process.send_signal(signal.SIGKILL)
        process.wait()
        time.sleep(0.05)
        shown = self.run_ok("flight").stdout
        self.assertRegex(shown, r"^killed, the process, ")
        self.assertIn(f"process {process.pid}", shown)

    def test_what_is_no_flight_file_is_refused_with_its_name(self):
        other = self.write("other.ring", "x" * 5000)
        for arguments, says in (((other,), r"other\.ring: expected a flight file, found something else"),
                                ((self.folder / "nowhere.ring",), r"nowhere\.ring"),
                                ((), "expected a flight file, found none"),
                                (("--of", 1), "--of 1: expected a process with a flight recorder, found none"),
                                ((other, "--json", "--csv"), "excludes")):
            with self.subTest(arguments=arguments):
                result = tactor("flight", *arguments, environment=self.environment)
                self.assertEqual(result.returncode, 2, result.stdout + result.stderr)
                self.assertRegex(result.stderr, says)

    def test_a_file_of_another_layout_names_the_version_that_reads_it(self):
        self.run_ok("run", self.write_graph(), "--out", self.folder / "out")
        file = self.folder / "out/flight.ring"
        file.write_bytes(file.read_bytes().replace(b"lateness", b"lateMess"))
        result = tactor("flight", file, environment=self.environment)
        self.assertEqual(result.returncode, 2)
        self.assertRegex(result.stderr, r"flight\.ring: tactor \S+ wrote it, whose records have another layout.*; read it with tactor")


if __name__ == "__main__":
    unittest.main()
