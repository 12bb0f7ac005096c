"""The HTML page of `harness report`: one file that loads nothing from the network."""

import base64
import itertools
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from matplotlib.figure import Figure

from harness.archive.conventions import (
    COMPLETED,
    HALF_WIDTH,
    Role,
    known_digits,
    over_cases,
    spoken,
    uncertainty_of,
    with_role,
)
from harness.archive.own_files import MAKER, write_own
from harness.archive.provenance import OF_CASE, other_version
from harness.compare.compared import misses, stored_references
from harness.compare.result_table import which_strength
from harness.compare.spread import spread_rows, spreads_of
from harness.errors import counted
from harness.pictures.drawing.caption import SOIL_AND_CONE
from harness.pictures.drawing.plot_parts import image
from harness.pictures.drawing.style import SMALL_DPI
from harness.pictures.method.stability import shows_stability, stability_rows
from harness.pictures.pictures import Failures, rendered
from harness.pictures.studied import Studied
from harness.references.reference import COMPARED
from harness.report import words
from harness.report.tables import case_columns, case_parameters, comparisons

TEMPLATES = Environment(
    loader=FileSystemLoader(Path(__file__).parent),
    autoescape=True,  # markup in texts of a result must not become part of the page
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)


@dataclass(frozen=True)
class Picture:
    """A picture in the page."""

    name: str
    address: str  # data URL of the PNG


def write_report(datasets: Sequence[xr.Dataset], path: Path) -> Failures:
    """Write the page; return the errors of pictures that could not be drawn and are left out."""
    text, failed = page(datasets)
    write_own(text.encode(), path)
    return failed


def page(datasets: Sequence[xr.Dataset]) -> tuple[str, Failures]:
    """The page as text, and the errors of pictures that could not be drawn."""
    # Small pictures are for the summary, which only a page on several studies has.
    sections = [
        _section(place, dataset, has_small=len(datasets) > 1)
        for place, dataset in enumerate(datasets, start=1)
    ]
    text = TEMPLATES.get_template("page.html").render(
        maker=MAKER, sections=sections, comparisons=comparisons(list(datasets))
    )
    return text, {
        f"{section['study']}_{name}": error
        for section in sections
        for name, error in section["failed"].items()
    }


def _drawn(
    dataset: xr.Dataset, *, has_small: bool
) -> tuple[list[Picture], list[Picture], Failures]:
    """The pictures of a study, the main one small, and the errors of those that are left out."""
    small: list[bytes] = []

    def render(figure: Figure) -> bytes:
        if has_small and not small:
            small.append(image(figure, dpi=SMALL_DPI))
        return image(figure)

    drawn, failed = rendered(dataset, render)
    pictures = list(itertools.starmap(embedded, drawn.items()))
    return pictures, list(map(embedded, drawn, small)), failed


def _section(place: int, dataset: xr.Dataset, *, has_small: bool) -> dict[str, Any]:
    """The variables of page.html for one study."""
    pictures, small, failed = _drawn(dataset, has_small=has_small)
    columns, parameters = case_columns(dataset), case_parameters(dataset)
    completed = (over_cases(dataset, "status") == COMPLETED).tolist()
    return {
        "anchor": f"study-{place}",
        "title": str(dataset.attrs.get("title", dataset.attrs["study"])),
        "study": str(dataset.attrs["study"]),
        "scene": str(dataset.attrs["scene"]).replace(" ", ", "),
        "summary": _summary(dataset),
        "other_version": other_version(dataset),
        "stands_on": _stands_on(dataset, parameters["fixed"]),
        "small": small,
        "pictures": pictures,
        "failed": failed,
        "missed": misses(dataset),
        "stability": stability_rows(dataset) if shows_stability(dataset) else [],
        "spreads": [(spoken(spread.name), spread_rows(spread)) for spread in spreads_of(dataset)],
        "columns": columns,
        "rows": list(
            zip(completed, zip(*(column.cells for column in columns), strict=True), strict=True)
        ),
        "parameters": parameters,
        "half_width": HALF_WIDTH if with_role(dataset, Role.UNCERTAINTY) else "",
        "references": [
            (it.label, it.text, it.definition, it.validity, it.source, it.how_known)
            for it in stored_references(dataset)
        ],
        "provenance": list(_provenance(dataset)),
    }


def _stands_on(dataset: xr.Dataset, parameters: Iterable[tuple[str, str, str]]) -> str:
    """Sentences on which strength is meant, and on the soil and cone of all cases."""
    fixed = [
        " ".join(filter(None, (spoken(name), value, unit)))
        for name, value, unit in parameters
        if name in SOIL_AND_CONE
    ]
    strength = f"Strength: {which_strength(dataset)}." if COMPARED in dataset else ""
    in_all = f"In all cases: {', '.join(fixed)}." if fixed else ""
    return " ".join(filter(None, (strength, in_all)))


def _summary(dataset: xr.Dataset) -> str:
    """The number of cases, how many did not complete, and the range of the headline, in words."""
    status = over_cases(dataset, "status")
    lost = int(np.sum(status != COMPLETED))
    parts = [counted(status.size, "case")]
    parts += [f"{lost} not completed"] if lost else []
    studied = Studied.of(dataset)
    if studied is not None and np.isfinite(studied.computed).any():
        half_widths = uncertainty_of(dataset)
        ends = (np.nanargmin(studied.computed), np.nanargmax(studied.computed))
        known = [known_digits(studied.computed[end], half_widths[end]) for end in ends]
        range_text = " to ".join(dict.fromkeys(known))
        unit = words.unit(dataset, studied.headline)
        parts.append(f"{words.title(dataset, studied.headline)} {range_text} {unit}".rstrip())
    return "; ".join(parts)


def embedded(name: str, png: bytes) -> Picture:
    """A picture with its image as a data URL."""
    data = base64.b64encode(png).decode("ascii")
    return Picture(name.replace("_", " "), f"data:image/png;base64,{data}")


def _provenance(dataset: xr.Dataset) -> Iterable[tuple[str, str]]:
    yield from ((str(name), str(value)) for name, value in dataset.attrs.items())
    for name in OF_CASE:
        if name in dataset:  # it differs between cases
            yield name, "; ".join(sorted({*map(str, dataset[name].values.flat)} - {""}))
