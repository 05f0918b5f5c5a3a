"""What the tests of the Python package share with those of the command."""
import os
import pathlib
import sys
import unittest
import warnings

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/command"))
BUILD = pathlib.Path(os.environ.setdefault("TACTOR_BUILD", str(ROOT / "build/release")))
sys.path.insert(0, str(BUILD / "python"))
from harness import (EDGES_OF_A_SMALL_GRAPH, IS_SANITIZED, METRICS_OF_A_SMALL_GRAPH, SCAN_SCENE, SCANS,  # noqa: E402, F401
                     CommandTest, needs_devices, needs_hdf5, needs_live, tactor as command)

if IS_SANITIZED:
    print("a Python that is not sanitized cannot load a library that is")
    sys.exit(77)
import tactor  # noqa: E402

# A ball that is led onto a wall: no mesh, all roles, milliseconds a run.
WALL = str(ROOT / "graphs/wall/refit.yaml")


class PackageTest(CommandTest):
    def setUp(self):
        super().setUp()
        # Reference runs are kept apart from the user's.
        os.environ["TACTOR_CACHE"] = self.environment["TACTOR_CACHE"]
        warnings.simplefilter("ignore", tactor.InputWarning)

    def refused(self, kind, work, *arguments, **options):
        """The text of the exception that `work` raises."""
        with self.assertRaises(kind) as caught:
            work(*arguments, **options)
        return str(caught.exception)


if __name__ == "__main__":
    unittest.main()
