"""Values that are allowed, but off by what looks like a unit: reported in one line each.

A warning needs every value that the study gives to be outside the usual range, and inside it in
another unit: a study that goes through many orders of magnitude means what it says.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from harness.errors import tell
from harness.study.designs import Range
from harness.study.scene_part import ScenePart
from harness.study.study import Study

PASCAL = {"kPa": 1e3, "MPa": 1e6}
METRE = {"mm": 1e-3, "cm": 1e-2}
MEANT = (0.0, 1.0)
"""Values that are no slip: none of it, and the unit of a scaled study, as lengths in cone radii."""


@dataclass(frozen=True)
class Usual:
    """The usual range of a parameter of soil or penetrometer.

    Attributes:
        low, high: the ends, in the parameter's own unit.
        units: other units that a value is often given in, and what one of them is.
    """

    low: float
    high: float
    units: Mapping[str, float]

    def unit_of(self, value: float) -> str | None:
        """The unit in which the value would be usual; None where it is, or in no unit would be."""
        if value in MEANT or self.low <= value <= self.high:
            return None
        return next(
            (unit for unit, size in self.units.items() if self.low <= value * size <= self.high),
            None,
        )


USUAL = {
    "undrained_shear_strength": Usual(1e3, 1e6, PASCAL),
    "in_situ_stress": Usual(1e3, 1e8, PASCAL),
    "normal_pressure": Usual(1e3, 1e8, PASCAL),
    "shear_modulus": Usual(1e5, 1e11, PASCAL),
    "cone_radius": Usual(5e-3, 0.1, METRE),
    "density": Usual(1000.0, 3000.0, {"t/m3": 1e3, "kN/m3": 1e3 / 9.81}),
}
"""Clays from very soft to hard, offshore and on land; penetrometers from 0.8 cm2 to 300 cm2."""


def tell_of_unusual_values(study: Study) -> None:
    """Warn of each value that looks like a slip of the unit, in one line."""
    for line in unusual_values(study):
        tell(line)


def unusual_values(study: Study) -> list[str]:
    """What a study gives that looks like a slip of the unit: name, value, what to give instead."""
    lines = [line for part in study.parts for line in _of_part(part)]
    return list(dict.fromkeys(lines))


def _of_part(part: ScenePart) -> list[str]:
    lines = []
    for name, usual in USUAL.items():
        values = _given(part, name)
        units = {usual.unit_of(value) for value in values}
        if len(units) != 1 or (unit := units.pop()) is None:
            continue
        own, value = part.parameters[name].unit, values[0]
        lines.append(
            f"{name} = {value:g} is in {own}; if {value:g} {unit} is meant, give "
            f"{value * usual.units[unit]:g}"
        )
    return lines


def _given(part: ScenePart, name: str) -> list[float]:
    """All values that a study gives to a parameter."""
    varied = part.varied.get(name, ())
    values = [part.fixed[name]] if name in part.fixed else []
    values += [varied.start, varied.stop] if isinstance(varied, Range) else varied
    values += [case[name] for case in part.listed if name in case]
    return [float(value) for value in values]
