"""The cone penetration test in undrained clay, to steady state."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.parameters import parameter
from mpm_warp.scenes.base import Progress, ReadyScene
from mpm_warp.scenes.families.yield_criterion import yield_criterion

# The simulator is imported where it is used: whoever only asks for parameters need not wait for it.
if TYPE_CHECKING:
    import xarray

    from mpm_warp.execution.execution import Execution
    from mpm_warp.penetrometer import PenetrometerSurface
    from mpm_warp.plan.plan import StepPlan
    from mpm_warp.scene import Scene

LARGEST_ENERGY_ERROR = 0.05
"""Share of the penetrometer's work that the method itself may create or dissipate."""


@dataclass(frozen=True, kw_only=True)
class ConePenetration(ReadyScene):
    """A penetrometer pushed at constant speed into uniform, weightless, undrained clay.

    The penetrometer starts in place, in undisturbed ground. Excess stresses are simulated: those
    over the isotropic in-situ stress, which balances itself.
    """

    summary: ClassVar[str] = "cone penetration test in undrained clay, to steady state"
    version: ClassVar[int] = 7
    headline: ClassVar[str] = "cone_factor"
    method: ClassVar[tuple[str, ...]] = (
        "contact_surface",
        "cells_per_radius",
        "cell_growth",
        "particles_per_cell",
        "time_step_fraction",
        "speed_ratio",
        "approach",
        "approach_speed_ratio",
        "penetration",
        "steady_tolerance",
        "domain_radius",
        "domain_above",
        "domain_below",
        "poissons_ratio_bound",
        "precision",
    )

    rigidity_index: float = parameter(
        100.0, unit="1", meaning="rigidity index G/su", minimum=2, maximum=5000
    )
    adhesion_factor: float = parameter(
        0.0, unit="1", meaning="adhesion factor of the cone face", minimum=0, maximum=1
    )
    shaft_adhesion_factor: float | None = parameter(
        None,
        unit="1",
        meaning="adhesion factor of the shaft (default: the face's)",
        minimum=0,
        maximum=1,
    )
    friction_coefficient: float = parameter(
        0.0,
        unit="1",
        meaning="Coulomb friction coefficient of the penetrometer",
        minimum=0,
        maximum=1,
    )
    undrained_shear_strength: float = parameter(
        20e3,
        unit="Pa",
        meaning="undrained shear strength su in pure shear",
        minimum=1e-3,
        maximum=1e9,
    )
    material: str = yield_criterion()
    poissons_ratio: float = parameter(
        0.49, unit="1", meaning="Poisson's ratio", minimum=0, maximum=0.4999
    )
    density: float = parameter(
        1700.0, unit="kg m-3", meaning="density of the clay", minimum=1e-3, maximum=1e9
    )
    in_situ_stress: float = parameter(
        400e3, unit="Pa", meaning="isotropic total stress in the ground before", minimum=0
    )
    cone_radius: float = parameter(
        0.01785, unit="m", meaning="radius of the cone's base", minimum=1e-6, maximum=1e3
    )
    apex_angle: float = parameter(
        60.0, unit="degree", meaning="apex angle of the cone", minimum=30, maximum=150
    )
    penetration: float = parameter(
        30.0, unit="1", meaning="greatest penetration over cone radius", minimum=1, maximum=200
    )
    approach: float = parameter(
        8.0,
        unit="1",
        meaning="penetration of the approach, its rise and fall of speed included, over cone "
        "radius; ends 5.5 before the greatest at the latest, 3 or less: none",
        minimum=0,
        maximum=200,
    )
    approach_speed_ratio: float | None = parameter(
        None,
        unit="1",
        meaning="approach speed over shear wave speed (default: the lesser of 4 speed_ratio and "
        "sqrt(7 / Ir)); not above speed_ratio: no approach",
        above=0,
        maximum=0.5,
    )
    steady_tolerance: float = parameter(
        0.003,
        unit="1",
        meaning="change of the resistance over two radii at which it counts as steady, and the run "
        "ends; 0: never",
        minimum=0,
        maximum=0.1,
    )
    speed_ratio: float = parameter(
        0.03, unit="1", meaning="penetration speed over shear wave speed", minimum=1e-4, maximum=0.5
    )
    cells_per_radius: float = parameter(
        3.0, unit="1", meaning="cells per cone radius at the cone", minimum=1, maximum=100
    )
    cell_growth: float = parameter(
        0.8,
        unit="1",
        meaning="growth of the cells' width per distance from the penetrometer",
        minimum=0.1,
        maximum=2,
    )
    contact_surface: str = parameter(
        "fitted",
        unit="1",
        meaning="grid fitted to the penetrometer, or a plain grid and its surface as points",
        choices=("fitted", "points"),
    )
    # One a cell leaves cells empty beside the shaft: the cone factor comes out a sixth too low.
    particles_per_cell: int = parameter(
        4, unit="1", meaning="material points per cell", choices=(4, 9, 16, 25)
    )
    time_step_fraction: float = parameter(
        0.85, unit="1", meaning="time step over the critical one", minimum=0.01, maximum=1.2
    )
    domain_radius: float = parameter(
        40.0, unit="1", meaning="radius of the grid over cone radius", minimum=5, maximum=1000
    )
    domain_above: float = parameter(
        14.0,
        unit="1",
        meaning="extent of the grid above the shoulder over cone radius",
        minimum=2,
        maximum=500,
    )
    domain_below: float = parameter(
        14.0,
        unit="1",
        meaning="extent of the grid below the tip over cone radius",
        minimum=2,
        maximum=500,
    )

    poissons_ratio_bound: float = parameter(
        0.4999,
        unit="1",
        meaning="greatest Poisson's ratio simulated: bounds the bulk modulus, and so the steps",
        minimum=0,
        maximum=0.4999,
    )
    precision: str = parameter(
        "float64",
        unit="1",
        meaning="floating point numbers of the simulation",
        choices=("float64", "float32"),
    )

    def build(self) -> tuple[Scene, PenetrometerSurface]:
        """The scene, and the surface from whose nodes the forces on the penetrometer are read."""
        from mpm_warp.parts.boundaries import FarField, Fixed
        from mpm_warp.immersed import ImmersedGrid, SampledSurface
        from mpm_warp.materials.materials import CRITERIA
        from mpm_warp.penetrometer import Penetrometer, PenetrometerSurface
        from mpm_warp.scene import Scene
        from mpm_warp.scenes.families.cone_window import cone_window

        strength, radius = self.undrained_shear_strength, self.cone_radius
        material = CRITERIA[self.material](
            shear_modulus=self.rigidity_index * strength,
            poissons_ratio=min(self.poissons_ratio, self.poissons_ratio_bound),
            density=self.density,
            strength=strength,
        )
        penetrometer = Penetrometer(radius=radius, apex_angle=math.radians(self.apex_angle))
        make_grid, surface_type = {
            "fitted": (Penetrometer.fitted_grid, PenetrometerSurface),
            "points": (ImmersedGrid.around, SampledSurface),
        }[self.contact_surface]
        grid = make_grid(
            penetrometer,
            cell_size=radius / self.cells_per_radius,
            cell_growth=self.cell_growth,
            outer_radius=self.domain_radius * radius,
            depth_below=self.domain_below * radius,
            height_above=self.domain_above * radius,
        )
        shaft_adhesion_factor = self.shaft_adhesion_factor
        if shaft_adhesion_factor is None:
            shaft_adhesion_factor = self.adhesion_factor
        surface = surface_type(
            penetrometer=penetrometer,
            grid=grid,
            face_adhesion=self.adhesion_factor * strength,
            shaft_adhesion=shaft_adhesion_factor * strength,
            friction=self.friction_coefficient,
            in_situ_stress=self.in_situ_stress,
        )
        scene = Scene(
            grid=grid,
            material=material,
            particles_per_side=math.isqrt(self.particles_per_cell),
            time_step_fraction=self.time_step_fraction,
            bulk_viscosity=0.2,
            fixed=Fixed.axis_and_ends(grid),
            far_field=FarField.around(grid, material),
            contact=surface.contact,
            window=cone_window(self, material),
            # Cells that the surface cuts have no edge along it.
            even_flow=self.contact_surface == "fitted",
            energy_audit=True,
            precision=self.precision,
        )
        return scene, surface

    def step_count_bound(self, plan: StepPlan) -> int:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        window = self.simulated_scene().window
        assert window is not None
        return math.ceil(window.time_to(self.penetration * self.cone_radius) / plan.time_step)

    def simulated_scene(self) -> Scene:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        return self.build()[0]

    def run(
        self, progress: Progress | None = None, execution: Execution | None = None
    ) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        from mpm_warp.watch.health import InaccurateRun
        from mpm_warp.results import cost, variable
        from mpm_warp.penetration import Penetration, steady_values
        from mpm_warp.scenes.families.cone_window import unsteady_penetration
        from mpm_warp.simulation import Simulation

        scene, surface = self.build()
        simulation = Simulation(scene, execution)
        penetration = Penetration(
            surface=surface,
            greatest=self.penetration,
            unsteady=unsteady_penetration(self, scene.window),
            tolerance=self.steady_tolerance,
        )
        start = time.perf_counter()
        penetration.run(simulation, progress)
        run_time = time.perf_counter() - start
        curves = penetration.curves()
        energy_error = simulation.transfer_energy / penetration.work
        if not abs(energy_error) <= LARGEST_ENERGY_ERROR:
            raise InaccurateRun(
                f"the transfers between material points and grid took {-energy_error:.1%} of the "
                f"penetrometer's work, more than {LARGEST_ENERGY_ERROR:.0%}: try a lower "
                "speed_ratio, more cells_per_radius or a longer penetration",
                curves,
            )
        return curves.assign(
            {
                **steady_values(curves, self.undrained_shear_strength),
                "energy_error": variable(
                    energy_error,
                    unit="1",
                    meaning="energy error",
                    description="kinetic energy that the transfers between material points and "
                    "grid created, dissipated if < 0, over the work of the penetrometer",
                ),
                "step_count_bound": variable(
                    self.step_count_bound(simulation.plan),
                    unit="1",
                    meaning="time steps to the greatest penetration",
                ),
                **cost(simulation, run_time=run_time),
            }
        )
