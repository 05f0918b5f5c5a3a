"""Nodes in Python: a class with declared ports and parameters, which a graph names by `python: FILE.py:Class`.

    class Gain(tactor.Node):
        \"\"\"Multiplies a force.\"\"\"

        force = tactor.Input("Wrench", trigger=True, doc="what comes")
        scaled = tactor.Output("Wrench", doc="what goes")
        factor = tactor.Parameter(1.0, min=0, max=10, doc="the factor")

        def step(self, step):
            for sample in self.force.new():
                value = {"force": self.factor * sample["force"], "torque": self.factor * sample["torque"]}
                self.scaled.send(sample["valid_ns"], value)
"""

from __future__ import annotations

import copy
import dataclasses
import math
import os
from typing import Any, Iterable, Sequence, Type

import numpy as np

__all__ = ["Context", "Input", "Node", "Output", "Parameter", "Rate", "Step"]

_ROLES = ("other", "source", "collision", "dynamics", "coupling", "prediction", "interpolation", "force_field")


class Input:
    """An input of messages of one type.

    message: the name of the message type, such as "Wrench"; `tactor schema --messages` describes them all.
    trigger: a message that arrives here makes the node step.
    required: a graph must connect it.
    queue: how many messages wait for the next step; of more the oldest are dropped. 1: only the newest waits.
    An edge of a graph may name another queue.
    """

    def __init__(self, message: str, *, trigger: bool = False, required: bool = True, queue: int = 1, doc: str = ""):
        self.message = message
        self.trigger = trigger
        self.required = required
        self.queue = queue
        self.doc = doc

    def latest(self) -> np.void | None:
        """The newest message that has arrived, new or not; None before the first.

        A record of its stamps `valid_ns`, `produced_ns` and `sequence` and the fields of the value. It is a copy.
        """
        raise RuntimeError(_UNBOUND)

    def new(self) -> list[np.void]:
        """The messages that are new since the last call, oldest first."""
        raise RuntimeError(_UNBOUND)


class Output:
    """An output of messages of one type."""

    def __init__(self, message: str, *, doc: str = ""):
        self.message = message
        self.doc = doc

    def send(self, valid_ns: int, value: Any) -> None:
        """Sends a value that holds for the time `valid_ns`, in ns of the run.

        value: a record of the type, or a dict with all of its fields; a message of an input will do.
        """
        raise RuntimeError(_UNBOUND)

    def zeros(self) -> np.void:
        """A record of the type in which all is zero, to be filled and sent."""
        raise RuntimeError(_UNBOUND)

    def wanted(self) -> bool:
        """False where nothing reads this output, so that its work can be saved."""
        raise RuntimeError(_UNBOUND)


_UNBOUND = "a port works in the steps of a node that runs, by self: self.force.latest()"


@dataclasses.dataclass
class _Parameter:
    default: Any
    kind: str
    unit: str
    min: float
    max: float
    choices: tuple[str, ...]
    tunable: bool
    doc: str
    ramp: bool = False
    in_reference: Any = None
    rate: bool = False
    fixed: bool = False  # of a rate


def Parameter(
    default: Any = None,
    *,
    type: type | None = None,
    unit: str = "1",
    min: float | None = None,
    max: float | None = None,
    choices: Sequence[str] = (),
    file: bool = False,
    tunable: bool = False,
    ramp: bool = False,
    in_reference: Any = None,
    doc: str = "",
) -> Any:
    """A parameter, which a graph may give beside `python:`. In the node its attribute is the value, in SI units.

    default: bool, int, float, str or a list of floats, which says the type; without one a graph must give the value, and
    `type` says what it is.
    unit: of a float or a list, the SI unit that values in a graph are converted to.
    min, max: bounds of a number, both allowed.
    choices: the texts that it may be.
    file: the path of a file that exists, found as meshes are; its content counts where results are kept.
    tunable: it may be set while a run goes on; the node's `tune()` is called afterwards, where it has one.
    ramp: the time in s in which the node reaches a new value; an experiment that sets the node must wait for it.
    in_reference: the value in a reference run, in SI units, whatever the graph gives: a finer step, or no noise. Without
    it a reference run has the graph's value.
    """
    kind = _kind_of(default, type, choices, file)
    if kind in ("integer", "real") and default is not None:
        default = int(default) if kind == "integer" else float(default)
    if kind == "reals" and default is not None:
        default = [float(x) for x in default]
    if kind not in ("integer", "real", "reals") and (min is not None or max is not None):
        raise TypeError("min and max are for numbers")
    if kind not in ("real", "reals") and unit != "1":
        raise TypeError("unit is for a float or a list of floats; write 1.0 instead of 1")
    if ramp and (kind, unit) != ("real", "s"):
        raise TypeError('ramp is for a float with unit="s"')
    low, high = (0, 2**31) if kind == "integer" else (-math.inf, math.inf)
    if kind == "integer" and isinstance(default, int) and min is None and default < 0:
        low = -(2**31)
    low = low if min is None else min
    high = high if max is None else max
    if not low <= high:
        raise ValueError(f"expected min <= max, found {low} and {high}")
    for number in default if kind == "reals" and default is not None else [default]:
        if isinstance(number, (int, float)) and not low <= number <= high:
            raise ValueError(f"expected a default from {low} to {high}, found {number}")
    truth = _reference_value(in_reference, kind, choices, low, high)
    return _Parameter(default, kind, unit, low, high, tuple(choices), tunable, doc, ramp, truth)


