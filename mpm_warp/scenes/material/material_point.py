"""One material point on strain paths whose stress is known exactly."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.materials import CRITERIA
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.material import Material
from mpm_warp.materials.perfectly_plastic import UndrainedClay
from mpm_warp.parameters import Value, parameter, redefined
from mpm_warp.plan.plan import Plan
from mpm_warp.results import labelled
from mpm_warp.sampling import even_steps, follow
from mpm_warp.scenes.catalogue import Progress, compared
from mpm_warp.scenes.clay import ClayScene, FieldClayScene
from mpm_warp.scenes.material.known_paths import PATH_COUNT, StrainPath, known_paths
from mpm_warp.scenes.material.strain_paths import StrainPaths
from mpm_warp.scenes.run_size import RunSize
from mpm_warp.simulation import Simulation

RANDOM_PATHS = 200
"""Paths in random directions, on which the stress must stay within the yield surface."""
CHANGING: dict[str, Value] = {
    "rate_factor": 0.1,
    "reference_strain_rate": 1e-3,
    "remoulded_strength_ratio": 0.2,
    "ductility": 0.2,
}
"""Clay that softens within the paths, at rates of one to four log cycles."""


@dataclass(frozen=True, kw_only=True)
class MaterialPoint(ClayScene):
    """Clay strained and turned through the stress update of the simulator, without a grid.

    In a law of another package no stress is known: it goes the same paths.

    Simple shear far beyond yield has the steady state of the Jaumann rate with perfect plasticity:
    half difference of the stresses and shear stress stand at the angle asin(su / G), at which the
    spin turns it as fast as the strain turns it back. In clay that softens, the angle follows the
    strength.
    """

    summary = "one material point on strain paths, against exact stresses"
    version = 3
    verifications = compared(
        "step_count",
        (1000, 10_000),
        {},
        *({"material": material, **CHANGING} for material in CRITERIA),
        error=1e-6,
        yield_excess=1e-9,
        least_order=1.9,
    )

    undrained_shear_strength: float = redefined(
        FieldClayScene, "undrained_shear_strength", meaning="undrained shear strength su"
    )
    step_count: int = parameter(
        10_000, unit="1", meaning="strain steps of each path", minimum=1, maximum=1_000_000
    )

    @property
    def clay(self) -> Material:
        """The material of the points: a path takes a second, in reality too."""
        return self.clay_with(strength=self.undrained_shear_strength, density=1.0, speed_up=1.0)

    def run_size(self) -> RunSize:
        """A point on each path."""
        return RunSize(
            cell_count=0,
            particle_count=PATH_COUNT + RANDOM_PATHS,
            step_count=self.step_count,
        )

    @property
    def loads_solvers(self) -> bool:
        """See `CatalogueScene`: for clay that changes on its paths."""
        return isinstance(self.clay, EinavRandolph)

    def build(self) -> StrainPaths:
        """The paths whose stress is known, then random ones that start without stress."""
        paths, strength = self._paths, self.undrained_shear_strength
        random = np.random.default_rng(0).uniform(-1.0, 1.0, (RANDOM_PATHS, 5))
        gradient = np.concatenate([[path.gradient for path in paths], random])
        start = np.zeros((len(gradient), 4))
        if self._is_known:
            start[: len(paths)] = [path.start for path in paths]
        return StrainPaths(
            material=self.clay,
            gradient=gradient,
            stress=start * strength,
            step_count=self.step_count,
        )

    @property
    def _is_known(self) -> bool:
        """Whether the law is one of the catalogue, whose stresses are known."""
        return self.material in CRITERIA

    @property
    def _paths(self) -> tuple[StrainPath, ...]:
        """The paths; those of a law of another package are for clay of Tresca as stiff and strong.

        Such a law starts without stress: no other may be allowed by it.
        """
        clay = self.clay
        if not self._is_known:
            clay = MaterialPoint(
                rigidity_index=self.rigidity_index,
                undrained_shear_strength=self.undrained_shear_strength,
            ).clay
        assert isinstance(clay, UndrainedClay)
        return known_paths(clay)

    def step_count_bound(self, plan: Plan) -> int:
        """The strain steps of a path."""
        return self.step_count

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Follow the paths to their ends, and compare the stress there with the exact one."""
        steps = even_steps(self.step_count)
        recorded = follow(simulation, steps, simulation.advance_to_step, [], progress)
        paths = self._paths
        stress = simulation.array("particle.stress")[: len(paths)] / self.undrained_shear_strength
        axes = {"path": [path.name for path in paths], "component": ["rr", "zz", "rz", "tt"]}
        shown = labelled(dims=tuple(axes), stress=(stress, "1", "stress over su"))
        if not self._is_known:
            shear = 0.5 * np.hypot(stress[:, 0] - stress[:, 1], 2.0 * stress[:, 2]).max()
            greatest = (shear, "1", "greatest shear stress in the plane over su")
            shown |= labelled(role="headline", shear_stress=greatest)
            return recorded.assign_coords(axes).assign(shown)
        exact = np.array([path.exact for path in paths])
        error = (
            np.abs(stress - exact).max(),
            "1",
            "error of stress",
            "greatest difference of a component from the exact one, over su",
        )
        excess = (
            simulation.array("particle.yield_excess").max(),
            "1",
            "stress beyond the yield surface",
            "greatest shear stress over strength, less 1, on any path at any step",
        )
        shown |= labelled(dims=tuple(axes), stress_exact=(exact, "1", "stress over su, exact"))
        shown |= labelled(role="headline", error=error) | labelled(yield_excess=excess)
        return recorded.assign_coords(axes).assign(shown)
