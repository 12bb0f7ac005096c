"""The caption of a picture: what it shows, and what was fixed."""

import math
import re
import textwrap
from collections.abc import Iterator

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from harness.archive.conventions import (
    COMPLETED,
    NUMERICAL,
    is_there,
    over_cases,
    parameter_names,
    reasons_of,
    scenes_of,
    spoken,
    uncertainty_of,
    varied_names,
    words_of,
)
from harness.compare.defaults import defaults_of_law, not_by_default
from harness.pictures.drawing.plot_parts import legend_above
from harness.pictures.drawing.quantities import Values, assigned, plain, quantity, spelt, symbol
from mpm_warp.scenes import scene_names
from mpm_warp.scenes.sounding.table import PROFILE, columns_of

LETTERS = 112
"""Letters of a line of the caption, which is as wide as the page."""
LINE = 0.126
"""Height of a line [inch]."""
MOST_FIXED = 14
"""Parameters that a caption names."""
MOST_TEXTS = 4
"""Long texts that a caption has room for."""
SYMBOL, IN_PLACE = re.compile(r"(?<!\\)\$[^$]*(?<!\\)\$"), "\ue000--"
"""A symbol in mathematics, and what holds its place while lines are wrapped."""
NO_BREAK = "\N{NO-BREAK SPACE}"
"""Between a symbol and its value: they stay on one line."""
SOIL_AND_CONE = (
    "rigidity_index",
    "adhesion_factor",
    "friction_coefficient",
    "apex_angle",
    "poissons_ratio",
    "stress_anisotropy",
    "material",
)
"""Parameters that a caption names even where they are the defaults: results depend on them most."""


def captioned(
    figure: Figure, dataset: xr.Dataset, *sentences: str, legend: Axes | None = None
) -> Figure:
    """A figure with what it shows, and what was fixed, below it; with the legend of axes above.

    Empty sentences are left out. For the key of long texts the figure is higher.
    """
    if legend is not None:
        legend_above(figure, legend)
    title = plain(dataset.attrs.get("title", "")).rstrip(".")
    ended = title if title.endswith(("?", "!")) or not title else f"{title}."
    key = " ".join(_numbered(dataset))
    parts = [ended, *sentences, key, fixed(dataset)]
    figure.set_figheight(figure.get_figheight() + LINE * math.ceil(len(key) / LETTERS))
    text = _wrapped(" ".join(filter(None, parts)))
    figure.supxlabel(text, x=0.01, ha="left", fontsize=7, color="0.2", linespacing=1.3)
    return figure


def _numbered(dataset: xr.Dataset) -> Iterator[str]:
    """What numbers stand for in the place of long texts, in sentences."""
    for name in varied_names(dataset):
        if long := Values.of(dataset, name).long:
            key = "; ".join(f'{place}: "{plain(text)}"' for place, text in enumerate(long, 1))
            told = f"is {key}" if len(long) <= MOST_TEXTS else "is numbered in the order of cases"
            yield f"{plain(spelt(spoken(name))).capitalize()} {told}."


def left_out(count: int, noun: str) -> str:
    """How many of something have no room in a picture, in a sentence."""
    return f"{count} more {noun} are not shown." if count else ""


def of_half_widths(dataset: xr.Dataset, holds: str, *, are_shown: bool) -> str:
    """What bars or bands are, and why there is none of some cases, in sentences.

    `holds` says which they are, and of what: "Bands hold the resistance".
    """
    meant = f"{holds} with 95 %: {NUMERICAL}." if are_shown else ""
    reasons = reasons_of(dataset)
    words, (_, _, sentence) = words_of(reasons), next(filter(None, reasons), "").partition(": ")
    if len(set(filter(None, reasons))) > 1:  # each with depths of its own
        sentence = sentence.partition(", from ")[0]
    where = "Where there is none" if are_shown else "There are no half widths:"
    why = f" the error is not known: {words}" if words else ""
    if sentence and "," not in words:  # there is room for the whole of one reason
        why = f"{':' if are_shown else ''} {sentence.partition(', but ')[0]}"
    without = f"{where}{why}." if why else ""
    return " ".join(filter(None, [meant, without, _not_measured(dataset) if are_shown else ""]))


def _not_measured(dataset: xr.Dataset) -> str:
    """Which scenes have neither a half width nor a reason for none, in a sentence."""
    silent = np.isnan(uncertainty_of(dataset)) & (np.array(reasons_of(dataset)) == "")
    silent &= over_cases(dataset, "status") == COMPLETED
    names = plain(" and ".join(dict.fromkeys(np.array(scenes_of(dataset))[silent].tolist())))
    return f"The error of {names} was not measured." if names else ""


def fixed(dataset: xr.Dataset) -> str:
    """The parameters that are the same in all cases, in a sentence.

    Those that matter most are named, and all that differ from the scene's defaults.
    """
    names = list(_fixed_names(dataset))
    texts = (assigned(dataset, name, dataset[name].item()) for name in names[:MOST_FIXED])
    shown = [text.replace(" ", NO_BREAK) for text in (*texts, *_by_depth(dataset))]
    scene = plain(dataset.attrs.get("scene", ""))
    rest = f"all else by the defaults of {scene}" if scene in scene_names() else ""
    return f"Fixed: {', '.join(filter(None, [*shown, rest]))}." if shown or rest else ""


def _by_depth(dataset: xr.Dataset) -> Iterator[str]:
    """What resistance depends on most of a profile that all cases have: from least to greatest."""
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
    """What they are called in the dataset."""
    constant = {
        name: own
        for name, own in parameter_names(dataset).items()
        if dataset[own].ndim == 0 and is_there(dataset[own].item())
    }
    constant.pop(PROFILE, None)  # a table has no room in a caption
    others = [name for name in not_by_default(dataset) if name in constant]
    main = [name for name in SOIL_AND_CONE if name in constant]
    main += [name for name in defaults_of_law(dataset) if name in others]
    yield from (constant[name] for name in dict.fromkeys([*main, *others]))


def _wrapped(text: str) -> str:
    """Lines of a page's width; a symbol is as wide as its few letters."""
    symbols = iter(SYMBOL.findall(text))
    # Each symbol is wrapped as a word of its own length, then put back.
    lines = textwrap.fill(SYMBOL.sub(IN_PLACE, text), LETTERS, break_on_hyphens=False)
    return re.sub(IN_PLACE, lambda _: next(symbols), lines)
