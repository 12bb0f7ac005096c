"""Scenes and studies in words: `harness describe`, `harness new`, and warnings of unusual values.

A value is unusual if it looks as if it were given in another unit. A parameter is reported only if
all of its values in the study are outside the usual range and would be inside in that other unit.
So a study that spans many orders of magnitude gets no warning.
"""

import itertools
import json
import math
import textwrap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from harness.errors import tell
from harness.references.registry import BANDS, ENVELOPE
from harness.study.cases import complete_parameters, most_cases
from harness.study.compared import takes_references
from harness.study.designs import DESIGNS, Range, Variation
from harness.study.distributions import Input
from harness.study.scene_part import ScenePart, method_of
from harness.study.study import Study
from mpm_warp.fields.declaration import Parameter, Value, own_parameters_of
from mpm_warp.materials.clay_law import PARAMETER, law_class, laws, own_parameters
from mpm_warp.scenes import CatalogueScene, scene_class
from mpm_warp.scenes.sounding.table import PROFILE, columns_of, units_of

MOST_COUNTED = 1000
"""Up to so many cases are made to count them; of more an upper bound is given."""


def scene_rows(name: str) -> list[str]:
    """What a scene simulates, and its parameters: default, unit, meaning, allowed range."""
    scene = scene_class(name)
    rows = [f"{name}: {scene.summary}", ""]
    for parameter, definition in own_parameters_of(scene).items():
        meaning = f"{definition.meaning}; {definition.allowed}{_sane_range(definition)}"
        rows.append(f"{parameter:26} {_default(definition):16} {meaning}")
    return rows


def law_title(name: str) -> str:
    """What a law of clay is, in one line; `ParameterError` if it cannot be loaded."""
    return (law_class(name).__doc__ or "").strip().partition("\n")[0].rstrip(".")


def law_rows(name: str) -> list[str]:
    """What a law of clay is, and its own parameters as a study gives them."""
    own = own_parameters(law_class(name))
    rows = [f"{name}: {law_title(name)}", ""]
    for definition in own.values():
        meaning = f"{definition.meaning}; {definition.allowed}"
        rows.append(f"{definition.name:42} {_default(definition):16} {meaning}")
    if not own:
        rows.append("It has no parameters of its own; a scene has those of a criterion.")
    return [
        *rows,
        "",
        f'in a study: material = {{ law = "{name}", ... }}; the scene gives the rest',
    ]


def _sane_range(definition: Parameter) -> str:
    """The range in which nearly all cases complete, if it is narrower than the allowed one."""
    if definition.sane is None:
        return ""
    least, greatest = definition.sane
    return f"; nearly all cases complete from {least:g} to {greatest:g}"


def _default(definition: Parameter) -> str:
    """The default of a parameter with its unit, in words."""
    if definition.default is None:
        return ("none" if definition.optional else "derived") + definition.in_unit
    return f"{definition.default}{_unit(definition)}"


def study_rows(study: Study) -> list[str]:
    """What a study runs, what it varies and fixes, and what it is compared with."""
    with_own = {law for part in study.parts for law in _laws_of(part)}
    described = [*(part.name for part in study.parts), *sorted(with_own)]
    scenes = ", ".join(f"harness describe {name}" for name in described)
    return [
        f"{study.name}: {study.title}",
        "",
        *(f"{title:12} {text}" for title, text in _study_lines(study)),
        "",
        f"all parameters: {scenes}",
    ]


def _study_lines(study: Study) -> Iterator[tuple[str, str]]:
    count, compared = most_cases(study.parts, study.design), study.compared
    number = f"{count} at most" if count > MOST_COUNTED else f"{len(study.cases)}"
    yield "file", str(study.source)
    yield "cases", f"{number}, {DESIGNS[study.design.kind]}"
    for part in study.parts:
        yield from _part_lines(part)
    if compared.references:
        yield "references", ", ".join(reference.id for reference in compared.references)
    if compared.reference_result is not None:
        yield "errors from", str(compared.reference_result)
    if compared.experience:
        yield "experience", ", ".join(compared.experience)
    for name, limit in compared.tolerances.items():
        yield "tolerance", f"{name} = {limit:g}"
    if study.timing_repeats:
        yield "timing", f"{study.timing_repeats} warm runs a case"


