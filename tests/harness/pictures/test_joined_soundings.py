"""Stretches joined to one sounding, with their difference in the half width."""

import numpy as np
import xarray as xr

from harness.pictures.sounding import joined, shows_sounding

DEPTH = np.arange(1.0, 7.0)


def cut(values: list[list[float]], half_width: float = 3.0) -> xr.Dataset:
    """A result of two stretches for each of some adhesion factors, with made-up resistances."""
    resistance = np.array(values).reshape(-1, 2, DEPTH.size)
    dims = ("adhesion_factor", "stretch_number", "depth")
    width = np.where(np.isnan(resistance), np.nan, half_width)
    return xr.Dataset(
        {
            "net_resistance": (dims, resistance, {"units": "Pa"}),
            "net_resistance_uncertainty": (dims, width),
            "strength": (dims, resistance / 10.0),
            "status": (dims[:2], np.full(resistance.shape[:2], "completed")),
        },
        coords={
            "depth": DEPTH,
            "stretch_number": ("stretch_number", [1, 2], {"role": "parameter"}),
            "adhesion_factor": (
                "adhesion_factor",
                np.linspace(0.0, 1.0, len(resistance)),
                {"role": "parameter"},
            ),
        },
        attrs={"design": "full"},
    )


NAN = np.nan
ONE = [[10.0, 10.0, 14.0, 10.0, NAN, NAN], [NAN, NAN, 6.0, 10.0, 20.0, 20.0]]


def test_an_overlap_is_the_mean_and_widens_the_uncertainty_by_half_its_difference() -> None:
    """Halves of the differences of 8 and 0: a root mean square of 4 / sqrt(2)."""
    result = cut(ONE)
    assert shows_sounding(result)
    one = joined(result).isel(sounding=0)
    np.testing.assert_allclose(one.net_resistance, [10.0, 10.0, 10.0, 10.0, 20.0, 20.0])
    half = 4.0 / np.sqrt(2.0)
    np.testing.assert_allclose(one.overlap_difference, [0.0, 0.0, half, half, 0.0, 0.0])
    widened = np.hypot(3.0, half)
    expected = [3.0, 3.0, widened, widened, 3.0, 3.0]
    np.testing.assert_allclose(one.net_resistance_uncertainty, expected)
    assert one.net_resistance.attrs["units"] == "Pa"


def test_soundings_stay_apart() -> None:
    """Each value of another parameter is a sounding of its own, known by its first case."""
    both = joined(cut([*ONE, *(np.array(ONE) * 2.0).tolist()]))
    assert both.sizes["sounding"] == 2
    np.testing.assert_allclose(both.net_resistance[1], 2.0 * both.net_resistance[0])
    np.testing.assert_array_equal(both["case"], [0, 2])


def test_a_result_without_stretches_is_itself() -> None:
    whole = cut(ONE).isel(stretch_number=0, drop=True)
    one = joined(whole).isel(sounding=0)
    np.testing.assert_allclose(one.net_resistance, whole.net_resistance[0])
    np.testing.assert_array_equal(one.overlap_difference, 0.0)


def test_where_no_error_is_known_there_is_no_half_width() -> None:
    unknown = cut(ONE).drop_vars("net_resistance_uncertainty")
    assert np.isnan(joined(unknown).net_resistance_uncertainty).all()
