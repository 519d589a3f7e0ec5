"""Periodic orbits and their branches."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from chatter import _chatter
from chatter._errors import InputError
from chatter._frozen import Frozen, frozen
from chatter._progress import shown
from chatter._text import labelled, text_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray
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
    neutral: bool
    """Whether the largest of them are on the unit circle, as far as they are known: then it is neither stable nor unstable by them."""

    _how: Mapping[str, Any]

    def __init__(self, model: Model, how: Mapping[str, Any], document: Mapping[str, Any]) -> None:
        self._set(**document)
        self._set(model=model, document=document, _how=dict(how), multipliers=frozen(_complex(document["multipliers"])))

    def follow(self, parameter: str, to: Any, *, progress: bool | Progress = False, **limits: Any) -> Branch:
        """The branch of this orbit, stable or not, from its own value of a parameter to another.

        limits: as for `branches`.
        """
        from chatter._branches import branches

        other = float(self.model.with_values({parameter: to}).parameters[parameter])
        ends = sorted((self.model.parameters[parameter], other))
        through = (list(self.start.values()), self.period)
        return branches(self.model, parameter, *ends, how=self._how, through=through, progress=progress, **limits)[0]

    def __reduce__(self) -> tuple[Any, ...]:
        return (PeriodicOrbit, (self.model, self._how, self.document))

    def __repr__(self) -> str:
        impacts = "complete chatter" if self.impacts is None else f"{self.impacts} impacts"
        stability = "stable" if self.stable else "neutral" if self.neutral else "unstable"
        return f"<PeriodicOrbit of period {self.period!r}, {impacts}, {stability}>"


class Special(Mapping[str, Any]):
    """A special point of a branch: a mapping with "kind", "value" of the parameter, "error", "period", "impacts",
    "multipliers", "state" and more, as `chatter continue --json` gives them.
    """

    def __init__(self, branch: Branch, document: Mapping[str, Any]) -> None:
        self._branch, self._document = branch, document

    def __getitem__(self, name: str) -> Any:
        return self._document[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._document)

    def __len__(self) -> int:
        return len(self._document)

    def follow(
        self, one: str, two: str, *, low: Any = None, high: Any = None, progress: bool | Progress = False, **limits: Any
    ) -> Curve:
        """The curve of this point in two parameters, one of them that of the branch.

        low, high: the range of the other one, over which it is followed; from half its value to twice as much without them.
        limits: `impacts` (80) a period at most, `points` (20000), and the longest `step` in parts of the range (0.01).
        """
        check_names(limits, {"impacts", "points", "step"})
        branch = self._branch
        other = {one, two} - {branch.parameter}
        if branch.parameter not in (one, two) or len(other) != 1:
            raise InputError(f"expected two parameters, one of them `{branch.parameter}`, that of the branch")
        (name,) = other
        model = branch.model.with_values({branch.parameter: self["value"]})
        if name not in model.parameters:
            raise InputError(f"the model has no parameter `{name}`")
        value = model.parameters[name]
        ends = sorted((value / 2, 2 * value)) if value else [-1.0, 1.0]
        low, high = ends[0] if low is None else low, ends[1] if high is None else high
        with shown(progress) as hears:
            text = _chatter.curve(
                model._core, self["kind"], list(self["state"].values()), self["period"], (branch.parameter, name),
                text_of(low), text_of(high), monitor=self["monitor"], progress=hears, **{**branch._how, **limits},
            )  # fmt: skip
        return Curve(model, (branch.parameter, name), json.loads(text)["branches"][0])

    def __reduce__(self) -> tuple[Any, ...]:
        return (Special, (self._branch, self._document))

    def __repr__(self) -> str:
        return f"<{self['kind'].replace('_', ' ')} at {self._branch.parameter} = {self['value']!r}>"


class Curve(Frozen):
    """The curve of a special point in two parameters: n points. Indexed with a name it gives a column of shape (n,)."""

    parameters: tuple[str, str]
    """Both parameters."""
    kind: str
    """What the points are."""
    points: Mapping[str, NDArray[Any]]
    """The columns by name; "multipliers" is a list of arrays."""
    ends: tuple[str, ...]
    """How each end came about."""
    model: Model
    """The model."""

    _document: Mapping[str, Any]

    def __init__(self, model: Model, parameters: tuple[str, str], document: Mapping[str, Any]) -> None:
        self._set(
            model=model, parameters=parameters, kind=document["kind"], points=_columns(document["points"]),
            ends=tuple(document["ends"]), _document=document,
        )  # fmt: skip

    def __len__(self) -> int:
        return len(self.points["period"])

    def __getitem__(self, name: str) -> Any:
        return self.points[name]

    def to_pandas(self) -> DataFrame:
        """A DataFrame, one point a row."""
        import pandas

        return pandas.DataFrame({name: list(values) for name, values in self.points.items()})

    def plot(self, ax: Axes | None = None, **style: Any) -> Axes:
        """Draws the second parameter over the first; gives the axes."""
        if ax is None:
            import matplotlib.pyplot as plt

            _, ax = plt.subplots()
        one, two = self.parameters
        labels = self.model._labels
        ax.plot(self[one], self[two], **{"linewidth": 1.0, "label": self.kind.replace("_", " "), **style})
        ax.set_xlabel(labelled(one, labels.get(one)))
        ax.set_ylabel(labelled(two, labels.get(two)))
        return ax

    def __reduce__(self) -> tuple[Any, ...]:
        return (Curve, (self.model, self.parameters, self._document))

    def __repr__(self) -> str:
        return f"<Curve of {len(self)} points of kind {self.kind} over {' and '.join(self.parameters)}>"


class Exponents(Frozen):
    """All Lyapunov exponents of a motion."""

    values: NDArray[np.float64]
    """The exponents, in falling order; minus infinity for a direction that chatter or contact forgets."""
    errors: NDArray[np.float64]
    """Their standard errors."""
    dimension: float
    """Kaplan and Yorke's."""
    time: float
    """How long was averaged."""
    intervals: int
    """Over how many intervals."""
    document: Mapping[str, Any]
    """The whole answer."""

    def __init__(self, document: Mapping[str, Any]) -> None:
        values = [-np.inf if value is None else value for value in document["exponents"]]
        errors = [np.nan if value is None else value for value in document["errors"]]
        self._set(
            values=frozen(values), errors=frozen(errors), dimension=document["dimension"], time=document["time"],
            intervals=document["intervals"], document=document,
        )  # fmt: skip

    def __reduce__(self) -> tuple[Any, ...]:
        return (Exponents, (self.document,))

    def __repr__(self) -> str:
        return f"<Exponents {self.values.tolist()}>"


