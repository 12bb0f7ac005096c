"""Columns of a measured test: their quantities, by their names, and their units."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from harness.interpret.forms import AXES
from harness.interpret.reading.contents import Heading, NotNamedError, plain_name
from harness.interpret.reading.units import ANGLES, LENGTHS, PRESSURES, size_of
from harness.study.tables import StudyError
from mpm_warp.fields.names import nearest_name

RODS = ("penetration", "penetrationlength", "sondeerlengte")
"""Names of a depth that is the length of the rods."""
NORTH_SOUTH, EAST_WEST = IN_PLANES = ("inclinationns", "inclinationew")
"""Names of inclinations in two planes; they are not used if there is a resultant."""
NAMES: Mapping[str, tuple[str, ...]] = {
    "depth": ("depth", "z", *RODS, "scpt_dpth", "tiefe", "diepte"),
    "qc": ("qc", "cone_resistance", "coneresistance", "tip", "cone", "scpt_res", "conus"),
    "fs": ("fs", "sleeve_friction", "localfriction", "friction", "scpt_fres", "reibung"),
    "u2": ("u2", "u", "pore_pressure", "porepressureu2", "pore_2", "scpt_pwp2", "pw_druck"),
    "inclination": (
        "inclination",
        "inclinationresultant",
        "tilt",
        "neigung",
        "slopeomni",
        "scpt_slp1",
        NORTH_SOUTH,
    ),
    "inclination_across": ("inclination_across", "scpt_slp2", EAST_WEST),
}
"""Names of columns, in small letters, by quantity."""
OPTIONAL = ("fs", "u2", *AXES)
UNITS = {"depth": LENGTHS} | dict.fromkeys(AXES, ANGLES)
"""Units by quantity, in SI units; all others have PRESSURES."""


def columns_in(
    path: Path,
    headings: Sequence[Heading],
    columns: Mapping[str, str],
    units: Mapping[str, str],
) -> dict[str, tuple[int, float]]:
    """The column and the unit, in SI units, of each quantity, which the site file may name.

    A quantity whose column or unit is unknown raises `NotNamedError`.
    """
    found, lacking = {}, {}
    names_of_all = {plain_name(heading.name) for heading in headings}
    whole = {plain_name(own) for own in NAMES[AXES[0]] if own not in IN_PLANES}
    resultant = AXES[0] in columns or bool(names_of_all & whole)
    for name, usual in NAMES.items():
        wanted = columns.get(name)
        names = [plain_name(heading) for heading in (usual if wanted is None else (wanted,))]
        if resultant and wanted is None:
            names = [own for own in names if own not in IN_PLANES]
        places = [
            place
            for place, heading in enumerate(headings)
            if plain_name(heading.name) in names or (wanted and plain_name(heading.title) in names)
        ]
        if name == "depth" and wanted is None:  # inclined rods are longer than the depth
            places = [place for place in places if headings[place].name == name] or places
        if len(places) > 1:
            titles = ", ".join(headings[place].title for place in places)
            raise NotNamedError(
                f"{path}: {len(places)} columns may be {name}: {titles}; name one under columns of "
                f'the site file, as columns = {{ {name} = "..." }}'
            )
        if places:
            found[name] = places[0]
        elif name not in OPTIONAL or wanted is not None:
            lacking[name] = wanted or name
    if lacking:
        near = nearest_name(
            next(iter(lacking.values())), [heading.title for heading in headings if heading.title]
        )
        keys = ", ".join(f'{name} = "..."' for name in lacking)
        raise NotNamedError(
            f"{path}: has no column {', '.join(map(repr, lacking.values()))}{near}; name it under "
            f"columns of the site file, as columns = {{ {keys} }}"
        )
    if unused := units.keys() - found.keys():
        raise StudyError(f"{path}: has no column {min(unused)!r}; units of the site file has it")
    return {
        name: (place, _unit(path, name, headings[place], units.get(name)))
        for name, place in found.items()
    }


def is_of_rods(heading: Heading) -> bool:
    """Whether a column of depths is, by its name, the length of the rods."""
    return plain_name(heading.name) in RODS


def _unit(path: Path, name: str, heading: Heading, given: str | None) -> float:
    known, unit = UNITS.get(name, PRESSURES), given or heading.unit
    size = size_of(unit, known)
    if size is None:
        problem = f"has unit {unit!r}" if unit else "has no unit"
        raise NotNamedError(
            f"{path}: column {heading.title!r} {problem}; allowed: {', '.join(known)}, in the "
            f'header as "{name} [{next(iter(known))}]", or under units of the site file'
        )
    return size
