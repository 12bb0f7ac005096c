"""The parameters of a sounding, and the ground and the path of the cone that follow from them."""

import math
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from mpm_warp.errors import ParameterError
from mpm_warp.fields.checks import in_words
from mpm_warp.fields.declaration import Derived, Value, parameter, redefined
from mpm_warp.fields.flat import parameters_of
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.clay_law import PARAMETER
from mpm_warp.scenes.clay_tower import FieldClayScene
from mpm_warp.scenes.cone.parameters import ConeInGround, FittedToCone
from mpm_warp.scenes.sounding.profile import Profile
from mpm_warp.scenes.sounding.table import (
    PROFILE,
    REPLACED,
    columns_of,
    refused,
    replaced_by,
    with_strength,
)
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING

LEAD = 2.5
"""Penetration before the curves begin, less the extent of the window above the shoulder, in cone
radii. The cone has then passed all soil beside the shaft."""
LAST_DEPTH = 1e4
"""Greatest depth of a sounding [m]."""
DEFAULT_LENGTH = 30.0
"""Default length of the curves in cone radii."""
ROUNDING = 1e-6
"""Rounding of a depth, over the distance of two samples."""
LIMITED_AS = {
    "strength": "undrained_shear_strength",
    "rigidity_index": "rigidity_index",
    "unit_weight": "unit_weight",
}
"""Columns of a profile, and the parameters whose limits they have."""
LAYER = 1.0
"""Thickness of the layer below the surface of the ground, over the radius of the cone. When it has
left the window at the top, no part of the surface is in the window."""


