"""Orbit diagrams by the workers of a Dask cluster."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from chatter._diagram import Diagram, merge

if TYPE_CHECKING:
    from chatter._model import Model
    from chatter._progress import Progress

_A_THREAD = 2
"""Shares for each thread: more than one, so that a slow worker does not keep all others waiting for the last."""


def share(model: Model, number: int, of: int, asked: Mapping[str, Any]) -> str:
    """What a worker does: one share, on one thread; gives its journal."""
    import warnings

    from chatter._errors import ChatterWarning

    with warnings.catch_warnings():
        # That a share goes on or is small is nothing to do anything about here.
        warnings.simplefilter("ignore", ChatterWarning)
        return model.diagram_shard(number, of, **{**asked, "threads": 1})


def diagram(model: Model, client: Any, shards: int | None, asked: Mapping[str, Any], hears: Progress | None) -> Diagram:
    """Deals shares out to the workers of a `dask.distributed.Client`, and merges them."""
    from distributed import as_completed

    of = shards or max(1, _A_THREAD * sum(client.nthreads().values()))
    futures = [client.submit(share, model, number, of, asked, pure=False) for number in range(1, of + 1)]
    try:
        for done, _ in enumerate(as_completed(futures, raise_errors=True), 1):
            if hears is not None:
                hears(done / of, f"{done} of {of} shares")
        journals: list[str] = client.gather(futures)
    except BaseException:
        client.cancel(futures)
        raise
    import warnings

    from chatter._errors import ChatterWarning

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ChatterWarning)
        found = merge(journals, asked["out"], None, None)
    for journal in journals:
        os.remove(journal)
    return found
