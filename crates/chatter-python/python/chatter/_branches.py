"""Branches of periodic orbits that are looked for: all of them, with journals, in shares."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from chatter import _chatter
from chatter._errors import InputError
from chatter._periodic import Branch, check_names
from chatter._progress import shown
from chatter._text import text_of

if TYPE_CHECKING:
    from chatter._model import Model
    from chatter._progress import Progress

    Path = str | os.PathLike[str]

OPTIONS = {"doublings", "branch_points", "impacts", "points", "step", "monitors", "starts", "seed", "period", "section"}


def branches(
    model: Model,
    parameter: str,
    low: Any,
    high: Any,
    *,
    how: Mapping[str, Any] | None = None,
    through: tuple[list[float], float] | None = None,
    all: int | None = None,
    starts: int | None = None,
    seed: int | None = None,
    out: Path | None = None,
    journal: Path | None = None,
    progress: bool | Progress = False,
    **limits: Any,
) -> list[Branch]:
    """All branches that are found over a range of a parameter, from the orbit that the motion settles to, or from the one through
    these states and of this period; as `Model.branches`, which says what the rest is.
    """
    if through is not None and (all is not None or out is not None or journal is not None):
        raise InputError("what is followed from a given orbit is neither searched for nor kept: leave out `all`, `out` and `journal`")
    if out is not None and journal is not None:
        raise InputError("what is done is kept beside `out`: leave out `journal`")
    asked = _asked(parameter, (low, high), {**(how or {}), **limits, "all": all, "starts": starts, "seed": seed, "out": out})
    kept = None if journal is None else os.fspath(journal)
    with shown(progress) as hears:
        told = _chatter.branches(model._core, asked, kept, None, through, hears)
    assert told is not None
    return _read(told, model)


def share(
    model: Model, number: int, of: int, parameter: str, ends: tuple[Any, Any], options: Mapping[str, Any], progress: Progress | None
) -> None:
    """Follows a share of the orbits, into its journal."""
    _chatter.branches(model._core, _asked(parameter, ends, options), None, (number, of), None, progress)


def resume(path: str, progress: Progress | None) -> list[Branch]:
    """Goes on with branches that were broken off."""
    return _read(_chatter.resume_branches(path, progress))


def merge(journals: Sequence[str], out: str, progress: Progress | None) -> list[Branch]:
    """Puts the shares of branches together."""
    return _read(_chatter.merge_branches(journals, out, progress))


def swept(sweep: Mapping[str, Any]) -> tuple[str, tuple[Any, Any]]:
    """The parameter and the ends of its range."""
    if len(sweep) != 1:
        raise InputError("branches are followed over one parameter: expected q=(low, high)")
    ((name, ends),) = sweep.items()
    if isinstance(ends, str) or not hasattr(ends, "__len__") or len(ends) != 2:
        raise InputError(f"{name}={ends!r}: expected (low, high), or there is no option {name}")
    return name, (ends[0], ends[1])


def _asked(parameter: str, ends: tuple[Any, Any], options: Mapping[str, Any]) -> dict[str, Any]:
    check_names(options, OPTIONS | {"all", "out"})
    asked = {name: value for name, value in options.items() if value is not None}
    asked["parameter"] = parameter
    asked["range"] = tuple(text_of(end) for end in ends)
    asked["monitors"] = [text_of(one) for one in asked.get("monitors", ())]
    for name in {"step", "period"} & asked.keys():
        asked[name] = text_of(asked[name])
    if "out" in asked:
        asked["out"] = os.fspath(asked["out"])
    return asked


def _read(told: tuple[str, str], model: Model | None = None) -> list[Branch]:
    job, document = (json.loads(text) for text in told)
    if model is None:
        from chatter._model import Model

        pairs = ([tuple(pair) for pair in job[name]] for name in ("set", "initial"))
        model = Model._of(_chatter.Core.restore((job["model"], job["model_text"], job.get("data_files", {}), *pairs)))
    how = {"period": job["period"], "section": job["section"]}
    return [Branch(model, job["parameter"], how, one) for one in document["branches"]]
