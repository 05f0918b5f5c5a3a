"""Tactor renders smooth force feedback from slow physics. From Python: run graphs, look at them while they run, compare them.

    import tactor
    result = tactor.run("wall/refit", duration="2 s")
    print(result.metrics["delivered.force.rms_error_N"])

Times are in s, or texts with a unit (`"10 ms"`); other numbers are in SI units. Arrays are numpy's, structured, with
`.units`. What is refused raises InputError, what fails while running RunError, with the texts of the command `tactor`.
"""
from ._commands import compare, study, study_table
from ._errors import Diagnostic, Error, InputError, InputWarning, RunError
from ._graph import Graph, check, load
from ._messages import Field, Messages, MessageType
from ._nodes import NodeType, Parameter, Port, nodes
from ._recording import Recording, Stream
from ._run import Metrics, Result, run
from ._session import Feed, Session, Tap
from ._tactor import version as __version__

__all__ = [
    "Diagnostic", "Error", "Feed", "Field", "Graph", "InputError", "InputWarning", "Messages", "MessageType", "Metrics",
    "NodeType", "Parameter", "Port", "Recording", "Result", "RunError", "Session", "Stream", "Tap", "__version__",
    "check", "compare", "load", "nodes", "run", "study", "study_table",
]
