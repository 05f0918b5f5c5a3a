"""Messages with everything that one may hold, through taps, feeds and recordings; recordings as h5py reads them."""
import os
import pathlib
import pickle
import pydoc
import subprocess
import sys
import unittest

import numpy

from package_harness import BUILD, SCAN_SCENE, SCANS, WALL, PackageTest, needs_hdf5, tactor

os.environ["TACTOR_NODE_PATH"] = str(BUILD / "tests/nodes")  # a library with message types of its own
FED = f"""{SCAN_SCENE}
nodes:
  hand: {{type: source.feed, message: scan.Scan}}
  judge: {{type: scan.judge}}
edges: [hand.message -> judge.scan]
record: [hand.message]
"""


def same(test, a, b, path=""):
    """Both hold the same, down to the elements of arrays that change size."""
    test.assertEqual(a.dtype.names, b.dtype.names, path)
    for name in a.dtype.names:
        if a.dtype[name].base.names:
            same(test, a[name], b[name], f"{path}{name}.")
        elif a.dtype[name].base == object:
            for one, other in zip(a[name].reshape(-1), b[name].reshape(-1)):
                test.assertEqual(len(one), len(other), path + name)
                if one.dtype.names:
                    same(test, one, other, f"{path}{name}.")
                else:
                    numpy.testing.assert_array_equal(one, other, path + name)
        else:
            numpy.testing.assert_array_equal(a[name], b[name], path + name)


@needs_hdf5
class Meaning(PackageTest):
    def help_of(self, type):
        """As `help(type)` prints it, on as few lines as it has sentences."""
        return " ".join(pydoc.render_doc(type, renderer=pydoc.plaintext).split())

    def test_help_on_the_type_of_a_feed_tells_unit_frame_and_meaning_of_each_field(self):
        graph = self.write("graph.yaml", f"""{SCAN_SCENE}
nodes:
  hand: {{type: source.feed, message: Target}}
  contacts: {{type: source.feed, message: ContactSet}}
  gate: {{type: source.feed, message: SafetyState}}
record: [hand.message, contacts.message, gate.message]
""")
        with tactor.Session(graph) as session:
            target = session.feed("hand").type
            self.assertEqual(target.field("v_WH").doc, "Velocity of the origin of H.")
            self.assertIn("<tactor.MessageType Target> Target: The pose and velocity", self.help_of(target))
            self.assertIn("v_WH (f64 [3], m/s, in W) Velocity of the origin of H.", self.help_of(target))
            said = self.help_of(session.feed("contacts").type)
            self.assertIn("contact.p_TC (f64 [3], m, in T) Contact point of the moving body", said)
            self.assertIn("pair (ContactPair [128]) The two bodies of a contact", said)
            gate = session.feed("gate").type
            self.assertEqual(gate.field("cause").value_docs["dead_man"], "The dead-man button was released.")
            self.assertIn("stale = 7: No fresh segment has come for too long.", self.help_of(gate))
            for type in (target, gate, session.feed("contacts").type):
                self.assertEqual(str(type), type.__doc__)
                for path, field in type.leaves():
                    self.assertRegex(field.doc, r"\.$", f"{type.name}.{path}")

    def test_what_a_type_says_is_no_part_of_what_it_is(self):
        plain = '{"name": "my.Thing", "frame": "W", "fields": [{"name": "a", "unit": "m", "kind": "f64"%s}]%s}'
        silent = tactor.MessageType.from_json(plain % ("", ""))
        spoken = tactor.MessageType.from_json(plain % (', "doc": "Length."', ', "doc": "A thing."'))
        self.assertEqual(silent, spoken)
        self.assertEqual(str(silent), "my.Thing\n\nFields:\n    a (f64, m)")
        self.assertEqual(str(spoken), "my.Thing: A thing.\n\nFields:\n    a (f64, m)\n        Length.")
        self.assertEqual(str(pickle.loads(pickle.dumps(spoken))), str(spoken))

    @unittest.skipUnless((BUILD / "tests/nodes/libtactor_scan.so").exists(), "the library of scans is not built")
    def test_types_of_other_libraries_say_theirs(self):
        with tactor.Session(self.write("fed.yaml", FED)) as session:
            said = self.help_of(session.feed("hand").type)
        self.assertIn("scan.Scan: One turn of a scanner.", said)
        self.assertIn("quality (u8) How far the turn can be trusted. good = 0 dusty = 7: Some points are missing.", said)
        self.assertIn("points.p_SP (f64 [3], m, in S) Position, measured from the scanner.", said)


