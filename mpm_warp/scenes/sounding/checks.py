"""Checks of the ground of a sounding: its limits, its reach, and that nothing is given twice."""

from collections.abc import Mapping

from mpm_warp.errors import ParameterError
from mpm_warp.fields.checked import refuse
from mpm_warp.fields.checks import in_words
from mpm_warp.fields.declaration import Derived, Parameter, own_parameters_of
from mpm_warp.materials.clay_law import PARAMETER, ClayLaw
from mpm_warp.scenes.sounding.groups import Layers, Path
from mpm_warp.scenes.sounding.profile import Profile
from mpm_warp.scenes.sounding.table import PROFILE, REPLACED, columns_of, refused

LIMITED_AS = {
    "strength": "undrained_shear_strength",
    "rigidity_index": "rigidity_index",
    "unit_weight": "unit_weight",
}
"""Columns of a profile, and the parameters whose limits they have."""


def check_limits(profile: str, declared: Mapping[str, Parameter]) -> None:
    """Check the columns of a profile by the limits of the parameters of the same meaning."""
    columns = columns_of(profile)
    rows = {parameter: columns[name] for name, parameter in LIMITED_AS.items() if name in columns}
    if "shear_modulus" in columns and "strength" in columns:
        rows["rigidity_index"] = columns["shear_modulus"] / columns["strength"]
    for name, values in rows.items():
        for row, value in enumerate(values.tolist(), 1):
            try:
                declared[name].checked(float(f"{value:.12g}"))  # a ratio has rounding
            except ParameterError as error:
                raise refused(f"row {row}: {error}") from None


def check_reach(ground: Profile, path: Path, *, highest_in_place: float, in_place: bool) -> None:
    """Refuse ground that ends above the last depth, or begins below a start at the surface.

    Args:
        ground: the ground.
        path: the path of the cone.
        highest_in_place: least depth at which the curves of a cone in place can begin [m].
        in_place: whether the cone of the stretch starts in place.
    """
    first, last = float(ground.depth[0]), float(ground.depth[-1])
    if last < path.to_depth:
        raise refused(f"ends at {last:g} m, must reach to_depth = {path.to_depth:g} m")
    if not in_place and first > 0.0:
        refuse(
            path,
            "from_depth",
            f": must be >= {highest_in_place:.4g}, or the profile, which begins at {first:g} "
            "m, must begin at 0, where the cone then starts",
        )


def check_thickness(ground: Profile, layers: Layers, cell_size: float) -> None:
    """Refuse a layer thinner than a cell [m]."""
    if ground.thinnest_layer < cell_size:
        raise ParameterError(
            "layer_thickness" if layers.profile is None else PROFILE,
            f"the thinnest layer is {ground.thinnest_layer:.4g} m thick, must be >= a cell, "
            f"{cell_size:.4g} m",
        )


def check_given_once(test: object, layers: Layers, law: ClayLaw, ground: Profile) -> None:
    """Refuse parameters of a test that its ground has by depth too."""
    optional = ("adhesion_factor", "stress_anisotropy")
    taken = [name for name in optional if getattr(ground, name) is not None]
    has_profile = layers.profile is not None
    where = "profile has it by depth" if has_profile else "law has it by K0"
    declared = own_parameters_of(type(test))
    for name in [*taken, *REPLACED] if has_profile else taken:
        # A case that is run again has the values that followed from its law.
        allowed = [declared[name].default] if has_profile else getattr(ground, name)[:1]
        value = getattr(test, name)
        if not isinstance(value, Derived) and value not in allowed:
            refuse(test, name, f": the {where}; keep one of them")
    for name in ground.of_law if has_profile else ():
        if law.own[name] != law.parameters[name].default:
            own = f"{PARAMETER}.{name}"
            raise ParameterError(
                own,
                f"{own} = {in_words(law.own[name])} is not allowed: the profile has it by depth; "
                "keep one of them",
            )
