"""prediction.linear once more, in Python: the same forecasts, to the byte (a test compares them)."""

import math
from typing import Any

import numpy as np

import tactor


class Linear(tactor.Node):
    """Extrapolates the last two forces in time."""

    role = "prediction"
    force = tactor.Input("Wrench", trigger=True, queue=64, doc="the physics force on the device")
    forecast = tactor.Output("Forecast", doc="the force and what is expected at the next physics periods")
    steps = tactor.Parameter(3, min=1, max=4, doc="physics periods that are predicted")
    period_initial = tactor.Parameter(0.01, unit="s", min=0, doc="the period before there are two samples")
    period_max = tactor.Parameter(0.1, unit="s", min=0, doc="a longer interval counts as this long")
    force_max = tactor.Parameter(8.0, unit="N", min=0, doc="forces are shortened to the device's largest")

    def __init__(self) -> None:
        self.last: Any = None  # the newest sample
        self.rate: Any = None  # N/s, over the last interval
        self.period_ns = round(self.period_initial * 1e9)

    def step(self, step: tactor.Step) -> None:
        samples = self.force.new()
        for sample in samples:
            self.take(sample)
        if samples:
            self.forecast.send(self.last["valid_ns"], self.predict())

    def take(self, sample: np.void) -> None:
        if self.last is not None:
            interval_ns = int(sample["valid_ns"]) - int(self.last["valid_ns"])
            self.rate = 1.0 / (interval_ns * 1e-9) * (sample["force"] - self.last["force"])
            self.period_ns = min(interval_ns, round(self.period_max * 1e9))
        self.last = sample

    def predict(self) -> np.void:
        made = self.forecast.zeros()
        made["horizon"] = self.period_ns * 1e-9
        made["count"] = self.steps
        made["fallback"] = self.rate is None  # then it holds
        made["current_force"] = self.limited(self.last["force"])
        for i in range(self.steps):
            expected = self.last["force"]
            if self.rate is not None:
                expected = expected + (i + 1) * made["horizon"] * self.rate
            made["predicted"]["force"][i] = self.limited(expected)
        return made

    def limited(self, force: Any) -> Any:
        x, y, z = force
        size = math.sqrt(x * x + y * y + z * z)
        return force if size <= self.force_max else force * (self.force_max / size)
