"""Hatched bands of experience behind the points of a picture."""

from typing import cast

import pytest
import xarray as xr
from matplotlib.patches import Rectangle

from harness.compare.compared import with_experience
from harness.pictures.drawing.literature import draw_experience
from harness.pictures.drawing.plot_parts import empty_figure

IDS = ("karlsrud_2005", "karlsrud_2005_pore_pressure", "mayne_peuchen_2018")


def test_bands_of_the_cone_factor_are_hatched_and_named(two_soils: xr.Dataset) -> None:
    figure, axes = empty_figure()
    draw_experience(axes, with_experience(two_soils, IDS))
    figure.draw_without_rendering()
    wide, narrow = cast("list[Rectangle]", list(axes.patches))
    bounds = wide.get_y(), wide.get_y() + wide.get_height()
    assert bounds == pytest.approx((6.17, 18.07), abs=0.005)
    assert wide.get_hatch() != narrow.get_hatch()
    assert wide.get_facecolor()[3] == 0.0
    assert not axes.lines
    assert axes.get_legend_handles_labels()[1] == [
        "experience, Karlsrud et al. 2005: Nkt 6.2 to 18.1, su peak in triaxial compression",
        "experience, Mayne & Peuchen 2018: Nkt 10.1 to 13.7, su peak in triaxial compression",
    ]


def test_without_experience_nothing_is_drawn(two_soils: xr.Dataset) -> None:
    _, axes = empty_figure()
    draw_experience(axes, two_soils)
    assert not axes.patches
