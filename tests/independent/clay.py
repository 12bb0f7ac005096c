"""Clay that is elastic and perfectly plastic: its stress, and how it follows the strain.

Stresses are (rr, zz, rz, tt) over su, tension positive; strains are (rr, zz, 2 rz, tt). So su = 1,
and the shear modulus is the rigidity index.
"""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[np.float64]
UNIT = np.array([1.0, 1.0, 0.0, 1.0])


@dataclass(frozen=True)
class Clay:
    """A clay by its rigidity index G / su, su being the strength in pure shear."""

    rigidity_index: float = 100.0
    poissons_ratio: float = 0.49
    criterion: str = "tresca"  # or von_mises

    @property
    def bulk_modulus(self) -> float:
        nu = self.poissons_ratio
        return 2.0 * self.rigidity_index * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu))

    @property
    def stiffness(self) -> Array:
        """Elastic, (4, 4)."""
        lame = self.bulk_modulus - 2.0 / 3.0 * self.rigidity_index
        return lame * np.outer(UNIT, UNIT) + self.rigidity_index * np.diag([2.0, 2.0, 1.0, 2.0])

    def respond(self, trial: Array) -> tuple[Array, Array]:
        """Stress (n, 4) and consistent tangent (n, 4, 4) by the elastic trial stress (n, 4)."""
        return {"tresca": self._tresca, "von_mises": self._von_mises}[self.criterion](trial)

    def _von_mises(self, trial: Array) -> tuple[Array, Array]:
        """Radial return: s = m s_trial, with m = min(1, 1 / sqrt(J2))."""
        mean = trial @ UNIT / 3.0
        deviator = trial - mean[:, None] * UNIT
        j2 = 0.5 * (deviator**2 @ UNIT) + deviator[:, 2] ** 2
        share = 1.0 / np.sqrt(np.maximum(j2, 1.0))[:, None]
        volumetric = self.bulk_modulus * np.outer(UNIT, UNIT)
        tangent = volumetric + share[:, :, None] * (self.stiffness - volumetric)
        turned = self.rigidity_index * share[:, 0] * (j2 > 1.0) / np.maximum(j2, 1.0)
        tangent -= np.einsum("n,ni,nj->nij", turned, deviator, deviator)
        return mean[:, None] * UNIT + share * deviator, tangent

    def _tresca(self, trial: Array) -> tuple[Array, Array]:
        """Return in principal stresses p1 >= p2 >= p3 to a face or an edge of p1 - p3 = 2.

        Where the face would change their order, the stress lies on an edge, at
        mean + (2, 2, -4) / 3 or mean + (4, -2, -2) / 3.
        """
        modulus, bulk = self.rigidity_index, self.bulk_modulus
        centre, half = (trial[:, 0] + trial[:, 1]) / 2.0, (trial[:, 0] - trial[:, 1]) / 2.0
        radius = np.hypot(half, trial[:, 2])
        angle = np.arctan2(trial[:, 2], half)  # twice that of the major axis to r
        principal = np.stack([centre + radius, centre - radius, trial[:, 3]], axis=1)

        order = np.argsort(-principal, axis=1)
        place = np.argsort(order, axis=1)
        major, middle, minor = np.take_along_axis(principal, order, axis=1).T
        excess = np.maximum(major - minor - 2.0, 0.0) / 2.0
        stress = np.stack([major - excess, middle, minor + excess], axis=1)
        slip = np.array([1.0, 0.0, -1.0])
        moduli = (
            bulk
            - 2.0 / 3.0 * modulus
            + 2.0 * modulus * np.eye(3)
            - np.where(excess[:, None, None] > 0.0, modulus * np.outer(slip, slip), 0.0)
        )
        for on_edge, edge in (
            (middle > stress[:, 0], (2.0, 2.0, -4.0)),
            (middle < stress[:, 2], (4.0, -2.0, -2.0)),
        ):
            stress[on_edge] = principal[on_edge].mean(axis=1)[:, None] + np.array(edge) / 3.0
            moduli[on_edge] = bulk
        stress = np.take_along_axis(stress, place, axis=1)
        moduli = moduli[np.arange(len(trial))[:, None, None], place[:, :, None], place[:, None, :]]

        # From the principal axes back to r and z; the turn of the axes has a modulus of its own.
        left = np.where(radius > 1e-12, (stress[:, 0] - stress[:, 1]) / 2.0, 0.0)
        local = np.zeros((len(trial), 4, 4))
        local[:, [[0], [1], [3]], [0, 1, 3]] = moduli
        local[:, 2, 2] = modulus * np.where(radius > 1e-12, left / np.maximum(radius, 1e-12), 1.0)
        cos, sin, zero = np.cos(angle), np.sin(angle), np.zeros(len(trial))
        turn = np.array(
            [
                [(1.0 + cos) / 2.0, (1.0 - cos) / 2.0, sin / 2.0, zero],
                [(1.0 - cos) / 2.0, (1.0 + cos) / 2.0, -sin / 2.0, zero],
                [-sin, sin, cos, zero],
                [zero, zero, zero, zero + 1.0],
            ]
        ).transpose(2, 0, 1)
        middle_of = (stress[:, 0] + stress[:, 1]) / 2.0
        back = [middle_of + left * cos, middle_of - left * cos, left * sin, stress[:, 2]]
        return np.stack(back, axis=1), turn.transpose(0, 2, 1) @ local @ turn


def rotated(stress: Array, angle: Array) -> Array:
    """The stress (n, 4) turned by an angle (n) from r to z."""
    centre, half = (stress[:, 0] + stress[:, 1]) / 2.0, (stress[:, 0] - stress[:, 1]) / 2.0
    cos, sin = np.cos(2.0 * angle), np.sin(2.0 * angle)
    difference, shear = half * cos - stress[:, 2] * sin, half * sin + stress[:, 2] * cos
    return np.stack([centre + difference, centre - difference, shear, stress[:, 3]], axis=1)
