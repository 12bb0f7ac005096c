"""The test of a sounding: its parameters, the ground and path that follow, and what is built."""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace

import numpy as np

from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.fields.declaration import Value, group, own_parameters_of, parameter
from mpm_warp.materials.material import Material
from mpm_warp.parts.free_surface import PassingSurface
from mpm_warp.parts.surrounding_ground import SurroundingGround
from mpm_warp.parts.window import Window
from mpm_warp.scene import Scene
from mpm_warp.scenes.clay_scene import ClayScene, StressAtRest
from mpm_warp.scenes.cone import defaults
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.cone.groups import Cone, InSituStress, Push, Resolution, StandardCone
from mpm_warp.scenes.sounding.checks import (
    check_given_once,
    check_limits,
    check_reach,
    check_thickness,
)
from mpm_warp.scenes.sounding.groups import ClayByDepth, DomainOfSounding, Layers, Path
from mpm_warp.scenes.sounding.profile import Profile
from mpm_warp.scenes.sounding.table import PROFILE, replaced_by
from mpm_warp.step.points import seed_rows
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING

LEAD = 2.5
"""Penetration before the curves begin, less the extent of the window above the shoulder, in cone
radii. The cone has then passed all soil beside the shaft."""
DEFAULT_LENGTH = 30.0
"""Default length of the curves in cone radii."""
ROUNDING = 1e-6
"""Rounding of a depth, over the distance of two samples."""
LAYER = 1.0
"""Thickness of the layer below the surface of the ground, over the radius of the cone. When it has
left the window at the top, no part of the surface is in the window."""
PIC_FRACTION = 0.02
"""PIC fraction of the material points near the surface of the ground; see `PassingSurface`. Without
it soil is thrown off the surface. At 3 cells per radius, the resistances with 0.01 and with 0.03
differ by 10 % two radii below the surface, and by 1 % from three radii on."""
TIME_STEP_FRACTION = 0.7
"""Largest time step over the critical one, in a sounding from the surface. Cells near the surface
have no mass-matrix correction; without it 0.76 is stable."""


