"""Captions of pictures: what is shown, and which parameters are fixed."""

import math
from collections import Counter
from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.archive.conventions import (
    COMPLETED,
    DERIVED_BY,
    NUMERICAL,
    is_there,
    largest_parts_of,
    over_cases,
    parameter_names,
    reasons_of,
    scenes_of,
    uncertainty_of,
    varied_names,
    words_of,
)
from harness.compare.defaults import defaults_of_law, not_by_default
from harness.pictures.drawing.plot_parts import legend_above
from harness.pictures.drawing.quantities import (
    Values,
    assigned,
    in_words,
    plain,
    quantity,
    shortened,
    symbol,
    wrapped,
)
from harness.pictures.drawing.style import LETTERS
from mpm_warp.scenes import scene_names
from mpm_warp.scenes.sounding.table import PROFILE, columns_of

UPRIGHT = 32
"""Number of letters in a line of the label of an upright axis."""
LINE = 0.12
"""Height of a line [inch]."""
MOST_FIXED = 14
"""Largest number of parameters that a caption names."""
MOST_TEXTS = 4
"""Largest number of long texts that a caption explains."""
LONGEST = 300
"""Number of letters of the longest title, or other text, that a caption gives in full."""
MISSING_NUMBERS = "missing_numbers"
"""Attribute of a result that is drawn: a sentence on numbers that are left out."""
NO_BREAK = "\N{NO-BREAK SPACE}"
"""Keeps a symbol and its value on one line."""
SOIL_AND_CONE = (
    "rigidity_index",
    "adhesion_factor",
    "friction_coefficient",
    "apex_angle",
    "poissons_ratio",
    "stress_anisotropy",
    "material",
)
"""Parameters that a caption always gives, because results depend on them most."""


def caption(figure: Figure, text: str) -> None:
    """Write a text below a figure, in lines as wide as it."""
    lines = wrapped(text, int(LETTERS * figure.get_figwidth()))
    figure.supxlabel(lines, x=0.01, ha="left")


def captioned(
    figure: Figure, dataset: xr.Dataset, *sentences: str, legend: Axes | None = None
) -> Figure:
    """Add a caption below a figure, and the legend of axes above it.

    The caption has the title of the study, the sentences, and the fixed parameters. Empty sentences
    are left out. The figure becomes higher if long texts need a key.
    """
    for axes in figure.axes:
        axes.set_ylabel(wrapped(axes.get_ylabel(), UPRIGHT))
    if legend is not None:
        legend_above(figure, legend)
    title = plain(shortened(str(dataset.attrs.get("title", "")), LONGEST)).rstrip(".")
    ended = title if title.endswith(("?", "!")) or not title else f"{title}."
    key = " ".join(_numbered(dataset))
    missing = dataset.attrs.get(MISSING_NUMBERS, "")
    parts = [ended, *sentences, missing, key, _derived(dataset), fixed(dataset)]
    lines = math.ceil(len(key) / (LETTERS * figure.get_figwidth()))
    figure.set_figheight(figure.get_figheight() + LINE * lines)
    caption(figure, " ".join(filter(None, parts)))
    return figure


def _numbered(dataset: xr.Dataset) -> Iterator[str]:
    """Sentences that explain the numbers which replace long texts."""
    for name in varied_names(dataset):
        if long := Values.of(dataset, name).long:
            key = "; ".join(
                f'{place}: "{plain(shortened(text, LONGEST))}"'
                for place, text in enumerate(long, 1)
            )
            text = key if len(long) <= MOST_TEXTS else "numbered in the order of cases"
            yield f"{in_words(name).capitalize()} is {text}."


def _derived(dataset: xr.Dataset) -> str:
    """A sentence on the parameters that the study derives from those it varies."""
    given = [
        f"{symbol(name) or in_words(name)} = {plain(it.attrs[DERIVED_BY])}"
        for name, it in dataset.coords.items()
        if DERIVED_BY in it.attrs
    ]
    return f"Derived: {', '.join(given)}." if given else ""


def left_out(count: int, noun: str) -> str:
    """A sentence on how many items are not shown; "" if there are none."""
    return f"{count} more {noun} are not shown." if count else ""


