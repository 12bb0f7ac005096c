"""A law of clay as a value: its name, and the parameters that only this law has.

A scene takes the name, "tresca"; a table with it, {"law": "modified_cam_clay",
"critical_state_ratio": 0.9}; or, in Python, ModifiedCamClay(critical_state_ratio=0.9). The scene
itself gives the fields of `GIVEN`. In flat form, as in results and under [vary], the parameters are
"material.critical_state_ratio".

Another package offers a law by an entry point in its pyproject.toml:

    [project.entry-points."mpm_warp.materials"]
    my_clay = "their_package.my_clay:MyClay"

The class is a `Material`; its own parameters are the fields made by `parameter`.
"""

import functools
from collections.abc import Mapping
from dataclasses import MISSING, dataclass, field, fields, replace
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Self

from mpm_warp.errors import ParameterError
from mpm_warp.fields.declaration import Parameter, Value, Variants, own_parameters_of
from mpm_warp.fields.names import nearest_name
from mpm_warp.materials.material import Material, class_name, register_name

GROUP = "mpm_warp.materials"
GIVEN = ("density", "shear_modulus", "poissons_ratio", "strength")
"""Fields that a scene gives to a law that has them: rho [kg/m3], G [Pa], nu, su [Pa]."""
PARAMETER, LAW = "material", "law"
"""The parameter of a scene whose value is a law, and the key of its name in a table."""
OF_THIS_PACKAGE = tuple(
    EntryPoint(name, f"mpm_warp.materials.{name}:{kind}", GROUP)
    for name, kind in (
        ("tresca", "Tresca"),
        ("von_mises", "VonMises"),
        ("anisotropic", "Anisotropic"),
        ("modified_cam_clay", "ModifiedCamClay"),
    )
)


@dataclass(frozen=True)
class ClayLaw:
    """A law with its own parameters, all of them checked."""

    name: str  # in studies and results
    kind: type[Material]
    own: Mapping[str, Value | None] = field(default_factory=dict, hash=False)

    def __repr__(self) -> str:
        """As it may be given to a scene, without defaults."""
        given = {it: own for it, own in self.own.items() if own != self.parameters[it].default}
        return repr({LAW: self.name, **given} if given else self.name)

    @classmethod
    def of(cls, value: object) -> Self:
        """The law that a name, a table or a material stands for.

        Raises:
            ParameterError: there is no such law, or it does not have a parameter or allow a value.
        """
        if isinstance(value, cls):
            return value
        if isinstance(value, Material):
            for it in _given(type(value)):
                if getattr(value, it) is not None:
                    raise _refused(
                        f"{type(value).__name__}: {it} is given by the scene; leave it out"
                    )
            own = {it: getattr(value, it) for it in own_parameters(type(value))}
            return cls(_name_of(type(value)), type(value), own)
        if isinstance(value, Mapping):
            own = dict(value)
            name: object = own.pop(LAW, None)
            if name is None:
                raise _refused(f'has no law; as in {{ {LAW} = "modified_cam_clay" }}')
        else:
            name, own = value, dict[str, object]()
        if not isinstance(name, str) or name not in laws():
            near = nearest_name(name, laws()) if isinstance(name, str) else ""
            raise ParameterError(
                PARAMETER,
                f"{PARAMETER} = {name!r} is not allowed: must be one of "
                f"{', '.join(map(repr, laws()))}{near if 'mean' in near else ''}",
            )
        kind = law_class(name)
        return cls(name, kind, _checked(name, own_parameters(kind), own))

    def changed(self, own: Mapping[str, Value | None]) -> Self:
        """The law with other values of some of its own parameters."""
        return replace(self, own=_checked(self.name, self.parameters, {**self.own, **own}))

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """The definitions of its own parameters, by name."""
        return own_parameters(self.kind)

    @property
    def given(self) -> frozenset[str]:
        """The fields of `GIVEN` that the law has."""
        return _given(self.kind)

    @property
    def has_own_strength(self) -> bool:
        """Whether the strength follows from its own parameters."""
        return "strength" not in self.given

    @property
    def has_own_stiffness(self) -> bool:
        """Whether the stiffness follows from its own parameters."""
        return "shear_modulus" not in self.given

    def material(self, **given: float) -> Material:
        """The material, from values of `GIVEN`; it takes those that it has."""
        values: dict[str, Any] = {name: it for name, it in given.items() if name in self.given}
        return self.kind(**values, **dict[str, Any](self.own))


