"""What ball and T-bar have in common when they are pushed down until soil flows round them."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.errors import UnfinishedRun
from mpm_warp.grid.fitted import Grid
from mpm_warp.grid.spacing import growing
from mpm_warp.materials.material import PerfectlyPlastic
from mpm_warp.parameters import parameter
from mpm_warp.parts.boundaries.fixed import Fixed
from mpm_warp.parts.window.surrounding_ground import SurroundingGround
from mpm_warp.parts.window.window import Window
from mpm_warp.plan.plan import Plan
from mpm_warp.results import curves, labelled
from mpm_warp.sampling import ContactForces, follow, soil_scene, transferred_energy
from mpm_warp.scene import Scene
from mpm_warp.scenes import rate_and_softening, shared_parameters
from mpm_warp.scenes.catalogue import CatalogueScene, Progress
from mpm_warp.scenes.cone.penetration import (
    SAMPLE_SPACING,
    STEADY_SAMPLES,
    penetration_axis,
    steady_mean,
)
from mpm_warp.scenes.cone.soundness import check_energy, energy_error
from mpm_warp.scenes.full_flow.round_body import RoundBody, upward_force
from mpm_warp.scenes.run_size import RunSize, shortest_crossing, size_in_grid
from mpm_warp.simulation import Simulation

NO_PARTING = 1000.0
"""In-situ stress over su, above any that the soil can pull with: it closes behind the body."""
TIME_STEP_FRACTION = 0.85
SPARE_FRACTION = 0.4
"""Slots for material points beside those that fill the grid, over their number."""
LARGEST_CHANGE = 0.02
"""What the mean resistance over two radii may differ from that over the two before, over it."""


@dataclass(frozen=True, kw_only=True)
class FullFlowPenetration(CatalogueScene):
    """A round body pushed at constant speed through uniform, weightless, undrained clay.

    It starts in place, deep in undisturbed ground, and the soil never leaves it. Excess stresses
    are simulated: those over the isotropic in-situ stress, which balances itself.
    """

    method: ClassVar[tuple[str, ...]] = (
        "cells_per_radius",
        "cell_growth",
        "particles_per_cell",
        "speed_ratio",
        "penetration",
        "domain_extent",
    )

    rigidity_index: float = shared_parameters.rigidity_index(20, 5000)
    adhesion_factor: float = shared_parameters.adhesion_factor("body")
    undrained_shear_strength: float = shared_parameters.undrained_shear_strength(
        "undrained shear strength su in pure shear"
    )
    material: str = shared_parameters.yield_criterion()
    rate_factor: float = rate_and_softening.rate_factor()
    reference_strain_rate: float | None = rate_and_softening.reference_strain_rate()
    remoulded_strength_ratio: float = rate_and_softening.remoulded_strength_ratio()
    ductility: float | None = rate_and_softening.ductility()
    poissons_ratio: float = shared_parameters.poissons_ratio(minimum=0.4)
    density: float = shared_parameters.density_of_clay()
    penetration_speed: float = shared_parameters.penetration_speed()
    penetration: float = parameter(
        8.0, unit="1", meaning="penetration over radius", minimum=5, maximum=50
    )
    speed_ratio: float = shared_parameters.speed_ratio(0.1)
    cells_per_radius: int = parameter(
        4, unit="1", meaning="cells per radius of the body", minimum=2, maximum=40
    )
    cell_growth: float = shared_parameters.cell_growth()
    particles_per_cell: int = parameter(
        9, unit="1", meaning="material points per cell", choices=(4, 9, 16)
    )
    domain_extent: int = parameter(
        8,
        unit="1",
        meaning="extent of the grid below, above and beside the centre over radius",
        minimum=3,
        maximum=100,
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        rate_and_softening.check_clay(self, lambda: self.clay)

    @property
    @abstractmethod
    def body(self) -> RoundBody:
        """What is pushed down."""

    @abstractmethod
    def surroundings(self, grid: Grid) -> SurroundingGround | None:
        """The ground around the window; none where it rests."""

    @property
    def clay(self) -> PerfectlyPlastic:
        """The soil."""
        shear_modulus = self.rigidity_index * self.undrained_shear_strength
        speed = self.speed_ratio * math.sqrt(shear_modulus / self.density)
        return rate_and_softening.clay_of(
            self,
            shear_modulus=shear_modulus,
            poissons_ratio=self.poissons_ratio,
            density=self.density,
            strength=self.undrained_shear_strength,
            speed_up=speed / self.penetration_speed,
        )

    @property
    def grid(self) -> Grid:
        """The grid around the body, which travels with it."""
        radius = self.body.radius
        size = radius / self.cells_per_radius
        growth = 1.0 + self.cell_growth / self.cells_per_radius
        return self.body.fitted_grid(
            cells_per_radius=self.cells_per_radius,
            columns=growing(size, (self.domain_extent - 1.0) * radius, growth),
            extent=self.domain_extent,
        )

    @property
    def window(self) -> Window:
        """The travel of the grid: the speed is reached after a radius."""
        return Window(
            speed=self.speed_ratio * self.clay.shear_wave_speed,
            ramp_travel=self.body.radius,
            spare_fraction=SPARE_FRACTION,
        )

    def build(self) -> Scene:
        """The soil around the body."""
        grid, strength = self.grid, self.undrained_shear_strength
        surroundings = self.surroundings(grid)
        return Scene(
            grid=grid,
            material=self.clay,
            particles_per_side=math.isqrt(self.particles_per_cell),
            time_step_fraction=TIME_STEP_FRACTION,
            bulk_viscosity=0.2,
            fixed=_fixed(grid, rests_around=surroundings is None),
            surroundings=surroundings,
            contact=self.body.contact(
                grid,
                adhesion=self.adhesion_factor * strength,
                in_situ_stress=NO_PARTING * strength,
            ),
            window=self.window,
            conservative_interpolation=True,
            energy_audit=True,
        )

    def run_size(self) -> RunSize:
        """Cells and material points of the grid, and the steps to the end."""
        grid = self.grid
        speed = self.clay.pressure_wave_speed + self.window.speed
        time_step = TIME_STEP_FRACTION * shortest_crossing(grid) / speed
        return size_in_grid(
            grid,
            particles_per_cell=self.particles_per_cell,
            spare_fraction=SPARE_FRACTION,
            step_count=self._time_to_the_end / time_step,
        )

    def step_count_bound(self, plan: Plan) -> int:
        """Steps to the end of the penetration."""
        return math.ceil(self._time_to_the_end / plan.time_step)

    @property
    def _time_to_the_end(self) -> float:
        return self.window.time_to(self.penetration * self.body.radius)

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Push the body down, and take the mean of its resistance over the last two radii.

        Raises:
            InaccurateRun: the transfers took too much of the work of the body.
            UnfinishedRun: the resistance still changes at the end.
        """
        curve = _ResistanceCurve(simulation, self.body)
        spacing = SAMPLE_SPACING * self.body.radius
        moments = [k * spacing for k in range(1, round(self.penetration / SAMPLE_SPACING) + 1)]
        recorded = follow(simulation, moments, simulation.travel_to, [curve], progress)
        results = recorded.assign(self._steady_values(recorded.penetration_resistance)).assign(
            energy_error=energy_error(transferred_energy(simulation) / curve.work)
        )
        check_energy(results)
        change = float(results.resistance_factor_change)
        if not abs(change) <= LARGEST_CHANGE:
            raise UnfinishedRun(
                f"the mean resistance over two radii still changes by {change:.0%}; try more "
                "penetration",
                results,
            )
        return results

    def _steady_values(self, resistance: xr.DataArray) -> dict[str, xr.Variable]:
        mean, over = steady_mean(resistance)
        before, _ = steady_mean(resistance[:-STEADY_SAMPLES])
        return labelled(
            role="headline",
            resistance_factor=(
                mean / self.undrained_shear_strength,
                "1",
                "resistance over projected area and su",
                f"mean {over}, of the excess over the in-situ stress",
            ),
        ) | labelled(
            resistance_factor_change=(
                1.0 - before / mean,
                "1",
                "change of the mean resistance over two radii",
                f"mean {over} less that over the two before, over it",
            )
        )


