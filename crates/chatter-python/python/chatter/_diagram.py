"""Orbit diagrams."""

from __future__ import annotations

import json
import numbers
import os
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from chatter import _chatter
from chatter._errors import InputError
from chatter._frozen import Frozen, frozen
from chatter._text import labelled, text_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import NDArray
    from pandas import DataFrame
    from xarray import Dataset

    from chatter._model import Model
    from chatter._progress import Progress

    Array = NDArray[Any]


class Orbit(Frozen):
    """One orbit of a diagram."""

    index: int
    """Which row."""
    parameters: Mapping[str, float]
    """What is swept, by name, at this orbit."""
    outcome: str
    """What it settled to, such as "periodic" or "chaotic"."""
    period: int
    """Its period in samples; 0 for none."""
    impacts_per_return: float
    """Mean number of impacts from sample to sample."""
    start: Mapping[str, float]
    """The states that it started from, by name."""
    samples: Mapping[str, NDArray[np.float64]]
    """What was observed, by name, each of shape (samples,)."""
    model: Model
    """The model at these values and that start: `orbit.model.simulate(...)` follows it from there."""

    def __init__(self, **values: Any) -> None:
        self._set(**values)

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.samples[name]

    def __repr__(self) -> str:
        at = ", ".join(f"{name}={value!r}" for name, value in self.parameters.items())
        return f"<Orbit {self.index} at {at}: {self.outcome}, period {self.period}>"


