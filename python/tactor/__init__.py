"""Tactor: smooth force feedback from slow physics. Runs graphs, looks at them while they run, compares them.

    import tactor
    result = tactor.run("wall/refit", duration="2 s")
    print(result.metrics["delivered.force.rms_error_N"])

Times are in s, or texts with a unit (`"10 ms"`); other numbers are in SI units. Arrays are numpy's, structured, with
`.units`. What is refused raises InputError, what fails while running RunError, with the texts of the command `tactor`.
"""
import importlib.util as _util
import sys as _sys

if _util.find_spec(f"{__name__}._tactor") is None:
    raise ImportError(f"tactor: its module _tactor was not built for Python {_sys.version_info[0]}.{_sys.version_info[1]}. In a build "
                      "folder, build it by `cmake --build build/release --target tactor`, and use /usr/bin/python3")

from ._commands import compare, study, study_table
from ._errors import Diagnostic, Error, InputError, InputWarning, RunError
from ._graph import Graph, check, load
from ._messages import Field, Messages, MessageType
from ._node_class import Context, Input, Node, Output, Parameter, Rate, Step
from ._nodes import NodeType, nodes
from ._physics import ErpCfm, Handle, ImplicitSpring, PhysicsLoop, PhysicsStep
from ._recording import Recording, Stream
from ._run import Metrics, Result, run
from ._session import Feed, Session, Tap
from ._tactor import version as __version__

__all__ = [
    "Context", "Diagnostic", "ErpCfm", "Error", "Feed", "Field", "Graph", "Handle", "ImplicitSpring", "Input",
    "InputError", "InputWarning", "Messages", "MessageType", "Metrics", "Node", "NodeType", "Output", "Parameter",
    "PhysicsLoop", "PhysicsStep", "Rate", "Recording", "Result", "RunError", "Session", "Step", "Stream", "Tap",
    "__version__", "check", "compare", "load", "nodes", "run", "study", "study_table",
]

# Texts of exceptions and of help() name what users import.
for _name in __all__:
    if _name != "__version__":
        globals()[_name].__module__ = __name__
del _name
