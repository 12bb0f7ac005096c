"""Rows with a label each, the first on top, over one axis of values.

The height in the row of a parameter is an axis of its own, for the parameter's value.
"""

from collections.abc import Sequence

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.pictures.drawing.plot_parts import panels
from harness.pictures.drawing.quantities import Floats, Values, named, quantity, unit_of, wrapped
from harness.pictures.drawing.style import PALE, THIN

LETTERS, LINE = 36, 0.16
"""Number of letters in a line of a label, and its height [inch]."""
MOST_ROWS = 20
"""Largest number of rows for parameters."""
MARGIN = 1.6
"""Height around the rows [inch]."""
MOST_VALUES = 6
"""Largest number of values that the label of a row gives one by one."""
INSIDE = 0.4
"""Half of the height of a row that curves use; rows are 1 apart."""


def labelled_rows(labels: Sequence[str], height: float) -> tuple[Figure, Axes]:
    """A figure with a row for each label, `height` [inch] or more."""
    texts = [wrapped(label, LETTERS) for label in labels]
    of_text = LINE * max(text.count("\n") + 1 for text in texts)
    figure, (axes,) = panels(height=max(height, of_text) * len(labels) + MARGIN)
    axes.set_yticks(range(len(labels)), texts)
    axes.set_ylim(len(labels) - 0.5, -0.5)
    axes.grid(visible=False, axis="y")
    for border in range(len(labels) - 1):
        axes.axhline(border + 0.5, color=PALE, lw=THIN)
    return figure, axes


def height_in_row(place: int, values: Values, numbers: Floats) -> Floats:
    """Heights of a parameter's values in a row: its least value at the bottom, its greatest on top.

    They are spaced as on the axis of the parameter; `numbers` are among its values.
    """
    low, high = values.on_axis(values.different[[0, -1]])
    share = (values.on_axis(numbers) - low) / (high - low)
    return np.asarray(place + INSIDE - 2.0 * INSIDE * share)


def label_of_row(dataset: xr.Dataset, values: Values) -> str:
    """The label of a row: the parameter, and its values from the bottom to the top."""
    unit = unit_of(dataset, values.name)
    numbers = values.different.tolist()
    if not values.categories:
        numbers = [float(f"{number:.3g}") for number in numbers]
    texts = [quantity(values.value(number), unit) for number in numbers]
    shown = ", ".join(texts) if len(texts) <= MOST_VALUES else f"{texts[0]} to {texts[-1]}"
    return f"{named(dataset, values.name)}: {shown}"
