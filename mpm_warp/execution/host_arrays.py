"""The arrays of a run as NumPy arrays on the host."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray


class HostArrays:
    """Gives arrays of a run by name; on a processor they are the memory of the run itself.

    Args:
        arrays: the arrays of the run on its device, by name; a batch may replace them.
    """

    def __init__(self, arrays: Mapping[str, Any]) -> None:
        self._arrays = arrays
        self._host = wp.get_device("cpu")
        self._seen: dict[str, tuple[Any, NDArray[Any]]] = {}

    def __call__(self, name: str) -> NDArray[Any]:
        """The present values of an array; on a processor writing to them changes the run.

        Raises:
            KeyError: the run has no array of that name.
        """
        array = self._arrays[name]
        seen, values = self._seen.get(name, (None, np.empty(0)))
        if seen is not array:
            values = array.numpy()
            if array.device == self._host:
                self._seen[name] = array, values  # asked for often where particles are few
        return values

    def assign(self, name: str, values: NDArray[np.generic] | float) -> None:
        """Give an array other values, or one value everywhere.

        Raises:
            KeyError: the run has no array of that name.
        """
        array = self._arrays[name]
        if array.device == self._host:
            self(name)[...] = values
        elif isinstance(values, float):
            array.fill_(values)
        else:
            array.assign(values)
