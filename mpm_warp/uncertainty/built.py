"""Whether a scene has the soil, contact, grid and window for which U was measured.

The error of the method is measured for scenes of the catalogue. A subclass may build a soil, a
contact or a grid of its own, while its parameters keep their names. So the scene that was built is
compared, part by part, with the scene that the catalogue builds from the same parameters. Where
they are equal, the parameters say what was simulated, and the laws of the error apply. Where they
differ, the error is not known.
"""

from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass
from inspect import isabstract
from typing import Any

import numpy as np

from mpm_warp.errors import ParameterError, SceneError
from mpm_warp.fields import parameters_of
from mpm_warp.grid.fitted import Grid
from mpm_warp.materials.anisotropic import Anisotropic
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.material import Material, built_name
from mpm_warp.materials.modified_cam_clay import ModifiedCamClay
from mpm_warp.materials.tresca import Tresca
from mpm_warp.materials.von_mises import VonMises
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.energy import EnergyAudit, EnergyBalance
from mpm_warp.parts.history import History
from mpm_warp.parts.surrounding_ground import SurroundingGround
from mpm_warp.parts.window import Window
from mpm_warp.scene import Part, Scene

MEASURED_LAWS = (Tresca, VonMises, EinavRandolph)
"""Material laws with which further runs were tested: errors depend on the width of cells and on the
speed as further runs assume. In a law of a user the strength may depend on the speed, or softening
may localise in one cell; further runs cannot distinguish such an effect from an error."""
LAWS_OF_CONES = (*MEASURED_LAWS, ModifiedCamClay, Anisotropic)
"""Material laws with which further runs of cones were tested."""
LARGEST_BRITTLENESS = 0.1
"""(1 - delta) / xi_95 up to which further runs measure the error of clay that softens. At 0.02 to
0.08 the cone factor follows the law of the mesh, within 0.008 on 5 to 14 rows of cells. At 0.18 it
falls below the limit that further runs give, by 1.7 of their half widths."""
RECORDS = (EnergyAudit, EnergyBalance, History)
"""Parts that only record and do not change a result."""
MEASURABLE = ", but further runs may measure it (uncertainty = measured)"
"""Remedy in the reason why a factor has no uncertainty; it does not hold for pore pressures."""
PARTS = (
    (Material, "law", "soil"),
    (SurfaceContact, "contact", "contact"),
    (Grid, "grid", "grid"),
    ((Window, SurroundingGround), "window", "window"),
)
"""Kinds of parts, each with the keyword of its reason and its name in the sentence."""
ORDERED_METHODS = (
    "add_forces",
    "add_boundary",
    "add_contact",
    "add_after_motion",
    "add_records",
    "between_steps",
    "enter",
    "follow",
)
"""Methods that are called for each part in order, within a step or between steps."""
OTHER = "scene"
"""Keyword and name of any other part."""


def expected_scene(test: Any) -> Scene | None:
    """The scene that the catalogue builds from the parameters of a test; None if it refuses them.

    The test may be of a user's class, derived from a class of this package.
    """
    own = __package__.partition(".")[0]
    catalogue: Any = next(
        kind for kind in type(test).__mro__ if kind.__module__.partition(".")[0] == own
    )
    if isabstract(catalogue):
        return None
    offered = catalogue.offered()  # adds the parameters of the laws, which a class may lack
    given = {name: getattr(test, name) for name in parameters_of(offered) if hasattr(test, name)}
    try:
        built: Scene = offered(**given).build()
    except (ParameterError, SceneError):
        return None
    return built


def why_not_as_measured(
    built: Scene, expected: Scene | None, laws: tuple[type[Material], ...] = MEASURED_LAWS
) -> list[str]:
    """Why the error was not measured for the scene built, as "word: sentence"; empty if it was.

    Args:
        built: the scene that was simulated.
        expected: the scene of `expected_scene`, or None.
        laws: the material laws with which the error was measured.
    """
    if expected is None:
        return ["scene: no scene of the catalogue has these parameters"]
    reasons = {}
    for one, other, where in _side_by_side(built, expected):
        difference = _difference(one, other, where)
        if difference is not None:
            word, what = _keyword_and_name(other)
            reasons[word] = f"{word}: the error is not known with the {what} built, {difference}"
    if not reasons:
        return why_law_not_measured(built.material, laws)
    # An earlier part may cause later differences: waves are faster in a stiffer soil.
    first = next(word for word in (*(word for _, word, _ in PARTS), OTHER) if word in reasons)
    return [reasons[first]]


