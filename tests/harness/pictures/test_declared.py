"""Curves that say where they are drawn: what a file keeps of it."""

from pathlib import Path

import numpy as np
import pytest

from harness.archive.netcdf_files import read_netcdf, write_netcdf
from mpm_warp.results import Drawn, curves

PLACES = [
    Drawn(picture="load"),
    Drawn(picture="load", panel=2, over="mean", divided_by="strength", downward=True),
    Drawn(picture="load", as_marks=True, to_rest=True, slope="ratio", joined_over="part"),
    None,
]


@pytest.mark.parametrize("place", PLACES)
def test_the_file_of_a_result_keeps_where_a_curve_is_drawn(
    place: Drawn | None, tmp_path: Path
) -> None:
    load = np.array([1.0, 2.0]), "Pa", "load"
    axis = np.array([0.0, 1.0]), "s", "time"
    made = curves("time", axis, load=load if place is None else (*load, "measured", place))
    write_netcdf(made, tmp_path / "x.nc")
    kept = read_netcdf(tmp_path / "x.nc")["load"]
    assert Drawn.of(kept) == place
    assert kept.attrs["long_name"] == "load"
    assert kept.attrs.get("description") == (place and "measured")
