"""A bar in terminals and notebooks for what lasts."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

Progress = Callable[[float, str], object]


@contextmanager
def shown(progress: bool | Progress) -> Iterator[Progress | None]:
    """What is called with the part that is done, from 0 to 1, and a message.

    `True` is a bar, of tqdm where that is installed; a function is called itself.
    """
    if callable(progress):
        yield progress
    elif not progress:
        yield None
    else:
        try:
            from tqdm.auto import tqdm
        except ImportError:
            yield _line
            sys.stderr.write("\r\x1b[K")
        else:
            with tqdm(total=1.0, bar_format="{l_bar}{bar}| {elapsed}<{remaining} {postfix}") as bar:

                def update(done: float, message: str) -> None:
                    bar.set_postfix_str(message, refresh=False)
                    bar.n = done
                    bar.refresh()

                yield update


def _line(done: float, message: str) -> Any:
    sys.stderr.write(f"\r\x1b[K{100 * done:3.0f} %  {message}")
    sys.stderr.flush()