@dataclass(frozen=True, kw_only=True)
class SoundingTest(FittedToCone, FieldClayScene):
    """Ground, penetrometer and method of a sounding."""

    profile: str | None = parameter(
        None,
        "ground by depth, as a table of one line, see Profile (default: made of the "
        "parameters of strength and layer)",
    )
    undrained_shear_strength: float = redefined(
        FieldClayScene, "undrained_shear_strength", meaning="strength su at the surface"
    )
    strength_gradient: float = parameter(
        0.0, "growth of strength with depth", unit="Pa m-1", minimum=0, maximum=1e9
    )
    layer_top: float | None = parameter(
        None,
        "depth of the top of the layer (default: no layer)",
        unit="m",
        above=0,
        maximum=LAST_DEPTH,
    )
    layer_thickness: float | None = parameter(
        None, "thickness of the layer (default: it has no end)", unit="m", above=0
    )
    layer_strength_ratio: float = parameter(
        1.0, "strength in the layer over that without a layer", minimum=0.01, maximum=100
    )
    unit_weight: float = parameter(
        17e3, "total unit weight of the clay", unit="N m-3", minimum=0, maximum=1e6
    )
    from_depth: float = parameter(
        1.0,
        "depth of the tip where the curves begin; 0: at the surface of the ground",
        unit="m",
        minimum=0,
        maximum=LAST_DEPTH,
    )
    to_depth: float = parameter(
        None,
        "depth of the tip where the curves end (default: 30 radii deeper)",
        unit="m",
        above=0,
        maximum=LAST_DEPTH,
    )
    stretch_count: int = parameter(
        1, "stretches that a sounding is cut into", minimum=1, maximum=1000
    )
    stretch_number: int = parameter(
        1, "number of the stretch that is run, 1 the highest", minimum=1
    )
    overlap: float = parameter(
        10.0,
        "overlap of a stretch with the one above it, over cone radius",
        minimum=2,
        maximum=1000,
    )
    speed_ratio: float = parameter(
        0.05,
        "penetration speed over that of shear waves in the softest soil",
        minimum=1e-4,
        maximum=0.5,
    )
    time_step_fraction: float = redefined(
        ConeInGround,
        "time_step_fraction",
        meaning="time step over the critical one; from the surface 0.7 at most",
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

    def derived(self) -> Mapping[str, float]:
        """The shaft is as rough as the face; the window follows the greatest rigidity index."""
        return self.default_extents | {
            "shaft_adhesion_factor": self.ground.greatest_adhesion_factor(self.adhesion_factor),
            "to_depth": self.from_depth + DEFAULT_LENGTH * self.cone_radius,
        }

    @property
    def greatest_rigidity_index(self) -> float:
        """See `FittedToCone`."""
        ground = self.ground
        return float((ground.shear_modulus / ground.strength).max())

    @property
    def ground(self) -> Profile:
        """The ground by depth: the profile, or linear strength with or without a layer."""
        if self.profile is not None:
            return Profile.of(with_strength(self, columns_of(self.profile)))
        top, thickness = self.layer_top, self.layer_thickness or math.inf
        borders = [] if top is None else [top, top + thickness]
        inside = [border for border in borders if border < LAST_DEPTH]
        depth = np.array([0.0, *np.repeat(inside, 2), LAST_DEPTH])
        weight = {"unit_weight": np.full_like(depth, self.unit_weight)}
        if self.own_strength is not None:
            by_depth = "give its parameters by depth in a profile"
            for name, absent, instead in (
                ("undrained_shear_strength", self.own_strength, "leave it out"),
                ("strength_gradient", 0.0, by_depth),
                ("layer_top", None, by_depth),
                ("layer_thickness", None, by_depth),
                ("layer_strength_ratio", 1.0, by_depth),
            ):
                value = getattr(self, name)
                if value != absent and not isinstance(value, Derived):
                    has_own = f"material = {self.material.name!r} has its own strength"
                    raise ParameterError(name, f"{name}: {has_own}; {instead}")
            if not self.material.has_own_stiffness:
                weight["rigidity_index"] = np.full_like(depth, self.rigidity_index)
            return Profile.of(with_strength(self, {"depth": depth} | weight))
        strength = self.undrained_shear_strength + self.strength_gradient * depth
        if inside:
            strength[2:4] *= self.layer_strength_ratio
        modulus = self.rigidity_index * strength
        return Profile.of({"depth": depth, "strength": strength, "shear_modulus": modulus} | weight)

    @property
    def ground_passed(self) -> Profile:
        """The ground that the window passes in the stretch; it sets speed and time step."""
        below = self.travel + self.domain_below * self.cone_radius
        begin = max(float(self.ground.depth[0]), self.start_depth - self._extent_above_tip)
        return self.ground.between(begin, self.start_depth + below)

    @property
    def dynamic_pressure(self) -> float:
        """Density times the square of the speed [Pa]."""
        return self.speed_ratio**2 * float(self.ground_passed.shear_modulus.min())

    @property
    def sample_count(self) -> int:
        """Number of samples of the whole sounding."""
        return max(1, round((self.to_depth - self.from_depth) / self.spacing))

    @property
    def samples(self) -> range:
        """Numbers of the samples of the stretch, 0 the first of the sounding."""
        count = self.sample_count
        first = count * (self.stretch_number - 1) // self.stretch_count
        overlap = round(self.overlap / SAMPLE_SPACING) if self.stretch_number > 1 else 0
        return range(max(0, first - overlap), count * self.stretch_number // self.stretch_count)

    @property
    def starts_at_surface(self) -> bool:
        """Whether the cone of the stretch starts at the surface.

        It does where the curves begin so high that the window around a cone in place would extend
        above the first depth of the ground.
        """
        return self._first_depth < self.highest_in_place

    @property
    def surface_passed(self) -> float:
        """Penetration from the surface until the layer below it has left the window [m]."""
        return self._extent_above_tip + LAYER * self.cone_radius

    @property
    def lead_count(self) -> int:
        """Number of samples before the curves begin."""
        if self.starts_at_surface:
            # The start is at the surface, or less than the distance of two samples above it.
            return math.ceil(self._first_depth / self.spacing - ROUNDING)
        return math.ceil((self.domain_above + LEAD) / SAMPLE_SPACING)

    @property
    def spacing(self) -> float:
        """Distance of two samples [m]."""
        return SAMPLE_SPACING * self.cone_radius

    @property
    def start_depth(self) -> float:
        """Depth of the tip at the start [m]."""
        return self.from_depth + (self.samples[0] - self.lead_count) * self.spacing

    def shaft_adhesion(self, of_face: float) -> float:
        """Adhesion factor of the shaft where that of the face is `of_face`, in proportion to it."""
        greatest = self.ground.greatest_adhesion_factor(self.adhesion_factor)
        share = of_face / greatest if greatest > 0.0 else 1.0
        return share * self.shaft_adhesion_factor

    @property
    def travel(self) -> float:
        """Penetration of the cone from its start to the end of the stretch [m]."""
        return (self.lead_count + len(self.samples)) * self.spacing

    @property
    def _first_depth(self) -> float:
        """Depth of the tip where the curves of the stretch begin [m]."""
        return self.from_depth + self.samples[0] * self.spacing

    @property
    def highest_in_place(self) -> float:
        """Least depth at which the curves of a cone that starts in place can begin [m]."""
        lead = (self.domain_above + LEAD) * self.cone_radius
        return lead + self._extent_above_tip + float(self.ground.depth[0])

    @property
    def _extent_above_tip(self) -> float:
        """Extent of the window above the tip [m]."""
        return self.domain_above * self.cone_radius + self.penetrometer.cone_height


def _check_limits(test: SoundingTest, columns: Mapping[str, Floats]) -> None:
    """Check the columns of a profile by the limits of the parameters of the same meaning."""
    rows = {parameter: columns[name] for name, parameter in LIMITED_AS.items() if name in columns}
    if "shear_modulus" in columns and "strength" in columns:
        rows["rigidity_index"] = columns["shear_modulus"] / columns["strength"]
    for name, values in rows.items():
        definition = parameters_of(type(test))[name]
        for row, value in enumerate(values.tolist(), 1):
            try:
                definition.checked(float(f"{value:.12g}"))  # a ratio has rounding
            except ParameterError as error:
                raise refused(f"row {row}: {error}") from None


def check_sounding(test: SoundingTest) -> None:
    """Raise `ParameterError` for the first depth, stretch, layer or property not allowed."""
    if test.profile is not None:
        _check_limits(test, columns_of(test.profile))
    elif test.layer_top is None:
        for name, absent in ("layer_thickness", None), ("layer_strength_ratio", 1.0):
            if (value := getattr(test, name)) != absent:
                needed = f"{name} = {value:g} needs layer_top, the depth of the layer's top in m"
                raise ParameterError("layer_top", f"{needed}: give both")
    spacing = f"{SAMPLE_SPACING:g} radii"
    if test.to_depth < test.from_depth + SAMPLE_SPACING * test.cone_radius:
        test.refuse("to_depth", f": must be > from_depth = {test.from_depth:g} by {spacing}")
    if test.stretch_number > test.stretch_count:
        test.refuse("stretch_number", f": must be <= stretch_count = {test.stretch_count}")
    if test.stretch_count > test.sample_count:
        samples = f"{test.sample_count}, the samples of {spacing} from from_depth to to_depth"
        test.refuse("stretch_count", f": must be <= {samples}")
    ground = test.ground
    first, last = float(ground.depth[0]), float(ground.depth[-1])
    if last < test.to_depth:
        raise refused(f"ends at {last:g} m, must reach to_depth = {test.to_depth:g} m")
    if test.starts_at_surface and first > 0.0:
        test.refuse(
            "from_depth",
            f": must be >= {test.highest_in_place:.4g}, or the profile, which begins at {first:g} "
            "m, must begin at 0, where the cone then starts",
        )
    thinnest, cell = ground.thinnest_layer, test.cell_size
    if thinnest < cell:
        raise ParameterError(
            "layer_thickness" if test.profile is None else PROFILE,
            f"the thinnest layer is {thinnest:.4g} m thick, must be >= a cell, {cell:.4g} m",
        )
    optional = ("adhesion_factor", "stress_anisotropy")
    taken = [name for name in optional if getattr(ground, name) is not None]
    where = "law has it by K0" if test.profile is None else "profile has it by depth"
    definitions = parameters_of(type(test))
    for name in taken if test.profile is None else [*taken, *REPLACED]:
        default = definitions[name].default
        value = getattr(test, name, default)
        # A case that is run again has the values that followed from its law.
        allowed = getattr(ground, name)[:1] if test.profile is None else [default]
        if not isinstance(value, Derived) and value not in allowed:
            test.refuse(name, f": the {where}; keep one of them")
    _check_law(test, ground)


def _check_law(test: SoundingTest, ground: Profile) -> None:
    """Refuse a parameter of the law that a profile has by depth too."""
    for name in ground.of_law if test.profile is not None else ():
        if test.material.own[name] != test.material.parameters[name].default:
            raise ParameterError(
                f"{PARAMETER}.{name}",
                f"{PARAMETER}.{name} = {in_words(test.material.own[name])} is not allowed: the "
                "profile has it by depth; keep one of them",
            )