class Diagram(Frozen):
    """What orbits settle to: n orbits, m samples of all of them together.

    Indexed with a name it gives a column, those of the NPZ file of `chatter diagram --out`: what is swept, "outcome",
    "period", "impacts_per_return", "start", "initial_NAME", each of shape (n,); of samples "column" (to which orbit each
    belongs) and what is observed, each of shape (m,).
    """

    columns: Mapping[str, Array]
    """One value an orbit, by name."""
    samples: Mapping[str, Array]
    """One value a sample, by name; nothing where samples were not kept."""
    specification: Mapping[str, Any]
    """What was computed, as in the NPZ file."""
    model: Model
    """The model, with what was set into it."""
    _text: tuple[str, str]

    def __init__(self, columns: Mapping[str, Any], samples: Mapping[str, Any], specification: str, text: str) -> None:
        from chatter._model import Model

        job = json.loads(specification)
        core = _chatter.Core.restore(
            (job["model"], text, job.get("data_files", {}), [tuple(p) for p in job["set"]], [tuple(p) for p in job["initial"]])
        )  # fmt: skip
        self._set(
            columns={name: _column(values) for name, values in columns.items()},
            samples={name: _column(values) for name, values in samples.items()},
            specification=job,
            model=Model._of(core),
            _text=(specification, text),
        )

    def __len__(self) -> int:
        return len(self.columns["outcome"])

    def __getitem__(self, name: str) -> Array:
        for columns in (self.columns, self.samples):
            if name in columns:
                return columns[name]
        raise KeyError(f"{name!r} is no column: there is {', '.join([*self.columns, *self.samples])}")

    @property
    def swept(self) -> tuple[str, ...]:
        """Names of what is swept: parameters, and "initial_NAME" of initial values."""
        sweeps = self.specification["diagram"]["sweeps"]
        return tuple(_swept_name(one) for one in sweeps)

    @property
    def observed(self) -> tuple[str, ...]:
        """Names of what is observed."""
        return tuple(one["name"] for one in self.specification["diagram"]["observe"])

    def orbit(self, index: int) -> Orbit:
        """One orbit, of -n to n - 1."""
        if not -len(self) <= index < len(self):
            raise IndexError(f"orbit {index}: there are {len(self)}")
        index %= len(self)
        row = {name: values[index] for name, values in self.columns.items()}
        start = {name[len("initial_") :]: float(row[name]) for name in row if name.startswith("initial_")}
        swept = {name: float(row[name]) for name in self.swept}
        values = {name: value for name, value in {**swept, **start}.items() if not name.startswith("initial_")}
        # What did not start stands nowhere.
        known = {name: value for name, value in values.items() if np.isfinite(value)}
        bounds = np.searchsorted(self.samples["column"], [index, index + 1]) if self.samples else (0, 0)
        samples = {name: self.samples[name][slice(*bounds)] for name in self.observed if self.samples}
        return Orbit(
            index=index,
            parameters=swept,
            outcome=str(row["outcome"]),
            period=int(row["period"]),
            impacts_per_return=float(row["impacts_per_return"]),
            start=start,
            samples=samples,
            model=self.model.with_values(known),
        )

    def to_pandas(self, samples: bool = False) -> DataFrame:
        """A DataFrame of orbits, one a row; or of samples, with what was swept beside them."""
        import pandas

        orbits = pandas.DataFrame(dict(self.columns))
        if not samples:
            return orbits
        beside = orbits[list(self.swept)].iloc[self.samples["column"]].reset_index(drop=True)
        return pandas.concat([beside, pandas.DataFrame(dict(self.samples))], axis=1)

    def to_xarray(self) -> Dataset:
        """A Dataset over "orbit"; samples over "orbit" and "sample", NaN where an orbit has fewer."""
        import xarray

        data: dict[str, Any] = {name: ("orbit", values) for name, values in self.columns.items()}
        if self.samples:
            column = self.samples["column"]
            counts = np.bincount(column, minlength=len(self))
            place = np.arange(len(column)) - np.repeat(np.cumsum(counts) - counts, counts)
            for name in self.observed:
                values = np.full((len(self), counts.max(initial=0)), np.nan)
                values[column, place] = self.samples[name]
                data[name] = (("orbit", "sample"), values)
        table: Dataset = xarray.Dataset(data).set_coords(list(self.swept))
        return table

    def plot(
        self, observed: str | None = None, ax: Axes | None = None, *, shear: float | str | None = None, **style: Any
    ) -> Axes:
        """Draws samples over what is swept, or periods over two that are swept; gives the axes.

        shear: this multiple of the parameter is subtracted; with "auto" the one that makes the diagram level.
        """
        if ax is None:
            import matplotlib.pyplot as plt

            _, ax = plt.subplots()
        labels = self.model._labels
        names = self.swept
        ax.set_xlabel(labelled(names[0], labels.get(names[0])))
        if len(names) == 2:
            shape = [one["count"] for one in reversed(self.specification["diagram"]["sweeps"])]
            each = len(self) // (shape[0] * shape[1])
            x, y, period = (np.asarray(self[name])[::each].reshape(shape) for name in (*names, "period"))
            mesh = ax.pcolormesh(x, y, np.where(period > 0, period, np.nan), **{"rasterized": True, **style})
            ax.figure.colorbar(mesh, ax=ax, label="period")
            ax.set_ylabel(labelled(names[1], labels.get(names[1])))
            return ax
        if not self.samples:
            raise InputError("the diagram has no samples to be drawn: it was computed with record=\"classes\"")
        observed = self.observed[0] if observed is None else observed
        look = {"linestyle": "none", "marker": ",", "color": "k", "alpha": 0.5, "rasterized": True}
        x, y = self[names[0]][self["column"]], self[observed]
        label = labelled(observed, labels.get(observed))
        if shear is not None:
            origin = x.mean()
            slope = np.polyfit(x - origin, y, 1)[0] if isinstance(shear, str) else shear
            y = y - slope * (x - origin)
            label = f"{label}, sheared by {slope:.4g}"
        ax.plot(x, y, **{**look, **style})
        ax.set_ylabel(label)
        return ax

    def __reduce__(self) -> tuple[Any, ...]:
        columns, samples = (
            {name: np.asarray(values) for name, values in of.items()} for of in (self.columns, self.samples)
        )
        return (Diagram, (columns, samples, *self._text))

    def __repr__(self) -> str:
        return f"<Diagram of {self.model.name!r} over {' and '.join(self.swept)}: {len(self)} orbits>"


