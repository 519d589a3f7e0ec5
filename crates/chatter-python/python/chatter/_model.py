"""A model: equations, with values set into them."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from chatter import _border, _branches, _chatter, _diagram, _drawing, _journals, _periodic, _run, _shared
from chatter._border import Border, Borders
from chatter._diagram import Diagram
from chatter._errors import InputError
from chatter._frozen import Frozen
from chatter._periodic import Branch, Exponents, PeriodicOrbit
from chatter._progress import Progress, shown
from chatter._run import Run
from chatter._text import text_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike


def shipped_models() -> dict[str, str]:
    """The models that come with chatter: names, and the texts of their files."""
    return dict(_chatter.shipped())


class Model(Frozen):
    """Equations of a mechanical system with impacts. Immutable: `with_values` gives another.

    `Model(text)` reads the text of a model file; a text that is wrong raises ModelError with all that is wrong with it.
    """

    _core: _chatter.Core

    def __init__(self, text: str, *, name: str = "model") -> None:
        self._set(_core=_chatter.Core.from_text(text, name))

    @classmethod
    def _of(cls, core: _chatter.Core) -> Model:
        model = cls.__new__(cls)
        model._set(_core=core)
        return model

    @classmethod
    def shipped(cls, name: str) -> Model:
        """A model that comes with chatter; `shipped_models()` lists them."""
        return cls._of(_chatter.Core.shipped(name))

    @classmethod
    def from_file(cls, path: str | os.PathLike[str]) -> Model:
        """A model file. Files of tables are looked for beside it."""
        return cls._of(_chatter.Core.from_file(os.fspath(path)))

    def with_values(self, values: Mapping[str, Any] | None = None, /, **more: Any) -> Model:
        """With other values of parameters, or of states at the start (`t` is the time at the start).

        Numbers, `Expr`, SymPy expressions or texts: expressions in other parameters, such as beta="2*delta".
        """
        values = {**(values or {}), **more}
        return self._of(self._core.with_values([(name, text_of(value)) for name, value in values.items()]))

    @property
    def name(self) -> str:
        """What it is called: the file, or the name of the shipped model."""
        return self._core.name

    @property
    def title(self) -> str | None:
        """Its title."""
        return self._core.title

    @property
    def text(self) -> str:
        """The text of its file, without what was set by `with_values`."""
        return self._core.text

    @property
    def states(self) -> tuple[str, ...]:
        """Names of the states, in the order of rows of `Run.y`; time is none of them."""
        return tuple(self._core.states)

    @property
    def parameters(self) -> Mapping[str, float]:
        """Values of the parameters by name."""
        return MappingProxyType(self._core.parameters)

    @property
    def start(self) -> Mapping[str, float]:
        """Values of the states at the start by name; `t` among them where the equations depend on time."""
        return MappingProxyType(self._core.start)

    @property
    def contacts(self) -> tuple[str, ...]:
        """Names of the contacts."""
        return tuple(self._core.contacts)

    @property
    def sections(self) -> tuple[str, ...]:
        """Names of the sections."""
        return tuple(self._core.sections)

    @property
    def warnings(self) -> tuple[str, ...]:
        """What looks wrong with the model, one sentence each."""
        return tuple(self._core.warnings)

    @property
    def _labels(self) -> dict[str, tuple[str | None, str | None]]:
        return {name: (text, unit) for name, text, unit in self._core.labels}

    def simulate(
        self,
        t: Any = None,
        *,
        stop: str | Sequence[str] = (),
        impacts: int | None = None,
        sample: Any = "dense",
        tolerance: Any = None,
        digits: int = 17,
        progress: bool | Progress = False,
    ) -> Run:
        """Follows the trajectory from the start.

        t: when it ends at the latest, a number or an expression in parameters. Without it at rest for ever, else 100 units of
            time after the start, or with `stop` or `impacts` after a million.
        stop: events that end it: "KIND[:NAME][=COUNT]", KIND one of impact, accumulation, release, graze, section, cascade,
            ambiguity, NAME a contact or section; or "rest".
        impacts: after how many impacts it ends (a million).
        sample: which times `Run.t` has: "dense" or "dense:N" (N a step of the integration, 16 without it, and each event from
            both sides), "events", an interval (a number, or a text such as "2*pi/omega"), an array of times in order, or None.
        tolerance: relative error allowed in a step; rounding error without it.
        digits: above 17 the whole run is done with more digits, up to 30: `Run.t_low` and `Run.y_low` have what doubles leave.
        progress: True for a bar, or a function of the part done and a message.

        Raises RunError, with the run up to there, where the run cannot go on.
        """
        request: dict[str, Any] = {
            "until": None if t is None else text_of(t),
            "stop": [stop] if isinstance(stop, str) else list(stop),
            "impacts": impacts,
            "tolerance": None if tolerance is None else text_of(tolerance),
            "digits": digits,
        }
        with shown(progress) as hears:
            return _run.simulate(self, request, sample, hears)

    def draw(
        self, state: Mapping[str, float] | ArrayLike | None = None, *, t: float | None = None, ax: Axes | None = None
    ) -> Axes:
        """Draws the mechanism as the model's `[drawing]` has it, in its units of length; gives the axes.

        state: where it is drawn, by name or in the order of `states`; the start, as far as it says nothing else.
        t: when, for drawings that depend on time; that of the start without it.
        """
        return _drawing.draw(self, state, t, ax)

    def diagram(
        self,
        *,
        observe: Any,
        section: str | None = None,
        at: str | None = None,
        period: Any = None,
        start: str = "fresh",
        chunk: int | None = None,
        transient: int | None = None,
        keep: int | None = None,
        every: int | None = None,
        exponent: bool = False,
        record: str | None = None,
        box: Mapping[str, tuple[Any, Any]] | None = None,
        seed: int | None = None,
        longest_period: int | None = None,
        period_tolerance: Any = None,
        longest_return: Any = None,
        most_impacts: int | None = None,
        tolerance: Any = None,
        threads: int | None = None,
        sweep: Mapping[str, Sequence[Any]] | None = None,
        out: str | os.PathLike[str] | None = None,
        journal: str | os.PathLike[str] | None = None,
        client: Any = None,
        shards: int | None = None,
        progress: bool | Progress = False,
        **swept: Sequence[Any],
    ) -> Diagram:
        """What orbits settle to, for many values of one parameter or two.

        q=(lo, hi, n): sweeps parameter q over n equally spaced values, both ends included; (lo, hi, n, "log") by equal ratios.
            Two of these are a map. In `sweep={"q": (lo, hi, n)}` stand names that are options here, and initial values of
            states, as "initial:x".
        observe: what is sampled: an expression, or several; {"name": expression} names them.
        section, at, period: where: at the crossings of a section (the model's only one without any of these), at an event such
            as "impact:floor", or once in a period.
        start: where orbits start: "fresh" at the initial state, "carry", "carry:down" or "carry:both" where the one before
            ended, "random:COUNT" in a `box` of bounds by state.
        chunk: carries the state through so many values only; chunks are computed side by side.
        transient, keep, every: samples passed over (300), kept (200), and every how many.
        exponent: the largest Lyapunov exponent, too.
        record: "samples", or "classes" without samples (for two sweeps).
        out: the NPZ or CSV file that `chatter diagram --out` writes, to the bit; what is done stands in out + ".journal" until then.
        journal: a file that keeps what is done. `chatter.resume` goes on with it; it stays when all is done.
        client: a `dask.distributed.Client`: its workers compute `shards` shares (two for each thread of theirs) into journals
            beside `out`, which has to stand on a file system that they share. A worker that is lost costs little: its share goes
            on elsewhere. The file is the same to the bit.
        progress: True for a bar, or a function of the part done and a message.

        Ctrl-C raises KeyboardInterrupt within a fraction of a second; with `out` or `journal` nothing is lost.
        """
        options = dict(locals())
        for name in ("self", "observe", "sweep", "swept", "journal", "progress", "client", "shards"):
            del options[name]
        sweeps = {**(sweep or {}), **swept}
        if client is not None:
            if out is None or journal is not None:
                raise InputError("a client needs `out`, beside which shares are kept, and no `journal`")
            options["out"] = os.path.abspath(out)
            with shown(progress) as hears:
                return _shared.diagram(self, client, shards, {**options, "observe": observe, "sweep": sweeps}, hears)
        with shown(progress) as hears:
            found = _diagram.compute(self._core, _asked(**options), observe, sweeps, journal, None, hears)
        assert found is not None
        return found

    def diagram_shard(
        self, number: int, of: int, *, observe: Any, out: str | os.PathLike[str], progress: bool | Progress = False, **asked: Any
    ) -> str:
        """Computes a share of a diagram, `number` (from 1) of so many, for `chatter.merge`; gives the path of its journal.

        Everything else as for `diagram`. Each share may be computed on another machine or by another process; one that was
        broken off goes on, one that is done does nothing.
        """
        out = os.fspath(out)
        sweeps = {**(asked.pop("sweep", None) or {}), **{name: asked.pop(name) for name in asked.keys() - _OPTIONS}}
        with shown(progress) as hears:
            _diagram.compute(self._core, _asked(out=out, **asked), observe, sweeps, None, (number, of), hears)
        return _journals.shard_journal(out, number, of)

    def border(
        self,
        parameter: str,
        *,
        near: Any,
        excursions: int | None = None,
        section: str | None = None,
        windows: tuple[int, int] | None = None,
        digits: int = 17,
    ) -> Border:
        """The border orbit nearest to a value of a parameter, where complete chatter ends exactly at release.

        near: it is looked for between half of this value and twice as much; around zero between -1 and 1.
        excursions: long flights between release and the beginning of chatter, at most (2).
        section: "STATE=LEVEL", where leading-order coefficients are taken.
        windows: the first and the last n of the windows that are predicted and found in the model.
        digits: up to 30; above 17 the whole computation is done with more.
        """
        text = _chatter.border(
            self._core, parameter, near=text_of(near), excursions=excursions, section=section, windows=windows,
            digits=digits,
        )  # fmt: skip
        border: Border = _border.read(text)
        return border

    def borders(
        self,
        parameter: str,
        low: Any,
        high: Any,
        *,
        samples: int | None = None,
        excursions: int | None = None,
        windows: tuple[int, int] | None = None,
        digits: int = 17,
        progress: bool | Progress = False,
    ) -> Borders:
        """All border orbits of a range of a parameter, which is divided into `samples` parts (200)."""
        with shown(progress) as hears:
            text = _chatter.border(
                self._core, parameter, range=(text_of(low), text_of(high)), samples=samples, excursions=excursions,
                windows=windows, digits=digits, progress=hears,
            )  # fmt: skip
        borders: Borders = _border.read(text)
        return borders

    def orbit(
        self,
        values: Mapping[str, Any] | None = None,
        /,
        *,
        period: Any = None,
        section: str | None = None,
        digits: int = 17,
        progress: bool | Progress = False,
        **more: Any,
    ) -> PeriodicOrbit:
        """The periodic orbit that the motion settles to at these values, closed by Newton's method.

        period: of the forcing, an expression in parameters, where the equations do not tell it.
        section: at which states are told (the first of the model).
        """
        model = self.with_values(values, **more)
        how: dict[str, Any] = {"period": _maybe(period), "section": section}
        with shown(progress) as hears:
            text = _chatter.orbit(model._core, digits=digits, progress=hears, **how)
        return _periodic.read_orbits(model, how, text)[0]

    def orbits(
        self,
        periods: int,
        *,
        starts: int = 200,
        seed: int = 0,
        period: Any = None,
        section: str | None = None,
        digits: int = 17,
        progress: bool | Progress = False,
    ) -> list[PeriodicOrbit]:
        """All periodic orbits of up to so many periods of the forcing, or returns to the section, stable or not, that are found
        from so many starts.
        """
        how: dict[str, Any] = {"period": _maybe(period), "section": section}
        with shown(progress) as hears:
            text = _chatter.orbit(
                self._core, periods=periods, starts=starts, seed=seed, digits=digits, progress=hears, **how
            )
        return _periodic.read_orbits(self, how, text)

    def branches(
        self,
        *,
        all: int | None = None,
        starts: int | None = None,
        seed: int | None = None,
        period: Any = None,
        section: str | None = None,
        monitors: Sequence[Any] = (),
        doublings: int = 0,
        branch_points: int = 0,
        impacts: int | None = None,
        points: int | None = None,
        step: Any = None,
        out: str | os.PathLike[str] | None = None,
        journal: str | os.PathLike[str] | None = None,
        progress: bool | Progress = False,
        **swept: tuple[Any, Any],
    ) -> list[Branch]:
        """Branches of periodic orbits over a range of a parameter, q=(low, high), from the orbit that the motion settles to.

        all: from every orbit of up to so many periods of the forcing, or returns to the section, that is found from so many
            `starts` (200), which `seed` draws (0): at the model's value of the parameter, or else in the middle of the range.
        period, section: as for `orbit`.
        monitors: functions of the state at the section and of parameters, whose zeros are special points.
        doublings, branch_points: how often a branch is left for another there (0).
        impacts, points, step: impacts a period (80) and orbits of a branch to either side (20000) at most, and the longest step in
            parts of the range (0.01).
        out: the NPZ or CSV file that `chatter continue --out` writes, to the bit; how far branches have come stands in
            out + ".journal" until then.
        journal: a file that keeps how far they have come. `chatter.resume` goes on with it; it stays when all is done.
        progress: True for a bar, or a function of the part done and a message.
        """
        name, (low, high) = _branches.swept(swept)
        how = {"period": period, "section": section}
        return _branches.branches(
            self, name, low, high, how=how, all=all, starts=starts, seed=seed, monitors=monitors, doublings=doublings,
            branch_points=branch_points, impacts=impacts, points=points, step=step, out=out, journal=journal, progress=progress,
        )  # fmt: skip

    def branches_shard(
        self, number: int, of: int, *, all: int, out: str | os.PathLike[str], progress: bool | Progress = False, **asked: Any
    ) -> str:
        """Follows a share of all orbits that are found, `number` (from 1) of so many, for `chatter.merge`; gives the path of its
        journal.

        Everything else as for `branches`. Each share may be followed on another machine or by another process; one that was
        broken off goes on, one that is done does nothing.
        """
        out = os.fspath(out)
        options = {name: asked.pop(name) for name in list(asked) if name in _branches.OPTIONS}
        name, ends = _branches.swept(asked)
        with shown(progress) as hears:
            _branches.share(self, number, of, name, ends, {**options, "all": all, "out": out}, hears)
        return _journals.shard_journal(out, number, of)

    def exponents(
        self,
        *,
        interval: Any = None,
        transient: int | None = None,
        intervals: int | None = None,
        progress: bool | Progress = False,
    ) -> Exponents:
        """All Lyapunov exponents of the motion from the start, with error bars, from the derivative of the flow.

        interval: time from one orthogonalisation to the next; the period of the forcing, or 1.
        transient, intervals: intervals passed over (200), and averaged over (2000).
        """
        with shown(progress) as hears:
            text = _chatter.exponents(
                self._core, interval=_maybe(interval), transient=_maybe(transient), intervals=_maybe(intervals), progress=hears
            )
        return Exponents(json.loads(text))

    def over(self, table: Any) -> list[Model]:
        """A model for each row of a table of values: a DataFrame, or a mapping of names to equally long columns."""
        names = list(table.columns if hasattr(table, "columns") else table)
        columns = [np.asarray(table[name]) for name in names]
        return [self.with_values(dict(zip(names, row))) for row in zip(*columns)]

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Model) and self._core.__getstate__() == other._core.__getstate__()

    def __hash__(self) -> int:
        return hash((self.text, tuple(self._core.set), tuple(self._core.initial)))

    def __reduce__(self) -> tuple[Any, ...]:
        return (_restored, (self._core.__getstate__(),))

    def __repr__(self) -> str:
        values = ", ".join(f"{name}={text!r}" for name, text in [*self._core.set, *self._core.initial])
        return f"<Model {self.name!r}" + (f" with {values}>" if values else ">")


def _restored(state: Any) -> Model:
    return Model._of(_chatter.Core.restore(state))


def _asked(**options: Any) -> dict[str, Any]:
    """Options of a diagram as texts, by name."""
    asked: dict[str, Any] = {"at": [], "exponent": bool(options.get("exponent", False))}
    for name in _TEXTS & options.keys():
        asked[name] = _maybe(options[name])
    for name in ("section", "start", "record"):
        asked[name] = options.get(name)
    if options.get("at") is not None:
        asked["at"] = [options["at"]]
    out = options.get("out")
    asked["out"] = None if out is None else os.fspath(out)
    bounds = options.get("box") or {}
    asked["box"] = [f"{name}={text_of(low)}:{text_of(high)}" for name, (low, high) in bounds.items()]
    return asked


_TEXTS = {
    "period", "chunk", "transient", "keep", "every", "seed", "longest_period", "period_tolerance", "longest_return",
    "most_impacts", "tolerance", "threads",
}  # fmt: skip
_OPTIONS = _TEXTS | {"section", "start", "record", "at", "box", "exponent", "sweep"}


def _maybe(value: ArrayLike | str | None) -> str | None:
    return None if value is None else text_of(value)
