"""What a sounding refuses beyond the ranges of its parameters: what does not go together."""

from __future__ import annotations

from mpm_warp.errors import ParameterError
from mpm_warp.scenes.cone.penetration import SAMPLE_SPACING
from mpm_warp.scenes.sounding.parameters import SoundingTest


def check_sounding(test: SoundingTest) -> None:
    """Refuse depths, stretches, layers and properties that do not go together.

    Raises:
        ParameterError: the first of what does not; its key names the parameter.
    """
    _check_depths(test)
    _check_stretches(test)
    _check_ground(test)


def _check_depths(test: SoundingTest) -> None:
    if test.to_depth < test.from_depth + SAMPLE_SPACING * test.cone_radius:
        raise ParameterError(
            "to_depth",
            f"to_depth = {test.to_depth:g} is not allowed: must be > from_depth = "
            f"{test.from_depth:g} by {SAMPLE_SPACING:g} radii",
        )


def _check_stretches(test: SoundingTest) -> None:
    if test.stretch_number > test.stretch_count:
        raise ParameterError(
            "stretch_number",
            f"stretch_number = {test.stretch_number} is not allowed: must be <= "
            f"stretch_count = {test.stretch_count}",
        )
    if test.stretch_count > test.sample_count:
        raise ParameterError(
            "stretch_count",
            f"stretch_count = {test.stretch_count} is not allowed: must be <= "
            f"{test.sample_count}, the samples of {SAMPLE_SPACING:g} radii from from_depth "
            "to to_depth",
        )


def _check_ground(test: SoundingTest) -> None:
    ground = test.ground
    first, last = float(ground.depth[0]), float(ground.depth[-1])
    if last < test.to_depth:
        raise ParameterError(
            "profile",
            f"profile: ends at {last:g} m, must reach to_depth = {test.to_depth:g} m",
        )
    if test.starts_at_surface and first > 0.0:
        raise ParameterError(
            "from_depth",
            f"from_depth = {test.from_depth:g} is not allowed: must be >= "
            f"{test.highest_in_place:.4g}, or the profile, which begins at {first:g} m, must "
            "begin at 0, where the cone then starts",
        )
    thinnest, cell = ground.thinnest_layer, test.cell_size
    if thinnest < cell:
        raise ParameterError(
            "layer_thickness" if test.profile is None else "profile",
            f"the thinnest layer is {thinnest:.4g} m thick, must be >= a cell, {cell:.4g} m",
        )
    for name in ("adhesion_factor", "stress_anisotropy"):
        value = getattr(test, name)
        if getattr(ground, name) is not None and value != 0.0:
            raise ParameterError(
                name,
                f"{name} = {value:g} is not allowed: the profile has it by depth; keep one of them",
            )
