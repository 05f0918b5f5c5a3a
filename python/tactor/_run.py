"""Whole runs, as `tactor run` makes them."""
from __future__ import annotations

import difflib
import json
import os
import shutil
from typing import Any, Dict, Iterable, Iterator, List, Mapping, Optional, Sequence, Tuple, Union

from . import _tactor
from ._errors import RunError
from ._graph import Graph, Overlay, Path, Time, Value, as_graph, warn
from ._messages import Messages, MessageType, curve, messages
from ._recording import Recording


class Metrics(Mapping[str, float]):
    """The metrics of a run by their dotted names, which carry the unit: `metrics["delivered.force.rms_error_N"]`."""

    def __init__(self, metrics: Sequence[Tuple[str, float, str, str, str]]) -> None:
        self._values = {name: value for name, value, _, _, _ in metrics}
        #: The unit of each, "1" for plain numbers.
        self.units: Dict[str, str] = {name: unit for name, _, unit, _, _ in metrics}
        #: `lower`, `higher` or `neither`.
        self.better: Dict[str, str] = {name: better for name, _, _, better, _ in metrics}
        #: One line on each.
        self.docs: Dict[str, str] = {name: doc for name, _, _, _, doc in metrics}

    def __getitem__(self, name: str) -> float:
        if name not in self._values:
            near = difflib.get_close_matches(name, self._values, 1)
            raise KeyError(name + (f"; did you mean {near[0]}?" if near else "; print(metrics) shows what there is"))
        return self._values[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        width = max(map(len, self), default=0)
        return "\n".join(f"{name:<{width}}  {value:.6g}" for name, value in self.items())


class Result:
    """A finished run."""

    def __init__(self, result: _tactor.RunResult) -> None:
        self._result = result
        #: What the run reports; see docs/reference/metrics.md.
        self.metrics: Metrics = Metrics(result.metrics)
        #: The whole of summary.json.
        self.summary: Dict[str, Any] = json.loads(result.summary)
        #: What was tapped, by output: see `run`.
        self.taps: Dict[str, Messages] = {output: messages(array, MessageType.from_json(said), output=output)
                                          for output, (said, array) in result.take_taps().items()}
        #: What was said of the graph before the run.
        self.notes: List[str] = result.notes
        #: Why it ended before its time, or None.
        self.failure: Optional[str] = result.failure
        #: The folder with its files, or None.
        self.folder: Optional[str] = result.folder or None

    @property
    def graph(self) -> str:
        """The graph's name."""
        return str(self.summary["graph"])

    @property
    def verdict(self) -> Optional[str]:
        """`stable`, `limit_cycle`, ...: how the run behaved, or None where no sink judges that.

        `no_force` where something kept every force from the devices: `no_force` says what.
        """
        found: Optional[str] = self.summary.get("stability", {}).get("verdict_name")
        return found

    @property
    def not_judged(self) -> Optional[str]:
        """Why no error is told: the reference is no finer than the run. None where it is finer, or nothing asks for one."""
        found: Optional[str] = self.summary.get("reference_too_coarse")
        return found

    @property
    def no_force(self) -> Dict[str, str]:
        """The devices that no force of the pipeline reached in the whole run, and why; empty where there is none.

        `{"device": "button 1 was never held"}`. The `reason` as a word and its counts are in `summary["no_force"]`.
        """
        return {one["device"]: one["text"] for one in self.summary.get("no_force", [])}

    @property
    def series(self) -> Dict[str, Messages]:
        """The curves of the run, by name: structured arrays of `time` (s) and `value`, with `.units`.

        `commanded.x`, `.y`, `.z` and `.norm` (N), `reference.x` to `.norm`, `torque.commanded.x` to
        `torque.reference.norm` (N m), `physics.x`, `.y`, `.z` (N, on arrival), `physics_rate` (Hz), `contacts` (1),
        `displacement` (m) and `one_step_error` (N), of those that the run has. Forces act on the hand, in W.
        """
        return {name: curve(name, unit, time, value) for name, (unit, time, value) in self._result.series.items()}

    @property
    def costs(self) -> Dict[str, Dict[str, Any]]:
        """What each node took: `type`, `steps`, `missed_ticks`, `median` and `p99` (us a step), `total_s` (CPU)."""
        costs: Dict[str, Dict[str, Any]] = self.summary["cost_us"]
        return costs

    @property
    def graph_yaml(self) -> str:
        """The graph that ran, with every parameter written out."""
        return self._result.graph_yaml

    @property
    def recording(self) -> Optional[Recording]:
        """What the graph records, or None where it does not, or no `out` was given."""
        path = self._result.recording
        return Recording(path) if path and os.path.exists(path) else None

    @property
    def report(self) -> str:
        """The page of the run, HTML that needs no other file."""
        return self._result.html()

    def table(self, columns: Optional[int] = None) -> str:
        """Every metric, and what each node took, as text: what `tactor run --all` prints."""
        return self._result.table(columns or shutil.get_terminal_size().columns)

    def __repr__(self) -> str:
        verdict = f", {self.verdict}" if self.verdict else ""
        return f"<tactor.Result {self.graph}: {self.summary['duration_s']:g} s, {len(self.metrics)} metrics{verdict}>"


def run(graph: Union[Graph, Path], over: Union[Overlay, Iterable[Overlay]] = (), set: Mapping[str, Value] = {}, *,
        seed: Optional[int] = None, duration: Optional[Time] = None, out: Optional[Path] = None,
        overwrite: bool = False, taps: Iterable[str] = (), follow: bool = False, reference: Optional[Path] = None,
        without_reference: bool = False, no_dead_man: bool = False) -> Result:
    """Runs a graph and its reference run, as `tactor run` does, in this process.

    `graph`, `over`, `set`, `seed` and `duration` are those of `load`. `out`: a folder for the files that the command
    leaves (recording.h5, summary.json, report.html, graph.yaml), which holds none unless `overwrite`; None: no file.
    `taps`: outputs whose messages are in `Result.taps`; what makes them runs, though no sink or recording needs it.
    `follow`: with clock: real, a reference follows the run.
    `reference`: a recording that judges the run instead of a reference run. `without_reference`: neither, and no
    metrics that need one. `no_dead_man`: hardware may give a force though no button stops it when a person lets go;
    otherwise InputError is raised, unless the graph says `dead_man_button: 0`.

    Ctrl-C raises KeyboardInterrupt within about 0.1 s; live, within about 0.2 s, once the devices are at zero. Raises
    InputError before anything runs, and RunError where the run fails, with its `result` up to there.
    """
    made = as_graph(graph, over, set, seed, duration)
    finished = Result(_tactor.run(made._graph, out=None if out is None else os.fsencode(out), overwrite=overwrite,
                                  follow=follow, reference=None if reference is None else os.fsencode(reference),
                                  without_reference=without_reference, no_dead_man=no_dead_man, taps=list(taps)))
    warn(finished.notes)
    if finished.failure is not None:
        error = RunError(finished.failure)
        error.result = finished
        raise error
    return finished
