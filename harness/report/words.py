"""Names, units and numbers as the report shows them."""

import re
from collections.abc import Hashable

import numpy as np
import xarray as xr
from markupsafe import Markup, escape

from harness.archive.conventions import spoken
from harness.pictures.drawing.quantities import SYMBOLS, unit_of

MISSING = "-"
_SHOWN_IN = {"byte": (1e6, "MB")}
"""Units that are shown as another one: divisor and name of the other."""


def symbol(name: Hashable) -> Markup:
    """The symbol of a variable with its subscript; "" if it has none."""
    written = SYMBOLS.get(str(name).removesuffix("_parameter"), "")
    return Markup(re.sub(r"_(\w+)", r"<sub>\1</sub>", str(escape(written))))


def title(dataset: xr.Dataset, name: str) -> str:
    """The long name of a variable."""
    return str(dataset[name].attrs.get("long_name", spoken(name)))


def unit(dataset: xr.Dataset, name: str) -> str:
    """The unit in which a variable is shown; "" if it has none."""
    own = unit_of(dataset, name)
    return _SHOWN_IN.get(own, (1.0, own))[1]


def in_unit(dataset: xr.Dataset, name: str, value: object) -> object:
    """A value converted to the unit in which it is shown."""
    factor = _SHOWN_IN.get(unit_of(dataset, name), (1.0, ""))[0]
    return value / factor if factor != 1.0 and isinstance(value, int | float) else value


def text(value: object, digits: int = 6) -> str:
    """A value with a number of digits, by default those of an input; a dash if it is missing."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return str(value) or MISSING
    if not np.isfinite(value):
        return MISSING
    return str(value) if isinstance(value, int) else f"{value:.{digits}g}"


def percent(value: float) -> str:
    """A relative difference with its sign."""
    return f"{value:+z.1%}".replace("%", " %") if np.isfinite(value) else MISSING