def _refused(problem: str) -> ParameterError:
    return ParameterError(PARAMETER, f"{PARAMETER}: {problem}")


def _checked(
    law: str, known: Mapping[str, Parameter], given: Mapping[str, object]
) -> dict[str, Value | None]:
    """All own parameters of a law, checked, from those that are given."""
    for name, value in given.items():
        if name not in known:
            raise ParameterError(
                f"{PARAMETER}.{name}",
                f"{PARAMETER}.{name} = {value!r} is no parameter of {PARAMETER} = {law!r}"
                f"{nearest_name(name, known) if known else ', which has none of its own'}",
            )
    return {
        name: definition.checked(given.get(name, definition.default))
        for name, definition in known.items()
    }


@functools.cache
def _given(kind: type[Material]) -> frozenset[str]:
    return frozenset(it.name for it in fields(kind) if it.init) & frozenset(GIVEN)


def _name_of(kind: type[Material]) -> str:
    """Name of a law by its class; that of one without an entry point is its full path."""
    of_entries = (name for name in laws() if laws()[name].value.endswith(f":{kind.__qualname__}"))
    return next((name for name in of_entries if law_class(name) is kind), class_name(kind))


@functools.cache
def laws() -> Mapping[str, EntryPoint]:
    """The entry points of all laws, by name; `ParameterError` if two have the same name."""
    own = {offered.name: offered for offered in OF_THIS_PACKAGE}
    theirs: dict[str, EntryPoint] = {}
    for offered in entry_points(group=GROUP):
        if offered.name in (*own, *theirs):
            raise ParameterError(
                PARAMETER,
                f"{PARAMETER} {offered.name!r}: the entry point {offered.value!r} has the name of "
                "another law; rename it",
            )
        theirs[offered.name] = offered
    return own | theirs


@functools.cache
def law_class(name: str) -> type[Material]:
    """The class of a law; `ParameterError` if its entry point has no law that scenes can use."""
    offered = laws()[name]
    where = f"{PARAMETER} {name!r}: the entry point {offered.value!r}"
    try:
        kind = offered.load()
    except (Exception, SystemExit) as error:  # another package's code
        raise ParameterError(
            PARAMETER, f"{where} cannot be loaded: {type(error).__name__}: {error}"
        ) from None
    if not (isinstance(kind, type) and issubclass(kind, Material)):
        raise ParameterError(PARAMETER, f"{where} is not a class of Material")
    try:
        own = own_parameters(kind)
    except TypeError as error:
        raise ParameterError(PARAMETER, f"{where}: {error}") from None
    for one in fields(kind):
        needed = one.default is MISSING and one.default_factory is MISSING
        if needed and one.name not in (*own, *GIVEN):
            raise ParameterError(
                PARAMETER,
                f"{where}: field {one.name!r} is neither made by `parameter` nor one that a "
                f"scene gives: {', '.join(GIVEN)}",
            )
    register_name(kind, name)
    return kind


@functools.cache
def own_parameters(kind: type[Material]) -> Mapping[str, Parameter]:
    """The own parameters of a law by name; messages name them "material.critical_state_ratio"."""
    declared = own_parameters_of(kind).items()
    return {
        name: replace(definition, name=f"{PARAMETER}.{name}")
        for name, definition in declared
        if name not in GIVEN
    }


LAWS = Variants(
    key=LAW, names=laws, parameters=lambda name: own_parameters(law_class(name)), value=ClayLaw.of
)
"""What the parameter `material` of a scene may be."""
