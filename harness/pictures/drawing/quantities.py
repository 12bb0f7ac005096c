"""How quantities are written in a picture: symbols, units, and the axis of a parameter.

The part of a symbol after the underscore is a subscript, as in ``I_r``. A variable without a symbol
is called by its name.
"""

import re
import textwrap
from collections.abc import Hashable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
import xarray as xr
from matplotlib import ticker
from matplotlib.axes import Axes
from numpy.typing import NDArray

from harness.archive.conventions import over_cases, spoken

SYMBOLS = {
    "cone_factor": "N_c",
    "cone_factor_uncertainty": "U_95",
    "rigidity_index": "I_r",
    "adhesion_factor": "α",
    "shaft_adhesion_factor": "α_s",
    "friction_coefficient": "μ_f",
    "friction": "μ",
    "undrained_shear_strength": "s_u",
    "in_situ_stress": "σ_v0",
    "stress_anisotropy": "Δ",
    "remoulded_strength_ratio": "δ_rem",
    "ductility": "ξ_95",
    "critical_state_ratio": "M",
    "compression_slope": "λ",
    "swelling_slope": "κ",
    "poissons_ratio": "ν",
    "poissons_ratio_bound": "ν_max",
    "density": "ρ",
    "cone_radius": "R",
    "apex_angle": "β",
    "penetration": "z/R",
    "cells_per_radius": "R/h",
    "cells_per_length": "L/h",
    "speed_ratio": "v/v_s",
    "time_step_fraction": "Δt/Δt_c",
}
"""R is the cone radius, h the width of a cell, and v_s the speed of shear waves."""

_UNITS = {"degree": "°", "kg m-3": "kg/m³", "m s-1": "m/s", "m s-2": "m/s²", "s-1": "1/s"}
"""Units as readers write them."""
_SPELT = {"poissons ratio": "Poisson's ratio", "in situ stress": "in-situ stress", "t bar": "T-bar"}
_PREFIXES = {"Pa": ((1e9, "G"), (1e6, "M"), (1e3, "k"))}
"""Larger units that readers expect, by the unit."""
LONGEST_LABEL = 24
"""Number of letters of the longest text that an axis has room for."""
MOST_LETTERS = 100
"""Number of letters of the longest name that is written in full."""
SYMLOG_SHARE = 0.5
"""Decades that are as wide as the part of an axis from 0 to the least positive value."""
DERIVED = "derived"
"""Shown for a parameter without a value in a case."""
SYMBOL, IN_PLACE = re.compile(r"(?<!\\)\$[^$]*(?<!\\)\$"), "\ue000--"
"""Pattern of a mathematical symbol, and its placeholder while lines are wrapped."""
_SUBSCRIPT = re.compile(r"_(\w+)")


def wrapped(text: str, letters: int) -> str:
    """The text in lines of so many letters; the placeholder of a symbol is about as wide as it."""
    symbols = iter(SYMBOL.findall(text))
    lines = textwrap.fill(SYMBOL.sub(IN_PLACE, text), letters, break_on_hyphens=False)
    return re.sub(IN_PLACE, lambda _: next(symbols), lines)


def shortened(text: str, letters: int) -> str:
    """The text, or so many of its letters with an ellipsis."""
    return text if len(text) <= letters else f"{text[: letters - 1].rstrip()}…"


def symbol(name: Hashable) -> str:
    """The symbol of a variable in matplotlib's mathematics; "" if it has none."""
    written = SYMBOLS.get(str(name).rpartition(".")[2].removesuffix("_parameter"), "")
    subscripted = _SUBSCRIPT.sub(r"_{\\mathrm{\1}}", written)
    return f"${subscripted}$" if written else ""


def plain(text: object) -> str:
    """A text with escaped dollar signs, so that matplotlib finds no mathematics in it."""
    return str(text).replace("$", r"\$")


def named(dataset: xr.Dataset, name: Hashable) -> str:
    """Name and symbol of a variable."""
    text = str(dataset[name].attrs.get("long_name", spoken(name)))
    return f"{plain(spelt(shortened(text, MOST_LETTERS)))} {symbol(name)}".rstrip()


