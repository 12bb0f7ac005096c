"""Laws with parameters of their own: those of this package, and of others by entry points.

Other packages offer laws by the entry point group `mpm_warp.materials`, in their pyproject.toml:

    [project.entry-points."mpm_warp.materials"]
    my_clay = "their_package.my_clay:MyClay"

The class is a `Material`. Fields that it makes by `mpm_warp.parameters.parameter` are its own:
every scene that takes a law has them as parameters, to be given with `material = "my_clay"`. Its
other fields are given by the scene, by their names: see `GIVEN`.
"""

import functools
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import MISSING, dataclass, fields
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from mpm_warp.errors import ParameterError
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.material import Material, register_name
from mpm_warp.parameters import Parameter, Value, definition_of

GROUP = "mpm_warp.materials"
"""Group of the entry points by which other packages offer laws."""
GIVEN = ("density", "shear_modulus", "poissons_ratio", "strength")
"""What a scene gives to a law that has a field of the name: rho [kg/m3], G [Pa], nu, su [Pa]."""
OF_THIS_PACKAGE = (
    EntryPoint("anisotropic", "mpm_warp.materials.anisotropic:Anisotropic", GROUP),
    EntryPoint("modified_cam_clay", "mpm_warp.materials.modified_cam_clay:ModifiedCamClay", GROUP),
)
"""The laws of this package that have parameters of their own."""


@dataclass(frozen=True, kw_only=True)
class OtherLaw:
    """A law of another package."""

    name: str  # that studies call it by
    kind: type[Material]
    parameters: Mapping[str, Parameter]  # its own, by name

    @property
    def given(self) -> set[str]:
        """Names of what a scene gives to it, or could, beside its own parameters."""
        return {field.name for field in fields(self.kind) if field.init}

    def make(self, own: Mapping[str, Value | None], given: Mapping[str, float]) -> Material:
        """The material, of its own parameters and of what the scene gives; both are checked."""
        values: dict[str, Any] = {
            name: definition.default if own.get(name) is None else own[name]
            for name, definition in self.parameters.items()
        }
        values |= {name: value for name, value in given.items() if name in self.given}
        return self.kind(**values)


@functools.cache
def other_laws() -> Mapping[str, EntryPoint]:
    """Where the laws are, by name; none is imported for that.

    Raises:
        ParameterError: two laws have the same name.
    """
    own = {offered.name: offered for offered in OF_THIS_PACKAGE}
    theirs: dict[str, EntryPoint] = {}
    for offered in entry_points(group=GROUP):
        if offered.name in (*CRITERIA, *own, *theirs):
            raise ParameterError(
                "material",
                f"material {offered.name!r}: the entry point {offered.value!r} has the name of "
                "another law; rename it",
            )
        theirs[offered.name] = offered
    return theirs | own


def loaded_laws() -> tuple[str, ...]:
    """Names of those that can be loaded; a study that names another one is told why it cannot."""
    names = []
    for name in other_laws():
        with suppress(ParameterError):
            names.append(other_law(name).name)
    return tuple(names)


@functools.cache
def other_law(name: str) -> OtherLaw:
    """The law of another package; `ParameterError` where its entry point gives none for a scene."""
    offered = other_laws()[name]
    where = f"material {name!r}: the entry point {offered.value!r}"
    try:
        kind = offered.load()
    except (Exception, SystemExit) as error:  # another package's code
        raise ParameterError(
            "material", f"{where} cannot be loaded: {type(error).__name__}: {error}"
        ) from None
    if not (isinstance(kind, type) and issubclass(kind, Material)):
        raise ParameterError("material", f"{where} is not a class of Material")
    own = {field.name: field for field in fields(kind) if "meaning" in field.metadata}
    for field in fields(kind):
        needed = field.default is MISSING and field.default_factory is MISSING
        if needed and field.name not in (*own, *GIVEN, "variation"):
            raise ParameterError(
                "material",
                f"{where}: field {field.name!r} is neither made by `parameter` nor one that a "
                f"scene gives: {', '.join(GIVEN)}",
            )
    register_name(kind, name)
    parameters = {name: definition_of(kind, field) for name, field in own.items()}
    return OtherLaw(name=name, kind=kind, parameters=parameters)
