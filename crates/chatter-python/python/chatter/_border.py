"""Border orbits: where complete chatter ends exactly at release."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

from chatter._frozen import Frozen

if TYPE_CHECKING:
    from decimal import Decimal


class Border(Frozen):
    """A border orbit, its normal form and its windows.

    Everything is in `document`, by the names that `chatter border --json` gives; the first floor of it are attributes, too.
    With more than 17 digits each number has a twin as text under its name with `_digits`; `decimal("value")` gives it as a
    number.
    """

    document: Mapping[str, Any]
    """The whole answer."""
    parameter: str
    """The parameter that is varied."""
    value: float
    """Its value at the border."""
    error: float
    """Estimate of the error of that value."""

    def __init__(self, document: Mapping[str, Any]) -> None:
        self._set(document=document, **document)

    def decimal(self, name: str) -> Decimal:
        """A number to all its digits."""
        from decimal import Decimal

        return Decimal(self.document.get(f"{name}_digits", repr(self.document[name])))

    def __reduce__(self) -> tuple[Any, ...]:
        return (Border, (self.document,))

    def __repr__(self) -> str:
        return f"<Border at {self.parameter} = {self.value!r}>"


class Borders(Frozen):
    """The borders of a range, and what is known beside them."""

    document: Mapping[str, Any]
    """The whole answer, by the names that `chatter border --range --json` gives."""
    _borders: tuple[Border, ...]
    breaks: list[Mapping[str, Any]]
    """Places where complete chatter ends without a border."""

    def __init__(self, document: Mapping[str, Any]) -> None:
        found = tuple(Border(one) for one in document["borders"])
        self._set(document=document, breaks=document["breaks"], _borders=found)

    def __len__(self) -> int:
        return len(self._borders)

    def __getitem__(self, index: int) -> Border:
        return self._borders[index]

    def __iter__(self) -> Iterator[Border]:
        return iter(self._borders)

    def __reduce__(self) -> tuple[Any, ...]:
        return (Borders, (self.document,))

    def __repr__(self) -> str:
        low, high = self.document["range"]
        return f"<{len(self)} borders from {low!r} to {high!r}>"


def read(text: str) -> Any:
    """What the document holds: one border, or those of a range."""
    document = json.loads(text)
    return Borders(document) if "borders" in document else Border(document)