def unit_of(dataset: xr.Dataset, name: Hashable) -> str:
    """The unit of a variable as readers write it; "" if it has none."""
    unit = str(dataset[name].attrs.get("units", "1"))
    return "" if unit == "1" else _UNITS.get(unit, unit)


def readable(unit: str) -> tuple[float, str]:
    """The unit in which curves are drawn, and the factor to it: stresses are in kPa."""
    return (1e-3, "kPa") if unit == "Pa" else (1.0, plain(unit))


def spelt(text: str) -> str:
    """Words of a name as readers write them."""
    for name, spelling in _SPELT.items():
        text = text.replace(name, spelling)
    return text


def in_words(name: Hashable) -> str:
    """The name of a variable as readers write it."""
    return plain(spelt(spoken(name)))


def axis_label(dataset: xr.Dataset, name: Hashable) -> str:
    """Name, symbol and unit of a variable; a text has no unit."""
    is_number = dataset[name].dtype.kind in "biuf"
    unit = unit_of(dataset, name)
    return f"{named(dataset, name)} [{plain(unit) or '-'}]" if is_number else named(dataset, name)


def number(value: float) -> str:
    """A number with four digits."""
    return f"{value:.4g}"


def quantity(value: object, unit: str = "") -> str:
    """A value with its unit, such as 20 kPa."""
    if isinstance(value, bool) or not isinstance(value, int | float):
        return plain(value).replace("_", " ")
    for factor, prefix in _PREFIXES.get(unit, ()):
        if abs(value) >= factor:
            return f"{number(value / factor)} {prefix}{unit}"
    return f"{number(value)} {plain(unit)}".rstrip().replace(" °", "°")


def assigned(dataset: xr.Dataset, name: Hashable, value: object) -> str:
    """A parameter, by its symbol or else its name, and its value: I_r = 100."""
    text = quantity(value, unit_of(dataset, name))
    return f"{symbol(name) or in_words(name)} = {text}"


Floats = NDArray[np.float64]
Texts = NDArray[np.str_]


