"""Checks that a cone factor is sound: its energy error, steadiness and size.

The energy balance is here too: the shares of the penetrometer's work by where it goes.
"""

import math

import numpy as np
import xarray as xr

from mpm_warp.errors import InaccurateRun, UnfinishedRun
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.perfectly_plastic import UndrainedClay, limit_pressure
from mpm_warp.materials.tresca import Tresca
from mpm_warp.materials.von_mises import VonMises
from mpm_warp.parts.energy import OF_CELLS, OF_NODES, OF_POINTS
from mpm_warp.parts.window import Window
from mpm_warp.plan.plan import AUDIT_INTERVAL
from mpm_warp.results import Quantity, labelled, variable
from mpm_warp.sampling import Samples, transferred_energy
from mpm_warp.scene import Scene
from mpm_warp.scenes.cone.penetrometer import PenetrometerContact
from mpm_warp.scenes.limits import LARGEST_LACK, Limit
from mpm_warp.simulation import Simulation
from mpm_warp.uncertainty.steadiness import STEADY_SAMPLES

LARGEST_VARIATION = 0.05
"""Largest range of the resistance over the last two radii, over its mean, in a run that has not
become steady. Steady runs end with 0.5 to 2 %, a run of 6 radii with 4.5 %, one of 2 radii with
30 % or more."""
LARGEST_OVER_CAVITY = 2.0
"""Largest ratio of a cone factor to the estimate from cavity expansion; sound ones reach 1.6."""

LARGEST_RESIDUAL = 0.01
"""Largest residual of the energy balance, over the work of the penetrometer."""
MEANING = {
    "plastic": "plastic work in the soil, over the penetrometer's",
    "sliding": "work of sliding along face and shaft, over the penetrometer's",
    "elastic": "energy stored in the soil or carried off with it, over the penetrometer's work",
    "ground": "work on the ground around the window, over the penetrometer's",
    "kinetic": "kinetic energy kept by the soil or carried off with it, over the penetrometer's "
    "work",
    "transfers": "kinetic energy that the transfers dissipate, over the penetrometer's work",
    "viscous": "work of the method's viscous pressure, over the penetrometer's",
    "least_mass": "work that the least mass of nodes keeps from the stress, over the "
    "penetrometer's",
}
"""Meaning of each share of the penetrometer's work in the energy balance, by name."""


def energy_error(simulation: Simulation, work: float) -> dict[str, xr.Variable]:
    """Energy that the transfers of a run created, over the penetrometer's work [J]."""
    error = variable(
        transferred_energy(simulation) / work,
        meaning="energy error",
        description="kinetic energy that the transfers between material points and grid "
        "created, dissipated if < 0, over the work of the penetrometer",
    )
    return {"energy_error": error}


def energy_limits(*longer: str) -> dict[str, Limit]:
    """Limits of the energy error and of the residual of the balance.

    `longer` names a parameter that lengthens the run, for scenes in which a longer run helps.
    """
    remedy = " or ".join(("a lower speed_ratio, or more cells_per_radius", *longer))
    of_work = "share of the penetrometer's work that"
    taken = f"{of_work} the transfers between material points and grid took"
    return {
        "energy_error": Limit(LARGEST_LACK, remedy, taken),
        "energy_residual": Limit(LARGEST_RESIDUAL, remedy, f"{of_work} is not found again"),
    }


def check_levelled(results: xr.Dataset) -> None:
    """Raise `UnfinishedRun` where the resistance still changes by over `LARGEST_VARIATION`."""
    variation = float(results.cone_factor_variation)
    if not variation <= LARGEST_VARIATION:
        raise UnfinishedRun(
            f"the resistance still changes by {variation:.0%} at the greatest penetration, "
            f"{float(results.penetration_reached):g} radii; try more penetration, or "
            "steady_tolerance = 0 where no steady resistance is wanted",
            results,
        )


