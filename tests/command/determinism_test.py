"""Same graph and seed give the same bytes; a debug and a release build agree on every event."""
import json
import os
import pathlib
import unittest

import h5py
import numpy

from harness import GRAPHS, CommandTest, needs_meshes, needs_hdf5
from recorded import recorded

DURATION = {"duck": "1.5", "peg_in_hole": "3.5", "bunny": "1.2"}
RECORD = "record: [device.state, device.interpolated, device.commanded, device.safety, collision.contacts, dynamics.state, coupling.force, prediction.forecast, interpolation.segment]\n"


@needs_meshes
class Determinism(CommandTest):
    def recording(self, scene, seed, out, **options):
        """A run into contact. Without metrics there is no reference run to wait for."""
        graph = self.write(f"{scene}.yaml", f"extends: {GRAPHS / scene / 'refit.yaml'}\nnodes: {{metrics: ~}}\n{RECORD}")
        self.run_graph(graph, "--duration", DURATION[scene], "--seed", str(seed), out=f"{scene}_{out}", **options)
        return self.folder / f"{scene}_{out}" / "recording.h5"

    @needs_hdf5
    def test_the_same_seed_gives_the_same_bytes_and_another_does_not(self):
        for scene in ("duck", "peg_in_hole", "bunny"):
            with self.subTest(scene=scene):
                # No message of a difference: it would be of megabytes.
                first = recorded(self.recording(scene, 3, "a"))
                self.assertTrue(first == recorded(self.recording(scene, 3, "b")))
                self.assertFalse(first == recorded(self.recording(scene, 4, "c")))

    def test_two_runs_in_one_process_agree(self):
        out = self.folder / "cmp"
        graph = GRAPHS / "peg_in_hole/refit.yaml"
        self.run_ok("compare", graph, graph, "--seeds", "2", "--duration", "0.6", "--judge", "whole", "--out", out)
        a, b = json.loads((out / "compare.json").read_text())["graphs"]
        for name, metric in a["metrics"].items():
            if not name.startswith(("cost_us", "cpu", "method_us")):
                self.assertEqual(metric, b["metrics"][name], name)

    @needs_hdf5
    def test_a_debug_build_makes_the_same_events(self):
        debug = pathlib.Path(os.environ.get("TACTOR_DEBUG_BUILD", ""))
        if not debug.is_file():
            self.skipTest("no debug build beside this one (scripts/build checked tactor_pipelines)")
        self.environment["TACTOR_MESH_PATH"] = os.environ["TACTOR_BUILD"] + "/meshes"
        for scene in ("duck", "peg_in_hole", "bunny"):
            with self.subTest(scene=scene):
                with h5py.File(self.recording(scene, 5, "release")) as release, \
                        h5py.File(self.recording(scene, 5, "debug", program=str(debug))) as checked:
                    self.assertEqual(sorted(release["streams"]), sorted(checked["streams"]))
                    self.assertGreater(max(release["streams/collision.contacts/data"]["penetrating"]), 0)
                    for stream in release["streams"]:
                        a = release["streams"][stream]["data"][...]
                        b = checked["streams"][stream]["data"][...]
                        self.assertEqual(len(a), len(b), stream)
                        for column in a.dtype.names:
                            if numpy.issubdtype(a.dtype[column].base, numpy.integer):
                                numpy.testing.assert_array_equal(a[column], b[column], f"{stream}.{column}")


if __name__ == "__main__":
    unittest.main()
