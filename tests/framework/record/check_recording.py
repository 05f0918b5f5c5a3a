"""Reads a recording of recording_fixture.hpp with h5py and compares it with the formulas there.

usage: check_recording.py FILE MIN_ROWS MAX_ROWS plain|swmr COMPLETE
"""
import json
import sys

import h5py
import numpy as np


def text(attribute):
    return attribute.decode() if isinstance(attribute, bytes) else str(attribute)


path, least, most, mode, complete = sys.argv[1:]
with h5py.File(path, "r", swmr=mode == "swmr") as f:
    assert f.attrs["tactor_recording"] == 2
    assert text(f.attrs["graph"]) == "clock: virtual\nname: \u00fc\n", f.attrs["graph"]
    assert f.attrs["seed"] == np.uint64(0xFEDCBA9876543210)
    assert text(f.attrs["tactor_version"]) == "0.1.0"
    assert f.attrs["complete"] == int(complete)
    assert list(f["streams"]) == ["coupling.force", "device.state"]

    g = f["streams/coupling.force"]
    assert text(g.attrs["message_type"]) == "Wrench" and text(g.attrs["frame"]) == "W"
    assert text(g.attrs["time_unit"]) == "ns"
    assert json.loads(text(g.attrs["description"])) == {"name": "Wrench", "frame": "W", "fields": [
        {"name": "force", "unit": "N", "kind": "f64", "shape": [3]},
        {"name": "torque", "unit": "N m", "kind": "f64", "shape": [3]}]}
    d = g["data"]
    assert d.dtype.names == ("valid_ns", "produced_ns", "sequence", "force", "torque")
    n = d.shape[0]
    assert int(least) <= n <= int(most), n
    i = np.arange(n)
    assert (d["valid_ns"] == i * 1_000_000).all() and (d["produced_ns"] == i * 1_000_000 + 250_000).all()
    assert (d["sequence"] == i).all()
    v = i.astype(float)
    assert (d["force"] == np.stack([0.1 * v, -v, 1 / (v + 1)], 1)).all()
    assert (d["torque"] == np.stack([1e-3 * v, 0 * v, np.full(n, 1e300)], 1)).all()

    g = f["streams/device.state"]
    assert text(g.attrs["message_type"]) == "DeviceState"
    d = g["data"]
    assert d.dtype.names == ("valid_ns", "produced_ns", "sequence", "p_WD", "R_WD", "v_WD", "w_WD", "buttons")
    i = np.arange(d.shape[0]) * 10
    assert (d["valid_ns"] == i * 1_000_000).all()
    assert (d["p_WD"] == np.stack([0.5 * i, 0 * i + 1, 0 * i + 2], 1)).all()
    assert (d["R_WD"] == [1, 0, 0, 0]).all() and (d["buttons"] == i % 3 - 1).all()
