"""The exceptions of the package. Their texts are those of the command."""
from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, List, Optional, Sequence, Tuple

if TYPE_CHECKING:
    from ._run import Result


class Error(Exception):
    """Whatever Tactor refuses or fails at."""


@dataclass(frozen=True)
class Diagnostic:
    """One error of a file."""

    file: str
    line: int  #: from 1; 0: the file as a whole, or an argument
    column: int  #: from 1; 0 likewise
    message: str


class InputError(Error, ValueError):
    """What was given (a graph, a mesh, a recording, an argument) cannot be used.

    `diagnostics` has every error of a graph file; `file`, `line` and `column` are those of the first, or None.
    """

    def __init__(self, text: str, diagnostics: Sequence[Tuple[str, int, int, str]] = ()) -> None:
        super().__init__(text)
        self.diagnostics: List[Diagnostic] = [Diagnostic(*one) for one in diagnostics]
        first = self.diagnostics[0] if self.diagnostics else None
        self.file: Optional[str] = first.file if first else None
        self.line: Optional[int] = first.line if first else None
        self.column: Optional[int] = first.column if first else None


class RunError(Error, RuntimeError):
    """Something failed while running, or a session was asked for what its state does not allow.

    `result` is what a failed `run` has up to there, or None.
    """

    def __init__(self, text: str, diagnostics: Sequence[Tuple[str, int, int, str]] = ()) -> None:
        super().__init__(text)
        self.result: Optional[Result] = None


class InputWarning(UserWarning):
    """Something of a graph that nothing stops for, such as a tool that touches no body."""
