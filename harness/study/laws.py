"""Laws in the tables of a study: their parameters, and what a law that is given anew replaces."""

from collections.abc import Mapping
from typing import Any, TypeVar

from harness.study.tables import StudyError, Table
from mpm_warp.errors import ParameterError
from mpm_warp.materials.clay_law import LAW, PARAMETER, ClayLaw

ASSIGNING_TABLES = ("fixed", "vary", "derived")
"""Tables that give a parameter its value; a study's own entry replaces all those of its base."""
STIFFNESS = "rigidity_index"
"""The parameter of a scene that a law with a stiffness of its own does not take."""

T = TypeVar("T")


def flat_tables(document: Table) -> dict[str, Any]:
    """The tables of a study in which parameters of a law have names as "material.its_parameter".

    A study may also have them in one table, material = { law = "its_name", its_parameter = 1 }.
    """
    flat = dict(document.values)
    for key in {*ASSIGNING_TABLES, "scenes", "case"} & flat.keys():
        where = f"{document.where} [{key}]"
        match flat[key]:
            case dict() as table if key == "scenes":
                flat[key] = {
                    name: flat_tables(Table(f"{where} [{name}]", own))
                    if isinstance(own, dict)
                    else own
                    for name, own in table.items()
                }
            case dict() as table:
                flat[key] = flat_material(where, table)
            case list() as tables:
                flat[key] = [
                    flat_material(f"{document.where} [[case]] {number}:", own)
                    if isinstance(own, dict)
                    else own
                    for number, own in enumerate(tables, 1)
                ]
    return flat


def flat_material(where: str, table: Mapping[str, Any]) -> dict[str, Any]:
    """The entries of a table in which those of a law have names as "material.its_parameter"."""
    flat: dict[str, Any] = {}
    for key, value in table.items():
        is_law = key == PARAMETER and isinstance(value, dict)
        entries = {f"{key}.{own}": it for own, it in value.items()} if is_law else {key: value}
        for given, own in entries.items():
            name = PARAMETER if given == f"{PARAMETER}.{LAW}" else given
            if name in flat:
                raise StudyError(f"{where} {name}: is given twice; keep one of them")
            flat[name] = own
    return flat


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