def Rate(default: float | None = None, *, min: float = 1e-3, max: float = 1e5, fixed: bool = False, doc: str = "how often it steps") -> Any:
    """A parameter in Hz: the node steps at this rate.

    In a reference run it is 10 kHz, or the graph's where that is faster, or `max` where that is slower: the truth has to
    be finer than the run. So take the time of a step from `step.now` or from the rate, never from a constant.
    fixed: the node can step no faster, because its data come at that rate, say. No reference can then judge its runs.
    """
    made = Parameter(default, type=float, unit="Hz", min=min, max=max, doc=doc)
    made.rate = True
    made.fixed = fixed
    return made


def _reference_value(value: Any, kind: str, choices: Sequence[str], low: float, high: float) -> Any:
    """The value of a parameter in a reference run, checked as a graph's would be; None where there is none."""
    if value is None:
        return None
    if kind == "file":
        raise TypeError("in_reference is not for a file")
    types: dict[str, Any] = {"boolean": bool, "integer": int, "real": (int, float), "reals": (list, tuple)}
    numbers = value if isinstance(value, (list, tuple)) else [value]
    is_number = all(isinstance(x, (int, float)) and not isinstance(x, bool) for x in numbers)
    if not isinstance(value, types.get(kind, str)) or (kind in ("integer", "real", "reals") and not is_number):
        raise TypeError(f"expected in_reference of the type of the parameter ({kind}), found {value!r}")
    if kind == "choice" and value not in choices:
        raise ValueError(f"expected in_reference as one of {', '.join(choices)}, found {value!r}")
    if kind in ("integer", "real", "reals"):
        for number in numbers:
            if not (math.isfinite(number) and low <= number <= high):
                raise ValueError(f"expected in_reference from {low} to {high}, found {number}")
    if kind == "reals":
        return [float(x) for x in numbers]
    return float(value) if kind == "real" else value


def _kind_of(default: Any, type_: type | None, choices: Sequence[str], file: bool) -> str:
    if choices or file:
        if default is not None and not isinstance(default, str):
            raise TypeError(f"expected a str as the default, found {default!r}")
        if choices and default is not None and default not in choices:
            raise ValueError(f"expected one of {', '.join(choices)}, found {default!r}")
        return "file" if file else "choice"
    kind = type_ if type_ is not None else type(default)
    if kind is type(None):
        raise TypeError("expected a default, or type=float (int, bool, str, list)")
    kinds = ((bool, "boolean"), (int, "integer"), (float, "real"), (str, "text"), (list, "reals"), (tuple, "reals"))
    for cls, name in kinds:
        if issubclass(kind, cls):
            return name
    raise TypeError(f"expected a bool, int, float, str or list of floats, found {kind.__name__}")


@dataclasses.dataclass(frozen=True)
class Context:
    """What a node knows of its run: `self.context`."""

    name: str
    """Its name in the graph."""
    seed: int
    """For its random numbers, derived from the run's seed and its name: `numpy.random.default_rng(seed)`."""
    torque: bool
    """False in a scene that is translation-only: torques are neither computed nor sent."""
    duration_ns: int
    """Of the run; 2 * 10**18 where it goes on until it is stopped."""


class Step:
    """What a step is told."""

    __slots__ = ("now_ns", "phase", "work")

    def __init__(self) -> None:
        self.now_ns = 0
        """The time of the step, in ns of the run."""
        self.phase = "running"
        """"starting", "running", or "stopping" while devices ramp down."""
        self.work = 0
        """Set by the step: how many items it worked on, for which a `cost` of the graph charges."""

    @property
    def now(self) -> float:
        """The time of the step, in s of the run."""
        return self.now_ns * 1e-9


