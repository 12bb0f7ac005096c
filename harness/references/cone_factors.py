"""Formulas for the cone factor Nc = (qc - sigma_v0) / su, from the literature and this project.

A new reference is one new entry in :data:`CONE_FACTORS`. The formulas take floats, numpy arrays
and xarray data arrays alike.
"""

import functools
import math
import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import xarray as xr

Quantity: TypeAlias = float | np.ndarray | xr.DataArray
Truth: TypeAlias = bool | np.ndarray | xr.DataArray
COMPARED = "cone_factor"
"""The result that references are compared with."""
NEEDED = ("rigidity_index", "adhesion_factor")
"""Parameters that a scene needs for a comparison."""
QUOTED = "coefficients as commonly quoted; the original was not read"
"""Origin of an entry whose source could not be consulted."""


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """The quantities that the formulas depend on. All but the angle are dimensionless.

    All formulas are for a cone of 60 degrees without friction, in clay whose strength does not
    depend on strain, strain rate or direction of shear.
    """

    rigidity_index: Quantity  # shear modulus over undrained shear strength, G/su, above 0
    face_adhesion: Quantity  # adhesion factor of the cone face, 0 to 1
    shaft_adhesion: Quantity
    stress_anisotropy: Quantity = 0.0  # (sigma_v0 - sigma_h0) / (2 su) in the ground before
    apex_angle: Quantity = 60.0  # of the cone [degree]
    friction: Quantity = 0.0  # Coulomb coefficient of the penetrometer
    strength_stays: Truth = True  # whether the strength depends on none of these
    # parameters of the scene by name, in SI units, for references that a study defines
    parameters: Mapping[str, Quantity] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class ConeFactor:
    """One formula for the cone factor.

    Analyses of penetration with an adhesion term form the envelope that is shown with a result.
    """

    id: str  # name in study definitions and in the variables of a result
    label: str  # authors and year, for pictures
    formula: str
    evaluate: Callable[[Conditions], Quantity]  # extrapolates; `applies` says where it should not
    method: str  # how the source arrived at the formula
    source: str  # where it was published
    criterion: str = "not stated here"  # yield criterion, and meaning of su where it is stated
    in_envelope: bool = False
    how_known: str = QUOTED  # where the coefficients were taken from
    rigidity_index_range: tuple[float, float] = (50.0, 500.0)  # in which it is valid
    largest_anisotropy: float = math.inf  # largest |Delta| for which it is valid

    @property
    def has_adhesion_term(self) -> bool:
        """Whether the formula has a term for adhesion; if not, it is for a smooth cone."""
        return "alpha" in self.formula

    @property
    def validity(self) -> str:
        """The conditions for which the formula is valid, in words."""
        low, high = self.rigidity_index_range
        smooth = "" if self.has_adhesion_term else ", smooth face"
        largest = self.largest_anisotropy
        anisotropy = f", |Delta| up to {largest:g}" if math.isfinite(largest) else ""
        return (
            "60 degree cone, no friction, no softening or rate effect, one su in all tests, "
            f"rigidity index {low:g} to {high:g}{anisotropy}{smooth}"
        )

    def applies(self, conditions: Conditions) -> Quantity:
        """Whether the formula is valid for `conditions`, element by element.

        The yield criterion and the meaning of su (see :attr:`criterion`) are not checked.
        """
        low, high = self.rigidity_index_range
        inside = (
            (conditions.rigidity_index >= low)
            & (conditions.rigidity_index <= high)
            & (conditions.apex_angle == 60.0)
            & (conditions.friction == 0.0)
            & (conditions.stress_anisotropy >= -self.largest_anisotropy)
            & (conditions.stress_anisotropy <= self.largest_anisotropy)
            & conditions.strength_stays
        )
        return inside if self.has_adhesion_term else inside & (conditions.face_adhesion == 0)


_ln: Callable[[Quantity], Quantity] = np.log


def _spherical_cavity(rigidity_index: Quantity) -> Quantity:
    """Limit pressure of a spherical cavity over su."""
    return 4 / 3 * (1 + _ln(rigidity_index))


