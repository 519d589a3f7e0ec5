"""The universal function Upsilon of chatter near a border orbit."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from chatter import _chatter
from chatter._frozen import Frozen, frozen

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray


class Universal(Frozen):
    """Upsilon for a coefficient of restitution `r` between 0 and 1.

    Called with an array of any shape it gives Upsilon there, dimensionless. Zero and negative arguments stand for chatter
    that is complete.
    """

    _core: _chatter.Upsilon
    restitution: float
    """The coefficient of restitution r."""
    chatter_fixed_point: float
    """u*, the limit of u along complete chatter."""
    eta: float
    """The ratio of the ends of neighbouring laps, below 1."""
    exponent: float
    """Upsilon is of the size of its argument to this power."""
    lap_end: float
    """x_e, where the lap of n = 0 ends."""

    def __init__(self, r: float) -> None:
        core = _chatter.Upsilon(float(r))
        self._set(_core=core, lap_end=core.lap_end, **core.constants)

    def __call__(self, x: ArrayLike) -> NDArray[np.float64]:
        """Upsilon at `x`, in its shape."""
        flat, shape = _flat(x)
        return np.reshape(self._core.values(flat), shape)

    def derivative(self, x: ArrayLike) -> NDArray[np.float64]:
        """The derivative of Upsilon at `x`, in its shape; minus infinity at the end of a lap."""
        return self._part(x, "derivative")

    def lap(self, x: ArrayLike) -> NDArray[np.float64]:
        """The number n of impacts of the lap in which `x` lies, in its shape; infinite where chatter is complete."""
        return self._part(x, "lap")

    def _part(self, x: ArrayLike, name: str) -> NDArray[np.float64]:
        flat, shape = _flat(x)
        return np.reshape(self._core.evaluations(flat)[name], shape)

    def windows(self, slope: float, first: int, last: int) -> dict[str, NDArray[Any]]:
        """Windows in mu of the fixed points of z -> Upsilon(`slope` z + mu), for n from `first` to `last`.

        Columns `n`, `fold`, `period_doubling`, `superstable`, `grazing`, each of shape (last - first + 1,); NaN where there is
        none.
        """
        found = self._core.windows(float(slope), int(first), int(last))
        return {name: frozen(values) for name, values in found.items()}

    def __reduce__(self) -> tuple[Any, ...]:
        return (Universal, (self.restitution,))

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Universal) and other.restitution == self.restitution

    def __hash__(self) -> int:
        return hash(("Universal", self.restitution))

    def __repr__(self) -> str:
        return f"Universal({self.restitution!r})"


def _flat(x: ArrayLike) -> tuple[NDArray[np.float64], tuple[int, ...]]:
    array = np.asarray(x, dtype=np.float64)
    return np.ascontiguousarray(array.ravel()), array.shape