class Node:
    """A node. The class declares ports and parameters as attributes, and does its work in `step`.

    The first line of the docstring tells what it does; the rest goes into its help. A node without outputs is a sink.
    `__init__` takes no arguments; ports, parameters and `self.context` are there already.
    """

    role: str = "other"
    """What it does in the pipeline: other, source, collision, dynamics, coupling, prediction, interpolation, force_field."""

    context: Context

    def start(self, step: Step) -> None:
        """Called once before any step; may send."""

    def step(self, step: Step) -> None:
        """The work: reads inputs, sends outputs."""
        raise NotImplementedError(f"{type(self).__name__} has no step")

    def tune(self) -> None:
        """Called when a tunable parameter was set; its attribute has the new value."""


# What follows is for the library that runs such classes in a graph.


class Refused(Exception):
    """The file or the class cannot be used; the text says why, with the file and the line."""


_RESERVED = frozenset(dir(Node)) | {"context"}


@dataclasses.dataclass
class _Loaded:
    namespace: dict[str, Any]
    sources: dict[str, bytes]  # path -> content that was run


_files: dict[str, _Loaded] = {}
_classes: dict[int, dict[str, Any]] = {}


def load(file: str, name: str) -> tuple[Type[Node], bytes]:
    """The class `name` of the file, which is run where it has changed, and the code that was run, its modules' too."""
    loaded = _files.get(file)
    if loaded is None or any(_read(path) != content for path, content in loaded.sources.items()):
        loaded = _files[file] = _run(file)
    found = loaded.namespace.get(name)
    if not (isinstance(found, type) and issubclass(found, Node)):
        own = [k for k, v in loaded.namespace.items() if isinstance(v, type) and issubclass(v, Node) and v is not Node]
        what = "no such name" if found is None else "something else"
        there = f"; it has {', '.join(own)}" if own else "; it has none at all"
        raise Refused(f"{file}: expected a class {name} that derives from tactor.Node, found {what}{there}")
    code = b""
    for path in sorted(loaded.sources):
        for part in (os.fsencode(os.path.relpath(path, os.path.dirname(file))), loaded.sources[path]):
            code += b"%d:%b" % (len(part), part)
    return found, code


def _read(path: str) -> bytes | None:
    try:
        with open(path, "rb") as stream:
            return stream.read()
    except OSError:
        return None


def _run(file: str) -> _Loaded:
    import sys
    import types

    content = _read(file)
    if content is None:
        raise Refused(f"{file}: cannot be read")
    module = types.ModuleType(os.path.splitext(os.path.basename(file))[0] + "@" + file)
    module.__file__ = file
    folder = os.path.dirname(file)
    sources = {file: content}
    finder = _Finder(folder, sources)
    # Modules below the folder belong to this run of the file: another one, or another folder, imports its own.
    others = _take_out(finder)
    sys.modules[module.__name__] = module
    sys.path.insert(0, folder)
    sys.meta_path.insert(0, finder)
    try:
        exec(compile(content, file, "exec", dont_inherit=True), module.__dict__)
    except SyntaxError as error:
        raise Refused(f"{error.filename}:{error.lineno}: {type(error).__name__}: {error.msg}") from None
    except BaseException as error:
        raise Refused(f"{_line_of(error, file)}: {explain(error, file)}") from None
    finally:
        sys.meta_path.remove(finder)
        sys.path.remove(folder)
        _take_out(finder)
        sys.modules.update(others)
    return _Loaded(module.__dict__, sources)


class _Finder:
    """Finds the modules below a folder, and compiles them from the bytes that count, without a .pyc file."""

    def __init__(self, folder: str, sources: dict[str, bytes]):
        self.folder = folder
        self.sources = sources

    def owns(self, path: Any) -> bool:
        """Whether the path lies below the folder, and not in what Python has installed there."""
        if not isinstance(path, str):
            return False
        path = os.path.abspath(path)
        installed = {"site-packages", "dist-packages"} & set(path[len(self.folder):].split(os.sep))
        return path.startswith(os.path.join(self.folder, "")) and not installed

    def find_spec(self, name: str, path: Any = None, target: Any = None) -> Any:
        from importlib.machinery import PathFinder, SourceFileLoader

        spec = PathFinder.find_spec(name, path, target)
        if spec is None or not self.owns(spec.origin) or name.partition(".")[0] == "tactor":
            return None
        source = os.path.abspath(str(spec.origin))
        content = _read(source)
        if content is not None:
            self.sources[source] = content
        if content is not None and type(spec.loader) is SourceFileLoader:
            spec.loader = _loader(name, source, content)
        return spec


def _loader(name: str, path: str, content: bytes) -> Any:
    from importlib.machinery import SourceFileLoader

    class Loader(SourceFileLoader):
        def get_code(self, fullname: str) -> Any:
            return compile(content, path, "exec", dont_inherit=True)

    return Loader(name, path)


