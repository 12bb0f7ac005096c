"""Laws with parameters of their own, of this package and of others.

Another package offers a law by an entry point in its pyproject.toml:

    [project.entry-points."mpm_warp.materials"]
    my_clay = "their_package.my_clay:MyClay"

The class is a `Material`. Fields made by `mpm_warp.fields.parameter` become parameters of every
scene that takes a law; they are given together with `material = "my_clay"`. The scene itself gives
the fields of `GIVEN`.
"""

import functools
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import MISSING, dataclass, fields
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from mpm_warp.errors import ParameterError
from mpm_warp.fields import Parameter, Value, definition_of
from mpm_warp.materials import CRITERIA
from mpm_warp.materials.material import Material, register_name

GROUP = "mpm_warp.materials"
GIVEN = ("density", "shear_modulus", "poissons_ratio", "strength")
"""Fields that a scene gives to a law that has them: rho [kg/m3], G [Pa], nu, su [Pa]."""
OF_THIS_PACKAGE = (
    EntryPoint("anisotropic", "mpm_warp.materials.anisotropic:Anisotropic", GROUP),
    EntryPoint("modified_cam_clay", "mpm_warp.materials.modified_cam_clay:ModifiedCamClay", GROUP),
)


@dataclass(frozen=True, kw_only=True)
class OtherLaw:
    """A law with parameters of its own."""

    name: str  # in studies
    kind: type[Material]
    parameters: Mapping[str, Parameter]  # its own, by name

    @property
    def given(self) -> set[str]:
        """Names of the fields that a scene or its user gives."""
        return {field.name for field in fields(self.kind) if field.init}

    def make(self, own: Mapping[str, Value | None], given: Mapping[str, float]) -> Material:
        """The material from its own parameters and from `given` values of the scene."""
        values: dict[str, Any] = {
            name: definition.default if own.get(name) is None else own[name]
            for name, definition in self.parameters.items()
        }
        values |= {name: value for name, value in given.items() if name in self.given}
        return self.kind(**values)


@functools.cache
def other_laws() -> Mapping[str, EntryPoint]:
    """The entry points of all laws, by name; `ParameterError` if two have the same name."""
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
    """Names of the laws that can be loaded."""
    names = []
    for name in other_laws():
        with suppress(ParameterError):
            names.append(other_law(name).name)
    return tuple(names)


@functools.cache
def other_law(name: str) -> OtherLaw:
    """The law of this name; `ParameterError` if its entry point has no law that scenes can use."""
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
