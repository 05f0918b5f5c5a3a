"""Recordings of real runs: read by h5py, exported, replayed, and readable after a kill."""
import csv
import io
import os
import signal
import subprocess
import time
import unittest

import h5py
import numpy

from harness import GRAPHS, ROOT, TACTOR, CommandTest, needs_collision, needs_hdf5

RECORDED = "record: [device.state, device.commanded, coupling.force, prediction.forecast]\n"
TELEOPERATION = ROOT.parent / "shared/data/tue_1dof_teleop"


@needs_hdf5
class Recordings(CommandTest):
    def recorded_run(self):
        graph = self.write("recorded.yaml", f"extends: {GRAPHS / 'peg_in_hole_refit.yaml'}\n{RECORDED}")
        self.run_graph(graph, "--duration", "3")
        return self.folder / "out" / "recording.h5"

    @needs_collision
    def test_h5py_reads_stamps_values_units_frames_and_the_graph(self):
        with h5py.File(self.recorded_run()) as file:
            data = file["streams/device.commanded/data"]
            self.assertEqual(len(data), 3000)
            numpy.testing.assert_array_equal(data["valid_ns"], numpy.arange(3000) * 1_000_000)
            attributes = data.attrs if "message_type" in data.attrs else file["streams/device.commanded"].attrs
            text = " ".join(str(v) for v in attributes.values())
            self.assertIn("Wrench", text)
            self.assertIn("N m", text)
            self.assertTrue(any("prediction.ar" in str(v) for v in file.attrs.values()))

    @needs_collision
    def test_the_csv_export_says_what_the_file_says(self):
        recording = self.recorded_run()
        text = self.run_ok("export", recording, "coupling.force").stdout
        rows = list(csv.DictReader(io.StringIO(text)))
        with h5py.File(recording) as file:
            data = file["streams/coupling.force/data"][...]
        self.assertEqual(len(rows), len(data))
        for row, entry in list(zip(rows, data))[::17]:
            self.assertEqual(float(row["force_z [N]"]), entry["force"][2])
            self.assertEqual(float(row["torque_x [N m]"]), entry["torque"][0])

    @needs_collision
    def test_a_replayed_force_is_predicted_as_it_was(self):
        recording = self.recorded_run()
        graph = self.write("replay.yaml", f"""
clock: virtual
duration: 3 s
scene: {{bodies: {{tool: {{sphere: {{radius: 1 mm}}, motion: rigid}}}}}}
nodes:
  recording: {{type: source.recording, file: {recording}, stream: coupling.force}}
  refit: {{type: prediction.refit}}
  prediction: {{type: prediction.ar}}
edges:
  - recording.force -> refit.force
  - recording.force -> prediction.force: queue(64, drop_oldest)
  - refit.coefficients -> prediction.coefficients
record: [recording.force, prediction.forecast]
""")
        self.run_graph(graph, out="replay")
        with h5py.File(recording) as file:
            force = file["streams/coupling.force/data"][...]
            forecast = file["streams/prediction.forecast/data"][...]
        with h5py.File(self.folder / "replay" / "recording.h5") as file:
            force_again = file["streams/recording.force/data"][...]
            forecast_again = file["streams/prediction.forecast/data"][...]
        n = min(len(force), len(force_again))
        self.assertGreaterEqual(n, len(force) - 1)
        numpy.testing.assert_array_equal(force["valid_ns"][:n], force_again["valid_ns"][:n])
        numpy.testing.assert_array_equal(force["force"][:n], force_again["force"][:n])
        n = min(len(forecast), len(forecast_again))
        self.assertGreater(n, 100)
        numpy.testing.assert_array_equal(forecast["predicted"][:n], forecast_again["predicted"][:n])

    @needs_collision
    def test_a_killed_run_leaves_a_readable_file(self):
        graph = self.write("long.yaml", f"extends: {GRAPHS / 'duck_off.yaml'}\nrecord: [device.state, device.commanded]\n")
        out = self.folder / "killed"
        process = subprocess.Popen([TACTOR, "run", graph, "--duration", "100000", "--out", out],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   env=dict(os.environ, **self.environment))
        recording = out / "recording.h5"
        self.wait_until(lambda: recording.exists() and recording.stat().st_size > 2_000_000, process,
                        "the recording had some length")
        # Some flushes later, which come every half second.
        time.sleep(2)
        process.send_signal(signal.SIGKILL)
        process.wait(timeout=30)
        text = self.run_ok("export", recording, "device.state").stdout
        self.assertGreater(len(text.splitlines()), 1000)
        with h5py.File(out / "recording.h5", swmr=True) as file:
            self.assertEqual(len(file["streams/device.state/data"]), len(text.splitlines()) - 1)
        self.run_ok("mend", out / "recording.h5")
        with h5py.File(out / "recording.h5") as file:
            self.assertEqual(len(file["streams/device.state/data"]), len(text.splitlines()) - 1)

    @unittest.skipUnless(TELEOPERATION.is_dir(), "the recordings in shared/data are not here")
    def test_a_real_recording_is_predicted(self):
        import gzip
        data = self.folder / "rigid.csv"
        data.write_bytes(gzip.decompress((TELEOPERATION / "m2_question1a_rigid.csv.gz").read_bytes()))
        graph = self.write("teleoperation.yaml", f"""
clock: virtual
duration: 2 s
scene: {{bodies: {{tool: {{sphere: {{radius: 1 mm}}, motion: translation}}}}}}
nodes:
  recording:
    type: source.recording
    file: {data}
    begin: at_zero
    columns: {{time: "t_s [s]", force.x: "Fe_Nm [N m] / 0.075 m"}}
  prediction: {{type: prediction.linear}}
edges:
  - recording.force -> prediction.force: queue(64, drop_oldest)
record: [recording.force, prediction.forecast]
""")
        self.run_graph(graph, out="teleoperation")
        with h5py.File(self.folder / "teleoperation" / "recording.h5") as file:
            self.assertGreater(len(file["streams/recording.force/data"]), 1000)


if __name__ == "__main__":
    unittest.main()