def _take_out(finder: _Finder) -> dict[str, Any]:
    """The modules that Python has of the finder's folder, which are imported anew from now on."""
    import sys

    def is_own(name: str, module: Any) -> bool:
        if name in ("__main__", "__mp_main__") or "@" in name or name.partition(".")[0] == "tactor":
            return False
        places = [getattr(module, "__file__", None)]
        if places == [None]:
            places = list(getattr(module, "__path__", []))  # a package without __init__.py
        return any(finder.owns(place) for place in places)

    own = {name: module for name, module in list(sys.modules.items()) if is_own(name, module)}
    for name in own:
        del sys.modules[name]
    return own


def _line_of(error: BaseException, file: str) -> str:
    line = 0
    traceback = error.__traceback__
    while traceback is not None:
        if traceback.tb_frame.f_code.co_filename == file:
            line = traceback.tb_lineno
        traceback = traceback.tb_next
    return f"{file}:{line}" if line else file


def explain(error: BaseException, file: str | None = None) -> str:
    """The error and its traceback, without the frames of this module before those of the file."""
    import traceback

    first = error.__traceback__
    while first is not None and first.tb_frame.f_code.co_filename == __file__:
        first = first.tb_next
    return "".join(traceback.format_exception(type(error), error, first)).rstrip()


def describe(cls: Type[Node]) -> dict[str, Any]:
    """The declaration of a class as plain data: name, summary, details, role, inputs, outputs, parameters."""
    import inspect

    where = f"{inspect.getfile(cls)}:{_line(cls)}: class {cls.__name__}"

    def refuse(what: str) -> None:
        raise Refused(f"{where}: {what}")

    doc = inspect.getdoc(cls) if cls.__doc__ else ""
    summary, _, details = (doc or "").partition("\n")
    if not summary:
        refuse("expected a docstring whose first line tells what the node does, found none")
    if cls.step is Node.step:
        refuse("expected a method step(self, step), found none")
    if cls.role not in _ROLES:
        refuse(f"role: expected one of {', '.join(_ROLES)}, found {cls.role!r}")
    made: dict[str, Any] = {"name": cls.__name__, "summary": summary, "details": details.strip()}
    made |= {"role": cls.role, "inputs": [], "outputs": [], "parameters": []}
    for name, value in _declared(cls).items():
        if name in _RESERVED:
            refuse(f"{name} is an attribute of every node; give the port or parameter another name")
        if not (name.isascii() and name.isidentifier()) or name.startswith("_") or len(name) > 64:
            refuse(f"{name}: expected a name of ASCII letters, digits and _ that begins with a letter")
        if isinstance(value, Input):
            if not isinstance(value.queue, int) or not 1 <= value.queue <= 100_000:
                refuse(f"{name}: expected a queue of 1 to 100000 messages, found {value.queue!r}")
            made["inputs"].append((name, value.message, value.trigger, value.required, value.queue, value.doc))
        elif isinstance(value, Output):
            made["outputs"].append((name, value.message, value.doc))
        else:
            made["parameters"].append((name, value))
    rates = [name for name, value in made["parameters"] if value.rate]
    if len(rates) > 1:
        refuse(f"expected one Rate at most, found {', '.join(rates)}")
    if not rates and not any(trigger for _, _, trigger, _, _, _ in made["inputs"]):
        refuse("expected an input with trigger=True or a Rate, without which it never steps, found neither")
    return made


def _line(cls: Type[Node]) -> int:
    import inspect

    try:
        return inspect.getsourcelines(cls)[1]
    except (OSError, TypeError):
        return 1


def _declared(cls: Type[Node]) -> dict[str, Any]:
    """Ports and parameters of the class and those it derives from, in the order of their declaration."""
    found: dict[str, Any] = {}
    for base in reversed(cls.__mro__):
        for name, value in vars(base).items():
            if isinstance(value, (Input, Output, _Parameter)):
                found[name] = value
            else:
                found.pop(name, None)  # a class may take out what its base declares
    return found


def make(
    cls: Type[Node],
    ports: Iterable[tuple[str, dict[str, Any]]],
    values: dict[str, Any],
    context: tuple[str, int, bool, int],
) -> Node:
    """A node whose ports do what the functions of `ports` do."""
    node = cls.__new__(cls)
    node.context = Context(*context)
    for name, functions in ports:
        port = copy.copy(getattr(cls, name))
        vars(port).update(functions)
        setattr(node, name, port)
    assign(node, values)
    node.__init__()  # type: ignore[misc]
    return node


def assign(node: Node, values: dict[str, Any]) -> None:
    """Sets parameters; a list becomes an array."""
    for name, value in values.items():
        setattr(node, name, np.array(value) if isinstance(value, list) else value)
