"""Sessions: runs that go on while the program looks at them, feeds them and changes them."""
from __future__ import annotations

import atexit
import math
import os
import sys
import weakref
from types import TracebackType
from typing import Any, Dict, Iterable, Mapping, Optional, Type, Union

import numpy as np

from . import _tactor
from ._errors import RunError
from ._graph import Graph, Overlay, Path, Time, Value, as_graph, text_of, warn
from ._messages import Messages, MessageType, messages
from ._physics import PhysicsLoop
from ._run import Metrics

_MOST_IN_TAP = 1 << 24  # as in the C++ session: more would be a slip of the pen


class Tap:
    """The messages of one output. See `Session.tap`."""

    def __init__(self, tap: _tactor.Tap) -> None:
        self._tap = tap
        #: What its messages hold.
        self.type: MessageType = MessageType.from_json(tap.description)

    @property
    def output(self) -> str:
        """`coupling.force`."""
        return self._tap.output

    @property
    def dtype(self) -> np.dtype[Any]:
        """Of the arrays that `take` returns."""
        return self._tap.dtype

    @property
    def units(self) -> Dict[str, str]:
        """The SI unit of each field of numbers, by its path."""
        return self.type.units

    @property
    def dropped(self) -> int:
        """Messages that went because `queue` of them waited. See `Session.dropped` for those of a live run."""
        return self._tap.dropped

    def take(self) -> Messages:
        """All messages that wait, oldest first, as one structured array; empty where none do.

        After the session has finished, the last ones. An array is the program's own, and no later `take` changes it.
        """
        return messages(self._tap.take(), self.type, output=self.output)

    def __repr__(self) -> str:
        return f"<tactor.Tap {self.output} ({self.type.name})>"


class Feed:
    """An input that the program fills. See `Session.feed`."""

    def __init__(self, feed: _tactor.Feed) -> None:
        self._feed = feed
        #: What its messages hold.
        self.type: MessageType = MessageType.from_json(feed.description)

    @property
    def dtype(self) -> np.dtype[Any]:
        """Of one value, for who fills it by name: `value = numpy.zeros((), feed.dtype)`."""
        return self._feed.dtype

    @property
    def units(self) -> Dict[str, str]:
        """The SI unit of each field of numbers, by its path."""
        return self.type.units

    def send(self, value: Any = None, *, valid: Optional[Time] = None, **fields: Any) -> bool:
        """Sends a message: one element of `dtype`, or a row of a tap or recording, or its fields by name.

        It is valid at `valid` (s of the run, or a text with its unit), else now. False where an edge of policy `block`
        has no room: then nothing is sent. Raises InputError where a field is missing, unknown, or does not fit.
        """
        if (value is None) == (not fields):
            raise TypeError("send: expected one value, or its fields by name")
        return self._feed.send(fields if value is None else value, valid)

    def __repr__(self) -> str:
        return f"<tactor.Feed ({self.type.name})>"


_live: weakref.WeakSet[Session] = weakref.WeakSet()


