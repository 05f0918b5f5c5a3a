"""Messages of a library that is not this repository's: recorded, exported, imported, replayed and described."""
import json
import pathlib
import os
import unittest

import h5py
import numpy

from harness import SCAN_SCENE, SCANS, CommandTest, needs_hdf5, tactor

NODES = pathlib.Path(os.environ["TACTOR_BUILD"]) / "tests/nodes"
REPLAY = f"""{SCAN_SCENE}
nodes:
  replay: {{type: source.recording, file: %s, stream: scanner.scan}}
  judge: {{type: scan.judge}}
edges: [replay.message -> judge.scan]
record: [replay.message]
"""


def same(a, b):
    """True where two recorded streams of scans hold the same, apart from when they became visible."""
    rows = [group["data"][...] for group in (a, b)]
    names = [name for name in rows[0].dtype.names if name not in ("produced_ns",)]
    return (len(rows[0]) == len(rows[1]) and all((rows[0][name] == rows[1][name]).all() for name in names)
            and list(a["arrays"]) == list(b["arrays"])
            and all((a["arrays"][name][...] == b["arrays"][name][...]).all() for name in a["arrays"]))


@needs_hdf5
class ForeignMessages(CommandTest):
    def setUp(self):
        super().setUp()
        os.environ["TACTOR_NODE_PATH"] = str(NODES)
        self.addCleanup(os.environ.pop, "TACTOR_NODE_PATH")

    def recorded(self):
        summary = self.run_graph(self.write("source.yaml", SCANS), out="source")
        self.assertEqual((summary["good_scans"], summary["bad_scans"]), (100, 0))
        return self.folder / "source/recording.h5"

    def check_replay(self, recording):
        summary = self.run_graph(self.write("replay.yaml", REPLAY % recording), out="replay")
        self.assertEqual((summary["good_scans"], summary["bad_scans"]), (100, 0))
        with h5py.File(recording) as first, h5py.File(self.folder / "replay/recording.h5") as second:
            self.assertTrue(same(first["streams/scanner.scan"], second["streams/replay.message"]))

    def test_another_program_reads_records_enumerations_and_arrays(self):
        with h5py.File(self.recorded()) as file:
            stream = file["streams/scanner.scan"]
            rows, points = stream["data"][...], stream["arrays/points"][...]
            self.assertEqual(h5py.check_enum_dtype(rows.dtype["quality"]), {"good": 0, "dusty": 7, "blind": 200})
            self.assertEqual(json.loads(stream.attrs["description"])["frame"], "S")
        n = numpy.arange(100)
        numpy.testing.assert_array_equal(rows["turn"], n)
        numpy.testing.assert_array_equal(rows["last"], -n)
        numpy.testing.assert_array_equal(rows["quality"], numpy.array([0, 7, 200])[n % 3])
        numpy.testing.assert_array_equal(rows["bounds"][:, 2, 1], n / 6)
        numpy.testing.assert_array_equal(rows["points"]["count"], n % 6)
        numpy.testing.assert_array_equal(rows["points"]["first"], numpy.cumsum(n % 6) - n % 6)
        x = numpy.concatenate([numpy.arange(k % 6) + 0.1 * k for k in n])
        numpy.testing.assert_array_equal(points["p_SP"][:, 0], x)
        numpy.testing.assert_array_equal(points["brightness"], x.astype(numpy.float32) / numpy.float32(3))

    def test_a_recording_is_replayed_equal(self):
        self.check_replay(self.recorded())

    def test_what_was_exported_and_imported_is_replayed_equal(self):
        recording = self.recorded()
        text = self.run_ok("export", recording, "scanner.scan").stdout
        csv = self.write("scans.csv", text)
        again = self.folder / "again.h5"
        self.run_ok("import", csv, again, "--type", "scan.Scan", "--stream", "scanner.scan")
        with h5py.File(recording) as first, h5py.File(again) as second:
            self.assertTrue(same(first["streams/scanner.scan"], second["streams/scanner.scan"]))
        self.check_replay(again)

    def test_the_schema_describes_it(self):
        types = {one["name"]: one for one in json.loads(self.run_ok("schema", "--messages").stdout)}
        self.assertIn("Wrench", types)
        fields = {one["name"]: one for one in types["scan.Scan"]["fields"]}
        self.assertEqual(fields["quality"]["enumerators"], {"good": 0, "dusty": 7, "blind": 200})
        self.assertTrue(fields["points"]["changes_size"])
        self.assertEqual(fields["bounds"]["shape"], [3, 2])
        self.assertEqual([one["unit"] for one in fields["points"]["fields"]], ["m", "1", "W/m^2"])
        self.assertEqual(types["scan.Scan"]["doc"], "One turn of a scanner.")
        self.assertEqual(fields["quality"]["doc"], "How far the turn can be trusted.")
        self.assertEqual(fields["quality"]["docs"], {"dusty": "Some points are missing."})
        self.assertEqual(fields["points"]["fields"][0]["doc"], "Position, measured from the scanner.")
        self.assertNotIn("doc", fields["turn"])

    def test_a_recording_keeps_no_sentence(self):
        with h5py.File(self.recorded()) as file:
            self.assertNotIn("doc", str(file["streams/scanner.scan"].attrs["description"]))

    def test_a_stream_of_another_type_is_refused_where_the_edge_is(self):
        graph = self.write("replay.yaml", (REPLAY % self.recorded()).replace(
            "judge: {type: scan.judge}", "judge: {type: prediction.hold}").replace("judge.scan", "judge.force"))
        self.assertIn("replay.message (scan.Scan) cannot feed judge.force (Wrench)", self.bad("run", graph))

    def test_bad_imports_leave_nothing_behind(self):
        csv = self.write("bad.csv", "valid_s,produced_s,sequence,force_x [N]\n0,0,0,1\n")
        again = self.folder / "again.h5"
        self.assertIn('did you mean "Wrench"', self.bad("import", csv, again, "--type", "Wrenhc", "--stream", "a.b"))
        self.assertIn("bad.csv:1: messages Wrench need a column", self.bad("import", csv, again, "--type", "Wrench", "--stream", "a.b"))
        self.assertIn("--stream", self.bad("import", csv, again, "--type", "Wrench", "--stream", "a/b"))
        self.assertFalse(again.exists())

    def bad(self, *arguments):
        result = tactor(*arguments)
        self.assertEqual(result.returncode, 2, result.stderr)
        return result.stderr


if __name__ == "__main__":
    unittest.main()
