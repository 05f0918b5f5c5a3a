#!/usr/bin/python3
"""What a step of a node in Python costs in the process of the run, and in a worker process: a Markdown table.

`bench/python_worker.py [--rounds N] [--steps N]`. The step is that of examples/python_node: a force in, a forecast out, as bytes of the
same size. It is called in this process; asked for over a pair of sockets; and asked for over two slots in shared memory, with an eventfd
that wakes the other side, or with a side that spins. In each round every way makes all its steps, a step each millisecond, in an order
that changes. The last column is the median of each round's ratio to the call. The asking side is Python too, which adds the same few
microseconds to each worker. Needs no build.
"""
import argparse
import mmap
import os
import pathlib
import socket
import statistics
import struct
import sys
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
from run_time import table  # noqa: E402

PERIOD = 1e-3  # s
FORCE = np.dtype([("valid_ns", "i8"), ("force", "f8", 3), ("torque", "f8", 3)])
FORECAST = np.dtype([("valid_ns", "i8"), ("current", "f8", 6), ("predicted", "f8", (4, 6)), ("horizon", "f8"), ("count", "i8")])
COUNT = struct.Struct("<q")


class Linear:
    """Extrapolates the last two forces."""

    def __init__(self):
        self.last = None

    def __call__(self, data):
        sample = np.frombuffer(data, FORCE)[0]
        made = np.zeros((), FORECAST)
        rate = np.zeros(3) if self.last is None else sample["force"] - self.last["force"]
        made["valid_ns"], made["horizon"], made["count"] = sample["valid_ns"], 0.01, 3
        made["current"][:3] = sample["force"]
        for i in range(3):
            made["predicted"][i, :3] = sample["force"] + (i + 1) * rate
        self.last = sample
        return made.tobytes()


class Call:
    """In this process."""

    def __init__(self):
        self.ask, self.end = Linear(), lambda: None


class Worker:
    """A child that answers until it is told to end; `serve` and `ask` say how."""

    def __init__(self):
        self.child = os.fork()
        if self.child == 0:
            try:
                self.serve(Linear())
            finally:
                os._exit(0)

    def end(self):
        self.finish()
        os.waitpid(self.child, 0)


class Sockets(Worker):
    """A pair of sockets that keep messages apart."""

    def __init__(self):
        self.mine, self.other = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        super().__init__()

    def serve(self, step):
        while data := self.other.recv(4096):
            self.other.send(step(data))

    def ask(self, data):
        self.mine.send(data)
        return self.mine.recv(4096)

    def finish(self):
        self.mine.send(b"")


class Slots(Worker):
    """Two slots in shared memory; an eventfd of each side wakes the other one."""

    def __init__(self):
        self.memory = mmap.mmap(-1, 8192)
        self.count = 0
        self.asked, self.answered = os.eventfd(0), os.eventfd(0)
        super().__init__()

    def wait(self, at, count, event):
        os.eventfd_read(event)

    def wake(self, event):
        os.eventfd_write(event, 1)

    def serve(self, step):
        count = 0
        while True:
            count += 1
            self.wait(0, count, self.asked)
            if COUNT.unpack_from(self.memory, 0)[0] < 0:
                return
            made = step(self.memory[8:8 + FORCE.itemsize])
            self.memory[4104:4104 + len(made)] = made
            COUNT.pack_into(self.memory, 4096, count)
            self.wake(self.answered)

    def ask(self, data):
        self.count += 1
        self.memory[8:8 + len(data)] = data
        COUNT.pack_into(self.memory, 0, self.count)
        self.wake(self.asked)
        self.wait(4096, self.count, self.answered)
        return self.memory[4104:4104 + FORECAST.itemsize]

    def finish(self):
        COUNT.pack_into(self.memory, 0, -1)
        self.wake(self.asked)


class SpinningSlots(Slots):
    """The same, but who waits looks without a pause: it takes a core of its own."""

    def wait(self, at, count, event):
        while 0 <= COUNT.unpack_from(self.memory, at)[0] < count:
            pass

    def wake(self, event):
        pass


WAYS = {"a call in the process": Call, "a worker, a pair of sockets": Sockets, "a worker, slots and eventfd": Slots,
        "a worker, slots, both spin": SpinningSlots}


def round_trips(way, steps):
    """The time from asking to the answer of each step, s."""
    made = way()
    told = np.zeros((), FORCE)
    found = []
    try:
        begin = time.perf_counter()
        for i in range(steps):
            time.sleep(max(0.0, begin + i * PERIOD - time.perf_counter()))
            told["valid_ns"], told["force"] = i, i
            data = told.tobytes()
            asked = time.perf_counter()
            answer = made.ask(data)
            found.append(time.perf_counter() - asked)
            if np.frombuffer(answer, FORECAST)[0]["valid_ns"] != i:
                raise RuntimeError(f"{way.__name__}: step {i} got the answer of another one")
    finally:
        made.end()
    return found


HEAD = ["a step of a node in Python", "p50, us", "p99, us", "max, us", "p50 / call"]


def rows(rounds, steps):
    found = {name: [] for name in WAYS}
    for i in range(rounds):
        names = list(WAYS)
        for k in range(len(names)):
            name = names[(i + k) % len(names)]
            found[name].append(np.array(round_trips(WAYS[name], steps)))
    base = [np.median(one) for one in found["a call in the process"]]
    for name, trips in found.items():
        every = 1e6 * np.concatenate(trips)
        ratio = statistics.median(np.median(one) / of for one, of in zip(trips, base))
        yield [name, *np.percentile(every, (50, 99)), every.max(), f"{ratio:.2f}"]


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--steps", type=int, default=2000)
    arguments = parser.parse_args()
    print(table(HEAD, rows(arguments.rounds, arguments.steps)), end="")


if __name__ == "__main__":
    main()