def _part_lines(part: ScenePart) -> Iterator[tuple[str, str]]:
    yield "scene", f"{part.name}, {part.scene.summary}"
    for name, values in part.varied.items():
        yield "varied", f"{name} = {_span(values)}{_unit(part.parameters[name])}"
    for name, value in part.fixed.items():
        yield "fixed", f"{name} = {value}{_unit(part.parameters[name])}"
    for name, expression in part.derived.items():
        yield "derived", f"{name} = {expression.text}"
    for condition in part.excluded:
        yield "excluded", condition.text


def _laws_of(part: ScenePart) -> set[str]:
    """The laws with parameters of their own that a study names for a scene."""
    varied = part.varied.get(PARAMETER, ())
    named = {part.fixed.get(PARAMETER), *(case.get(PARAMETER) for case in part.listed)}
    named |= set(varied) if isinstance(varied, tuple) else set()
    return {str(name) for name in named if name in laws() and own_parameters(law_class(str(name)))}


def _span(values: Variation) -> str:
    if isinstance(values, Input):
        return f"{{ {values.text} }}"
    if isinstance(values, Range):
        return f"{values.start:g} to {values.stop:g}"
    return ", ".join(map(str, values))


def _unit(definition: Parameter) -> str:
    return "" if definition.unit == "1" else f" {definition.unit}"


LINE_WIDTH = 100
"""Characters of a line in the file that `harness new` writes."""


OWN_GROUND = """\
# Ground by depth, in place of strength, stiffness and stress above; two rows of one depth are a
# border. In place of the arrays: file = "ground.csv".
#[profile]
#"depth [m]" = [0, 3, 3, 12]
#"strength [kPa]" = [40, 15, 25, 45]
#"rigidity_index [1]" = [100, 100, 150, 150]
#"unit_weight [kN/m3]" = [18, 16, 17, 17]
#"K0 [1]" = [1, 0.6, 0.6, 0.6]
#"ground_water [m]" = [1, 1, 1, 1]
"""
OWN_REFERENCE = """\
# A reference of your own: a formula of parameters, or of Ir, alpha_c, alpha_s, Delta; or points.
#[references.our_laboratory]
#formula = "10.5 + 1.5 * alpha_c"
#label = "Our laboratory 2026"
#source = "calibration chamber, unpublished"
#su_mode = "triaxial_compression"
#range = { Ir = [80, 120] }
"""


def study_text(name: str, scene_name: str) -> str:
    """A study in TOML that varies one parameter and shows the other defaults as comments."""
    scene = scene_class(scene_name)
    parameters = own_parameters_of(scene)
    varied, values = _parameter_to_vary(scene)
    method = method_of(scene)
    others = {key: definition for key, definition in parameters.items() if key != varied}
    parts = [
        f"# {scene_name}: {scene.summary}.",
        f"# Run it with `harness run {name}.toml`; the result goes to results/{name}.nc.",
        "# A line that begins with # is a comment. Take the # away from `#name = value` to give a",
        "# value of your own in the place of the default. All values are in SI units.",
        assignment("title", scene.summary),
        assignment("scene", scene_name),
        "",
        "# What varies: a list of values. Of several lists every combination is a case.",
        "# A range of values: { from = 1, to = 100, count = 5 }.",
        "[vary]",
        *template([parameters[varied]], {varied: values}),
        "",
        "# What is the same in all cases. A parameter stands here or under [vary], not in both.",
        "[fixed]",
        *template((it for key, it in others.items() if key not in method), {}),
    ]
    if others.keys() & set(method):
        parts += ["", "# Mesh, steps and extent: a good result does not depend on them."]
        parts += template((it for key, it in others.items() if key in method), {})
    if PROFILE in parameters:
        parts += ["", *OWN_GROUND.splitlines()]
    if takes_references(scene):
        ids = [reference.id for reference in ENVELOPE]
        parts += ["", "# The literature beside its cone factor:"]
        parts += ["#[compare]", f"#{assignment('references', ids)}"]
        parts += ["# and a band of factors measured in the field; others: `harness references`"]
        parts += [f"#{assignment('experience', [next(iter(BANDS))])}"]
        parts += ["", *OWN_REFERENCE.splitlines()]
    return "\n".join([*parts, ""])


