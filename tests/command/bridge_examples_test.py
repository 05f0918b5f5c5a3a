"""The clients of examples/bridge, each against the bridge: all compute the same ball."""
import csv
import importlib.util
import io
import json
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

from bridge_client import EXAMPLE, Ball, Bridge
from harness import HAS_LIVE, PATIENCE, ROOT, CommandTest, needs_hdf5, needs_live

BUILD = pathlib.Path(os.environ.get("TACTOR_BUILD", ROOT / "build/release"))
CPP = BUILD / "tests/bridge_ball"
POSITION = 1e-9  # m, between clients that round differently


@needs_hdf5
class Examples(CommandTest):
    def bridge(self, *options, out="out"):
        bridge = Bridge(EXAMPLE / "graph.yaml", "--out", self.folder / out, *options, environment=self.environment)
        self.addCleanup(bridge.end)
        return bridge

    def heights(self, out):
        """m, of the ball by time."""
        text = self.run_ok("export", self.folder / out / "recording.h5", "physics.state").stdout
        return {row["valid_s"]: float(row["p_WT_z [m]"]) for row in csv.DictReader(io.StringIO(text))}

    def check_client(self, *words):
        virtual = ("--set", "clock=virtual", "--duration", "1.5 s")
        ours = self.bridge(*virtual, out="ours")
        ours.client().play(Ball())
        self.assertEqual(ours.wait(), 0, ours.told)
        theirs = self.bridge(*virtual, out="theirs")
        done = subprocess.run([*map(str, words), theirs.url], capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(theirs.wait(), 0, theirs.told)
        expected, found = self.heights("ours"), self.heights("theirs")
        self.assertEqual(list(found), list(expected))
        self.assertGreater(len(found), 140)
        for time, height in expected.items():
            self.assertAlmostEqual(found[time], height, delta=POSITION)
        # It rests in the plane, where the springs of plane and hand balance.
        self.assertLess(min(found.values()), 0.004)
        self.assertGreater(min(found.values()), 0.002)

    def check_live(self, *words):
        bridge = self.bridge("--duration", "3 s", out="live")
        done = subprocess.run([*map(str, words), bridge.url], capture_output=True, text=True, timeout=PATIENCE, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(bridge.wait(), 0, bridge.told)
        figures = json.loads((self.folder / "live/bridge.json").read_text())
        self.assertGreater(figures["results"], 20)
        self.assertEqual(figures["refused"], 0)

    @unittest.skipUnless(importlib.util.find_spec("websockets"), "python3-websockets is not installed")
    def test_python(self):
        self.check_client(sys.executable, EXAMPLE / "ball.py")

    @needs_live
    @unittest.skipUnless(importlib.util.find_spec("websockets"), "python3-websockets is not installed")
    def test_python_live(self):
        self.check_live(sys.executable, EXAMPLE / "ball.py")

    @unittest.skipUnless(CPP.exists(), "the client in C++ is not built")
    def test_cpp(self):
        self.check_client(CPP)

    @needs_live
    @unittest.skipUnless(CPP.exists(), "the client in C++ is not built")
    def test_cpp_live(self):
        self.check_live(CPP)

    @unittest.skipUnless(shutil.which("mcs") and shutil.which("mono"), "mono-mcs is not installed")
    def test_csharp(self):
        program = self.folder / "ball.exe"
        subprocess.run(["mcs", f"-out:{program}", EXAMPLE / "ball.cs"], check=True, timeout=PATIENCE)
        self.check_client("mono", program)
        if HAS_LIVE:
            self.check_live("mono", program)


if __name__ == "__main__":
    unittest.main()