CONE_FACTORS: tuple[ConeFactor, ...] = (
    ConeFactor(
        id="lu_2004",
        label="Lu et al. 2004",
        formula="3.4 + 1.6 ln Ir - 1.9 Delta + 1.3 alpha_c",
        evaluate=lambda c: (
            3.4 + 1.6 * _ln(c.rigidity_index) - 1.9 * c.stress_anisotropy + 1.3 * c.face_adhesion
        ),
        criterion="Tresca",
        method="large-deformation finite elements with remeshing",
        source="Lu, Randolph, Hu & Bugarski 2004, Geotechnique 54(4):257-267",
        in_envelope=True,
    ),
    ConeFactor(
        id="teh_houlsby_1991",
        label="Teh & Houlsby 1991",
        formula="4/3 (1 + ln Ir) (1.25 + Ir/2000) + 2.4 alpha_c - 0.2 alpha_s - 1.8 Delta",
        evaluate=lambda c: (
            _spherical_cavity(c.rigidity_index) * (1.25 + c.rigidity_index / 2000)
            + 2.4 * c.face_adhesion
            - 0.2 * c.shaft_adhesion
            - 1.8 * c.stress_anisotropy
        ),
        criterion="von Mises, su from triaxial compression",
        method="strain path and finite elements",
        source="Teh & Houlsby 1991, Geotechnique 41(1):17-34",
        in_envelope=True,
    ),
    ConeFactor(
        id="yu_2000",
        label="Yu et al. 2000",
        formula="0.33 + 2 ln Ir + 2.37 alpha - 1.83 Delta",
        evaluate=lambda c: (
            0.33 + 2 * _ln(c.rigidity_index) + 2.37 * c.face_adhesion - 1.83 * c.stress_anisotropy
        ),
        criterion="von Mises",
        method="steady-state finite elements",
        source="Yu, Herrmann & Boulanger 2000, J. Geotech. Geoenviron. Eng. 126(7):594-605",
        in_envelope=True,
    ),
    ConeFactor(
        id="vesic_1977",
        label="Vesic 1977",
        formula="4/3 (1 + ln Ir) + 2.57",
        evaluate=lambda c: _spherical_cavity(c.rigidity_index) + 2.57,
        method="spherical cavity and end wedge",
        source="Vesic 1977, NCHRP Synthesis 42",
    ),
    ConeFactor(
        id="ladanyi_johnston_1974",
        label="Ladanyi & Johnston 1974",
        formula="4/3 (1 + ln Ir) + sqrt(3) alpha_c",
        evaluate=lambda c: _spherical_cavity(c.rigidity_index) + math.sqrt(3) * c.face_adhesion,
        method="spherical cavity on the face and face adhesion",
        source="Ladanyi & Johnston 1974, Can. Geotech. J. 11(4):531-553",
    ),
    ConeFactor(
        id="baligh_1985",
        label="Baligh 1985",
        formula="1.51 + 2 ln Ir",
        evaluate=lambda c: 1.51 + 2 * _ln(c.rigidity_index),
        method="strain path",
        source="Baligh 1985, J. Geotech. Eng. 111(9):1108-1136",
    ),
    ConeFactor(
        id="yu_1993",
        label="Yu 1993",
        formula="4.18 + 1.155 ln(sqrt(3)/2 Ir)",
        evaluate=lambda c: 4.18 + 1.155 * _ln(math.sqrt(3) / 2 * c.rigidity_index),
        criterion="von Mises",
        method="cylindrical cavity",
        source="Yu 2000, Cavity Expansion Methods in Geomechanics, ch. 8",
    ),
    ConeFactor(
        id="abu_farsakh_2003",
        label="Abu-Farsakh et al. 2003",
        formula="2.45 + 1.8 ln Ir - 2.1 Delta",
        evaluate=lambda c: 2.45 + 1.8 * _ln(c.rigidity_index) - 2.1 * c.stress_anisotropy,
        criterion="modified Cam clay",
        method="coupled finite elements",
        source="Abu-Farsakh, Tumay & Voyiadjis 2003, Int. J. Geomech. 3(2):170-181",
    ),
    ConeFactor(
        id="this_project",
        label="this project",
        formula="0.75 + 2.152 ln Ir + 1.36 alpha_c + 0.10 alpha_s - 2.11 Delta",
        evaluate=lambda c: (
            0.75
            + 2.152 * _ln(c.rigidity_index)
            + 1.36 * c.face_adhesion
            + 0.10 * c.shaft_adhesion
            - 2.11 * c.stress_anisotropy
        ),
        criterion="Tresca, su in pure shear",
        method="material point method; least squares over 200 cases",
        source="studies/cone_factor_table.csv of this project",
        how_known="95 % of the cases are within 0.10 of it, all within 0.15; their own U is 0.06 "
        "to 0.16",
        rigidity_index_range=(20.0, 1000.0),
        largest_anisotropy=0.5,
    ),
)

ENVELOPE = tuple(reference for reference in CONE_FACTORS if reference.in_envelope)


def envelope(conditions: Conditions) -> tuple[Quantity, Quantity]:
    """Smallest and largest cone factor among the references of the envelope.

    It is not a confidence interval: the references differ in criterion, meaning of su and method.
    """
    values = [reference.evaluate(conditions) for reference in ENVELOPE]
    return functools.reduce(np.minimum, values), functools.reduce(np.maximum, values)


def envelope_applies(conditions: Conditions) -> Quantity:
    """Whether all references of the envelope are valid, element by element."""
    return functools.reduce(operator.and_, (member.applies(conditions) for member in ENVELOPE))
