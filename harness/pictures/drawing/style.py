"""The style of all pictures: sizes, letters, lines, colours, marks, for print and for grey print.

No other module has numbers of these. What matplotlib has a name for is in ``style.mplstyle``: the
letters of 7 and 8 pt, the lines, the resolution. Widths are those of Elsevier ("Artwork sizing",
elsevier.com: columns of 90, 140 and 190 mm, letters of 7 pt). Colours are after Okabe and Ito,
or a scale by luminance; what must be told apart in grey differs in dashes, marks or hatches too.
"""

from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps, style
from matplotlib.colors import ListedColormap, to_hex

from harness.archive.conventions import COMPLETED, CRASHED, TIMED_OUT, UNFINISHED

STYLED = style.context(Path(__file__).with_name("style.mplstyle"))
"""Decorator of functions that make a figure or its image."""
WIDE, PAGE = 140 / 25.4, 190 / 25.4
"""Width of a picture with a single panel, and of any other [inch]: 1.5 and two columns."""
TALL = 5.2
"""Height of panels that go down the page [inch]."""
LETTERS = 19
"""Letters of 7 pt in an inch of a line."""
SMALL_DPI = 75
"""Resolution of small pictures in the summary of a page [dots per inch]."""

THIN, BOLD = 0.7, 2.5
"""Widths of secondary lines, and of highlighted ones [pt]."""
DOT, LARGE, BAR = 2.5, 7.0, 16.0
"""Sizes of marks: one among many, one around another, and a bar at a text [pt]."""
MARKS, DASHES = "osD^v<>pPXh*", ("-", "--", "-.", ":")
"""Marks and dashes of series, which tell them apart in grey."""
OTHER_DASHES = ((0, (4, 3)), (0, (1, 1.5)), (0, (6, 2, 1, 2)), (0, (10, 2)))
"""Dashes of references beside several series."""
HATCHES = ("///", "\\\\\\", "...", "---")
"""Hatches of bands that may overlap."""
BAND: dict[str, Any] = {"alpha": 0.3, "lw": 0.0}
"""Style of a band around a line."""
FAINT = 0.5
"""Opacity of what has less weight."""

INK, GREY, PALE, PAPER = "black", "0.5", "0.9", "white"
ACCENT, LIGHT = "#0072B2", "#E69F00"
"""A second and a third colour beside ink; they differ in grey."""
FAILED = "#B00020"
"""Colour of cases that failed, and of values that cannot be."""
COLOURS = (
    *(ACCENT, "#D55E00", "#009E73", "#CC79A7", "#56B4E9"),
    *(LIGHT, "#A65628", "#661100", "#332288", "#882255"),
)
"""Colours of things without an order, which colour-blind readers can tell apart."""
STATUSES = {
    COMPLETED: (PALE, ""),
    "inaccurate": (LIGHT, "..."),
    UNFINISHED: ("#56B4E9", "\\\\\\"),
    "diverged": ("#D55E00", "///"),
    "refused": (GREY, "---"),
    TIMED_OUT: (ACCENT, "xxx"),
    CRASHED: ("#882255", "+++"),
    "failed": ("#332288", "ooo"),
}
"""Colour and hatch of each status."""
SHADES = ListedColormap(colormaps["viridis"](np.linspace(0.0, 0.8, 256)))
"""Colours of a scale, by luminance; the lightest can still be seen on paper."""


def series_colour(index: int, count: int) -> str:
    """Colour of a series among `count`, by luminance; black if it is the only one."""
    return INK if count == 1 else shade(index / (count - 1))


def shade(fraction: float) -> str:
    """Colour of a number on the scale `SHADES`, from 0 to 1."""
    return to_hex(SHADES(fraction))
