"""Periodic orbits and their branches."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from chatter import _chatter
from chatter._errors import InputError
from chatter._frozen import Frozen, frozen
from chatter._progress import shown
from chatter._text import labelled, text_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from pandas import DataFrame

    from chatter._model import Model
    from chatter._progress import Progress


class PeriodicOrbit(Frozen):
    """A periodic orbit, stable or not.

    Everything is in `document`, by the names that `chatter orbit --json` gives; the first floor of it are attributes, too.
    """

    document: Mapping[str, Any]
    """The whole answer."""
    model: Model
    """The model, at the values of the orbit."""
    period: float
    """Its period."""
    start: Mapping[str, float]
    """The states where it starts, by name: `model.with_values(orbit.start)` follows it."""
    impacts: int | None
    """Impacts in a period; None where they are infinitely many."""
    multipliers: NDArray[np.complex128]
    """Those of the return map, by size."""
    stable: bool
    """Whether all of them are within the unit circle."""

    _how: Mapping[str, Any]

    def __init__(self, model: Model, how: Mapping[str, Any], document: Mapping[str, Any]) -> None:
        self._set(**document)
        self._set(model=model, document=document, _how=dict(how), multipliers=frozen(_complex(document["multipliers"])))

    def follow(self, parameter: str, to: Any, *, progress: bool | Progress = False, **limits: Any) -> Branch:
        """The branch of this orbit from its own value of a parameter to another; as for `branches`, the first found."""
        own = self.model.parameters[parameter]
        ends = sorted((own, float(self.model.with_values({parameter: to}).parameters[parameter])))
        return branches(self.model, parameter, *ends, how=self._how, progress=progress, **limits)[0]

    def __reduce__(self) -> tuple[Any, ...]:
        return (PeriodicOrbit, (self.model, self._how, self.document))

    def __repr__(self) -> str:
        impacts = "complete chatter" if self.impacts is None else f"{self.impacts} impacts"
        return f"<PeriodicOrbit of period {self.period!r}, {impacts}, {'stable' if self.stable else 'unstable'}>"


class Branch(Frozen):
    """A branch of periodic orbits: n of them.

    Indexed with a name it gives a column, of shape (n,): the parameter, "period", "impacts" (-1 where infinitely many), "stable",
    and the states at the section.
    """

    parameter: str
    """The parameter."""
    points: Mapping[str, NDArray[Any]]
    """The columns by name; "multipliers" is a list of arrays."""
    special: Mapping[str, tuple[Mapping[str, Any], ...]]
    """Special points by kind: "fold", "period_doubling", "neimark_sacker", "branch_point", "impact_graze", …; each has
    "value", "error", "impacts", "multipliers", "state" and more."""
    ends: tuple[str, ...]
    """How each end came about."""
    model: Model
    """The model."""

    _document: Mapping[str, Any]

    def __init__(self, model: Model, parameter: str, document: Mapping[str, Any]) -> None:
        points: dict[str, Any] = {}
        for name, values in document["points"].items():
            if name == "multipliers":
                points[name] = [_complex(one) for one in values]
            elif name == "impacts":
                points[name] = frozen([-1 if value is None else value for value in values])
            else:
                points[name] = frozen(values)
        special: dict[str, tuple[Any, ...]] = {}
        for one in document["special"]:
            special[one["kind"]] = (*special.get(one["kind"], ()), one)
        self._set(
            model=model, parameter=parameter, points=points, special=special, ends=tuple(document["ends"]),
            _document=document,
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.points["period"])

    def __getitem__(self, name: str) -> Any:
        return self.points[name]

    def to_pandas(self) -> DataFrame:
        """A DataFrame, one orbit a row."""
        import pandas

        return pandas.DataFrame({name: list(values) for name, values in self.points.items()})

    def plot(self, name: str | None = None, ax: Axes | None = None, **style: Any) -> Axes:
        """Draws a state at the section, or "period", over the parameter: stable orbits solid, others dashed, special points
        marked; gives the axes.
        """
        if ax is None:
            import matplotlib.pyplot as plt

            _, ax = plt.subplots()
        labels = self.model._labels
        changing = [state for state in self.model.states if np.ptp(self[state]) > 0]
        name = name or (changing or ["period"])[0]
        x, y, stable = self[self.parameter], self[name], self["stable"]
        for kept, line in [(stable, "-"), (~stable, "--")]:
            # A piece reaches to the first orbit of the next.
            near = kept | np.roll(kept, 1)
            near[0] = kept[0]
            ax.plot(x, np.where(near, y, np.nan), **{"color": "C0", "linewidth": 1.0, "linestyle": line, **style})
        for (kind, found), marker in zip(self.special.items(), "os^vDPX*<>"):
            places = [(one["value"], one["period"] if name == "period" else one["state"][name]) for one in found]
            ax.plot(*zip(*places), linestyle="none", marker=marker, markersize=4, label=kind.replace("_", " "))
        if self.special:
            ax.legend()
        ax.set_xlabel(labelled(self.parameter, labels.get(self.parameter)))
        ax.set_ylabel(labelled(name, labels.get(name)))
        return ax

    def __reduce__(self) -> tuple[Any, ...]:
        return (Branch, (self.model, self.parameter, self._document))

    def __repr__(self) -> str:
        return f"<Branch of {len(self)} orbits over {self.parameter}>"


def _complex(values: list[Mapping[str, float]]) -> NDArray[np.complex128]:
    return np.array([complex(one["re"], one["im"]) for one in values], dtype=np.complex128)


def read_orbits(model: Model, how: Mapping[str, Any], text: str) -> list[PeriodicOrbit]:
    """The orbits of a document."""
    document = json.loads(text)
    found = document["orbits"] if "orbits" in document else [document["orbit"]]
    return [PeriodicOrbit(model, how, one) for one in found]


def branches(
    model: Model,
    parameter: str,
    low: Any,
    high: Any,
    *,
    how: Mapping[str, Any] | None = None,
    progress: bool | Progress = False,
    **limits: Any,
) -> list[Branch]:
    """All branches that are found over a range of a parameter, from the orbit that the motion settles to.

    limits: `doublings` and `branch_points`, how often a branch is left for another there (0), `impacts` (80) a period at most,
        `points` (20000), and the longest `step` in parts of the range (0.01).
    """
    unknown = limits.keys() - {"doublings", "branch_points", "impacts", "points", "step"}
    if unknown:
        raise InputError(f"there is no option {', '.join(sorted(unknown))}")
    with shown(progress) as hears:
        text = _chatter.branches(
            model._core, parameter, text_of(low), text_of(high), progress=hears, **{**(how or {}), **limits}
        )
    found = json.loads(text)["branches"]
    return [Branch(model, parameter, one) for one in found]