def _parameter_to_vary(scene: type[CatalogueScene]) -> tuple[str, list[Value]]:
    """The first parameter for which the scene allows several values; those of the method last."""
    method, known = method_of(scene), own_parameters_of(scene)
    tried = {
        name: [
            it
            for it in _candidates(known[name])
            if complete_parameters(scene, {name: it})[1] is None
        ]
        for name in sorted(known, key=lambda it: it in method)
    }
    return max(tried.items(), key=lambda it: min(len(it[1]), 2))


def _candidates(definition: Parameter) -> list[Value]:
    """Values to try: all choices of a parameter, or its default and half of it.

    Where the default is 0 the greatest allowed value takes the place of the half.
    """
    default = definition.default
    if definition.choices is not None:
        return list(definition.choices)
    if isinstance(default, bool | str) or default is None:
        return []
    if default != 0:
        return [type(default)(default / 2), default]
    greatest = definition.bounds.maximum
    return [default, *([float(greatest)] if math.isfinite(greatest) else [])]


def template(declared: Iterable[Parameter], given: Mapping[str, object]) -> list[str]:
    """A comment on each key, and its value; if none is given, its default or dots as a comment."""
    lines = []
    for it in declared:
        is_open = it.is_required or it.default in (None, {})
        value = "..." if is_open else toml(it.default)
        own = f"{it.name} = {toml(given[it.name])}" if it.name in given else f"#{it.name} = {value}"
        lines += [comment(it.explanation), own]
    return lines


def comment(text: str) -> str:
    """A text as a comment, broken into lines."""
    return textwrap.fill(text, LINE_WIDTH, initial_indent="# ", subsequent_indent="#   ")


def assignment(name: str, value: object) -> str:
    """A key and its value as they stand in a file."""
    return f"{name} = {toml(value)}"


def toml(value: object) -> str:
    """A value in TOML. JSON writes texts, numbers, true and false in the same way."""
    if isinstance(value, dict):
        return "{ " + ", ".join(itertools.starmap(assignment, value.items())) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(toml, value)) + "]"
    return json.dumps(value, ensure_ascii=False)


STRESS_UNITS = {"kPa": 1e3, "MPa": 1e6}
LENGTH_UNITS = {"mm": 1e-3, "cm": 1e-2}
NEVER_A_SLIP = (0.0, 1.0)
"""Values that are never reported: 0 means none, 1 is the unit of a dimensionless study."""


@dataclass(frozen=True)
class Usual:
    """The usual range of a parameter, and other units in which it is often given by mistake."""

    low: float  # in the unit of the parameter, as `high`
    high: float
    units: Mapping[str, float]  # other units: name, and size in the unit of the parameter

    def unit_of(self, value: float) -> str | None:
        """The other unit in which the value would be usual; None if it is usual, or in no unit."""
        if value in NEVER_A_SLIP or self.low <= value <= self.high:
            return None
        return next(
            (unit for unit, size in self.units.items() if self.low <= value * size <= self.high),
            None,
        )

    def unit_of_all(self, values: Iterable[float]) -> str | None:
        """The other unit in which all values would be usual; None if there is no such unit."""
        units = {self.unit_of(value) for value in values}
        return units.pop() if len(units) == 1 else None


