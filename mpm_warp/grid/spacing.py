"""Spacing of columns: cells that grow away from a surface."""

from __future__ import annotations

import math

import numpy as np

from mpm_warp.arguments import POSITIVE, Range, check_number
from mpm_warp.grid.fitted import Floats

LARGEST_EXPONENT = 700.0
"""Of e, in double precision: beyond 709 it overflows."""


def graded(first: float, length: float, growth: float) -> Floats:
    """Edges from 0 to `length` whose spacing starts near `first` and grows by about `growth`.

    The number of cells is the nearest whole one; `first` is then kept and the growth adjusted.

    Args:
        first: width of the first cell [m].
        length: sum of all widths [m], more than `first`.
        growth: ratio of a cell's width to the one before, more than 1.

    Raises:
        SceneError: a value is not allowed.
    """
    check_number("graded: first", first, POSITIVE, unit="m")
    check_number("graded: length", length, Range(above=first), unit="m")
    check_number("graded: growth", growth, Range(above=1.0))
    count = max(1, round(np.log1p(length / first * (growth - 1.0)) / np.log(growth)))
    low, high = 1.0 + 1e-12, 10.0
    for _ in range(100):
        middle = 0.5 * (low + high)
        # A sum beyond the largest number is beyond the length, too.
        is_huge = count * math.log(middle) > LARGEST_EXPONENT
        reached = math.inf if is_huge else first * (middle**count - 1.0) / (middle - 1.0)
        low, high = (middle, high) if reached < length else (low, middle)
    edges: Floats = first * (low ** np.arange(count + 1) - 1.0) / (low - 1.0)
    edges[-1] = length
    return edges


def growing(first: float, length: float, growth: float) -> Floats:
    """Edges from 0 to about `length` whose spacing starts with `first` and grows by `growth`.

    Both are exact; the number of cells is the whole one with which the last edge is nearest.

    Args:
        first: width of the first cell [m].
        length: sum of all widths, about [m], more than `first`.
        growth: ratio of a cell's width to the one before, more than 1.

    Raises:
        SceneError: a value is not allowed.
    """
    check_number("growing: first", first, POSITIVE, unit="m")
    check_number("growing: length", length, Range(above=first), unit="m")
    check_number("growing: growth", growth, Range(above=1.0))
    count = round(np.log1p(length / first * (growth - 1.0)) / np.log(growth))
    edges: Floats = first * (growth ** np.arange(count + 1) - 1.0) / (growth - 1.0)
    return edges
