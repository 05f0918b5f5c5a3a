"""Recordings of real runs: read by h5py, exported, replayed, and readable after a kill."""
import csv
import io
import os
import pathlib
import signal
import subprocess
import unittest

import h5py
import numpy

from harness import GRAPHS, ROOT, TACTOR, CommandTest, needs_meshes, needs_hdf5

RECORDED = "record: [device.state, device.commanded, coupling.force, prediction.forecast]\n"
TELEOPERATION = pathlib.Path(os.environ.get("TACTOR_DATA", ROOT.parent / "shared/data")) / "tue_1dof_teleop"


@needs_hdf5
class Recordings(CommandTest):
    def recorded_run(self):
        graph = self.write("recorded.yaml", f"extends: {GRAPHS / 'peg_in_hole/refit.yaml'}\n{RECORDED}")
        self.run_graph(graph, "--duration", "3")
        return self.folder / "out" / "recording.h5"

    @needs_meshes
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

    @needs_meshes
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

    @needs_meshes
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

    @staticmethod
    def rows_on_disk(recording):
        try:
            with h5py.File(recording, swmr=True) as file:
                return len(file["streams/device.state/data"])
        except (OSError, KeyError):  # not begun yet
            return 0

    @needs_meshes
    def test_a_killed_run_leaves_a_readable_file(self):
        graph = self.write("long.yaml", f"extends: {GRAPHS / 'duck/off.yaml'}\nrecord: [device.state, device.commanded]\n")
        out = self.folder / "killed"
        process = subprocess.Popen([TACTOR, "run", graph, "--duration", "100000", "--out", out],
                                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
                                   env=dict(os.environ, **self.environment))
        recording = out / "recording.h5"
        self.wait_until(lambda: self.rows_on_disk(recording) > 1000, process, "some thousand rows were on the disk")
        process.send_signal(signal.SIGKILL)
        process.wait(timeout=30)
        text = self.run_ok("export", recording, "device.state").stdout
        self.assertGreater(len(text.splitlines()), 1000)
        with h5py.File(out / "recording.h5", swmr=True) as file:
            self.assertEqual(len(file["streams/device.state/data"]), len(text.splitlines()) - 1)
        self.run_ok("repair", out / "recording.h5")
        with h5py.File(out / "recording.h5") as file:
            self.assertEqual(len(file["streams/device.state/data"]), len(text.splitlines()) - 1)

    @unittest.skipUnless(TELEOPERATION.is_dir(), "the recordings of tue_1dof_teleop are not here; set TACTOR_DATA")
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


class RecordedForceAsPhysics(CommandTest):
    """graphs/recorded/scene.yaml, by its own recording and by those of a rig."""

    def judged(self, *arguments):
        graph = self.write("late.yaml", f"extends: {GRAPHS / 'recorded/scene.yaml'}\nrecord: [coupling.force]\n")
        summary = self.run_graph(graph, *arguments)
        physics = summary["physics"]
        with h5py.File(self.folder / "out" / "recording.h5") as file:
            produced = file["streams/coupling.force/data"]["produced_ns"]
        # Periods of 6.7 to 20 ms, uneven, of which a rate counts ten in a row.
        periods = numpy.diff(produced)
        self.assertGreaterEqual(periods.min(), 6_700_000)
        self.assertLessEqual(periods.max(), 20_000_000)
        self.assertGreater(periods.max(), 2 * periods.min())
        rates = 10 / ((produced[10:] - produced[:-10]) * 1e-9)
        self.assertAlmostEqual(physics["rate_hz_min"], rates.min(), delta=1e-6 * rates.min())
        self.assertAlmostEqual(physics["rate_hz_max"], rates.max(), delta=1e-6 * rates.max())
        # Late, but right: the truth it is compared with is the recording it was taken from.
        self.assertEqual(physics["force"]["rms_error_N"], 0)
        self.assertGreater(summary["delivered"]["force"]["rms_error_N"], 0.01)
        # A period late, and held for one.
        self.assertGreater(summary["delivered"]["force"]["delay_ms"], 10)
        self.assertLess(summary["delivered"]["force"]["delay_ms"], 25)
        return summary

    @needs_hdf5
    def test_each_force_comes_one_period_late_and_the_next_is_taken_then(self):
        self.judged()
        with h5py.File(self.folder / "out" / "recording.h5") as file:
            data = file["streams/coupling.force/data"]
            valid, produced = data["valid_ns"][...], data["produced_ns"][...]
        # A step takes the newest force of 1 kHz, at most a millisecond old, when the one before has ended.
        begin = produced[:-1]
        self.assertTrue(((begin - valid[1:] >= 0) & (begin - valid[1:] < 1_000_000)).all())
        self.assertTrue((numpy.diff(valid) > 0).all())

    @needs_hdf5
    def test_the_seed_draws_other_periods_of_the_same_truth(self):
        one, two = (self.judged("--seed", seed) for seed in ("1", "2"))
        self.assertEqual(one["reference"], two["reference"])
        self.assertNotEqual(one["physics"], two["physics"])

    @needs_hdf5
    @unittest.skipUnless(TELEOPERATION.is_dir(), "the recordings of tue_1dof_teleop are not here; set TACTOR_DATA")
    def test_real_recordings_play_as_physics(self):
        for file in sorted(TELEOPERATION.glob("*.csv.gz")):
            with self.subTest(recording=file.name):
                summary = self.judged("--set", f"recording.file={file}", "--set", "prediction.force_max=20 N",
                                      "--duration", "4.2")
                self.assertEqual(summary["prediction"]["clamped"], 0)
                self.assertEqual(summary["device"]["clamped_ticks"] + summary["device"]["slewed_ticks"], 0)


if __name__ == "__main__":
    unittest.main()
