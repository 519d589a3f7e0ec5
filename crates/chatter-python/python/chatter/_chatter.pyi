"""The compiled part of `chatter`. Texts are in the notation of the command line."""

import os
from collections.abc import Callable, Sequence
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Core", "EVENT_KINDS", "Question", "Upsilon", "__version__", "border", "branches", "curve", "diagram", "explorer_answer",
    "explorer_page", "exponents", "main", "merge", "merge_branches", "of_branches", "orbit", "resume", "resume_branches", "shipped",
    "simulate",
]
__version__: str
EVENT_KINDS: list[str]

_Pairs = Sequence[tuple[str, str]]
_Progress = Callable[[float, str], object] | None

@final
class Core:
    """A model with what was set into it."""

    name: str
    text: str
    data_files: dict[str, str]
    set: list[tuple[str, str]]
    initial: list[tuple[str, str]]
    title: str | None
    states: list[str]
    parameters: dict[str, float]
    start: dict[str, float]
    depends_on_time: bool
    contacts: list[str]
    sections: list[str]
    labels: list[tuple[str, str | None, str | None]]
    warnings: list[str]
    @staticmethod
    def shipped(name: str) -> Core: ...
    @staticmethod
    def from_file(path: str) -> Core: ...
    @staticmethod
    def from_text(text: str, name: str) -> Core: ...
    @staticmethod
    def restore(state: tuple[str, str, dict[str, str], _Pairs, _Pairs]) -> Core: ...
    def with_values(self, values: _Pairs) -> Core: ...
    def drawn(self, state: Sequence[float], time: float) -> list[tuple[str, list[float], list[NDArray[np.float64]]]]: ...
    def __getstate__(self) -> tuple[str, str, dict[str, str], list[tuple[str, str]], list[tuple[str, str]]]: ...

@final
class Upsilon:
    """Upsilon for one restitution."""

    def __new__(cls, restitution: float) -> Upsilon: ...
    lap_end: float
    constants: dict[str, float]
    def values(self, x: NDArray[np.float64]) -> NDArray[np.float64]: ...
    def evaluations(self, x: NDArray[np.float64]) -> dict[str, NDArray[np.float64]]: ...
    def windows(self, slope: float, first: int, last: int) -> dict[str, Any]: ...

def shipped() -> list[tuple[str, str]]: ...
def simulate(
    core: Core,
    *,
    until: str | None = None,
    impacts: int | None = None,
    stop: Sequence[str] = ...,
    tolerance: str | None = None,
    sample: str | None = None,
    times: NDArray[np.float64] | None = None,
    digits: int = 17,
    progress: _Progress = None,
) -> dict[str, Any]: ...
def diagram(
    core: Core,
    asked: dict[str, Any],
    journal: str | os.PathLike[str] | None = None,
    shard: tuple[int, int] | None = None,
    progress: _Progress = None,
) -> dict[str, Any] | None: ...
def merge(
    journals: Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    threads_wanted: str | None = None,
    progress: _Progress = None,
) -> dict[str, Any]: ...
def orbit(
    core: Core,
    *,
    period: str | None = None,
    section: str | None = None,
    periods: int | None = None,
    starts: int | None = None,
    seed: int = 0,
    digits: int = 17,
    progress: _Progress = None,
) -> str: ...
def branches(
    core: Core,
    asked: dict[str, Any],
    journal: str | os.PathLike[str] | None = None,
    shard: tuple[int, int] | None = None,
    through: tuple[Sequence[float], float] | None = None,
    progress: _Progress = None,
) -> tuple[str, str] | None: ...
def merge_branches(
    journals: Sequence[str | os.PathLike[str]],
    out: str | os.PathLike[str],
    progress: _Progress = None,
) -> tuple[str, str]: ...
def resume_branches(path: str | os.PathLike[str], progress: _Progress = None) -> tuple[str, str]: ...
def of_branches(paths: Sequence[str | os.PathLike[str]]) -> bool: ...
def curve(
    core: Core,
    kind: str,
    state: Sequence[float],
    orbit_period: float,
    parameters: tuple[str, str],
    low: str,
    high: str,
    *,
    period: str | None = None,
    section: str | None = None,
    monitor: str | None = None,
    impacts: int | None = None,
    points: int | None = None,
    step: float | None = None,
    progress: _Progress = None,
) -> str: ...
def exponents(
    core: Core,
    *,
    interval: str | None = None,
    transient: str | None = None,
    intervals: str | None = None,
    progress: _Progress = None,
) -> str: ...
def resume(
    path: str | os.PathLike[str],
    threads_wanted: str | None = None,
    progress: _Progress = None,
) -> dict[str, Any] | None: ...
def border(
    core: Core,
    parameter: str,
    *,
    near: str | None = None,
    range: tuple[str, str] | None = None,
    samples: int | None = None,
    excursions: int | None = None,
    section: str | None = None,
    windows: tuple[int, int] | None = None,
    digits: int = 17,
    progress: _Progress = None,
) -> str: ...
def main(arguments: Sequence[str]) -> int: ...

@final
class Question:
    """A question of the explorer's page that is being answered."""

    def stop(self) -> None: ...

def explorer_page() -> list[tuple[str, str]]: ...
def explorer_answer(core: Core, asked: str, body: bytes, put: Callable[[bytes], object]) -> Question: ...
