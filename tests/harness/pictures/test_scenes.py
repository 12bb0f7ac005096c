"""Several scenes in the same soils: a row for each soil, and which results have such rows."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.container import ErrorbarContainer

from harness.pictures.cases import scenes_figure
from harness.report.tables import case_columns
from mpm_warp.results import labelled
from tests.harness.pictures.conftest import caption_of, figures, texts

CASE = ("case",)
SCENES = ["cone_penetration", "cone_penetration", "t_bar_penetration", "t_bar_penetration"]
CONES, BARS = [11.3, 10.5], [10.8, 8.4]


def cones_and_bars(adhesion_of_bars: list[float], unit: str = "1") -> xr.Dataset:
    """Two cones at adhesion factor 0 and 0.5, and two T-bars; a half width is known of cones."""
    nan = np.nan
    headlines = labelled(
        dims=CASE, role="headline", cone_factor=([*CONES, nan, nan], "1", "cone factor")
    ) | labelled(
        dims=CASE, role="headline", resistance_factor=([nan, nan, *BARS], unit, "resistance factor")
    )
    half_widths = labelled(
        dims=CASE,
        role="uncertainty",
        cone_factor_uncertainty=([0.1, 0.2, nan, nan], "1", "uncertainty"),
    )
    coordinates = {
        "scene": (CASE, SCENES),
        "adhesion_factor": (CASE, [0.0, 0.5, *adhesion_of_bars]),
        # Alike in all cases of a scene, so no name of a row.
        "particles_per_cell": (CASE, [4, 4, 9, 9]),
    }
    made = xr.Dataset(headlines | half_widths, coords=coordinates)
    return made.assign(status=(CASE, ["completed"] * 4))


def test_each_soil_is_a_row_with_the_result_of_each_scene() -> None:
    """In whatever order a scene has the soils."""
    (axes,) = scenes_figure(cones_and_bars([0.5, 0.0])).axes
    marks = [it for it in axes.containers if isinstance(it, ErrorbarContainer)]
    drawn = [np.asarray(it.lines[0].get_xdata()).tolist() for it in marks]
    assert drawn == [CONES, BARS[::-1]]
    assert texts(axes.get_yticklabels()) == [r"$α$ = 0", r"$α$ = 0.5"]
    assert axes.get_xlabel().endswith("resistance factor [-]")


def test_no_half_width_stands_in_a_table_where_the_value_is_missing() -> None:
    cells = {it.title: it.cells for it in case_columns(cones_and_bars([0.5, 0.0]))}
    assert cells["cone factor"] == ["11.30 ± 0.10", "10.5 ± 0.2", "-", "-"]
    assert cells["resistance factor"] == ["-", "-", "10.8", "8.40"]


def test_a_case_that_did_not_complete_is_told_of() -> None:
    dataset = cones_and_bars([0.0, 0.5])
    dataset["status"] = CASE, ["completed", "completed", "completed", "diverged"]
    told = caption_of(scenes_figure(dataset))
    assert "1 of 4 cases did not complete." in told
    assert "scenes" in figures(dataset)


def test_the_caption_tells_what_was_not_measured_and_what_is_no_default() -> None:
    made = cones_and_bars([0.0, 0.5]).assign(ductility=((), 10.0, {"role": "parameter"}))
    told = caption_of(scenes_figure(made))
    assert "The error of t_bar_penetration was not measured." in told
    assert told.endswith(r"Fixed: $ξ_{\mathrm{95}}$ = 10.")


@pytest.mark.parametrize(
    "dataset",
    [
        cones_and_bars([0.0, 1.0]),
        cones_and_bars([0.0, 0.0]),
        cones_and_bars([0.0, 0.5], unit="Pa"),
        cones_and_bars([0.0, 0.5]).isel(case=[0, 1]),
    ],
    ids=["other soils", "a soil twice", "other units", "one scene"],
)
def test_scenes_that_share_no_rows_have_no_such_picture(dataset: xr.Dataset) -> None:
    assert scenes_figure(dataset) is None