USUAL = {
    "undrained_shear_strength": Usual(1e3, 1e6, STRESS_UNITS),
    "in_situ_stress": Usual(1e3, 1e8, STRESS_UNITS),
    "normal_pressure": Usual(1e3, 1e8, STRESS_UNITS),
    "shear_modulus": Usual(1e5, 1e11, STRESS_UNITS),
    "cone_radius": Usual(5e-3, 0.1, LENGTH_UNITS),
    "density": Usual(1000.0, 3000.0, {"t/m3": 1e3, "kN/m3": 1e3 / 9.81}),
}
"""Usual ranges: clays from very soft to hard, offshore and on land; cones of 0.8 to 300 cm2."""
USUAL_BY_DEPTH = {
    "strength": USUAL["undrained_shear_strength"],
    "unit_weight": Usual(1e4, 3e4, {"kN/m3": 1e3}),
}
USUAL_STRESS = Usual(1e3, 1e11, STRESS_UNITS)
"""Usual range of any stress or stiffness of a material law from another package."""
MOST_NAMED = 8
"""Values outside the sane range that a warning lists; it counts the others."""


def warn_of_unusual_values(study: Study) -> None:
    """Warn of values that seem to be in a wrong unit, or with which fewer cases complete."""
    for line in [*unusual_values(study), *outside_sane_range(study)]:
        tell(line)


def outside_sane_range(study: Study) -> list[str]:
    """A line for each parameter with a value outside its sane range: fewer cases complete there."""
    lines = []
    for part in study.parts:
        for name, definition in part.parameters.items():
            least, greatest = definition.sane or (-math.inf, math.inf)
            values = _given(part, name) if definition.sane else []
            beyond = sorted({value for value in values if not least <= value <= greatest})
            if beyond:
                named = ", ".join(f"{value:g}" for value in beyond[:MOST_NAMED])
                further = f" and {len(beyond) - MOST_NAMED} more" if beyond[MOST_NAMED:] else ""
                lines.append(f"{name} = {named}{further}{_sane_range(definition)}")
    return list(dict.fromkeys(lines))


def unusual_values(study: Study) -> list[str]:
    """A line for each parameter that seems to be in a wrong unit; it says what to give instead."""
    lines = []
    for part in study.parts:
        own = own_parameters_of(part.scene)
        laws = [it for it, one in part.parameters.items() if it not in own and one.unit == "Pa"]
        for name, usual in {**dict.fromkeys(laws, USUAL_STRESS), **USUAL}.items():
            values = _given(part, name)
            if (unit := usual.unit_of_all(values)) is not None:
                lines.append(
                    f"{name} = {values[0]:g} is in {part.parameters[name].unit}; if {values[0]:g} "
                    f"{unit} is meant, give {values[0] * usual.units[unit]:g}"
                )
        columns = columns_of(str(part.fixed[PROFILE])) if PROFILE in part.fixed else {}
        for name, usual in USUAL_BY_DEPTH.items():
            column = columns.get(name, np.array([])).tolist()
            if (unit := usual.unit_of_all(column)) is not None:
                lines.append(
                    f"{PROFILE}: {name} = {column[0]:g} is in {next(iter(units_of(name)))}; if "
                    f"{column[0]:g} {unit} is meant, its column is [{unit}]"
                )
    return list(dict.fromkeys(lines))


def _given(part: ScenePart, name: str) -> list[float]:
    """All values that a study gives to a parameter."""
    varied = part.varied.get(name, ())
    values = [part.fixed[name]] if name in part.fixed else []
    match varied:
        case Range():
            values += [varied.start, varied.stop]
        case Input():
            values += [varied.at(0.05), varied.at(0.95)]
        case _:
            values += varied
    values += [case[name] for case in part.listed if name in case]
    return [float(value) for value in values]