class Arc(Frozen):
    """A part of a branch from graze to graze."""

    impacts: int | None
    """Impacts in a period; None where they are infinitely many."""
    low: float
    """The least value of the parameter on it, …"""
    high: float
    """… and the greatest."""
    points: slice
    """Which orbits of the branch: `branch["period"][arc.points]`."""
    special: tuple[Special, ...]
    """Its special points; a graze is one of both arcs that meet there."""

    def __init__(self, document: Mapping[str, Any], special: tuple[Special, ...]) -> None:
        first = document["first"]
        self._set(
            impacts=document["impacts"], low=document["low"], high=document["high"],
            points=slice(first, first + document["points"]), special=special, _document=document,
        )  # fmt: skip

    _document: Mapping[str, Any]

    def __reduce__(self) -> tuple[Any, ...]:
        return (Arc, (self._document, self.special))

    def __repr__(self) -> str:
        impacts = "complete chatter" if self.impacts is None else f"{self.impacts} impacts"
        return f"<Arc of {impacts}, from {self.low!r} to {self.high!r}>"


class Branch(Frozen):
    """A branch of periodic orbits: n of them.

    Indexed with a name it gives a column, of shape (n,): the parameter, "period", "impacts" (-1 where infinitely many), "stable",
    "neutral", the states at the section, and the functions that were watched, by their text.
    """

    parameter: str
    """The parameter."""
    points: Mapping[str, NDArray[Any]]
    """The columns by name; "multipliers" is a list of arrays."""
    special: Mapping[str, tuple[Special, ...]]
    """Special points by kind: "fold", "period_doubling", "neimark_sacker", "branch_point", "impact_graze", …; each has
    "value", "error", "impacts", "multipliers", "state" and more, and can be followed in two parameters."""
    arcs: tuple[Arc, ...]
    """Its parts from graze to graze, each with one number of impacts."""
    ends: tuple[str, ...]
    """How each end came about."""
    model: Model
    """The model."""

    _document: Mapping[str, Any]
    _how: Mapping[str, Any]

    def __init__(self, model: Model, parameter: str, how: Mapping[str, Any], document: Mapping[str, Any]) -> None:
        special: dict[str, tuple[Special, ...]] = {}
        points = [Special(self, one) for one in document["special"]]
        for one in points:
            special[one["kind"]] = (*special.get(one["kind"], ()), one)
        arcs = tuple(Arc(one, tuple(points[place] for place in one["special"])) for one in document["arcs"])
        self._set(
            model=model, parameter=parameter, points=_columns(document["points"]), special=special, arcs=arcs,
            ends=tuple(document["ends"]), _document=document, _how=dict(how),
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
        """Draws a state at the section, or "period", over the parameter: stable orbits solid, neutral ones dotted, others dashed,
        special points marked; gives the axes.
        """
        if ax is None:
            import matplotlib.pyplot as plt

            _, ax = plt.subplots()
        labels = self.model._labels
        changing = [state for state in self.model.states if np.ptp(self[state]) > 0]
        name = name or (changing or ["period"])[0]
        x, y, stable, neutral = self[self.parameter], self[name], self["stable"], self["neutral"]
        for kept, line in [(stable, "-"), (neutral, ":"), (~(stable | neutral), "--")]:
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
        return (Branch, (self.model, self.parameter, self._how, self._document))

    def __repr__(self) -> str:
        return f"<Branch of {len(self)} orbits over {self.parameter}>"


def _columns(document: Mapping[str, Any]) -> dict[str, Any]:
    columns: dict[str, Any] = {}
    for name, values in document.items():
        if name == "multipliers":
            columns[name] = [_complex(one) for one in values]
        elif name == "impacts":
            columns[name] = frozen([-1 if value is None else value for value in values])
        else:
            columns[name] = frozen(values)
    return columns


def check_names(limits: Mapping[str, Any], known: set[str]) -> None:
    """Refuses options that are none."""
    unknown = limits.keys() - known
    if unknown:
        raise InputError(f"there is no option {', '.join(sorted(unknown))}")


def _complex(values: list[Mapping[str, float]]) -> NDArray[np.complex128]:
    return np.array([complex(one["re"], one["im"]) for one in values], dtype=np.complex128)


def read_orbits(model: Model, how: Mapping[str, Any], text: str) -> list[PeriodicOrbit]:
    """The orbits of a document."""
    document = json.loads(text)
    found = document["orbits"] if "orbits" in document else [document["orbit"]]
    return [PeriodicOrbit(model, how, one) for one in found]
