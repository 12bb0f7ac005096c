"""Strength, stiffness and stress of a ground by the law of its clay, from the columns of a table.

Parameters of a law are linear between two rows. Strength and stiffness that follow from them need
not be linear, so rows are added in between.
"""

from collections.abc import Collection, Mapping

import numpy as np

from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.material import Material
from mpm_warp.scenes.clay import FieldClay
from mpm_warp.scenes.sounding.table import (
    EARTH_PRESSURE,
    MEAN_STRESS,
    OF_EFFECTIVE_STRESS,
    OWN,
    STIFFNESS,
    effective_vertical_stress,
    refused,
    with_anisotropy,
    without_effective_stress,
)

SUBDIVISION = 10
"""Parts of the distance of two rows, for linear interpolation of strength and stiffness. It divides
the error by a hundred."""
VERTICAL, HORIZONTAL = "vertical", "horizontal"
"""Temporary columns of effective stresses [Pa]."""


def with_strength(clay: FieldClay, columns: Mapping[str, Floats]) -> Mapping[str, Floats]:
    """The columns of a ground in SI units, with strength and stiffness where the law gives them.

    Parameters of the law without a column are those of the clay.

    Raises:
        ParameterError: a column is of another law or conflicts with this one, or the law does not
            allow the values of a row.
    """
    law = clay.material
    own = law.parameters.keys()
    for name in columns:
        if name in own or name in (*OWN, *STIFFNESS, *OF_EFFECTIVE_STRESS):
            continue
        raise refused(f"column {name} is no parameter of material = {law.name!r}")
    if not law.has_own_strength:
        return columns
    for name in ["strength", *(STIFFNESS if law.has_own_stiffness else [])]:
        if name in columns:
            raise refused(f"column {name}: material = {law.name!r} has its own; leave it out")
    deviator: Floats | None = None
    rows = _with_stresses(columns, own) if "K0" in columns else dict(columns)
    if {*own, VERTICAL} & rows.keys():
        rows = _finer(rows)
    if VERTICAL in rows:
        vertical, horizontal = rows.pop(VERTICAL), rows.pop(HORIZONTAL)
        deviator = vertical - horizontal
        if MEAN_STRESS in own:
            rows[MEAN_STRESS] = (vertical + 2.0 * horizontal) / 3.0
            rows[EARTH_PRESSURE] = horizontal / vertical
    by_row = [_law_in(clay, rows, row) for row in range(len(rows["depth"]))]
    strengths = [it.undrained_strength(it.reference_test) for it in by_row]
    found = {"strength": np.array(strengths, dtype=float)}
    if law.has_own_stiffness:
        found["shear_modulus"] = np.array([it.ground_shear_modulus for it in by_row])
    if deviator is None and "stress_anisotropy" not in rows:
        own_deviators = [it.deviator_at_rest for it in by_row]
        deviator = None if None in own_deviators else np.array(own_deviators, dtype=float)
    return rows | found if deviator is None else with_anisotropy(rows | found, deviator)


def _with_stresses(columns: Mapping[str, Floats], own: Collection[str]) -> dict[str, Floats]:
    """Columns with the effective stresses of the ground instead of K0 and ground water."""
    if MEAN_STRESS in columns:
        raise refused(f"has K0 with ground_water and {MEAN_STRESS}; keep one of them")
    vertical = effective_vertical_stress(columns)
    if MEAN_STRESS in own and not vertical.min() > 0.0:
        where = columns["depth"][int(vertical.argmin())]
        raise refused(
            f"there is no effective vertical stress at {where:g} m, which the law needs: begin the "
            "ground deeper"
        )
    stresses = {VERTICAL: vertical, HORIZONTAL: columns["K0"] * vertical}
    return without_effective_stress(columns) | stresses


def _finer(columns: Mapping[str, Floats]) -> dict[str, Floats]:
    """The same ground with more rows, but none between the two rows of a border."""
    numbers = np.arange(len(columns["depth"]))
    between = numbers[:-1][np.diff(columns["depth"]) > 0.0]
    parts = (between + part / SUBDIVISION for part in range(SUBDIVISION))
    finer = np.unique(np.concatenate([numbers, *parts]))
    return {name: np.interp(finer, numbers, values) for name, values in columns.items()}


def _law_in(clay: FieldClay, rows: Mapping[str, Floats], row: int) -> Material:
    names = clay.material.own.keys() & rows.keys()
    try:
        law = clay.material.changed({name: float(rows[name][row]) for name in names})
        return law.material(density=1.0, shear_modulus=1.0, poissons_ratio=clay.poissons_ratio)
    except (SceneError, ParameterError) as refusal:
        raise ParameterError("material", f"at {rows['depth'][row]:g} m: {refusal}") from None
