"""Readings that no cone can have, and units that no soil lets stand."""

import math
from collections.abc import Mapping

import numpy as np

from harness.interpret.forms import AXES, WATER, ByDepth
from harness.interpret.site import MeasuredTest
from harness.study.tables import StudyError
from mpm_warp.fields.checks import Range
from mpm_warp.grid.fitted import Floats

POSSIBLE: Mapping[str, tuple[Range, str, float]] = {
    "qc": (Range(minimum=-0.2, maximum=200), "MPa", 1e6),
    "fs": (Range(minimum=-0.2, maximum=5), "MPa", 1e6),
    "u2": (Range(minimum=-100, maximum=100), "MPa", 1e6),
} | dict.fromkeys(AXES, (Range(minimum=-45, maximum=45), "degrees", math.pi / 180.0))
"""Values that a cone, a sleeve, a filter and an inclinometer can measure, their unit and its size;
a zero may be shifted."""
ABOVE_VACUUM = Range(minimum=-0.2, maximum=100), "MPa", 1e6
"""The same of u2 if its zero is the pressure of the air: water boils at -0.1 MPa."""
FEW = 0.02
"""Largest share of rows with a reading that is lost, as by a bad contact."""
OF_SOIL: Mapping[str, tuple[Range, str]] = {
    "fs": (Range(minimum=2e-4, maximum=0.5), "0.001 to 0.1"),
    "u2": (Range(maximum=10), "at most 1"),
}
"""Median ratios to qc, with a margin, and in words; a wrong unit is mostly a thousand off."""
LEAST_OF_WATER = 0.01
"""Least u2 over the pressure of the water in the ground, if it is measured at all."""


def without_lost(
    test: MeasuredTest, places: np.ndarray, values: dict[str, Floats], notes: list[str]
) -> None:
    """Set single lost readings to NaN, with a note; refuse values that no cone measures.

    Few readings below all that is possible are lost ones, and so are few inclinations; a value
    above, or many, have another unit.
    """
    # At sea water_level is 0, and the zero of the sensors may be the pressure at the sea bed.
    from_air = not isinstance(test.water, ByDepth) and test.water != 0.0
    bounds = {**POSSIBLE, "u2": ABOVE_VACUUM} if from_air else POSSIBLE
    for name, (possible, unit, size) in bounds.items():
        own = values.get(name, np.zeros(0)) / size
        low, high = (np.nan_to_num(own) < possible.minimum, np.nan_to_num(own) > possible.maximum)
        if not (wrong := low | high).any():
            continue
        first = int(np.argmax(wrong))
        if wrong.mean() <= FEW and (name in AXES or not high.any()):
            values[name][wrong] = np.nan
            notes.append(
                f"readings of {name} left out that no cone can have: {np.sum(wrong)}, the first "
                f"{own[first]:.3g} {unit}, at {places[first]}"
            )
            continue
        remedy = (
            "look at its unit; a code for no value belongs under `missing` of the site file, as "
            "missing = [-9999]"
        )
        if name == "u2" and from_air and low[first]:
            remedy += "; where sensors were set to zero on the sea bed water_level is 0"
        raise StudyError(
            f"{test.file}: {places[first]}: {name} = {own[first]:.4g} {unit}, must be "
            f"{possible.allowed}; {remedy}"
        )


def check_units(
    test: MeasuredTest, values: Mapping[str, Floats], units: Mapping[str, str], notes: list[str]
) -> None:
    """Refuse units of fs and u2 by which no soil has their values beside qc.

    A u2 far below the pressure of the water is noted, as a filter may be out of order.
    """
    qc, depth, water = values["qc"], values["depth"], test.water
    for name, (possible, of_soil) in OF_SOIL.items():
        above = (qc > 0.0) & (values[name] > 0.0)
        ratio = float(np.median(values[name][above] / qc[above])) if above.any() else math.nan
        if above.any() and not possible.holds(ratio, ratio):
            raise StudyError(
                f"{test.file}: {name} / qc is {ratio:.2g} (median), in soil it is {of_soil}; qc is "
                f"read in {units['qc']}, {name} in {units[name]}: look at these units; "
                f'the site file may state others, as units = {{ qc = "MPa", {name} = "kPa" }}'
            )
    largest = float(np.max(np.abs(np.nan_to_num(values["u2"]))))
    deepest = max(water.value) if isinstance(water, ByDepth) else WATER * (depth[-1] - water)
    if 0.0 < largest < LEAST_OF_WATER * deepest:
        notes.append(
            f"u2 is at most {largest:.2g} Pa, where water has {deepest:.2g} Pa: no filter "
            f"measures, or not in {units['u2']}"
        )
