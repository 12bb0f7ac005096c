"""A cone test: its parameters, and the soil around the penetrometer that is built of them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from mpm_warp.fields.checked import refuse
from mpm_warp.fields.declaration import group, parameter
from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.materials.material import Material
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.energy import EnergyAudit, EnergyBalance
from mpm_warp.parts.interpolation import ConservativeInterpolation
from mpm_warp.parts.surrounding_ground import SurroundingGround, TravellingSource
from mpm_warp.parts.window import Approach, Window
from mpm_warp.scene import Scene
from mpm_warp.scenes.clay import FieldClay
from mpm_warp.scenes.clay_scene import ClayScene
from mpm_warp.scenes.cone import defaults, failure
from mpm_warp.scenes.cone.groups import Cone, Domain, InSituStress, Push, Resolution
from mpm_warp.scenes.cone.interface import Interface, interface_of
from mpm_warp.scenes.cone.penetrometer import PenetrometerContact
from mpm_warp.uncertainty.built import is_of_catalogue
from mpm_warp.uncertainty.laws import APEX_ANGLE, ErrorLaws
from mpm_warp.uncertainty.steadiness import steady_penetration

SOURCE_HEIGHT = 2.0 / 3.0
"""Height above the tip, over that of the cone, of the point source that the cone resembles from
afar: the centroid of the volume that it displaces."""
SPARE_SLOTS, SPARE_SLOTS_WITH_FRICTION = 0.15, 0.4
"""Additional slots for material points, over the number of points that fill the grid. Many small
points from near the axis gather in the cells along a rough shaft, with friction even more."""


@dataclass(frozen=True, kw_only=True, init=False)
class ConeTest(ClayScene):
    """A penetrometer pushed at constant speed into uniform, weightless, undrained clay.

    It starts in place, in ground stressed as if it had come from far above. The simulated stresses
    are in excess of the vertical in-situ stress, which is in equilibrium.
    """

    clay: FieldClay = group()
    cone: Cone = group()
    stress: InSituStress = group()
    domain: Domain = group()
    push: Push = group()
    resolution: Resolution = group()
    uncertainty: str = parameter(
        "known",
        "how the error of the cone factor is found: known from other cases, or measured by "
        "four further runs of this one, which take some ten times as long",
        choices=("known", "measured"),
    )
    energy_audit: str = parameter(
        "transfers",
        "what is recorded of energy: what the transfers of the method dissipate, or the "
        "balance, where all work of the penetrometer goes",
        choices=("transfers", "balance"),
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.inertia > failure.REFUSED_INERTIA:
            beside = f" with rigidity_index = {self.clay.rigidity_index:g}"
            refuse(self, "speed_ratio", f"{beside}: {self.thrown_off(failure.REFUSED_INERTIA)}")

    def derived(self) -> Mapping[str, float]:
        """The method by default, see `defaults`; it follows the clay."""
        index, accuracy = self.clay.rigidity_index, self.resolution.accuracy
        known = {"is_corrected": self._is_corrected}
        share = defaults.WINDOW[accuracy]
        extents = {name: share * extent for name, extent in self.default_extents.items()}
        above, approach = self.domain.domain_above, self.push.approach
        if approach is None:
            # By then all soil that the cone has never passed has left the window.
            approach = (extents["domain_above"] if above is None else above) + 1.0
        return {
            **super().derived(),
            **extents,
            "cells_per_radius": defaults.cells_per_radius(index, accuracy, **known),
            "speed_ratio": defaults.speed_ratio(index, accuracy, is_tresca=self._is_tresca),
            "poissons_ratio_bound": defaults.poissons_ratio_bound(index, accuracy, **known),
            "approach_speed_ratio": defaults.approach_speed_ratio(index, self.cone.apex_angle),
            "approach": approach,
            "penetration": defaults.penetration(index, approach),
        }

    @property
    def _is_tresca(self) -> bool:
        """Whether the laws of the error are of this criterion; see `is_of_catalogue`."""
        return is_of_catalogue(self) and self.clay.material.name == "tresca"

    @property
    def _is_corrected(self) -> bool:
        """Whether laws take off the error of a cheaper method, so that no further runs do.

        They go on where friction, a rate effect or softening begins, and so does the method. Blunt
        cones need more rows beside the face.
        """
        is_blunt = self.cone.apex_angle > defaults.BLUNTEST_WITH_FEW_ROWS
        return self._is_tresca and not is_blunt and self.uncertainty == "known"

    @property
    def default_extents(self) -> dict[str, float]:
        """Extents of the window by default, accuracy standard, over the radius."""
        return defaults.extents(self.clay.rigidity_index)

    @property
    def likely_failure(self) -> str:
        """See `CatalogueScene`: soil is thrown off, or waves grow from row to row."""
        return self.failure_told(1.0)

    def failure_told(self, scale: float) -> str:
        """The likely failure; the speeds in its remedy are multiplied by `scale`.

        A scene whose speed is over that of other waves has another scale than 1.
        """
        has_few_cells = self.resolution.cells_per_radius < failure.CELLS_AT_SPEED
        if self.inertia > failure.GREATEST_INERTIA and has_few_cells:
            remedy = f"or {failure.CELLS_AT_SPEED:g} cells_per_radius or more"
            return f"{self.thrown_off(failure.GREATEST_INERTIA, scale)}, {remedy}"
        return failure.growing_waves(
            self._grid.row_count,
            self.soil,
            speed_ratio=self.push.speed_ratio,
            approach_speed_ratio=math.sqrt(self.approach_inertia / self.clay.rigidity_index),
            time_step_fraction=self.domain.time_step_fraction,
            scale=scale,
        )

    def thrown_off(self, limit: float, scale: float = 1.0) -> str:
        """Message that the cone is above a limit of rho V^2 / su, with a speed to try."""
        return failure.thrown_off(self.clay.rigidity_index, self.inertia, limit, scale)

    @property
    def inertia(self) -> float:
        """Inertia of the soil over its strength, rho V^2 / su."""
        return self.clay.rigidity_index * self.push.speed_ratio * self.push.speed_ratio

    @property
    def approach_travel(self) -> float:
        """Penetration of the approach over the radius; 0 if it would be no faster, or too short.

        The last part of the penetration, in which the resistance becomes steady, has the final
        speed.
        """
        push = self.push
        latest = push.penetration - steady_penetration(self.clay.rigidity_index)
        travel = min(push.approach, latest)
        is_faster = push.approach_speed_ratio > push.speed_ratio
        return travel if travel > defaults.RAMP + defaults.SLOWING and is_faster else 0.0

    @property
    def approach_inertia(self) -> float:
        """Inertia rho V^2 / su in a fast approach; 0 without one."""
        is_made = self.approach_travel > 0.0
        return self.clay.rigidity_index * self.push.approach_speed_ratio**2 if is_made else 0.0

    def laws(self, penetration: float) -> ErrorLaws:
        """The laws of the error after a penetration, over the radius of the cone."""
        nu, bound = self.clay.poissons_ratio, self.resolution.poissons_ratio_bound
        reduction = max(0.0, nu - bound)
        return self.domain.error_laws(
            self.clay,
            self.cone,
            cells_per_radius=self.resolution.cells_per_radius,
            extents=self.default_extents,
            approach_inertia=self.approach_inertia,
            rigidity_index=self.clay.rigidity_index,
            adhesion_factor=self.interface.face,
            stress_anisotropy=self.stress.stress_anisotropy,
            poissons_ratio=nu - reduction,
            poissons_ratio_reduction=reduction,
            inertia=self.inertia,
            penetration=penetration,
        )

    @property
    def interface(self) -> Interface:
        """Adhesion and friction of face and shaft as they are built."""
        return interface_of(self.cone, self.clay, self.stress)

    @property
    def stress_at_rest(self) -> Floats:
        """See `ClayScene`."""
        return self.stress.at_rest(self.clay.undrained_shear_strength)

    @property
    def soil(self) -> Material:
        """The clay as simulated: Poisson's ratio bounded, strain rates those of the real speed."""
        bound = float(self.resolution.poissons_ratio_bound)
        return self.clay.at_speed(self.push.speed_ratio, self.stress_at_rest, bound)

    @property
    def window(self) -> Window:
        """The travel of the grid."""
        push, radius, clay = self.push, self.cone.cone_radius, self.clay
        speed, approach = push.speed_ratio * self.soil.shear_wave_speed, None
        if self.approach_travel > 0.0:
            approach = Approach(
                speed=speed * push.approach_speed_ratio / push.speed_ratio,
                travel=self.approach_travel * radius,
                slowing_travel=defaults.SLOWING * radius,
            )
        rubs = self.interface.friction > 0.0
        # Beside a face blunter than the standard one points stay for long, and their velocities
        # drift from that of the grid. Bounding the difference w by rho w^2 <= su keeps the stress
        # that they exert below the strength.
        is_blunt = self.cone.apex_angle > APEX_ANGLE
        stray_speed = math.sqrt(clay.undrained_shear_strength / clay.density)
        return Window(
            speed=speed,
            ramp_travel=defaults.RAMP * radius,
            approach=approach,
            spare_fraction=SPARE_SLOTS_WITH_FRICTION if rubs else SPARE_SLOTS,
            stray_speed=stray_speed if is_blunt else None,
        )

    def build(self) -> Scene:
        """The soil around the penetrometer; its contact is a `PenetrometerContact`."""
        return self.build_in(self._grid)

    def build_in(self, grid: Grid) -> Scene:
        """The scene in a grid with other rows and columns around the penetrometer."""
        strength, soil = self.clay.undrained_shear_strength, self.soil
        penetrometer, interface = self.cone.penetrometer, self.interface
        source = TravellingSource(
            radius=penetrometer.radius,
            height=SOURCE_HEIGHT * penetrometer.cone_height,
            shear_modulus=soil.ground_shear_modulus,
        )
        return Scene(
            grid=grid,
            material=soil,
            particles_per_side=math.isqrt(self.resolution.particles_per_cell),
            time_step_fraction=self.domain.time_step_fraction,
            bulk_viscosity=0.2,
            stress_at_rest=self.stress_at_rest,
            parts=(
                Fixed.on(grid, radial=["axis"]),
                SurroundingGround(grid=grid, material=soil, source=source, strength=strength),
                PenetrometerContact.of(
                    penetrometer,
                    grid,
                    face_adhesion=interface.face * strength,
                    shaft_adhesion=interface.shaft * strength,
                    friction=interface.friction,
                    strength=strength,
                    in_situ_stress=self.stress.in_situ_stress,
                ),
                self.window,
                ConservativeInterpolation(),
                EnergyAudit(),
                *([EnergyBalance()] if self.energy_audit == "balance" else []),
            ),
        )

    @property
    def _grid(self) -> Grid:
        return self.domain.grid(self.cone.penetrometer, self.cell_size)

    @property
    def cell_size(self) -> float:
        """Width and height of the cells at the cone [m]."""
        return self.cone.cell_size(self.resolution.cells_per_radius)

    @property
    def end_time(self) -> float:
        """Time to the greatest penetration [s]."""
        return self.window.time_to(self.push.penetration * self.cone.cone_radius)
