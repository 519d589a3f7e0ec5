"""One trajectory with all that happens on it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from chatter import _chatter
from chatter._errors import InputError, RunError
from chatter._frozen import Frozen, frozen
from chatter._text import labelled, text_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike, NDArray
    from pandas import DataFrame
    from xarray import Dataset

    from chatter._model import Model
    from chatter._progress import Progress

    Floats = NDArray[np.float64]


class Events(Frozen):
    """What happened, in order: n events.

    Indexing by a kind ("impact", "accumulation", "release", "graze", "section", "cascade", "ambiguity", …), by a kind and a
    place ("impact:seat"), or by an array of booleans gives these alone; by the name of a state, its values just after the events.
    """

    time: Floats
    """When, shape (n,)."""
    time_low: Floats
    """What doubles leave of the times, shape (n,); zero up to 17 digits."""
    kind: NDArray[np.str_]
    """What, shape (n,)."""
    place: NDArray[np.str_]
    """Names of the contacts, sections and surfaces, shape (n,)."""
    y: Floats
    """States just after, shape (states, n)."""
    rate_before: Floats
    """Rates of the gap before impacts and grazes, shape (n,); NaN for others."""
    rate_after: Floats
    """Rates of the gap after, shape (n,)."""
    impacts: NDArray[np.int64]
    """How many impacts each stands for, shape (n,): one for an impact, those of its sequence for an accumulation."""
    error: Floats
    """Local errors of the times of accumulations, shape (n,); NaN for others."""
    closes: NDArray[np.bool_]
    """Whether an impact is without rebound, shape (n,)."""

    _states: tuple[str, ...]
    _COLUMNS = ("time", "time_low", "kind", "place", "rate_before", "rate_after", "impacts", "error", "closes")

    def __init__(self, states: tuple[str, ...], y: Floats, **columns: Any) -> None:
        self._set(_states=states, y=frozen(y), **{name: frozen(values) for name, values in columns.items()})

    def __len__(self) -> int:
        return len(self.time)

    def __getitem__(self, which: Any) -> Any:
        if isinstance(which, str):
            if which in self._states:
                return self.y[self._states.index(which)]
            kind, _, place = which.partition(":")
            chosen = self.kind == kind
            if place:
                chosen = chosen & (self.place == place)
            if kind not in _chatter.EVENT_KINDS:
                known = ", ".join([*_chatter.EVENT_KINDS, *self._states])
                raise KeyError(f"{which!r} is neither a kind of event nor a state: there is {known}")
        else:
            chosen = which
        return self._only(chosen)

    def at(self, place: str) -> Events:
        """Those at a contact, section or surface."""
        return self._only(self.place == place)

    def _only(self, chosen: Any) -> Events:
        columns = {name: np.atleast_1d(getattr(self, name)[chosen]) for name in self._COLUMNS}
        y = self.y[:, chosen]
        return Events(self._states, y.reshape(len(self._states), -1), **columns)

    def to_pandas(self) -> DataFrame:
        """A DataFrame, one event a row."""
        import pandas

        columns = {name: getattr(self, name) for name in self._COLUMNS if name != "time_low"}
        return pandas.DataFrame({**columns, **dict(zip(self._states, self.y))})

    def __repr__(self) -> str:
        kinds, counts = np.unique(self.kind, return_counts=True)
        return "<Events: " + (", ".join(f"{n} {kind}" for kind, n in zip(kinds, counts)) or "none") + ">"


class ContactPhases(Frozen):
    """From when to when contacts were closed, m phases in the order of their starts."""

    contact: NDArray[np.str_]
    """Names of the contacts, shape (m,)."""
    start: Floats
    """When they closed, shape (m,)."""
    end: Floats
    """When they opened, shape (m,); NaN where the run ended before."""

    def __init__(self, contact: Any, start: Any, end: Any) -> None:
        self._set(contact=frozen(contact), start=frozen(start), end=frozen(end))

    def __len__(self) -> int:
        return len(self.start)

    def to_pandas(self) -> DataFrame:
        """A DataFrame, one phase a row."""
        import pandas

        return pandas.DataFrame({"contact": self.contact, "start": self.start, "end": self.end})

    def __repr__(self) -> str:
        return f"<{len(self)} ContactPhases>"


class Run(Frozen):
    """A trajectory, in the shape that SciPy's `solve_ivp` gives: n times, in the model's units.

    Called with times it gives the states there (dense output); indexed with a name, the values of a state at `t`.
    """

    model: Model
    """The model that was followed."""
    t: Floats
    """The sampled times, shape (n,); they never fall, and an event stands there twice, before and after."""
    y: Floats
    """The states at these times, shape (states, n), in the order of `model.states`."""
    t_low: Floats
    """What doubles leave of the times, shape (n,); zero up to 17 digits."""
    y_low: Floats
    """What doubles leave of the states, shape (states, n)."""
    closed: NDArray[np.bool_]
    """Which contacts were closed, shape (contacts, n), in the order of `model.contacts`."""
    events: Events
    """What happened."""
    contact_phases: ContactPhases
    """From when to when contacts were closed."""
    outcome: str
    """How it ended: "horizon", "event", "rest", "impact_budget", or why it could not go on, such as "singular"."""
    success: bool
    """Whether it ended as asked; a run that could not go on is in a RunError."""
    message: str
    """How it ended, in words."""
    counts: Mapping[str, int]
    """How many flights, impacts, accumulations, releases, grazes, sections, switches and ambiguities there were."""
    time: float
    """Where it ended."""
    end: Mapping[str, float]
    """The states there by name, and `t` where the equations depend on time: `model.with_values(run.end)` goes on from there."""
    start_time: float
    """Where it began."""
    closed_at_end: tuple[str, ...]
    """Names of the contacts that were closed at the end."""
    _request: Mapping[str, Any]
    digits: Mapping[str, str]
    """Time ("time") and states at the end to all the digits that were asked for."""

    def __init__(self, model: Model, request: Mapping[str, Any], answer: Mapping[str, Any], by_events: bool) -> None:
        states = model.states
        found = dict(answer["events"])
        time, time_low, y, y_low, _ = found.pop("motion")
        y, y_low = (_shaped(values, len(states)) for values in (y, y_low))
        found["closes"] = np.asarray(found["closes"], dtype=bool)
        found["kind"] = np.asarray(found["kind"], dtype=np.str_)
        found["place"] = np.asarray(found["place"], dtype=np.str_)
        events = Events(states, y, time=time, time_low=time_low, **found)
        if by_events:
            motion = time, time_low, y, y_low, np.zeros((len(model.contacts), 0), dtype=bool)
        elif answer["motion"] is not None:
            motion = answer["motion"]
        else:
            motion = (np.empty(0), np.empty(0), np.empty((0, 0)), np.empty((0, 0)), np.empty((0, 0), dtype=bool))
        t, t_low, y, y_low, closed = motion
        phases = dict(answer["phases"])
        contacts = np.asarray(model.contacts, dtype=np.str_)
        end = dict(zip(states, answer["state"]))
        if model._core.depends_on_time:
            end["t"] = answer["time"]
        self._set(
            model=model,
            _request=dict(request),
            t=frozen(t),
            t_low=frozen(t_low),
            y=frozen(_shaped(y, len(states))),
            y_low=frozen(_shaped(y_low, len(states))),
            closed=frozen(_shaped(closed, len(contacts))),
            events=events,
            contact_phases=ContactPhases(contacts[phases["contact"]], phases["start"], phases["end"]),
            outcome=answer["outcome"],
            success=not answer["failed"],
            message=answer["message"],
            counts=dict(answer["counts"]),
            start_time=answer["start_time"],
            time=answer["time"],
            end=end,
            digits=dict(zip(("time", *states), answer["texts"])),
            closed_at_end=tuple(answer["closed_at_end"]),
        )

    def __getitem__(self, name: str) -> Floats:
        """Values of a state at `t`, shape (n,)."""
        if name not in self.model.states:
            raise KeyError(f"{name!r} is no state: there is {', '.join(self.model.states)}")
        values: Floats = self.y[self.model.states.index(name)]
        return values

    def __call__(self, times: ArrayLike) -> Floats:
        """The states at these times, in any order: shape (states, *times.shape), NaN after the end of the run.

        At the instant of an event the state before it. The run is followed again to be looked at there, to the same bits.
        """
        times = np.asarray(times, dtype=np.float64)
        flat = times.ravel()
        if flat.size and not np.all(np.isfinite(flat)):
            raise InputError("times must be finite")
        order = np.argsort(flat, kind="stable")
        answer = _chatter.simulate(self.model._core, times=np.ascontiguousarray(flat[order]), **self._request)
        y = answer["motion"][2] if answer["motion"] is not None else np.empty((0, 0))
        found = np.full((len(self.model.states), flat.size), np.nan)
        y = _shaped(y, len(self.model.states))
        found[:, order[: y.shape[1]]] = y
        return found.reshape((len(self.model.states), *times.shape))

    def to_pandas(self) -> DataFrame:
        """A DataFrame: the states by name over the time."""
        import pandas

        return pandas.DataFrame(dict(zip(self.model.states, self.y)), index=pandas.Index(self.t, name="time"))

    def to_xarray(self) -> Dataset:
        """A Dataset: the states by name over the time, with their units where the model has them; parameters as attributes."""
        import xarray

        labels = self.model._labels

        def variable(name: str, values: Floats) -> tuple[str, Floats, dict[str, str]]:
            text, unit = labels.get(name, (None, None))
            return ("time", values, {k: v for k, v in [("long_name", text), ("units", unit)] if v is not None})

        data = {name: variable(name, values) for name, values in zip(self.model.states, self.y)}
        attributes = {**self.model.parameters, "model": self.model.name, "outcome": self.outcome}
        return xarray.Dataset(data, coords={"time": self.t}, attrs=attributes)

    def plot(self, *names: str, ax: Axes | None = None, **style: Any) -> Axes:
        """Draws states over time, those named or all, with bars where contacts are closed; gives the axes."""
        if ax is None:
            import matplotlib.pyplot as plt

            _, ax = plt.subplots()
        labels = self.model._labels
        chosen = names or self.model.states
        for name in chosen:
            ax.plot(self.t, self[name], label=labelled(name, labels.get(name)), **{"linewidth": 0.8, **style})
        for start, end in zip(self.contact_phases.start, self.contact_phases.end):
            ax.axvspan(start, self.time if np.isnan(end) else end, color="0.85", zorder=0)
        ax.set_xlabel("time")
        if len(chosen) == 1:
            ax.set_ylabel(labelled(chosen[0], labels.get(chosen[0])))
        else:
            ax.legend()
        return ax

    def draw(self, t: float | None = None, *, ax: Axes | None = None) -> Axes:
        """Draws the mechanism as the model's `[drawing]` has it at a time, or at the end; gives the axes."""
        if t is None:
            return self.model.draw(self.end, t=self.time, ax=ax)
        state = self(t)
        if not np.all(np.isfinite(state)):
            raise InputError(f"the run goes from {self.start_time!r} to {self.time!r}: it is nowhere at {t!r}")
        return self.model.draw(state, t=t, ax=ax)

    def __repr__(self) -> str:
        return f"<Run of {self.model.name!r} to {self.time!r}: {self.outcome}, {self.events!r}>"


def _shaped(values: Any, rows: int) -> Any:
    """Rows of no length have lost their number."""
    return values if values.shape[0] == rows else values.reshape(rows, -1)


def simulate(model: Model, request: Mapping[str, Any], sample: Any, progress: Progress | None) -> Run:
    """Follows a trajectory; raises what it is when it cannot go on."""
    by_events = isinstance(sample, str) and sample == "events"
    how: dict[str, Any] = {}
    if sample is None or by_events:
        pass
    elif isinstance(sample, str) or np.ndim(sample) == 0:
        how["sample"] = text_of(sample)
    else:
        how["times"] = np.ascontiguousarray(sample, dtype=np.float64)
    answer = _chatter.simulate(model._core, progress=progress, **how, **request)
    run = Run(model, request, answer, by_events)
    if not run.success:
        raise RunError(run.message, run)
    return run
