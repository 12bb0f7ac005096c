"""The arrays of a run as the host sees them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray



class HostArrays:
    """Gives arrays by name: the device's own memory where host and device share it.

    Args:
        arrays: on the device; others may take their places.
    """

    def __init__(self, arrays: Mapping[str, Any]) -> None:
        self._arrays = arrays
        self._host = wp.get_device("cpu")
        self._seen: dict[str, tuple[Any, NDArray[Any]]] = {}

    def __call__(self, name: str) -> NDArray[Any]:
        """The array of that name."""
        array = self._arrays[name]
        seen, values = self._seen.get(name, (None, np.empty(0)))
        if seen is not array:
            values = array.numpy()
            if array.device == self._host:
                self._seen[name] = array, values  # runs of few particles ask often
        return values

    def assign(self, name: str, values: NDArray[np.generic] | float) -> None:
        """Give the array of that name other values, or one value everywhere."""
        array = self._arrays[name]
        if array.device == self._host:
            self(name)[...] = values
        elif isinstance(values, float):
            array.fill_(values)
        else:
            array.assign(values)