def why_not_tresca(material: Material) -> list[str]:
    """Why the laws of the error do not hold in this soil of the catalogue; empty in Tresca soil."""
    if type(material) is Tresca:
        return []
    changing = isinstance(material, EinavRandolph)
    name = "clay that softens or has a rate effect" if changing else built_name(material)
    return [f"law: the error is known in tresca, not in {name}{MEASURABLE}"]


def why_law_not_measured(
    material: Material, laws: tuple[type[Material], ...] = MEASURED_LAWS
) -> list[str]:
    """Why neither laws nor further runs give the error in this material; empty where they do."""
    if type(material) not in laws:
        return [f"law: the error is not known in {built_name(material)}"]
    if not isinstance(material, EinavRandolph):
        return []
    if material.criterion not in MEASURED_LAWS:
        criterion = material.criterion.__name__
        return [f"law: the error is not known in {criterion} clay whose strength changes"]
    lost = 1.0 - material.remoulded_strength_ratio
    if lost > LARGEST_BRITTLENESS * material.ductility:
        above = f"(1 - delta) / xi_95 above {LARGEST_BRITTLENESS:g}"
        return [f"law: no limit of fine cells is known in clay so brittle, {above}"]
    return []


def _side_by_side(built: Scene, expected: Scene) -> Iterator[tuple[object, object, str]]:
    """Pairs of the components of two scenes, with a name, without parts that only record."""
    for field in fields(Scene):
        if field.name != "parts":
            yield getattr(built, field.name), getattr(expected, field.name), field.name
    parts, others = (scene.without(*RECORDS).parts for scene in (built, expected))
    if len(parts) != len(others):
        yield _names(parts), _names(others), "parts"
        return
    in_order, others_in_order = (sorted(them, key=built_name) for them in (parts, others))
    if _names(in_order) == _names(others_in_order):
        # The order matters only among parts with the same method.
        for place in ORDERED_METHODS:
            one, other = (_names(_acting_at(place, them)) for them in (parts, others))
            yield one, other, "the order of its parts"
        parts, others = tuple(in_order), tuple(others_in_order)
    yield from ((*pair, "part") for pair in zip(parts, others, strict=True))


def _acting_at(place: str, parts: Sequence[Part]) -> list[Part]:
    return [part for part in parts if getattr(type(part), place) is not getattr(Part, place)]


def _names(parts: Sequence[Part]) -> str:
    return ", ".join(map(built_name, parts))


def _keyword_and_name(part: object) -> tuple[str, str]:
    """Keyword and name of a part in a reason."""
    for kind, word, what in PARTS:
        if isinstance(part, kind):
            return word, what
    return OTHER, OTHER


def _difference(built: object, expected: object, where: str) -> str | None:
    """The first difference, as "friction = 0.2 instead of 0"; None if there is none."""
    if type(built) is not type(expected):
        names_of_types = ("none" if it is None else built_name(it) for it in (built, expected))
        return " instead of ".join(names_of_types)
    if isinstance(expected, np.ndarray):
        return None if np.array_equal(np.asarray(built), expected) else f"with other {where}"
    if isinstance(built, tuple) and isinstance(expected, tuple) and len(built) == len(expected):
        pairs = [(one, other, where) for one, other in zip(built, expected, strict=True)]
    elif is_dataclass(expected) and not isinstance(expected, type):
        names = [field.name for field in fields(expected)]
        pairs = [(getattr(built, name), getattr(expected, name), name) for name in names]
    elif isinstance(expected, Part):
        pairs = [(value, vars(expected).get(name), name) for name, value in vars(built).items()]
    else:
        shown = (f"{it:g}" if isinstance(it, float) else str(it) for it in (built, expected))
        return None if built == expected else f"{where} = {' instead of '.join(shown)}"
    return next(filter(None, (_difference(*pair) for pair in pairs)), None)
