"""Results that nobody changes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np


def frozen(values: Any, dtype: Any = None) -> np.ndarray[Any, Any]:
    """An array that cannot be written to."""
    array = np.asarray(values, dtype=dtype)
    array.flags.writeable = False
    return array


class Frozen:
    """Attributes are set once, by `_set`."""

    def _set(self, **values: Any) -> None:
        for name, value in values.items():
            object.__setattr__(self, name, value)

    def __setattr__(self, name: str, value: Any) -> None:
        raise AttributeError(f"a {type(self).__name__} is a result and cannot be changed")

    def __delattr__(self, name: str) -> None:
        raise AttributeError(f"a {type(self).__name__} is a result and cannot be changed")

    def __getstate__(self) -> Mapping[str, Any]:
        return dict(self.__dict__)

    def __setstate__(self, state: Mapping[str, Any]) -> None:
        # Pickles do not keep that arrays cannot be written to.
        self._set(**{name: frozen(v) if isinstance(v, np.ndarray) else v for name, v in state.items()})