class _ResistanceCurve:
    """Samples the resistance, at every `SAMPLE_SPACING` radii of penetration."""

    def __init__(self, simulation: Simulation, body: RoundBody) -> None:
        contact = soil_scene(simulation).contact
        assert contact is not None
        self._contact = contact
        self._radius = body.radius
        # Forces are those on half a cylinder, or on a radian of a ball.
        self._area = body.radius if body.planar else 0.5 * body.radius**2
        self._contact_forces = ContactForces(simulation)
        self._forces: list[float] = []

    def sample(self) -> None:
        """Take down the mean force since the sample before."""
        self._forces.append(upward_force(self._contact, self._contact_forces.take()))

    @property
    def work(self) -> float:
        """Of the body so far [J], per radian or per unit length of half of it."""
        return math.fsum(self._forces) * SAMPLE_SPACING * self._radius

    def dataset(self) -> xr.Dataset:
        """The curve."""
        return curves(
            "penetration",
            penetration_axis(len(self._forces), over="radius of the body"),
            penetration_resistance=(
                np.array(self._forces) / self._area,
                "Pa",
                "resistance over projected area",
                "excess over the in-situ stress",
            ),
        )


def _fixed(grid: Grid, *, rests_around: bool) -> Fixed:
    """Soil stays on the line of travel; around a window that rests nothing moves."""
    around = np.zeros((grid.row_count + 1, grid.column_count + 1), dtype=bool)
    if rests_around:
        around[[0, -1]] = True
        around[:, -1] = True
    radial = around.copy()
    radial[grid.surface_radius == 0.0, 0] = True
    return Fixed.where(radial=radial, vertical=around)
