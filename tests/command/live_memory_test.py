"""A live run that records everything takes no more memory the longer it is."""
import os
import re
import subprocess
import time
import unittest

from harness import GRAPHS, IS_SANITIZED, TACTOR, CommandTest, needs_meshes, needs_hdf5, needs_live

GRAPH = f"""extends: {GRAPHS / 'wall/refit.yaml'}
clock: real
nodes: {{metrics: ~}}
record: [trajectory.target, device.state, device.commanded, device.safety, device.interpolated, collision.contacts,
         dynamics.state, coupling.force, coupling.parameters, refit.coefficients, prediction.forecast, interpolation.segment]
"""
WARM, LATER = 10, 40  # s after the start
MOST = 400  # KiB: three steps of the heap, for the indices of the recording; this graph once grew by 17 KiB a second


@needs_live
@needs_meshes
@needs_hdf5
@unittest.skipIf(IS_SANITIZED, "a sanitizer keeps freed memory")
class Memory(CommandTest):
    def test_a_live_run_with_everything_recorded_grows_no_more_when_it_is_warm(self):
        process = subprocess.Popen([TACTOR, "run", self.write("all.yaml", GRAPH), "--duration", "1000", "--out",
                                    self.folder / "out"], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                   env=dict(os.environ, **self.environment))
        self.addCleanup(lambda: process.poll() is None and process.kill())
        sizes = []
        for seconds in (WARM, LATER - WARM):
            time.sleep(seconds)
            with open(f"/proc/{process.pid}/status", encoding="ascii") as status:
                sizes.append(int(re.search(r"RssAnon:\s*(\d+) kB", status.read()).group(1)))
        process.terminate()
        _, stderr = process.communicate(timeout=60)
        self.assertEqual(process.returncode, 0, stderr)
        self.assertLess(sizes[1] - sizes[0], MOST, sizes)


if __name__ == "__main__":
    unittest.main()
