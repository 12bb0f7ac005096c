"""What a law that is given anew leaves out of what was given before."""

from collections.abc import Mapping
from typing import Any, TypeVar

from mpm_warp.errors import ParameterError
from mpm_warp.materials.clay_law import PARAMETER, ClayLaw

STIFFNESS = "rigidity_index"
"""The parameter of a scene that a law with a stiffness of its own does not take."""

T = TypeVar("T")


def without_replaced(before: Mapping[str, T], given: Mapping[str, Any]) -> dict[str, T]:
    """The entries in flat form that no law in `given` replaces.

    A law that is given anew, by its name or as a table, has none of the parameters of the one
    before. If its stiffness is its own, there is no rigidity index either.
    """
    if PARAMETER not in given:
        return dict(before)
    laws = given[PARAMETER] if isinstance(given[PARAMETER], list) else [given[PARAMETER]]
    replaced = {STIFFNESS} if all(map(_has_own_stiffness, laws)) else set()
    return {
        name: value
        for name, value in before.items()
        if name not in replaced and not name.startswith(f"{PARAMETER}.")
    }


def _has_own_stiffness(law: object) -> bool:
    try:
        return ClayLaw.of(law).has_own_stiffness
    except ParameterError:  # told where the law is read
        return False
