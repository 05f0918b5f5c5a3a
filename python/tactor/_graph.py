"""Graphs: files with what is laid over them."""
from __future__ import annotations

import json
import os
import shutil
import warnings
from typing import Any, Dict, Iterable, List, Mapping, Optional, Sequence, Tuple, Union

from . import _tactor
from ._errors import InputWarning
from ._messages import MessageType

Path = Union[str, "os.PathLike[str]"]
#: A file or a method's name (`kalman`), or the keys of a graph file as a mapping.
Overlay = Union[Path, Mapping[str, Any]]
#: A text with its unit (`"1200 N/m"`), or a number in the SI unit.
Value = Union[str, int, float, bool, Sequence[Any]]
#: Seconds, or a text with its unit (`"10 ms"`).
Time = Union[str, int, float]


def _json(value: Any) -> str:
    """JSON is YAML. Numbers and arrays of numpy are as Python's own."""
    return json.dumps(value, ensure_ascii=False, default=lambda one: one.tolist())


def text_of(value: Value) -> str:
    """A value as a graph file says it."""
    return value if isinstance(value, str) else _json(value)


def time_text(time: Time) -> str:
    return time if isinstance(time, str) else f"{time!r} s"


def changes(over: Union[Overlay, Iterable[Overlay]], set: Mapping[str, Value], seed: Optional[int],
            duration: Optional[Time]) -> List[Tuple[str, Union[str, bytes]]]:
    """What is laid over a graph, in order, as the extension takes it."""
    overlays = [over] if isinstance(over, (str, os.PathLike, Mapping)) else list(over)
    made: List[Tuple[str, Union[str, bytes]]] = []
    for one in overlays:
        if isinstance(one, Mapping):
            made.append(("map", _json(one)))
        else:
            made.append(("over", os.fsencode(one)))
    made += [("set", f"{path}={text_of(value)}") for path, value in set.items()]
    if seed is not None:
        made.append(("seed", str(seed)))
    if duration is not None:
        made.append(("duration", time_text(duration)))
    return made


class Graph:
    """A checked graph: what a run or a session is made of. See `load`."""

    def __init__(self, graph: _tactor.Graph) -> None:
        self._graph = graph

    @property
    def name(self) -> str:
        """`bunny_refit` for bunny/refit.yaml."""
        return self._graph.name

    @property
    def title(self) -> str:
        """One line of prose, or empty."""
        return self._graph.title

    @property
    def file(self) -> str:
        """The file it was read from."""
        return self._graph.file

    @property
    def clock(self) -> str:
        """`virtual` or `real`."""
        return self._graph.clock

    @property
    def seed(self) -> int:
        """The seed of everything random."""
        return self._graph.seed

    @property
    def duration(self) -> float:
        """Time of the graph's clock that a run takes, in s; `math.inf`: until it is stopped."""
        return self._graph.duration

    @property
    def nodes(self) -> Dict[str, str]:
        """The type of each node by its name."""
        return self._graph.nodes

    @property
    def inputs(self) -> List[str]:
        """Every input, `device.target`: what `feeds` may name."""
        return self._graph.inputs

    @property
    def outputs(self) -> Dict[str, MessageType]:
        """The messages of every output of the run: what a tap may name."""
        return {name: MessageType.from_json(said) for name, said in self._graph.outputs.items()}

    def with_feeds(self, *inputs: str) -> Graph:
        """The same graph, in which the program fills these inputs (`device.target`) in the place of what fed them."""
        return Graph(self._graph.with_feeds(list(inputs)))

    def check(self) -> List[str]:
        """Refuses what a run would refuse before it begins; returns what the nodes say of their input."""
        return self._graph.check()

    def to_yaml(self) -> str:
        """The graph as a file that loads to the same graph, with every parameter written out."""
        return self._graph.to_yaml()

    def explain(self, columns: Optional[int] = None) -> str:
        """What runs, the queues, and what was left out and why; in so many columns (default: the terminal's)."""
        return self._graph.explain(columns or shutil.get_terminal_size().columns)

    def diagram(self) -> str:
        """The plan as a diagram of Mermaid."""
        return self._graph.diagram()

    def __repr__(self) -> str:
        return f"<tactor.Graph {self.name}: {len(self.nodes)} nodes, {self.duration:g} s, clock: {self.clock}>"


def load(path: Path, over: Union[Overlay, Iterable[Overlay]] = (), set: Mapping[str, Value] = {}, *,
         seed: Optional[int] = None, duration: Optional[Time] = None, feeds: Iterable[str] = ()) -> Graph:
    """Reads a graph and checks it.

    `path` is a file or the name of a shipped graph (`wall/refit`). Laid over it, in this order: `over`, files, methods'
    names or mappings with the keys of a graph file; `set`, values by path (`{"coupling.k_0": "1200 N/m"}`); `seed`;
    `duration`, in s or a text with its unit. `feeds` names inputs that the program fills (see `Session.feed`).

    Raises InputError with every error that the graph has.
    """
    graph = Graph(_tactor.Graph(os.fsencode(path), changes(over, set, seed, duration)))
    names = list(feeds)
    return graph.with_feeds(*names) if names else graph


def check(graph: Union[Graph, Path], over: Union[Overlay, Iterable[Overlay]] = (),
          set: Mapping[str, Value] = {}) -> List[str]:
    """Checks a graph without running it, as `tactor check` does. Returns the notes; raises InputError."""
    return as_graph(graph, over, set).check()


def as_graph(graph: Union[Graph, Path], over: Union[Overlay, Iterable[Overlay]] = (),
             set: Mapping[str, Value] = {}, seed: Optional[int] = None, duration: Optional[Time] = None) -> Graph:
    """The graph, or that of the file with what is laid over it."""
    if not isinstance(graph, Graph):
        return load(graph, over, set, seed=seed, duration=duration)
    if changes(over, set, seed, duration):
        raise TypeError("a loaded graph takes no over, set, seed or duration; give them to tactor.load")
    return graph


def warn(notes: Iterable[str], stacklevel: int = 3) -> None:
    """Tells notes as warnings of the caller's caller."""
    for note in notes:
        warnings.warn(note, InputWarning, stacklevel=stacklevel)