def _column(values: Any) -> Array:
    return frozen(values, None if isinstance(values, np.ndarray) else np.str_)


def _swept_name(sweep: Mapping[str, Any]) -> str:
    name: str = sweep["parameter"]
    return f"initial_{name}" if sweep.get("swept") == "initial" else name


def _sweep(name: str, value: Any) -> tuple[str, str]:
    """The option that a sweep is, and what it says."""
    if isinstance(value, (str, int, float)) or np.ndim(value) == 0:
        return "at", f"{name}={text_of(value)}"
    try:
        low, high, count, *spacing = value
    except ValueError:
        spacing = ["too few"]
    if len(spacing) > 1 or (spacing and spacing[0] != "log"):
        raise InputError(f"{name}={value!r}: expected (from, to, count), or (from, to, count, \"log\")")
    # A whole number may come as a double; what is none is refused as it was written.
    whole = int(float(count)) if isinstance(count, numbers.Real) and float(count).is_integer() else count
    return "sweep", ":".join([f"{name}={text_of(low)}", text_of(high), text_of(whole), *spacing])


def compute(
    core: _chatter.Core,
    asked: dict[str, Any],
    observe: Any,
    sweeps: Mapping[str, Sequence[Any]],
    journal: str | os.PathLike[str] | None,
    shard: tuple[int, int] | None,
    progress: Progress | None,
) -> Diagram | None:
    """Computes a diagram, or a share of it."""
    if isinstance(observe, Mapping):
        asked["observe"] = [f"{name}={text_of(what)}" for name, what in observe.items()]
    elif isinstance(observe, (list, tuple)):
        asked["observe"] = [text_of(what) for what in observe]
    else:
        asked["observe"] = [text_of(observe)]
    asked["sweep"] = []
    for name, value in sweeps.items():
        option, text = _sweep(name, value)
        asked[option] = [*asked[option], text]
    if journal is not None and asked["out"] is not None:
        raise InputError("what is done is kept beside `out`: leave out `journal`")
    if journal is not None and shard is not None:
        raise InputError("a share has its journal beside `out`: leave out `journal`")
    where = None if journal is None else os.fspath(journal)
    answer = _chatter.diagram(core, asked, where, shard, progress)
    return None if answer is None else _made(answer)


def _made(answer: Mapping[str, Any]) -> Diagram:
    return Diagram(answer["orbits"], answer["samples"], answer["specification"], answer["model"])


def resume(path: str, threads: int | None, progress: Progress | None) -> Diagram:
    """Goes on with a diagram that was broken off; gives a finished one as it is."""
    answer = _chatter.resume(path, None if threads is None else str(threads), progress)
    return _read(path) if answer is None else _made(answer)


def merge(journals: Sequence[str], out: str, threads: int | None, progress: Progress | None) -> Diagram:
    """Puts the shares of a diagram together."""
    return _made(_chatter.merge(journals, out, None if threads is None else str(threads), progress))


_TEXTS = ("specification", "model", "parameters", "version")


def _read(path: str) -> Diagram:
    """A finished diagram from its NPZ file."""
    if not path.endswith(".npz"):
        raise InputError(f"`{path}` is finished; only .npz files are read back")
    with np.load(path) as file:
        arrays = {name: file[name] for name in file.files}
    if not set(_TEXTS) <= set(arrays):
        raise InputError(f"`{path}` holds no orbit diagram")
    specification, text = (str(arrays[name]) for name in _TEXTS[:2])
    columns: dict[str, Array] = {}
    samples: dict[str, Array] = {}
    observed = {one["name"] for one in json.loads(specification)["diagram"]["observe"]} | {"column"}
    for name, values in arrays.items():
        if name not in _TEXTS:
            of_samples = name in observed and "column" in arrays
            (samples if of_samples else columns)[name] = values
    return Diagram(columns, samples, specification, text)
