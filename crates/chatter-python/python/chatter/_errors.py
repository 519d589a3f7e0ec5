"""What goes wrong, as exceptions with fields."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from chatter._run import Run


class ChatterError(Exception):
    """Anything that chatter refuses."""


class ChatterWarning(UserWarning):
    """Something to know about an answer, such as how long it is going to take."""


@dataclass(frozen=True)
class ModelIssue:
    """One thing that is wrong with a model, or with a text set into it."""

    line: int
    """Where it starts, from 1."""
    column: int
    """Where it starts in the line, in characters from 1."""
    source: str
    """The file or text that it stands in."""
    message: str
    """What is wrong, in one sentence."""
    text: str
    """The whole message, with the place underlined."""


class ModelError(ChatterError, ValueError):
    """A model, or a text set into one, is wrong. All that is wrong is told at once."""

    errors: tuple[ModelIssue, ...]
    """Everything that is wrong, in the order of the text."""

    def __init__(self, text: str, errors: list[ModelIssue] | tuple[ModelIssue, ...]) -> None:
        super().__init__(text, tuple(errors))
        self.errors = tuple(errors)

    def __str__(self) -> str:
        return str(self.args[0])


class _Told(ChatterError):
    message: str
    """What is wrong."""
    help: str | None
    """What to do about it, where that is known."""

    def __init__(self, message: str, help: str | None = None) -> None:
        super().__init__(message, help)
        self.message = message
        self.help = help

    def __str__(self) -> str:
        return self.message if self.help is None else f"{self.message}\n  help: {self.help}"


class InputError(_Told, ValueError):
    """What was asked for is wrong, or does not fit the model."""


class UnfinishedError(_Told, RuntimeError):
    """What was asked for is in order, but there is no answer, or none was found."""


class OutputError(_Told, OSError):
    """A result could not be written or read back."""


class RunError(ChatterError, RuntimeError):
    """A run could not go on; what was computed before is in `run`."""

    run: Run
    """The run up to there; `run.outcome` says why it ended."""

    def __init__(self, message: str, run: Run) -> None:
        super().__init__(message, run)
        self.run = run

    def __str__(self) -> str:
        return str(self.args[0])


def warn(remark: str) -> None:
    """Tells a remark of the computation."""
    warnings.warn(remark, ChatterWarning, stacklevel=3)
