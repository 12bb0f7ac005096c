"""Ground of a law with parameters of its own: what of it the profile has by depth, what the scene.

Between two rows of the table the parameters are linear. Strength and stiffness that follow from
them need not be: so each part between two rows is made of several.
"""

from collections.abc import Collection, Mapping

import numpy as np

from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.material import Material
from mpm_warp.materials.other_laws import OtherLaw
from mpm_warp.scenes.clay import FieldClayScene
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

PARTS = 10
"""Rows that one row becomes; strength and stiffness are then within a hundredth of how much they
are curved between the rows of the table."""
VERTICAL, HORIZONTAL = "vertical", "horizontal"
"""Effective stresses of the ground [Pa], as columns on the way."""


def with_strength(test: FieldClayScene, columns: Mapping[str, Floats]) -> Mapping[str, Floats]:
    """The columns of a ground, with strength and stiffness where these are of its law.

    They are in SI units, each of shape [row_count]. Where there is none the parameters of the
    sounding hold.

    Raises:
        ParameterError: a column is of another law, or not beside this one, or a row is no clay.
    """
    law = test.law
    own = set() if law is None else law.parameters.keys()
    for name in columns.keys() - {*OWN, *STIFFNESS, *OF_EFFECTIVE_STRESS} - own:
        raise refused(f"column {name} is no parameter of material = {test.material!r}")
    if law is None or "strength" in law.given:
        return columns
    of_law = ["strength", *([] if "shear_modulus" in law.given else STIFFNESS)]
    for name in of_law:
        if name in columns:
            raise refused(f"column {name}: material = {test.material!r} has its own; leave it out")
    columns = _with_stresses(columns, own)
    rows = _finer(columns) if {*own, VERTICAL} & columns.keys() else columns
    deviator = _of_stresses(rows, own)
    clays = [_clay_in(test, law, rows, row) for row in range(len(rows["depth"]))]
    strengths = [clay.undrained_strength(clay.reference_test) for clay in clays]
    found = {"strength": np.array(strengths, dtype=float)}
    if "shear_modulus" not in law.given:
        found["shear_modulus"] = np.array([clay.ground_shear_modulus for clay in clays])
    if deviator is None and "stress_anisotropy" not in rows:
        own_deviators = [clay.deviator_at_rest for clay in clays]
        deviator = None if None in own_deviators else np.array(own_deviators, dtype=float)
    return rows | found if deviator is None else with_anisotropy(rows | found, deviator)


def _with_stresses(columns: Mapping[str, Floats], own: Collection[str]) -> dict[str, Floats]:
    """Columns with the effective stresses of the ground in the place of K0 and ground water."""
    if "K0" not in columns:
        return dict(columns)
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


def _of_stresses(rows: dict[str, Floats], own: Collection[str]) -> Floats | None:
    """Vertical less horizontal stress in rows, whose p0' and K0 a law of effective stress gets."""
    if VERTICAL not in rows:
        return None
    vertical, horizontal = rows.pop(VERTICAL), rows.pop(HORIZONTAL)
    if MEAN_STRESS in own:
        rows[MEAN_STRESS] = (vertical + 2.0 * horizontal) / 3.0
        rows[EARTH_PRESSURE] = horizontal / vertical
    return vertical - horizontal


def _finer(columns: Mapping[str, Floats]) -> dict[str, Floats]:
    """The same ground in more rows; a border stays a border."""
    numbers = np.arange(len(columns["depth"]))
    between = numbers[:-1][np.diff(columns["depth"]) > 0.0]
    finer = np.unique(np.concatenate([numbers, *(between + k / PARTS for k in range(PARTS))]))
    return {name: np.interp(finer, numbers, values) for name, values in columns.items()}


def _clay_in(test: FieldClayScene, law: OtherLaw, rows: Mapping[str, Floats], row: int) -> Material:
    given = {"density": 1.0, "shear_modulus": 1.0, "poissons_ratio": test.poissons_ratio}
    own = {name: getattr(test, name, None) for name in law.parameters}
    try:
        for name in own.keys() & rows.keys():
            own[name] = law.parameters[name].checked(float(rows[name][row]))
        return law.make(own, given)
    except (SceneError, ParameterError) as refusal:
        raise ParameterError("material", f"at {rows['depth'][row]:g} m: {refusal}") from None
