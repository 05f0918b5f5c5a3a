"""Comparisons and studies: the command `tactor` makes them in processes of its own, and their tables come back."""
from __future__ import annotations

import contextlib
import json
import os
import pathlib
import re
import shutil
import signal
import sqlite3
import subprocess
import tempfile
from typing import TYPE_CHECKING, Any, Dict, Iterable, List, Mapping, Optional, Sequence, Union

from . import _tactor
from ._errors import InputError, RunError
from ._graph import Graph, Overlay, Path, Time, Value, changes, time_text
from ._needs import needed

if TYPE_CHECKING:
    import pandas  # type: ignore  # releases of mypy call the missing stubs by different codes


def command() -> str:
    """The command `tactor` of this installation, else the one in the PATH. Raises InputError where there is none."""
    beside = pathlib.Path(_tactor.prefix) / "bin" / "tactor"
    found = str(beside) if beside.exists() else shutil.which("tactor")
    if found is None:
        raise InputError(f"the command tactor is neither {beside} nor in the PATH; install the package tactor")
    return found


def _call(arguments: Sequence[str]) -> subprocess.CompletedProcess[str]:
    """Runs the command. Ctrl-C ends it, and then raises KeyboardInterrupt. What it refuses is raised."""
    process = subprocess.Popen([command(), *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        said, errors = process.communicate()
    except BaseException:
        # It ends once the runs under way have ended, and ends them where it is asked again a second later. What comes
        # before it looks for the first time counts once, and a terminal may have asked it too.
        while process.poll() is None:
            process.send_signal(signal.SIGINT)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.communicate(timeout=2)
        raise
    errors = _by_keywords(errors)
    if process.returncode == 2:
        raise InputError(errors.strip())
    return subprocess.CompletedProcess(process.args, process.returncode, said, errors)


def _by_keywords(text: str) -> str:
    """What the command says of its options, said of the keywords that stand for them here."""
    text = re.sub(r"(?<![\w-])--(short|resume|overwrite)\b(?![-=])", r"\1=True", text)
    return re.sub(r"(?<![\w-])--(set|over|out|seeds|first-seed|repeats|jobs|duration)\b(?!-)",
                  lambda option: option.group(1).replace("-", "_"), text)


def _options(over: Union[Overlay, Iterable[Overlay]], set: Mapping[str, Value], folder: str) -> List[str]:
    """What is laid over, as options of the command."""
    options: List[str] = []
    for i, (how, text) in enumerate(changes(over, set, None, None)):
        if how == "map":
            file = pathlib.Path(folder) / f"over_{i}.yaml"
            file.write_text(os.fsdecode(text))
            how, text = "over", str(file)
        options += [f"--{how}", os.fsdecode(text)]
    return options


def _counts(seeds: Optional[int], first_seed: Optional[int], repeats: Optional[int], jobs: Optional[int],
            duration: Optional[Time]) -> List[str]:
    given = {"--seeds": seeds, "--first-seed": first_seed, "--repeats": repeats, "--jobs": jobs,
             "--duration": None if duration is None else time_text(duration)}
    return [word for name, value in given.items() if value is not None for word in (name, str(value))]


def compare(graphs: Union[Graph, Path, Iterable[Union[Graph, Path]]], over: Union[Overlay, Iterable[Overlay]] = (),
            set: Mapping[str, Value] = {}, *, seeds: int = 6, first_seed: int = 1, repeats: int = 1,
            jobs: Optional[int] = None, duration: Optional[Time] = None,
            out: Optional[Path] = None) -> pandas.DataFrame:
    """Runs graphs over several seeds, side by side, as `tactor compare` does. The others are compared with the first.

    Returns a row for each graph and seed: `place` in `graphs`, which tells graphs of one name apart, `graph`, `seed`,
    `status`, and the metrics as columns. `table.attrs` has `units` and `better` of each
    column, `comparison` (compare.json: means, intervals, tests), and `text`, the table that the command prints. `out`
    keeps its files, with the report.

    Raises InputError where a graph is refused, and RunError where no run was made; a run that failed is a row of NaN
    with its `status`.
    """
    pd = needed("pandas", "python3-pandas", "for tables")
    with tempfile.TemporaryDirectory(prefix="tactor-") as folder:
        files = []
        several = [graphs] if isinstance(graphs, (Graph, str, bytes, os.PathLike)) else graphs
        for i, graph in enumerate(several):
            if isinstance(graph, Graph):
                # In a folder of its own, because its name is the graph's.
                file = pathlib.Path(folder) / str(i) / f"{graph.name}.yaml"
                file.parent.mkdir()
                file.write_text(graph.to_yaml())
                files.append(str(file))
            else:
                files.append(os.fspath(graph))
        results = pathlib.Path(folder) / "out" if out is None else pathlib.Path(os.fspath(out))
        called = _call(["compare", *files, *_options(over, set, folder),
                        *_counts(seeds, first_seed, repeats, jobs, duration), "--out", str(results)])
        if not (results / "compare.json").exists():
            raise RunError(called.stderr.strip())
        said = json.loads((results / "compare.json").read_text())
    rows: List[Dict[str, Any]] = []
    units: Dict[str, str] = {}
    better: Dict[str, str] = {}
    for place, row in enumerate(said["graphs"]):
        for i, seed in enumerate(said["seeds"]):
            rows.append({"place": place, "graph": row["graph"], "seed": seed, "status": row["status"][i]}
                        | {name: metric["by_seed"][i] for name, metric in row["metrics"].items()})
        units.update({name: metric["unit"] for name, metric in row["metrics"].items()})
        better.update({name: metric["better"] for name, metric in row["metrics"].items()})
    table: pandas.DataFrame = pd.DataFrame(rows)
    table.attrs.update(units=units, better=better, comparison=said, text=called.stdout)
    return table


def study(file: Path, over: Union[Overlay, Iterable[Overlay]] = (), set: Mapping[str, Value] = {}, *,
          seeds: Optional[int] = None, first_seed: Optional[int] = None, repeats: Optional[int] = None,
          jobs: Optional[int] = None, duration: Optional[Time] = None, short: bool = False, resume: bool = False,
          overwrite: bool = False, out: Optional[Path] = None) -> pandas.DataFrame:
    """Runs a study, as `tactor study` does, and returns its table (see docs/howto/studies.md).

    A row a run: `graph`, `method`, what is varied, `seed`, `status`, then metrics and run times. `table.attrs` has
    `units` and `better` of each metric, `study` (study.json), `text`, the table that the command prints, and `folder`
    where `out` was given. Without `out` no files stay.

    Raises InputError where the study is refused, and RunError where it came to no table. Ctrl-C ends it; with `out`,
    `resume=True` goes on.
    """
    needed("pandas", "python3-pandas", "for tables")
    with tempfile.TemporaryDirectory(prefix="tactor-") as folder:
        results = pathlib.Path(folder) / "out" if out is None else pathlib.Path(os.fspath(out))
        asked = {"short": short, "resume": resume, "overwrite": overwrite}
        flags = [f"--{name}" for name, given in asked.items() if given]
        called = _call(["study", os.fspath(file), *_options(over, set, folder),
                        *_counts(seeds, first_seed, repeats, jobs, duration), *flags, "--out", str(results)])
        # A study with runs that failed has a table; their metrics are missing in it.
        if called.returncode != 0 and not _is_whole(results, called.stderr):
            raise RunError(called.stderr.strip())
        table = study_table(results)
        table.attrs.update(text=called.stdout)
        if out is not None:
            table.attrs["folder"] = str(results)
    return table


def _is_whole(results: pathlib.Path, errors: str) -> bool:
    return (results / "study.json").exists() and "runs that failed" in errors


def study_table(folder: Path) -> pandas.DataFrame:
    """The table of a study that was made before, from its folder. See `study`."""
    pd = needed("pandas", "python3-pandas", "for tables")
    path = pathlib.Path(os.fspath(folder))
    if not (path / "study.json").exists():
        raise InputError(f"{path}: expected the results of a study, found no study.json")
    said = json.loads((path / "study.json").read_text())
    metrics, times = (
        pd.read_csv(path / name, float_precision="round_trip") for name in ("study.csv", "run_times.csv"))
    # Both have the same lines in the same order.
    more = [column for column in times.columns if column not in metrics.columns]
    table: pandas.DataFrame = pd.concat([metrics, times[more]], axis=1)
    with sqlite3.connect(f"file:{path / 'study.sqlite'}?mode=ro", uri=True) as database:
        declared = database.execute("SELECT name, unit, better FROM declared").fetchall()
    columns = {str(column) for column in table.columns}
    table.attrs.update(units={name: unit for name, unit, _ in declared if name in columns},
                       better={name: better for name, _, better in declared if name in columns}, study=said)
    return table