@needs_hdf5
class Recordings(PackageTest):
    def recorded(self, text, **options):
        return tactor.run(self.write("graph.yaml", text), out=self.folder / "out", **options)

    def test_streams_are_those_that_h5py_reads(self):
        import h5py
        recording = self.recorded(f"extends: {WALL}\nduration: 1 s\nrecord: [coupling.force, device.state, collision.contacts]\n").recording
        self.assertEqual(list(recording), ["collision.contacts", "coupling.force", "device.state"])
        with h5py.File(recording.path) as file:
            for name, stream in recording.items():
                rows = file[f"streams/{name}/data"][...]
                self.assertEqual(stream[:].dtype, rows.dtype)
                self.assertEqual(stream[:].tobytes(), rows.tobytes())
                self.assertEqual(stream[3:9].tobytes(), rows[3:9].tobytes())
                self.assertEqual(stream[-1].tobytes(), rows[-1].tobytes())
                self.assertEqual(len(stream), len(rows))
                self.assertEqual(stream.attrs["message_type"], file[f"streams/{name}"].attrs["message_type"].decode())
        self.assertEqual(recording["coupling.force"].units["torque"], "N m")
        self.assertEqual(recording.attrs["seed"], 1)
        self.assertIn("prediction.ar", recording.graph_yaml)
        self.assertIn("it has: collision.contacts", self.refused(KeyError, lambda: recording["no.such"]))
        recording.close()

    def test_files_that_are_none_are_refused(self):
        import h5py
        self.assertIn("no.h5", self.refused(tactor.InputError, tactor.Recording, self.folder / "no.h5"))
        self.refused(tactor.InputError, tactor.Recording, self.write("text.h5", "not HDF5"))
        h5py.File(self.folder / "other.h5", "w").close()
        self.assertIn("another HDF5 file", self.refused(tactor.InputError, tactor.Recording, self.folder / "other.h5"))
        holder = "import h5py, sys; file = h5py.File(sys.argv[1], 'r+'); print('open', flush=True); sys.stdin.read()"
        with subprocess.Popen([sys.executable, "-c", holder, self.folder / "other.h5"], stdin=subprocess.PIPE,
                              stdout=subprocess.PIPE) as writer:
            self.assertEqual(writer.stdout.readline(), b"open\n")
            self.assertIn("is being written by another program",
                          self.refused(tactor.InputError, tactor.Recording, self.folder / "other.h5"))
            writer.stdin.close()

    @unittest.skipUnless((BUILD / "tests/nodes/libtactor_scan.so").exists(), "the library of scans is not built")
    def test_a_type_with_everything_is_the_same_from_tap_recording_and_feed(self):
        result = self.recorded(SCANS, taps=["scanner.scan"])
        tapped, recorded = result.taps["scanner.scan"], result.recording["scanner.scan"][:]
        self.assertGreater(len(tapped), 20)
        same(self, tapped, recorded)
        self.assertEqual(tapped.units, recorded.units)
        self.assertEqual(tapped.type, recorded.type)
        self.assertEqual(tapped.units["points.p_SP"], "m")
        self.assertEqual(tapped.units["heads.warmth"], "K")
        self.assertEqual(tapped["heads"].units, {"code": "1", "R_SH": "1", "warmth": "K"})
        self.assertEqual(tapped.type.enumerations["quality"], {"good": 0, "dusty": 7, "blind": 200})
        self.assertEqual(tapped.type.frames["bounds"], "W")
        # Closed form of the scanner: see tests/scan_nodes/scan.hpp.
        n = int(tapped[5]["turn"])
        self.assertEqual(tapped[5]["begin"], n * 1_000_003)
        numpy.testing.assert_array_equal(tapped[5]["bounds"].ravel(), n / numpy.arange(1, 7))
        self.assertEqual(tapped[5]["points"]["p_SP"].shape, (len(tapped[5]["points"]), 3))

        with tactor.Session(self.write("fed.yaml", FED)) as session:
            feed, tap = session.feed("hand"), session.tap("hand.message")
            session.start()
            for i, row in enumerate(recorded):
                value = row if i % 2 else {name: row[name] for name in row.dtype.names[3:]}
                self.assertTrue(feed.send(value, valid=float(row["valid_ns"]) * 1e-9))
                session.advance("1 ms")
            sent = tap.take()
        names = [name for name in recorded.dtype.names if name not in ("valid_ns", "produced_ns")]
        for row, came in zip(recorded, sent):
            for name in names:
                if recorded.dtype[name].base == object:
                    same(self, row[name], came[name])
                elif name != "heads":
                    numpy.testing.assert_array_equal(row[name], came[name], name)
        same(self, recorded["heads"], sent["heads"])

    @unittest.skipUnless((BUILD / "tests/nodes/libtactor_scan.so").exists(), "the library of scans is not built")
    def test_numbers_that_a_field_cannot_hold_are_refused(self):
        row = self.recorded(SCANS, taps=["scanner.scan"]).taps["scanner.scan"][3]
        whole = {name: row[name] for name in row.dtype.names[3:]}
        with tactor.Session(self.write("fed.yaml", FED)) as session:
            feed = session.feed("hand")
            session.start()
            self.assertTrue(feed.send({**whole, "quality": "dusty"}))
            for change, said in [({"turn": 256}, "turn: expected uint8"), ({"turn": -1}, "turn: expected uint8"),
                                 ({"turn": 1.5}, "turn: expected uint8"), ({"last": 1 << 31}, "last: expected int32"),
                                 ({"last": 1 << 80}, "last: expected int32"),
                                 ({"quality": 3}, "quality: expected good (0), dusty (7), blind (200), found 3"),
                                 ({"quality": "clean"}, "quality: expected good (0)"),
                                 ({"points": 3}, "points: expected elements of scan.Point"),
                                 ({"points": [3]}, "points[0]: expected a dict"),
                                 ({"heads": []}, "heads: expected 2 elements of scan.Head"),
                                 ({"heads": [{"code": [0, 0, 0], "R_SH": [0] * 4, "warmth": 3.0}] * 2},
                                  "heads[0].warmth: expected elements")]:
                with self.subTest(change=change):
                    self.assertIn(said, self.refused(tactor.InputError, feed.send, {**whole, **change}))


class Arrays(PackageTest):
    def test_units_survive_slices_masks_copies_records_and_pickling_and_no_more(self):
        force = tactor.run(WALL, duration="0.5 s", taps=["collision.contacts"], without_reference=True).taps["collision.contacts"]
        for made in (force[3:9], force[force["count"] > 0], force.copy(), force[["valid_ns", "contact"]],
                     pickle.loads(pickle.dumps(force))):
            self.assertIsInstance(made, tactor.Messages)
            self.assertEqual(made.units["contact.distance"], "m")
        self.assertEqual(force["contact"].units["stiffness"], "N/m")
        self.assertEqual(set(force[["valid_ns", "count"]].units), {"valid_ns", "count"})
        # A product of two has another unit, so that numbers alone have none.
        self.assertIs(type(force["count"]), numpy.ndarray)
        self.assertIs(type(force["contact"]["distance"] * 2), numpy.ndarray)
        numpy.testing.assert_allclose(force.time, force["valid_ns"] * 1e-9)


if __name__ == "__main__":
    unittest.main()
