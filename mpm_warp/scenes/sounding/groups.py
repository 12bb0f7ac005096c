"""The groups of parameters of a sounding: clay, layers of the ground, and path of the cone."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from mpm_warp.errors import ParameterError
from mpm_warp.fields.checked import Group, fill_in, refuse
from mpm_warp.fields.declaration import Derived, own_parameters_of, parameter, redefined
from mpm_warp.scenes.clay import FieldClay
from mpm_warp.scenes.cone.groups import Domain
from mpm_warp.scenes.sounding.by_law import with_strength
from mpm_warp.scenes.sounding.profile import Profile
from mpm_warp.scenes.sounding.table import columns_of
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING

LAST_DEPTH = 1e4
"""Greatest depth of a sounding [m]."""


@dataclass(frozen=True, kw_only=True)
class ClayByDepth(FieldClay):
    """The clay of a ground; its strength and stiffness may be those of a profile."""

    undrained_shear_strength: float = redefined(
        FieldClay, "undrained_shear_strength", meaning="strength su at the surface"
    )

    def derived(self) -> Mapping[str, float]:
        """Nothing: strength and stiffness follow the law only without a profile."""
        return {}

    def check_stiffness(self) -> None:
        """See `follow_law`."""

    def follow_law(self) -> None:
        """Take strength and stiffness of the law, in ground without a profile."""
        fill_in(self, super().derived())
        super().check_stiffness()

    def at(self, strength: float, rigidity_index: float, own: Mapping[str, float]) -> FieldClay:
        """The clay at a place of this strength [Pa] and `own` parameters of the law.

        The stiffness that a law derives from its parameters is not linear between rows.
        """
        kept = {name: getattr(self, name) for name in own_parameters_of(FieldClay)}
        del kept["rigidity_index"]
        index = {} if self.material.has_own_stiffness else {"rigidity_index": rigidity_index}
        here = {"undrained_shear_strength": strength, "material": self.material.changed(own)}
        return FieldClay(**{**kept, **index, **here})


@dataclass(frozen=True, kw_only=True)
class DomainOfSounding(Domain):
    """The domain around a cone that may start at the surface."""

    time_step_fraction: float = redefined(
        Domain,
        "time_step_fraction",
        meaning="time step over the critical one; from the surface 0.7 at most",
    )


@dataclass(frozen=True, kw_only=True)
class Layers(Group):
    """The ground by depth: a profile, or a strength that is linear, with or without a layer."""

    profile: str | None = parameter(
        None,
        "ground by depth, as a table of one line, see Profile (default: made of the "
        "parameters of strength and layer)",
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

    def check_layer(self) -> None:
        """Refuse a layer whose top is not given, in clay whose law allows one."""
        if self.profile is not None or self.layer_top is not None:
            return
        for name, absent in ("layer_thickness", None), ("layer_strength_ratio", 1.0):
            if (value := getattr(self, name)) != absent:
                needed = f"{name} = {value:g} needs layer_top, the depth of the layer's top in m"
                raise ParameterError("layer_top", f"{needed}: give both")

    def profile_in(self, clay: FieldClay) -> Profile:
        """The profile of the ground in this clay, which has the strength at the surface."""
        if self.profile is not None:
            return Profile.of(with_strength(clay, columns_of(self.profile)))
        top, thickness = self.layer_top, self.layer_thickness or math.inf
        borders = [] if top is None else [top, top + thickness]
        inside = [border for border in borders if border < LAST_DEPTH]
        depth = np.array([0.0, *np.repeat(inside, 2), LAST_DEPTH])
        weight = {"unit_weight": np.full_like(depth, self.unit_weight)}
        if clay.own_strength is not None:
            self._check_left_to_law(clay)
            if not clay.material.has_own_stiffness:
                weight["rigidity_index"] = np.full_like(depth, clay.rigidity_index)
            return Profile.of(with_strength(clay, {"depth": depth} | weight))
        strength = clay.undrained_shear_strength + self.strength_gradient * depth
        if inside:
            strength[2:4] *= self.layer_strength_ratio
        modulus = clay.rigidity_index * strength
        return Profile.of({"depth": depth, "strength": strength, "shear_modulus": modulus} | weight)

    def _check_left_to_law(self, clay: FieldClay) -> None:
        """Refuse what would change the strength of a law that has its own."""
        has_own = f"material = {clay.material.name!r} has its own strength"
        strength = clay.undrained_shear_strength
        if strength != clay.own_strength and not isinstance(strength, Derived):
            name = "undrained_shear_strength"
            raise ParameterError(name, f"{name}: {has_own}; leave it out")
        for name in ("strength_gradient", "layer_top", "layer_thickness", "layer_strength_ratio"):
            if getattr(self, name) != own_parameters_of(Layers)[name].default:
                by_depth = "give its parameters by depth in a profile"
                raise ParameterError(name, f"{name}: {has_own}; {by_depth}")


@dataclass(frozen=True, kw_only=True)
class Path(Group):
    """Where a sounding begins and ends, and the stretch of it that is run."""

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

    def sample_count(self, spacing: float) -> int:
        """Number of samples of the whole sounding, at a distance [m]."""
        return max(1, round((self.to_depth - self.from_depth) / spacing))

    def samples(self, spacing: float) -> range:
        """Numbers of the samples of the stretch, 0 the first of the sounding."""
        count = self.sample_count(spacing)
        first = count * (self.stretch_number - 1) // self.stretch_count
        overlap = round(self.overlap / SAMPLE_SPACING) if self.stretch_number > 1 else 0
        return range(max(0, first - overlap), count * self.stretch_number // self.stretch_count)

    def check_with(self, radius: float) -> None:
        """Refuse an end above the begin, or a stretch that there is not; radius of the cone [m]."""
        spacing = f"{SAMPLE_SPACING:g} radii"
        if self.to_depth < self.from_depth + SAMPLE_SPACING * radius:
            refuse(self, "to_depth", f": must be > from_depth = {self.from_depth:g} by {spacing}")
        if self.stretch_number > self.stretch_count:
            refuse(self, "stretch_number", f": must be <= stretch_count = {self.stretch_count}")
        count = self.sample_count(SAMPLE_SPACING * radius)
        if self.stretch_count > count:
            samples = f"{count}, the samples of {spacing} from from_depth to to_depth"
            refuse(self, "stretch_count", f": must be <= {samples}")