class Session:
    """A run that goes on while the program looks at it; a context manager, which finishes it.

        with tactor.Session("wall/refit") as session:
            force = session.tap("device.commanded")
            session.advance("1 s")
            print(force.take()["force"])

    Under the virtual clock nothing happens but in `advance`, the same however time is cut. With `clock: real` the run
    goes by itself from `start` on. Any thread may call a session; its calls take turns.
    """

    def __init__(self, graph: Union[Graph, Path], over: Union[Overlay, Iterable[Overlay]] = (),
                 set: Mapping[str, Value] = {}, *, seed: Optional[int] = None, duration: Optional[Time] = None,
                 feeds: Iterable[str] = (), pace: float = 0.0, no_dead_man: bool = False) -> None:
        """Makes the nodes of a graph, or of a file with what is laid over it (see `load`).

        `feeds`: inputs that the program fills. `pace`: under the virtual clock, seconds of the run for a second of wall
        time; 0: as fast as it goes. `no_dead_man`: hardware may give a force though no button stops it when a person
        lets go; otherwise InputError is raised, unless the graph says `dead_man_button: 0`.
        """
        made = as_graph(graph, over, set, seed, duration)
        names = list(feeds)
        #: The graph that runs.
        self.graph: Graph = made.with_feeds(*names) if names else made
        self._session = _tactor.Session(self.graph._graph, pace, no_dead_man=no_dead_man)
        self._loops: Dict[str, PhysicsLoop] = {}
        warn(self._session.notes())
        if self._session.live:
            _live.add(self)

    def start(self) -> None:
        """Begins the run, at time zero; live, the devices begin to tick. `advance` does it where nobody has."""
        self._session.start()

    def advance(self, time: Time) -> None:
        """Lets so much time of the run pass (s, or a text as `"10 ms"`), up to the run's end.

        Ctrl-C raises KeyboardInterrupt within about 0.1 s; live, within about 0.2 s, once the run is finished, its
        devices at zero. Raises RunError where a step fails.
        """
        self._session.advance(time)

    def run(self) -> None:
        """Advances to the run's end; with `duration: until stopped` until a thread of the program calls `stop`."""
        if self.graph.duration == math.inf:
            while self.running:
                self.advance(3600.0)
            return
        self.advance(self.graph.duration + 60.0 if self.live else self.graph.duration)

    def tap(self, output: str, queue: Optional[int] = None) -> Tap:
        """The messages of an output (`coupling.force`) from now on, before the start or while the run goes on.

        Under the virtual clock none is lost. `queue`: how many may wait for `take`, at most 16777216, of which the
        oldest goes; None: as many as come. Live, they are fetched in `advance` and `take`; between these the session
        holds up to 2 MB.
        """
        if queue is not None and not 1 <= queue <= _MOST_IN_TAP:
            raise ValueError(f"queue: expected 1 to {_MOST_IN_TAP} messages, or None, found {queue}")
        return Tap(self._session.tap(output, queue or 0))

    def feed(self, name: str) -> Feed:
        """What fills an input (`device.target`) that `feeds` has named, a node of type source.feed, or an output.

        An output is one that programs fill, such as `physics.force` of a node physics.external.
        """
        return Feed(self._session.feed(name))

    def physics(self, node: Optional[str] = None) -> PhysicsLoop:
        """The loop in which the program itself is the physics: of the graph's node `node` of type physics.external.

        None: the only node of that type. The same object for the same node each time. Raises InputError where there is
        none, or several.
        """
        name = _tactor.PhysicsLoop.node_of(self._session, node or "")
        if name not in self._loops:
            self._loops[name] = PhysicsLoop(_tactor.PhysicsLoop(self._session, name))
        return self._loops[name]

    def set(self, parameter: str, value: Value) -> None:
        """Sets a tunable parameter: `set("coupling.k_0", "1200 N/m")`; a number is in the SI unit.

        It holds from the node's next step on. Raises InputError, and changes nothing, where the value is refused or the
        parameter is not tunable.
        """
        self._session.set(parameter, text_of(value))

    @property
    def now(self) -> float:
        """The time up to which it has run, in s."""
        return self._session.now

    @property
    def running(self) -> bool:
        """True until the run has come to its end, was stopped or has failed; before its start as well."""
        return self._session.running

    @property
    def live(self) -> bool:
        """Whether its clock is real."""
        return self._session.live

    @property
    def dropped(self) -> int:
        """Live: messages for taps that were lost because nobody called `advance` or `take` in time."""
        return self._session.dropped

    def status(self) -> Dict[str, Any]:
        """Live: `now_s`, `phase` (starting, running, stopping), `waiting_for`, and what `nodes` and `devices` did."""
        return self._session.status()

    @property
    def metrics(self) -> Metrics:
        """What the nodes report so far, without what needs a reference run (see `run`); live, once finished."""
        return Metrics(self._session.metrics())

    def stop(self) -> None:
        """Ends the run where it is; live, the devices ramp down in `finish`."""
        self._session.stop()

    def finish(self) -> None:
        """Ends the run where it goes on, with live devices at zero; taps and metrics stay. Any number of times.

        Raises RunError where a live run has ended before its time, with the reason.
        """
        _live.discard(self)
        failure = self._session.finish()
        if failure is not None:
            raise RunError(failure)

    def __enter__(self) -> Session:
        return self

    def __exit__(self, kind: Optional[Type[BaseException]], error: Optional[BaseException],
                 traceback: Optional[TracebackType]) -> None:
        try:
            self.finish()
        except RunError:
            # What ended the block is told first.
            if error is None:
                raise

    def __repr__(self) -> str:
        state = "finished" if self._session.finished else "running" if self.running else "at its end"
        return f"<tactor.Session {self.graph.name}: {state} at {self.now:g} s>"


@atexit.register
def _finish_all() -> None:
    """Nothing that runs outlasts the interpreter: other threads' runs end, and live ones ramp down."""
    _tactor.end_work()
    for session in list(_live):
        try:
            session._session.finish()
        except Exception:
            # The others end all the same.
            sys.excepthook(*sys.exc_info())


def _forget_all() -> None:
    """The child of a fork has no thread of a run, and none of its sessions."""
    _tactor.forget_work()
    _live.clear()


os.register_at_fork(after_in_child=_forget_all)
