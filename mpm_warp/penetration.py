"""A penetration, from a simulation at rest to curves of resistance and their steady values."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.penetrometer import PenetrometerForces, PenetrometerSurface
from mpm_warp.results import curves_kept, variable
from mpm_warp.simulation import Simulation
from mpm_warp.steady_state import is_steady
from mpm_warp.travel import Travel

SAMPLE_SPACING = 0.1
"""Penetration between two samples of the curves, in cone radii."""
STEADY_SAMPLES = 20
"""Samples whose mean is the steady value: two radii."""


@dataclass(kw_only=True)
class Penetration:
    """A penetrometer that is pushed in until its resistance is steady.

    Attributes:
        surface: of the penetrometer.
        greatest: penetration at which it ends in any case, over the radius.
        unsteady: penetration before which no resistance counts as steady, over the radius.
        tolerance: change of the resistance over two radii at which it counts as steady.
    """

    surface: PenetrometerSurface
    greatest: float
    unsteady: float
    tolerance: float
    _nodal_forces: list[Floats] = field(default_factory=list, init=False)  # by sample
    _moved: list[float] = field(default_factory=list, init=False)  # in each sample [m]
    _forces: list[PenetrometerForces] = field(default_factory=list, init=False)
    _sampled_at: float = field(default=0.0, init=False)

    @property
    def forces(self) -> list[PenetrometerForces]:
        """Mean forces over each sample so far."""
        # Few ask before the end, and all together they take a fraction of the time.
        new = self._nodal_forces[len(self._forces) :]
        self._forces.extend(map(self.surface.forces, new))
        return self._forces

    @property
    def work(self) -> float:
        """Of the penetrometer so far, per radian [J]."""
        parts = zip(self.forces, self._moved, strict=True)
        return math.fsum(force.upward * moved for force, moved in parts)

    def run(self, simulation: Simulation, progress: Callable[[float], None] | None) -> None:
        """Push it in.

        Raises:
            SimulationDiverged: its `history` holds the curves up to there.
            WindowOverfull: see `Travel`.
        """
        with curves_kept(self.curves):
            self._push(simulation, progress)

    def _push(self, simulation: Simulation, progress: Callable[[float], None] | None) -> None:
        travel = Travel(simulation)
        sample_count = round(self.greatest / SAMPLE_SPACING)
        for sample in range(1, sample_count + 1):
            steady = self.push_to(sample * self._spacing, travel, simulation)
            if progress is not None:
                progress(sample / sample_count)
            if steady:
                break
        simulation.check()

    def push_to(self, distance: float, travel: Travel, simulation: Simulation) -> bool:
        """Push it in by `distance` [m] since the start; returns whether its resistance is steady.

        Raises:
            SimulationDiverged: see `Travel`.
        """
        steady = False
        while (next_sample := (len(self._moved) + 1) * self._spacing) <= distance:
            travel.advance_to(next_sample)
            reached = travel.distance
            if reached > self._sampled_at:
                nodal_forces = simulation.take_contact_forces()
            else:  # one step may go past several samples
                nodal_forces = self._nodal_forces[-1]
            self._nodal_forces.append(nodal_forces)
            self._moved.append(reached - self._sampled_at)
            self._sampled_at = reached
            steady = self._is_steady
        travel.advance_to(distance)
        return steady

    @property
    def _is_steady(self) -> bool:
        earliest = len(self._moved) - 2 * STEADY_SAMPLES
        if (earliest + 0.5) * SAMPLE_SPACING < self.unsteady:
            return False
        resistance = [it.face_normal + it.face_shear for it in self.forces[earliest:]]
        return is_steady(resistance, STEADY_SAMPLES, self.tolerance)

    @property
    def _spacing(self) -> float:
        """Travel between two samples [m]."""
        return SAMPLE_SPACING * self.surface.penetrometer.radius

    def curves(self) -> xr.Dataset:
        """Resistance, its shear part, friction of the shaft and contact over penetration."""
        # Each sample is a mean over the travel since the one before; it stands in the middle.
        penetration = (np.arange(len(self._moved)) + 0.5) * SAMPLE_SPACING
        base_area = 0.5 * self.surface.penetrometer.radius**2
        normal, shear, shaft, share = (
            np.array(
                [
                    (it.face_normal, it.face_shear, it.shaft_shear, it.contact_share)
                    for it in self.forces
                ]
            )
            .reshape(-1, 4)
            .T
        )
        curves = {
            "penetration_resistance": (
                (normal + shear) / base_area,
                "Pa",
                "net cone resistance",
            ),
            "penetration_resistance_shear": (
                shear / base_area,
                "Pa",
                "net cone resistance, shear part",
            ),
            "shaft_friction": (
                shaft / self.surface.shaft_area,
                "Pa",
                "mean shear stress on the shaft",
            ),
            "contact_share": (share, "1", "share of cone and shaft in contact"),
        }
        axis = variable(
            penetration, unit="1", meaning="penetration over cone radius", dims=("penetration",)
        )
        return xr.Dataset(
            {
                name: variable(values, unit=unit, meaning=meaning, dims=("penetration",))
                for name, (values, unit, meaning) in curves.items()
            },
            coords={"penetration": axis},
        )


def steady_values(curves: xr.Dataset, strength: float) -> dict[str, xr.Variable]:
    """The cone factor and its parts, from the last two radii of the curves or their last half.

    Args:
        curves: see :meth:`Penetration.curves`.
        strength: undrained shear strength su [Pa].
    """
    count = curves.sizes["penetration"]
    mean_count = min(STEADY_SAMPLES, count // 2)
    last = slice(-mean_count, None)
    over = f"over the last {mean_count * SAMPLE_SPACING:g} radii"
    resistance = curves.penetration_resistance.values[last]
    shear = curves.penetration_resistance_shear.values[last]
    steady = {
        "cone_factor": (resistance, "cone factor", "Nc = (qc - sigma_v0) / su"),
        "cone_factor_normal": (
            resistance - shear,
            "cone factor, normal part",
            "what the normal traction on the face adds to Nc",
        ),
        "cone_factor_shear": (
            shear,
            "cone factor, shear part",
            "what the shear traction on the face adds to Nc",
        ),
    }
    variables = {
        name: variable(
            values.mean() / strength,
            unit="1",
            meaning=meaning,
            description=f"{description}, mean {over}",
        )
        for name, (values, meaning, description) in steady.items()
    }
    variables["cone_factor_variation"] = variable(
        np.ptp(resistance) / resistance.mean(),
        unit="1",
        meaning="variation of the cone factor",
        description=f"range {over} of penetration, over the mean",
    )
    variables["penetration_reached"] = variable(
        count * SAMPLE_SPACING,
        unit="1",
        meaning="penetration reached over cone radius",
        description="where the resistance was steady, or the greatest penetration",
    )
    return variables
