"""The cone penetration test in undrained clay, to steady state."""

from __future__ import annotations

import math
import time
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.parameters import parameter
from mpm_warp.scenes.base import Progress, ReadyScene

# The simulator is imported where it is used: whoever only asks for parameters need not wait for it.
if TYPE_CHECKING:
    import xarray

    from mpm_warp.execution import Execution
    from mpm_warp.penetrometer import PenetrometerForces, PenetrometerSurface
    from mpm_warp.scene import Scene
    from mpm_warp.window import Approach, Window

SAMPLE_SPACING = 0.1
"""Penetration between two samples of the curves, in cone radii."""
LARGEST_ENERGY_ERROR = 0.05
"""Share of the penetrometer's work that the method itself may create or dissipate."""
STEADY_SAMPLES = 20
"""Samples whose mean is the steady value: two radii."""
STEADY_PENETRATION = 5.0
"""Penetration at the final speed, at least, in cone radii: two such means, and one to forget."""
SLOWING = 2.0
"""Penetration in which the speed falls to the final one, in cone radii."""
LARGEST_INERTIA = 7.0
"""What rho V^2 / su may be on the way by default."""


@dataclass(frozen=True, kw_only=True)
class ConePenetration(ReadyScene):
    """A penetrometer pushed at constant speed into uniform, weightless, undrained clay.

    The penetrometer starts in place, in undisturbed ground. Excess stresses are simulated: those
    over the isotropic in-situ stress, which balances itself.
    """

    summary: ClassVar[str] = "cone penetration test in undrained clay, to steady state"
    version: ClassVar[int] = 3
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
        20e3, unit="Pa", meaning="undrained shear strength su", minimum=1e-3, maximum=1e9
    )
    material: str = parameter(
        "tresca", unit="1", meaning="yield criterion", choices=("tresca", "von_mises")
    )
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
        meaning="penetration at the approach speed over cone radius; ends 5 before the greatest",
        minimum=0,
        maximum=200,
    )
    approach_speed_ratio: float | None = parameter(
        None,
        unit="1",
        meaning="approach speed over shear wave speed (default: 4 speed_ratio or sqrt(7 / Ir))",
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
        from mpm_warp.boundaries import FarField, Fixed
        from mpm_warp.immersed import ImmersedGrid, SampledSurface
        from mpm_warp.materials import Tresca, VonMises
        from mpm_warp.penetrometer import Penetrometer, PenetrometerSurface
        from mpm_warp.scene import Scene
        from mpm_warp.window import Window

        strength, radius = self.undrained_shear_strength, self.cone_radius
        material = {"tresca": Tresca, "von_mises": VonMises}[self.material](
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
        speed = self.speed_ratio * material.shear_wave_speed
        scene = Scene(
            grid=grid,
            material=material,
            particles_per_side=math.isqrt(self.particles_per_cell),
            time_step_fraction=self.time_step_fraction,
            # The time in which soil passes a cell: noise comes from the crossing of cells.
            velocity_memory=radius / self.cells_per_radius / speed,
            bulk_viscosity=0.2,
            fixed=Fixed.axis_and_ends(grid),
            far_field=FarField.around(grid, material),
            contact=surface.contact,
            window=Window(speed=speed, ramp_travel=radius, approach=self._approach(speed)),
            energy_audit=True,
            precision=self.precision,
        )
        return scene, surface

    def _approach(self, speed: float) -> Approach | None:
        from mpm_warp.window import Approach

        ratio = self.approach_speed_ratio
        if ratio is None:
            ratio = min(4 * self.speed_ratio, math.sqrt(LARGEST_INERTIA / self.rigidity_index))
        travel = min(self.approach, self.penetration - STEADY_PENETRATION)
        if travel <= SLOWING or ratio <= self.speed_ratio:
            return None
        return Approach(
            speed=speed * ratio / self.speed_ratio,
            travel=travel * self.cone_radius,
            slowing_travel=SLOWING * self.cone_radius,
        )

    def _unsteady_samples(self, window: Window | None) -> int:
        """Samples of the ramp, or of the approach and the radius after it."""
        if window is None or window.approach is None:
            return STEADY_SAMPLES
        return math.ceil((window.approach.travel / self.cone_radius + 1.0) / SAMPLE_SPACING)

    def simulated_scene(self) -> Scene:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        return self.build()[0]

    def run(
        self, progress: Progress | None = None, execution: Execution | None = None
    ) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        import numpy as np

        from mpm_warp.health import InaccurateRun
        from mpm_warp.history import cost, variable
        from mpm_warp.simulation import Simulation
        from mpm_warp.steady_state import is_steady
        from mpm_warp.travel import Travel

        scene, surface = self.build()
        simulation = Simulation(scene, execution)
        travel = Travel(simulation)
        start = time.perf_counter()
        sample_count = round(self.penetration / SAMPLE_SPACING)
        unsteady = self._unsteady_samples(scene.window)
        forces, places = [], []
        for sample in range(1, sample_count + 1):
            travel.advance_to(sample * SAMPLE_SPACING * self.cone_radius)
            forces.append(surface.forces(simulation.take_contact_forces()))
            places.append(travel.distance)
            if progress is not None:
                progress(sample / sample_count)
            resistance = [force.face_normal + force.face_shear for force in forces[unsteady:]]
            if is_steady(resistance, STEADY_SAMPLES, self.steady_tolerance):
                break
        simulation.check()
        run_time = time.perf_counter() - start
        travelled = np.diff(places, prepend=0.0)
        upward = [force.face_normal + force.face_shear + force.shaft_shear for force in forces]
        work = float(np.array(upward) @ travelled)
        energy_error = simulation.transfer_energy / work
        if not abs(energy_error) <= LARGEST_ENERGY_ERROR:
            raise InaccurateRun(
                f"the transfers between material points and grid took {-energy_error:.1%} of the "
                f"penetrometer's work, more than {LARGEST_ENERGY_ERROR:.0%}: try a lower "
                "speed_ratio, more cells_per_radius or a longer penetration"
            )
        return self._dataset(forces, surface.shaft_area).assign(
            {
                "energy_error": variable(
                    energy_error,
                    unit="1",
                    meaning="energy error",
                    description="kinetic energy that the transfers between material points and "
                    "grid created, dissipated if < 0, over the work of the penetrometer",
                ),
                **cost(simulation, run_time=run_time),
            }
        )

    def _dataset(self, forces: list[PenetrometerForces], shaft_area: float) -> xarray.Dataset:
        """Curves over penetration and their steady values, from the forces of each sample."""
        import numpy as np
        import xarray as xr

        from mpm_warp.history import variable

        # Each sample is a mean over the travel since the one before; it stands in the middle.
        penetration = (np.arange(len(forces)) + 0.5) * SAMPLE_SPACING
        base_area = 0.5 * self.cone_radius**2
        normal = np.array([force.face_normal for force in forces]) / base_area
        shear = np.array([force.face_shear for force in forces]) / base_area
        friction = np.array([force.shaft_shear for force in forces]) / shaft_area
        last = slice(-min(STEADY_SAMPLES, len(forces) // 2), None)
        resistance = (normal + shear)[last]
        steady = {
            "cone_factor": (resistance, "cone factor"),
            "cone_factor_normal": (normal[last], "cone factor, normal part"),
            "cone_factor_shear": (shear[last], "cone factor, shear part"),
        }
        curves = {
            "penetration_resistance": (normal + shear, "net cone resistance"),
            "shaft_friction": (friction, "mean shear stress on the shaft"),
        }
        variables = {
            name: variable(values, unit="Pa", meaning=meaning, dims=("penetration",))
            for name, (values, meaning) in curves.items()
        } | {
            name: variable(
                values.mean() / self.undrained_shear_strength,
                unit="1",
                meaning=meaning,
                description="Nc = (qc - sigma_v0) / su, mean over the last two radii",
            )
            for name, (values, meaning) in steady.items()
        }
        variables["cone_factor_variation"] = variable(
            np.ptp(resistance) / resistance.mean(),
            unit="1",
            meaning="variation of the cone factor",
            description="range over the last two radii of penetration, over the mean",
        )
        variables["penetration_reached"] = variable(
            len(forces) * SAMPLE_SPACING,
            unit="1",
            meaning="penetration reached over cone radius",
            description="where the resistance was steady, or the greatest penetration",
        )
        meaning = "penetration over cone radius"
        axis = variable(penetration, unit="1", meaning=meaning, dims=("penetration",))
        return xr.Dataset(variables, coords={"penetration": axis})