@dataclass(frozen=True, kw_only=True, init=False)
class SoundingTest(ClayScene):
    """Ground, penetrometer and method of a sounding, and the scene that is built of them."""

    clay: ClayByDepth = group()
    cone: StandardCone = group()
    stress: StressAtRest = group()
    domain: DomainOfSounding = group()
    layers: Layers = group()
    path: Path = group()
    speed_ratio: float = parameter(
        0.05,
        "penetration speed over that of shear waves in the softest soil",
        minimum=1e-4,
        maximum=0.5,
    )
    cells_per_radius: float = parameter(
        3.0, "cells per cone radius at the cone, about", minimum=1, maximum=100
    )
    uncertainty: str = parameter(
        "known",
        "how the error of the resistance is found: known from other cases, or measured by further "
        "runs of cone tests, in the clay of both ends of the stretch and of both sides of each "
        "border; each takes some ten times as long as a cone test",
        choices=("known", "measured"),
    )

    @classmethod
    def replaced(cls, parameters: Mapping[str, Value | None]) -> Collection[str]:
        """See `CatalogueScene`: those that a profile gives."""
        text = parameters[PROFILE]
        return replaced_by(str(text)) if text else ()

    def __post_init__(self) -> None:
        if self.layers.profile is None:
            self.clay.follow_law()
        super().__post_init__()

    def derived(self) -> Mapping[str, float]:
        """The shaft is as rough as the face; the window follows the greatest rigidity index."""
        of_law = super().derived() if self.layers.profile is None else {}
        return {
            **of_law,
            **self.default_extents,
            "shaft_adhesion_factor": self.ground.greatest_adhesion_factor(
                self.cone.adhesion_factor
            ),
            "to_depth": self.path.from_depth + DEFAULT_LENGTH * self.cone.cone_radius,
        }

    def check_soil(self) -> None:
        """Check the ground, and the clay of each of its rows."""
        layers, ground = self.layers, self.ground
        if layers.profile is not None:
            check_limits(layers.profile, own_parameters_of(type(self)))
        layers.check_layer()
        self.path.check_with(self.cone.cone_radius)
        in_place, highest = not self.starts_at_surface, self.highest_in_place
        check_reach(ground, self.path, in_place=in_place, highest_in_place=highest)
        check_thickness(ground, layers, self.cell_size)
        check_given_once(self, layers, self.clay.material, ground)
        try:
            _ = self.soil
        except (ParameterError, SceneError) as refusal:
            key = refusal.key if isinstance(refusal, ParameterError) else "ductility"
            raise ParameterError(key, f"in the ground that the cone passes: {refusal}") from None

    @property
    def ground(self) -> Profile:
        """The ground by depth: the profile, or linear strength with or without a layer."""
        return self.layers.profile_in(self.clay)

    @property
    def default_extents(self) -> dict[str, float]:
        """Extents of the window by default over cone radius."""
        ground = self.ground
        return defaults.extents(float((ground.shear_modulus / ground.strength).max()))

    @property
    def cell_size(self) -> float:
        """Width and height of the cells at the cone [m]."""
        return self.cone.cell_size(self.cells_per_radius)

    @property
    def ground_passed(self) -> Profile:
        """The ground that the window passes in the stretch; it sets speed and time step."""
        below = self.travel + self.domain.domain_below * self.cone.cone_radius
        begin = max(float(self.ground.depth[0]), self.start_depth - self._extent_above_tip)
        return self.ground.between(begin, self.start_depth + below)

    @property
    def dynamic_pressure(self) -> float:
        """Density times the square of the speed [Pa]."""
        return self.speed_ratio**2 * float(self.ground_passed.shear_modulus.min())

    @property
    def spacing(self) -> float:
        """Distance of two samples [m]."""
        return SAMPLE_SPACING * self.cone.cone_radius

    @property
    def samples(self) -> range:
        """Numbers of the samples of the stretch, 0 the first of the sounding."""
        return self.path.samples(self.spacing)

    @property
    def starts_at_surface(self) -> bool:
        """Whether the cone of the stretch starts at the surface.

        It does where the curves begin so high that the window around a cone in place would extend
        above the first depth of the ground.
        """
        return self.first_depth < self.highest_in_place

    @property
    def surface_passed(self) -> float:
        """Penetration from the surface until the layer below it has left the window [m]."""
        return self._extent_above_tip + LAYER * self.cone.cone_radius

    @property
    def lead_count(self) -> int:
        """Number of samples before the curves begin."""
        if self.starts_at_surface:
            # The start is at the surface, or less than the distance of two samples above it.
            return math.ceil(self.first_depth / self.spacing - ROUNDING)
        return math.ceil((self.domain.domain_above + LEAD) / SAMPLE_SPACING)

    @property
    def start_depth(self) -> float:
        """Depth of the tip at the start [m]."""
        return self.path.from_depth + (self.samples[0] - self.lead_count) * self.spacing

    @property
    def travel(self) -> float:
        """Penetration of the cone from its start to the end of the stretch [m]."""
        return (self.lead_count + len(self.samples)) * self.spacing

    @property
    def first_depth(self) -> float:
        """Depth of the tip where the curves of the stretch begin [m]."""
        return self.path.from_depth + self.samples[0] * self.spacing

    @property
    def highest_in_place(self) -> float:
        """Least depth at which the curves of a cone that starts in place can begin [m]."""
        lead = (self.domain.domain_above + LEAD) * self.cone.cone_radius
        return lead + self._extent_above_tip + float(self.ground.depth[0])

    @property
    def _extent_above_tip(self) -> float:
        """Extent of the window above the tip [m]."""
        cone = self.cone
        return self.domain.domain_above * cone.cone_radius + cone.penetrometer.cone_height

    def cone_with(self, adhesion_factor: float) -> Cone:
        """The cone of a test in uniform clay; its shaft is in proportion as rough as here."""
        greatest = self.ground.greatest_adhesion_factor(self.cone.adhesion_factor)
        share = adhesion_factor / greatest if greatest > 0.0 else 1.0
        return Cone(
            adhesion_factor=adhesion_factor,
            shaft_adhesion_factor=share * self.cone.shaft_adhesion_factor,
            cone_radius=self.cone.cone_radius,
        )

    @property
    def test(self) -> ConePenetration:
        """The cone test in uniform clay with the greatest strength and stiffness passed.

        If parameters of the material law vary, it is the test in the clay of the stiffest row.
        """
        ground = self.ground_passed
        row = int(ground.shear_modulus.argmax()) if ground.of_law else None
        # In ground that varies, the variation of the material holds the in-situ anisotropy.
        of_ground = ground.stress_anisotropy_at(ground.depth[:1], self.stress.stress_anisotropy)
        return self._test_in(row, float(of_ground[0]) if ground.is_uniform else 0.0)

    def _test_in(self, row: int | None, stress_anisotropy: float) -> ConePenetration:
        """The cone test in the clay of a row of the ground passed; None: see `test`."""
        ground = self.ground_passed
        chosen = slice(None) if row is None else slice(row, row + 1)
        strength = float(ground.strength[chosen].max())
        stiffness = ground.shear_modulus[chosen].max()
        of_law = {name: float(values[row]) for name, values in ground.of_law.items()}
        vertical = ground.vertical_stress_at(np.array(max(0.0, self.start_depth)))
        speed_ratio = self.speed_ratio * math.sqrt(ground.shear_modulus.min() / stiffness)
        # The test would derive another default window than that of the sounding.
        domain = self.domain.kept
        if self.starts_at_surface:
            step = min(domain.time_step_fraction, TIME_STEP_FRACTION)
            domain = replace(domain, time_step_fraction=step)
        return ConePenetration(
            clay=self.clay.at(strength, float(stiffness) / strength, of_law),
            cone=self.cone_with(ground.greatest_adhesion_factor(self.cone.adhesion_factor)),
            stress=InSituStress(
                stress_anisotropy=stress_anisotropy, in_situ_stress=float(vertical)
            ),
            domain=domain,
            push=Push(approach=0.0, steady_tolerance=0.0, speed_ratio=speed_ratio),
            # No law corrects a sample for the bound of Poisson's ratio.
            resolution=Resolution(
                cells_per_radius=self.cells_per_radius,
                poissons_ratio_bound=defaults.INCOMPRESSIBLE,
            ),
        )

    @property
    def soil(self) -> Material:
        """The clay of `test`, varied with depth like the ground."""
        test, ground, elsewhere = self.test, self.ground_passed, self.stress.stress_anisotropy
        anisotropy = ground.stress_anisotropy_at(ground.depth, elsewhere)
        rows = None
        if ground.of_law:
            rows = tuple(self._test_in(*row).soil for row in enumerate(anisotropy.tolist()))
        else:  # raise where the in-situ stress is outside the yield surface
            _ = [self._test_in(None, extreme) for extreme in {anisotropy.min(), anisotropy.max()}]
        variation = ground.variation(
            self.start_depth,
            elsewhere,
            strength=test.clay.undrained_shear_strength,
            rows=rows,
        )
        return replace(test.soil, variation=variation)

    def build(self) -> Scene:
        """The scene of a cone test in clay that varies, in place or from the surface."""
        scene = replace(self.test.build(), material=self.soil)
        return self._from_surface(scene) if self.starts_at_surface else scene

    def _from_surface(self, scene: Scene) -> Scene:
        """The scene of a cone test that starts with its tip at the surface of the ground.

        As the cone penetrates, soil heaves beside it. The surface moves up through the window and
        leaves it at the top; from then on the scene is that of a deep cone. The simulated soil is
        weightless: its weight is in the in-situ stress, and acts on the cone as sigma_v0. The
        weight of the heave is left out; it is some gamma R / su, about 0.01, of the strength.
        """
        level = self.start_depth
        grid, window = replace(scene.grid, ground_level=level), scene[Window]
        seeded = len(seed_rows(grid, grid.row_count, scene.particles_per_side).volume)
        slots = (1.0 + window.spare_fraction) * grid.cell_count * scene.particles_per_side**2
        surface = PassingSurface(
            level=level, layer=LAYER * self.cone.cone_radius, pic_fraction=PIC_FRACTION
        )
        return replace(scene, grid=grid).with_parts(
            replace(window, spare_fraction=slots / seeded - 1.0),
            replace(scene[SurroundingGround], from_afar=False),
            surface,
        )
