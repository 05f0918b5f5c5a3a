"""A run in virtual time gives the same bytes on a processor of 2008 as on this one: the command under an emulated Nehalem, which has
neither AVX nor fused multiply-add."""
import concurrent.futures
import json
import os
import pathlib
import platform
import shutil
import subprocess
import unittest

from harness import GRAPHS, IS_SANITIZED, LONGEST_RUN, TACTOR, CommandTest, needs_hdf5, needs_meshes, tactor
from recorded import recorded

EMULATOR = "qemu-x86_64"
OLD_PROCESSOR = "Nehalem"
# What is of the machine: times and memory.
OF_THE_MACHINE = {"cost_us", "cpu_s", "wall_s", "realtime_factor", "peak_memory_MB", "provenance"}
RECORDED = ["device.state", "device.commanded", "dynamics.state", "coupling.force", "interpolation.segment"]
LOCAL = RECORDED[:-1]


def graph(base, record, extra=""):
    return f"extends: {base}\nrecord: [{', '.join(record)}]\n{extra}"


def without_the_machine(value):
    if isinstance(value, dict):
        return {key: without_the_machine(inner) for key, inner in value.items() if key not in OF_THE_MACHINE}
    return [without_the_machine(inner) for inner in value] if isinstance(value, list) else value


@unittest.skipIf(shutil.which(EMULATOR) is None, f"{EMULATOR} of Debian's qemu-user is not installed")
@unittest.skipIf(platform.machine() != "x86_64", "another processor architecture")
@unittest.skipIf(IS_SANITIZED, "sanitizers do not run under an emulator")
class Processors(CommandTest):
    def old(self, *arguments, cache):
        environment = dict(os.environ, TACTOR_CACHE=str(cache))
        return subprocess.run([EMULATOR, "-cpu", OLD_PROCESSOR, TACTOR, *map(str, arguments)], capture_output=True, text=True,
                              env=environment, timeout=LONGEST_RUN, check=False)

    def both(self, name, text, duration, *options):
        """Runs a graph here and there, each with a reference run of its own. Distances of meshes, which take an emulator minutes,
        are made once; another test compares those of a small mesh."""
        path = self.write(f"{name}.yaml", text)
        caches = [self.folder / f"{name}_cache", self.folder / f"{name}_old_cache"]
        outs = [self.folder / f"{name}_out", self.folder / f"{name}_old_out"]
        words = [("run", path, "--duration", duration, *options, "--out", out) for out in outs]
        self.done(tactor(*words[0], environment={"TACTOR_CACHE": str(caches[0])}))
        caches[0].mkdir(exist_ok=True)
        shutil.copytree(caches[0], caches[1], ignore=shutil.ignore_patterns("*.ref", "*.warm"))
        self.done(self.old(*words[1], cache=caches[1]))
        return caches, outs

    def done(self, result):
        self.assertEqual(result.returncode, 0, f"{result.stdout}\n{result.stderr}")

    def same(self, name, caches, outs):
        here, there = (without_the_machine(json.loads((out / "summary.json").read_text())) for out in outs)
        self.assertFalse(here["reference_run"]["cached"] or there["reference_run"]["cached"], name)
        self.assertGreater(here["contacts"]["max"], 0, name)
        self.assertEqual(here, there, name)
        here, there = (recorded(out / "recording.h5") for out in outs)
        self.assertTrue(here == there, f"{name}: the recordings differ")
        # A reference run that follows the run under test is not kept.
        references = [[file.read_bytes() for file in sorted(cache.glob("*.ref"))] for cache in caches]
        self.assertEqual(*references, f"{name}: the reference runs differ")

    @needs_meshes
    @needs_hdf5
    def test_runs_give_the_same_bytes(self):
        cases = [
            ("wall_refit", graph(GRAPHS / "wall/refit.yaml", RECORDED), "6 s"),
            ("wall_closed_loop", graph(GRAPHS / "wall/closed_loop.yaml", RECORDED), "1 s"),
            ("gel_local", graph(GRAPHS / "gel_cube/local.yaml", LOCAL, """
scene: {bodies: {gel: {tetrahedra: 60}}}
nodes: {dynamics: {solver: portable}}
"""), "0.3 s"),
            ("bunny_refit", graph(GRAPHS / "bunny/refit.yaml", RECORDED), "0.6 s"),
            ("peg_local", graph(GRAPHS / "peg_in_hole/local.yaml", LOCAL), "2 s"),
            ("duck_texture", graph(GRAPHS / "duck/refit.yaml", RECORDED), "0.8 s", "--over", GRAPHS / "renderers/impact_and_texture.yaml"),
        ]
        # Two at a time; the emulator has one thread for each of the program.
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            results = {case[0]: pool.submit(self.both, *case) for case in cases}
        for name, result in results.items():
            with self.subTest(name):
                self.same(name, *result.result())

    @needs_meshes
    def test_a_body_is_filled_with_the_same_tetrahedra(self):
        """CGAL repairs the mesh and fills it; both are kept in the cache."""
        text = f"""extends: {GRAPHS / "gel_cube/scene.yaml"}
scene:
  bodies:
    gel: {{box: ~, mesh: transfer/bowl_tool.off, tetrahedra: 300, fixed: {{behind: {{p: [0, 0, 0], n: [0, 0, 1]}}}}}}
nodes: {{dynamics: {{solver: portable}}}}
"""
        path = self.write("filled.yaml", text)
        caches = [self.folder / "here", self.folder / "there"]
        words = ("run", path, "--duration", "0.05 s", "--overwrite", "--out", self.folder / "filled")
        self.done(tactor(*words, environment={"TACTOR_CACHE": str(caches[0])}))
        self.done(self.old(*words, cache=caches[1]))
        files = [{file.name: file.read_bytes() for file in cache.iterdir() if file.suffix != ".hashes"} for cache in caches]
        self.assertEqual({pathlib.Path(name).suffix for name in files[0]}, {".mesh", ".tetrahedra", ".ref"})
        self.assertEqual(*files)


if __name__ == "__main__":
    unittest.main()
