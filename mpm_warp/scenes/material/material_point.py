"""Single material points on strain paths whose stress is known exactly."""

from dataclasses import dataclass

import numpy as np
import xarray as xr

from mpm_warp.fields.declaration import Value, group, parameter, redefined
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.material import (
    Material,
)
from mpm_warp.materials.perfectly_plastic import UndrainedClay
from mpm_warp.plan.plan import Plan
from mpm_warp.results import labelled
from mpm_warp.sampling import even_steps, follow
from mpm_warp.scenes.catalogue_scene import Progress
from mpm_warp.scenes.clay import Clay, FieldClay
from mpm_warp.scenes.clay_scene import ClayScene
from mpm_warp.scenes.limits import limited
from mpm_warp.scenes.material.strain_paths import PATH_COUNT, StrainPath, StrainPaths, known_paths
from mpm_warp.scenes.run_size import RunSize
from mpm_warp.scenes.verification import compared
from mpm_warp.simulation import Simulation

RANDOM_PATHS = 200
"""Number of paths in random directions, on which the stress must not leave the yield surface."""
CHANGING: dict[str, Value] = {
    "rate_factor": 0.1,
    "reference_strain_rate": 1e-3,
    "remoulded_strength_ratio": 0.2,
    "ductility": 0.2,
}
"""Clay that softens along the paths, at rates one to four log cycles above the reference."""


@dataclass(frozen=True, kw_only=True)
class ClayOfPoints(Clay):
    """Clay of a given strength."""

    undrained_shear_strength: float = redefined(
        FieldClay, "undrained_shear_strength", meaning="undrained shear strength su"
    )


@dataclass(frozen=True, kw_only=True, init=False)
class PointScene(ClayScene):
    """Points of clay without a grid, each strained at a constant rate for one second."""

    clay: ClayOfPoints = group()
    step_count: int = parameter(10_000, "strain steps of each path", minimum=1, maximum=1_000_000)

    def step_count_bound(self, plan: Plan) -> int:
        """See `CatalogueScene`: the steps of a path."""
        return self.step_count


@dataclass(frozen=True, kw_only=True, init=False)
class MaterialPoint(PointScene):
    """Clay strained and rotated by the stress update of the simulator, without a grid.

    A law of another package follows the same paths, but no exact stress is known.

    Simple shear far beyond yield of perfectly plastic clay has a steady state: the stress is turned
    by asin(su / G), where rotation by the spin and by the strain (Jaumann rate) balance. In clay
    that softens the angle follows the strength.

    Example:
        >>> MaterialPoint(material="von_mises").soil.strength
        20000.0
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
    limits = limited(error="more step_count", yield_excess="more step_count")

    @property
    def soil(self) -> Material:
        """The clay of the points; strain rates are those of the run."""
        return self.clay.built(density=1.0, speed_up=1.0, stress_at_rest=self.stress_at_rest)

    def run_size(self) -> RunSize:
        """See `CatalogueScene`."""
        return RunSize(
            cell_count=0, particle_count=PATH_COUNT + RANDOM_PATHS, step_count=self.step_count
        )

    @property
    def loads_solvers(self) -> bool:
        """See `CatalogueScene`: for clay that changes on its paths."""
        return isinstance(self.soil, EinavRandolph)

    def build(self) -> StrainPaths:
        """The paths of known stress, and then random ones that start without stress."""
        paths, strength = self._paths, self.clay.undrained_shear_strength
        random = np.random.default_rng(0).uniform(-1.0, 1.0, (RANDOM_PATHS, 5))
        rates = np.concatenate([[path.gradient for path in paths], random])
        start = np.zeros((len(rates), 4))
        if self.clay.is_criterion:
            start[: len(paths)] = [path.start for path in paths]
        return StrainPaths(
            material=self.soil, gradient=rates, stress=start * strength, step_count=self.step_count
        )

    @property
    def _paths(self) -> tuple[StrainPath, ...]:
        """The paths of known stress.

        A law of another package follows those of Tresca clay of the same stiffness and strength.
        """
        soil = self.soil
        if not self.clay.is_criterion:
            soil = MaterialPoint(
                rigidity_index=self.clay.rigidity_index,
                undrained_shear_strength=self.clay.undrained_shear_strength,
            ).soil
        assert isinstance(soil, UndrainedClay)
        return known_paths(soil)

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Strain the points, and compare the final stresses with the exact ones."""
        steps = even_steps(self.step_count)
        recorded = follow(simulation, steps, simulation.advance_to_step, [], progress)
        paths = self._paths
        stress = simulation.array("particle.stress")[: len(paths)]
        stress /= self.clay.undrained_shear_strength
        axes = {"path": [path.name for path in paths], "component": ["rr", "zz", "rz", "tt"]}
        shown = labelled(dims=tuple(axes), stress=(stress, "1", "stress over su"))
        if not self.clay.is_criterion:
            shear = 0.5 * np.hypot(stress[:, 0] - stress[:, 1], 2.0 * stress[:, 2]).max()
            greatest = (shear, "1", "greatest shear stress in the plane over su")
            shown |= labelled(role="headline", shear_stress=greatest)
            return recorded.assign_coords(axes).assign(shown)
        exact = np.array([path.exact for path in paths])
        of_error = "greatest difference of a component from the exact one, over su"
        error = (np.abs(stress - exact).max(), "1", "error of stress", of_error)
        beyond = simulation.array("particle.yield_excess").max()
        of_excess = "greatest shear stress over strength, less 1, on any path at any step"
        excess = (beyond, "1", "stress beyond the yield surface", of_excess)
        shown |= labelled(dims=tuple(axes), stress_exact=(exact, "1", "stress over su, exact"))
        shown |= labelled(role="headline", error=error) | labelled(yield_excess=excess)
        return recorded.assign_coords(axes).assign(shown)