def check_bound(results: xr.Dataset, built: Scene, strength: float) -> None:
    """Raise `InaccurateRun` where a cone factor is far above any possible one.

    The bound is `LARGEST_OVER_CAVITY` times the limit pressure of a spherical cavity plus the shear
    on the face, by material and contact of the scene built, over the strength su [Pa]. Added to it
    is the inertia of the soil, 3/2 rho v^2 (Rayleigh 1917, Phil. Mag. 34:94-98), for a cavity wall
    that moves at the outward speed v of the face.
    """
    contact = built[PenetrometerContact]
    # Friction too gives a shear stress of at most su.
    face_shear = 1.0 if contact.friction > 0.0 else contact.face_adhesion / strength
    estimate = _cavity_pressure(built) / strength + face_shear / math.tan(contact.half_angle)
    outward = built[Window].speed * math.sin(contact.half_angle)
    inertia = 1.5 * built.material.density * outward**2 / strength
    factor, bound = float(results.cone_factor), LARGEST_OVER_CAVITY * estimate + inertia
    if factor > bound:
        raise InaccurateRun(
            f"the cone factor {factor:.3g} is above {bound:.3g}, twice what cavity expansion and "
            "the face can give, and what inertia adds: try a lower speed_ratio, or more "
            "cells_per_radius",
            results,
        )


def _cavity_pressure(built: Scene) -> float:
    """Limit pressure of a spherical cavity in the soil of a cone test [Pa].

    It is 4/3 q (1 + ln(G / q)), q half the strength of intact clay in uniaxial compression at the
    strain rate of the cone. A material of a user gives its own limit pressure.
    """
    clay, criterion = built.material, type(built.material)
    if not isinstance(clay, UndrainedClay) or criterion not in (Tresca, VonMises, EinavRandolph):
        return clay.limit_pressure
    half = clay.strength
    if isinstance(clay, EinavRandolph):
        criterion = clay.criterion
        rate = built[Window].speed / float(built.grid.surface_radius[-1])
        half *= 1.0 + clay.rate_factor * math.log10(max(rate / clay.reference_strain_rate, 1.0))
    if criterion is VonMises:
        half *= 2.0 / math.sqrt(3.0)
    return limit_pressure(clay.shear_modulus, half)


def energy_balance_curves(simulation: Simulation) -> Samples:
    """Samples the terms of the energy balance, as shares of the penetrometer's work.

    This work is that of the excess over the in-situ stress, on face and shaft in the window.
    """

    def works_so_far() -> list[float]:
        """The sums over the audited steps, scaled to all steps [J]."""
        array = simulation.array
        sums = [*array(OF_NODES).sum(axis=0), array(OF_CELLS).sum(), *array(OF_POINTS).sum(axis=0)]
        return [*(AUDIT_INTERVAL * float(total) for total in sums), transferred_energy(simulation)]

    at_first = works_so_far()

    def shares_of_work(*by_work: Floats) -> xr.Dataset:
        """The shares over the last two radii, or over the last half if that is shorter."""
        works = np.vstack([at_first, np.stack(by_work, axis=-1)])
        count = min(STEADY_SAMPLES, len(works) // 2)
        done = works[-1] - works[-1 - count]
        body, to_soil, by_ground, kinetic, least_mass, viscous, plastic, elastic, created = done
        turned = kinetic + created, -created
        found = (plastic, body - to_soil, elastic, -by_ground, *turned, viscous, -least_mass)
        residual = body - sum(found)
        with np.errstate(invalid="ignore"):  # 0 / 0 without an audited step
            shares: dict[str, Quantity] = {
                f"work_share_{name}": (work / body, "1", meaning)
                for (name, meaning), work in zip(MEANING.items(), found, strict=True)
            }
            lost = "work of the penetrometer that is not found again, over all of it"
            shares["energy_residual"] = residual / body, "1", lost
        return xr.Dataset(labelled(dims=(), role=None, **shares))

    return Samples(works_so_far, shares_of_work)
