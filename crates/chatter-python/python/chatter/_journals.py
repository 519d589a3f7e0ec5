"""Work that was broken off or dealt out, diagrams and branches alike: their journals are gone on with and put together."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from chatter import _branches, _chatter, _diagram
from chatter._errors import InputError
from chatter._progress import shown

if TYPE_CHECKING:
    from chatter._diagram import Diagram
    from chatter._progress import Progress

    Path = str | os.PathLike[str]


def shard_journal(out: str, number: int, of: int) -> str:
    """The journal of a share, beside the table."""
    stem = os.path.splitext(os.path.basename(out))[0]
    return os.path.join(os.path.dirname(out), f"{stem}.{number:0{len(str(of))}}-of-{of}.journal")


def resume(path: Path, *, threads: int | None = None, progress: bool | Progress = False) -> Diagram | Any:
    """Goes on with a diagram, or with branches, that were broken off, to the same bits; gives a `Diagram`, finished ones as
    they are, or a list of `Branch`.

    path: the `out` or the `journal` that was given, by Python or by the command line.
    threads: how many compute a diagram.
    """
    path = os.fspath(path)
    journal = path + ".journal"
    with shown(progress) as hears:
        if not _chatter.of_branches([journal, path]):
            return _diagram.resume(path, threads, hears)
        if not os.path.exists(journal) and path.endswith((".npz", ".csv")):
            raise InputError(f"`{path}` is finished: there is nothing to resume, and no branch is read back from a table")
        return _branches.resume(path, hears)


def merge(
    journals: Sequence[Path], out: Path, *, threads: int | None = None, progress: bool | Progress = False
) -> Diagram | Any:
    """Puts the shares of a diagram, or of branches, together: writes `out`, to the bit as one machine would have, and gives a
    `Diagram` or a list of `Branch`.

    journals: those of `Model.diagram_shard` and `Model.branches_shard`, or of the command line's `--shard`; foreign ones are
        refused, and what none of them has is computed. They stay.
    threads: how many compute what is missing of a diagram.
    """
    paths = [os.fspath(path) for path in journals]
    with shown(progress) as hears:
        if _chatter.of_branches(paths):
            return _branches.merge(paths, os.fspath(out), hears)
        return _diagram.merge(paths, os.fspath(out), threads, hears)