@dataclass(frozen=True, kw_only=True)
class Values:
    """A parameter's values in the cases that were run."""

    name: str
    unit: str  # SI unit, "1" for a dimensionless number
    numbers: Floats  # the value of each case, or the index of its category
    categories: tuple[str, ...] = ()  # all values as texts, unless all are numbers
    some_are_numbers: bool = False  # whether categories are numbers, but for cases without one
    long: tuple[str, ...] = ()  # texts too long for a picture; their categories are numbers

    @classmethod
    def of(cls, dataset: xr.Dataset, name: str) -> Self:
        """The values that the cases of a dataset have."""
        values, unit = over_cases(dataset, name), str(dataset[name].attrs.get("units", "1"))
        are_numbers = values.dtype.kind in "iuf"
        if are_numbers and np.isfinite(values).all():
            return cls(name=name, unit=unit, numbers=values.astype(float))
        texts = [_category(value) for value in values.tolist()]
        every = list(dict.fromkeys(texts))
        numbers = np.array([float(every.index(text)) for text in texts])
        long = tuple(text for text in every if len(text) > LONGEST_LABEL)
        shown = tuple(f"{long.index(text) + 1}" if text in long else text for text in every)
        return cls(
            name=name,
            unit=unit,
            numbers=numbers,
            categories=shown,
            some_are_numbers=are_numbers,
            long=long,
        )

    def at(self, cases: np.ndarray) -> Self:
        """The values of some cases."""
        return replace(self, numbers=self.numbers[cases])

    @property
    def label(self) -> str:
        """Name and unit."""
        name = in_words(self.name)
        return name if self.unit == "1" else f"{name} [{self.unit}]"

    @property
    def different(self) -> Floats:
        """The different numbers, ascending."""
        return np.unique(self.numbers)

    @property
    def logarithmic(self) -> bool:
        """Whether a logarithmic axis is used: the numbers, except 0, span a decade or more."""
        positive = self.numbers[self.numbers > 0.0]
        if self.categories or positive.size == 0 or self.numbers.min() < 0.0:
            return False
        low, high = positive.min(), positive.max()
        # The least of evenly distributed random values may be small by chance.
        is_even = not self.has_single_ticks and np.median(positive) > 0.3 * (low + high)
        return bool(high >= 10.0 * low) and not is_even

    @property
    def scale(self) -> str:
        """Matplotlib's name for the scale of the axis.

        If 0 is among numbers that span two decades or more, the axis is linear from 0 to the
        smallest of them.
        """
        if not self.logarithmic:
            return "linear"
        if self.numbers.min() > 0.0:
            return "log"
        positive = self.numbers[self.numbers > 0.0]
        return "symlog" if positive.max() >= 100.0 * positive.min() else "linear"

    def on_axis(self, numbers: Floats | float) -> Floats:
        """Places of values on an even axis: their logarithms, if the axis is logarithmic."""
        return np.asarray(np.log(numbers) if self.scale == "log" else numbers)

    @property
    def has_single_ticks(self) -> bool:
        """Whether each number has its own tick: there are few, with at most four digits."""
        short = all(float(f"{number:.4g}") == number for number in self.different.tolist())
        return short and self.different.size <= 24

    def text(self, number: float) -> str:
        """A value in words."""
        return self.categories[int(number)] if self.categories else f"{number:.6g}"

    def value(self, number: float) -> float | str:
        """The value of a case with this number: itself, or a category."""
        if not self.categories:
            return number
        category = self.categories[int(number)]
        return float(category) if self.some_are_numbers and category != DERIVED else category

    def of_case(self, case: int) -> float | str:
        """The value of a case."""
        return self.value(float(self.numbers[case]))

    def dress(self, axes: Axes, room: int, which: str = "x") -> None:
        """Set the scale of an axis, and ticks at the values; it has room for `room` labels."""
        is_x = which == "x"
        axis = axes.xaxis if is_x else axes.yaxis
        set_scale = axes.set_xscale if is_x else axes.set_yscale
        set_margin = axes.set_xmargin if is_x else axes.set_ymargin
        if self.categories:
            names = [category.replace("_", " ") for category in self.categories]
            axis.set_ticks(range(len(names)), names)
            set_margin(0.2)
            return
        if self.scale == "symlog":
            smallest = self.numbers[self.numbers > 0.0].min()
            set_scale(self.scale, linthresh=smallest, linscale=SYMLOG_SHARE)
        else:
            set_scale(self.scale)
        axis.set_minor_formatter(ticker.NullFormatter())
        if not self.has_single_ticks or self.different.size == 1:  # of a single value: around it
            wide = self.numbers.max() > 1000.0 * max(self.numbers.min(), 1e-300)
            automatic = ticker.LogLocator(subs=(1,) if wide else (1, 2, 5), numticks=room)
            axis.set_major_locator(automatic if self.logarithmic else ticker.MaxNLocator(room))
            axis.set_minor_locator(ticker.NullLocator())
        else:
            axis.set_major_locator(ticker.FixedLocator(apart(self.different, self.scale, room)))
            axis.set_minor_locator(ticker.FixedLocator(self.different.tolist()))
        axis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))


def apart(ascending: Floats, scale: str, room: int) -> Sequence[float]:
    """The first and last number, and others whose labels do not overlap; see `Values.dress`."""
    if ascending.size <= 2:
        return [float(number) for number in ascending]
    places = ascending
    if scale != "linear":
        smallest = ascending[ascending > 0.0].min()
        places = np.log(np.maximum(ascending, 0.3 * smallest))
    share = (places - places[0]) / (places[-1] - places[0])
    kept = [0]
    for place in range(1, ascending.size - 1):
        if min(share[place] - share[kept[-1]], 1.0 - share[place]) >= 1.0 / room:
            kept.append(place)
    return [float(ascending[place]) for place in (*kept, ascending.size - 1)]


def _category(value: object) -> str:
    if isinstance(value, float):
        return DERIVED if np.isnan(value) else f"{value:.6g}"
    return str(value) or DERIVED
