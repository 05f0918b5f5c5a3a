"""Experiments with a simulated observer: from the graph to the table, through a crash and a replay, and nothing told."""
import csv
import json
import os
import re
import signal
import subprocess
import time
import unittest

from harness import GRAPHS, TACTOR, CommandTest, needs_hdf5, needs_live

# No scene: what is felt is a constant force, so that a trial costs a millisecond.
STUDY = """
format: 2
clock: virtual
duration: 3600 s
scene: {bodies: {}}
nodes:
  gain: {type: interpolation.gain, factor: 0, ramp: 20 ms}
  source: {type: source.physics, force: [2, 0, 0]}
"""
SHORT = ("protocol.interval=0.1 s", "protocol.change=0.15 s", "observer.response_time=30 ms")


def rows_of(file):
    with open(file, newline="") as table:
        return list(csv.DictReader(table))


class Experiment(CommandTest):
    SIMULATED = GRAPHS / "experiments/simulated.yaml"

    def options(self, folder, participant, *settings):
        settings = (f"protocol.folder={folder}", f"protocol.participant={participant}", "device.rate=1000", *SHORT, *settings)
        return [word for setting in settings for word in ("--set", setting)]

    def study(self, participant, *settings, folder=None, **options):
        return self.run_tactor("run", self.SIMULATED, "--out", self.folder / f"out_{participant}", "--overwrite",
                               *self.options(folder or self.folder / "tables", participant, *settings), **options)
