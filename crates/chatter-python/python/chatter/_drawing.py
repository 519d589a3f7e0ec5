"""The mechanism, as the model's `[drawing]` has it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from chatter._errors import InputError

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

    from chatter._model import Model

_BLUE, _GREY, _INK = "#0072b2", "#8c8c8c", "#1a1a1a"
# From back to front, and how each is drawn: the colour of its outline, and of what it holds.
_LOOKS: dict[str, tuple[int, str, str | None]] = {
    "round_wall": (1, _INK, None), "wall": (2, _INK, None), "spring": (3, _GREY, None), "rod": (4, _INK, None),
    "mass": (5, _BLUE, "#d5e3f0"), "disc": (6, _BLUE, "#d5e3f0"),
}  # fmt: skip


def draw(model: Model, state: Mapping[str, float] | ArrayLike | None, t: float | None, ax: Axes | None) -> Axes:
    """Draws the shapes at a state."""
    start = model.start
    given = dict(state) if isinstance(state, Mapping) else {} if state is None else _in_order(model, state)
    unknown = [name for name in given if name not in model.states and name != "t"]
    if unknown:
        raise InputError(f"`{unknown[0]}` is no state: there is {', '.join(model.states)}")
    at = {**start, **given}
    time = float(at.get("t", 0.0) if t is None else t)
    shapes = model._core.drawn([float(at[name]) for name in model.states], time)
    if not shapes:
        raise InputError("there is nothing to draw: the model has no [drawing], or none that has a place at this state")
    if ax is None:
        import matplotlib.pyplot as plt

        _, ax = plt.subplots()
    for kind, _, (x, y, hatch_x, hatch_y) in shapes:
        order, color, inside = _LOOKS[kind]
        ax.plot(hatch_x, hatch_y, color=_GREY, linewidth=0.6, zorder=order)
        if inside is not None:
            # The mark of a disc follows behind a gap.
            ring = slice(None, int(np.argmax(np.isnan(x))) if np.isnan(x).any() else None)
            ax.fill(x[ring], y[ring], color=inside, zorder=order)
        ax.plot(x, y, color=color, linewidth=1.4, zorder=order, label=f"_{kind}")
    ax.set_aspect("equal")
    return ax


def _in_order(model: Model, state: Any) -> dict[str, float]:
    values = np.asarray(state, dtype=np.float64)
    if values.shape != (len(model.states),):
        raise InputError(f"{len(model.states)} states are expected, {', '.join(model.states)}: these have shape {values.shape}")
    return dict(zip(model.states, values.tolist()))