def not_completed(dataset: xr.Dataset) -> str:
    """A sentence on how many cases did not complete; "" if all did."""
    status = over_cases(dataset, "status")
    failed = np.count_nonzero(status != COMPLETED)
    return f"{failed} of {status.size} cases did not complete." if failed else ""


def of_half_widths(dataset: xr.Dataset, holds: str, *, are_shown: bool) -> str:
    """Sentences on what error bars or bands mean, and why some cases have none.

    `holds` is the beginning of the first one, "Bands hold the resistance"; without bars or bands in
    the picture it is left out.
    """
    meaning = f"{holds} with 95 %: {NUMERICAL}." if are_shown else ""
    reasons = reasons_of(dataset)
    words, (_, _, sentence) = words_of(reasons), next(filter(None, reasons), "").partition(": ")
    if len(set(filter(None, reasons))) > 1:  # they apply to different depths
        sentence = sentence.partition(", from ")[0]
    where = "Where there is none" if are_shown else "There are no half widths:"
    why = f" the error is not known: {words}" if words else ""
    if sentence and "," not in words:  # a single reason is given in full
        why = f"{':' if are_shown else ''} {sentence.partition(', but ')[0]}"
    without = f"{where}{why}." if why else ""
    others = [largest_parts(dataset), _not_measured(dataset)] if are_shown else []
    return " ".join(filter(None, [meaning, without, *others]))


def largest_parts(dataset: xr.Dataset) -> str:
    """A sentence on the part of U that is the largest, in the most cases; "" if none is known."""
    parts = Counter(text.partition(",")[0] for text in largest_parts_of(dataset) if text)
    texts = [f"{part} in {count}" for part, count in parts.most_common()]
    if len(parts) == 1:
        texts = [*parts]
    return f"Largest part of U: {', '.join(texts)}." if parts else ""


def _not_measured(dataset: xr.Dataset) -> str:
    """A sentence on scenes that have neither a half width nor a reason for its absence."""
    silent = np.isnan(uncertainty_of(dataset)) & (np.array(reasons_of(dataset)) == "")
    silent &= over_cases(dataset, "status") == COMPLETED
    names = plain(" and ".join(dict.fromkeys(np.array(scenes_of(dataset))[silent].tolist())))
    return f"The error of {names} was not measured." if names else ""


def fixed(dataset: xr.Dataset) -> str:
    """A sentence on the parameters that are the same in all cases.

    It gives the most important ones, and all that differ from the scene's defaults.
    """
    names = list(_fixed_names(dataset))
    texts = (assigned(dataset, name, dataset[name].item()) for name in names[:MOST_FIXED])
    shown = [text.replace(" ", NO_BREAK) for text in (*texts, *_by_depth(dataset))]
    scene = plain(dataset.attrs.get("scene", ""))
    rest = f"all else as by default in {scene}" if scene in scene_names() else ""
    return f"Fixed: {', '.join(filter(None, [*shown, rest]))}." if shown or rest else ""


def _by_depth(dataset: xr.Dataset) -> Iterator[str]:
    """The ranges of the most important quantities in a profile that all cases have."""
    text = dataset[PROFILE].item() if PROFILE in dataset and not dataset[PROFILE].ndim else ""
    columns = columns_of(text) if text else {}
    if "shear_modulus" in columns and "strength" in columns:
        columns["rigidity_index"] = columns["shear_modulus"] / columns["strength"]
    for name in SOIL_AND_CONE:
        if name in columns:
            low, high = (quantity(float(end)) for end in np.percentile(columns[name], [0, 100]))
            span = low if low == high else f"{low} to {high}"
            yield f"{symbol(name)} = {span} by the profile"


def _fixed_names(dataset: xr.Dataset) -> Iterator[str]:
    """The variables of the dataset that a caption gives as fixed."""
    constant = {
        name: own
        for name, own in parameter_names(dataset).items()
        if dataset[own].ndim == 0 and is_there(dataset[own].item())
    }
    constant.pop(PROFILE, None)  # a caption has no room for a table
    others = [name for name in not_by_default(dataset) if name in constant]
    main = [name for name in SOIL_AND_CONE if name in constant]
    main += [name for name in defaults_of_law(dataset) if name in others]
    yield from (constant[name] for name in dict.fromkeys([*main, *others]))
