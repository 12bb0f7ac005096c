"""Ground of a law with parameters of its own: what of it the profile has by depth, what the scene.

Between two rows of the table the parameters are linear. Strength and stiffness that follow from
them need not be: so each part between two rows is made of several.
"""

from collections.abc import Mapping

import numpy as np

from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.material import Material
from mpm_warp.materials.other_laws import OtherLaw, other_law, other_laws
from mpm_warp.scenes.clay import FieldClayScene
from mpm_warp.scenes.sounding.profile import OWN, STIFFNESS, refused

PARTS = 10
"""Rows that one row becomes; strength and stiffness are then within a hundredth of how much they
are curved between the rows of the table."""


def with_strength(test: FieldClayScene, columns: Mapping[str, Floats]) -> Mapping[str, Floats]:
    """The columns of a ground, with strength and stiffness where these are of its law.

    Args:
        test: a sounding, whose parameters hold where there is no column.
        columns: by name, in SI units, each of shape [row_count].

    Raises:
        ParameterError: a column is of another law, or not beside this one, or a row is no clay.
    """
    law = other_law(test.material) if test.material in other_laws() else None
    own = set() if law is None else law.parameters.keys()
    for name in columns.keys() - {*OWN, *STIFFNESS} - own:
        raise refused(f"column {name} is no parameter of material = {test.material!r}")
    if law is None or "strength" in law.given:
        return columns
    of_law = ["strength", *([] if "shear_modulus" in law.given else STIFFNESS)]
    for name in of_law:
        if name in columns:
            raise refused(f"column {name}: material = {test.material!r} has its own; leave it out")
    rows = _finer(columns) if own & columns.keys() else dict(columns)
    clays = [_clay_in(test, law, rows, row) for row in range(len(rows["depth"]))]
    strengths = [clay.undrained_strength(clay.reference_test) for clay in clays]
    found = {"strength": np.array(strengths, dtype=float)}
    if "shear_modulus" not in law.given:
        found["shear_modulus"] = np.array([clay.ground_shear_modulus for clay in clays])
    return rows | found


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
