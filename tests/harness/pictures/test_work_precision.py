"""Error against run time, as a picture."""

from __future__ import annotations

import numpy as np
import xarray as xr

from harness.pictures.pictures import figures
from harness.pictures.work_precision import study_figure


def test_picture_marks_the_front_and_the_failure(two_soils: xr.Dataset) -> None:
    (axes,) = study_figure(two_soils).axes
    labels = [text.get_text() for text in axes.get_legend().get_texts()]
    assert labels == ["cases", "cone_penetration, Pareto front: cells per radius", "failed"]
    front = axes.lines[1].get_xydata()
    np.testing.assert_allclose(front, [[1.0, 11.0 / 10.1 - 1.0], [2.0, 0.02]], rtol=1e-12)


def test_pictures_of_a_result_with_finest_error(two_soils: xr.Dataset) -> None:
    assert set(figures(two_soils)) == {"cone_factor", "work_precision"}


def test_each_scene_of_several_has_its_own_front() -> None:
    dataset = xr.Dataset(
        {
            "error": ("case", [0.1, 0.01, 0.5, 0.3]),
            "run_time": ("case", [1.0, 2.0, 1.5, 3.0]),
            "status": ("case", ["completed"] * 4),
        },
        coords={
            "case": range(4),
            "scene": ("case", ["thick_cylinder"] * 2 + ["cavity_sphere"] * 2),
            "cells_per_radius": ("case", [np.nan, np.nan, 4.0, 8.0]),
        },
    )
    (axes,) = study_figure(dataset).axes
    fronts = [line.get_xydata() for line in axes.lines[1:]]
    np.testing.assert_allclose(fronts, [[[1, 0.1], [2, 0.01]], [[1.5, 0.5], [3, 0.3]]])
