"""The references and bands that ship: a row of a table for each entry of the file."""

import itertools
import math
from typing import Any

import numpy as np
import pytest
import xarray as xr

from harness.references.band import Band, Factor
from harness.references.listing import WIDTH, all_entries, one_entry
from harness.references.reference import (
    USUAL,
    Reference,
)
from harness.references.registry import BANDS, ENVELOPE, REFERENCES, envelope, envelope_applies
from harness.references.strength import Conditions, Criterion, Quantity, StrengthMode, of_law
from mpm_warp.scenes.catalogue import scene_class
from tests.harness.conftest import Command, Refusal

IN_ENVELOPE = ("lu_2004", "teh_houlsby_1991", "yu_2000")
"""Their values were given to two decimals; all others are by hand."""
CHECKED = """
lu_2004               |  9.66     10.77     12.53     13.34    | 1.3   0  -1.9  | tresca     | not_stated
teh_houlsby_1991      |  8.35      9.72     12.51     14.43    | 2.4 -0.2 -1.8  | von_mises  | triaxial_compression
yu_2000               |  8.15      9.54     11.74     12.76    | 2.37  0  -1.83 | von_mises  | not_stated
vesic_1977            | 9.119364 10.043560 11.508377 12.189477 | 0     0   0    | not_stated | not_stated
ladanyi_johnston_1974 | 6.549364  7.473560  8.938377  9.619477 | 1.732051 0 0   | not_stated | not_stated
baligh_1985           | 9.334046 10.720340 12.917565 13.939216 | 0     0   0    | not_stated | not_stated
yu_1993               | 8.532250  9.332835 10.601732 11.191736 | 0     0   0    | von_mises  | not_stated
abu_farsakh_2003      | 9.491641 10.739306 12.716808 13.636295 | 0     0  -2.1  | modified_cam_clay | not_stated
this_project          | 9.168674 10.660326 13.024540 14.123837 | 1.36 0.1 -2.11 | tresca     | pure_shear
"""  # noqa: E501
"""Nc of a smooth cone at Ir 50, 100, 300 and 500 (ln 3.912023, 4.605170, 5.703782, 6.214608); what
adhesion factor 1 of the face, of the shaft, and Delta 1 add; yield criterion; mode of su."""
ROWS = (row.split("|") for row in CHECKED.strip().splitlines())
VALUES = {name.strip(): cells for name, *cells in ROWS}
BOUNDS = {
    # 0.7 (7.8 + 0.1979531 + 0.82), 1.3 (7.8 + 1.9983514 + 4.1)
    "karlsrud_2005": (6.172567, 18.067857),
    # 0.85 (8.5 + 0.1979531), 1.15 (8.5 + 1.9983514)
    "karlsrud_2005_sensitive": (7.393260, 12.073104),
    # 10.5 - 4.6 ln 1.1, 10.5 - 4.6 ln 0.5
    "mayne_peuchen_2018": (10.061573, 13.688477),
    "mayne_peuchen_2018_all": (8.0, 25.0),
    # 0.85 (6.9 - 3.1973622 + 0.7), 1.15 (6.9 - 0.3167250 + 3.5)
    "karlsrud_2005_pore_pressure": (3.742242, 11.595766),
    # 0.85 (9.8 - 3.5970325), 1.15 (9.8 - 0.3563156)
    "karlsrud_2005_pore_pressure_sensitive": (5.272522, 10.860237),
}
"""By hand: log10 of 1.2 and 6.3 are 0.0791812 and 0.7993405, ln of 0.5 and 1.1 -0.6931472 and
0.0953102."""
POINTS = "steady_flow_elements"
"""Values of its own at single points, each within 0.17 of the truth by its page."""
FORMULAS = {name: it for name, it in REFERENCES.items() if it.formula is not None}
each_reference = pytest.mark.parametrize("reference", FORMULAS.values(), ids=FORMULAS)
each_band = pytest.mark.parametrize("band", BANDS.values(), ids=BANDS)


def conditions(index: Quantity = 100.0, **others: float) -> Conditions:
    return {**USUAL, "Ir": index, **others}


def test_every_entry_has_a_row_here() -> None:
    assert (*REFERENCES, *BANDS) == (*VALUES, POINTS, *BOUNDS)


@each_reference
def test_a_formula_gives_its_values_and_slopes_and_says_which_su(reference: Reference) -> None:
    values, slopes, criterion, mode = VALUES[reference.id]
    smooth = reference.evaluate(conditions(np.array([50.0, 100.0, 300.0, 500.0])))
    rounding = 0.00501 if reference.id in IN_ENVELOPE else 1e-6
    np.testing.assert_allclose(smooth, [*map(float, values.split())], rtol=0, atol=rounding)
    at_start = reference.evaluate(conditions())
    for symbol, slope in zip(("alpha_c", "alpha_s", "Delta"), slopes.split(), strict=True):
        change = reference.evaluate(conditions(**{symbol: 1.0})) - at_start
        assert float(change) == pytest.approx(float(slope), abs=1e-6)
    assert reference.criterion is Criterion(criterion.strip())
    assert reference.su_mode is StrengthMode(mode.strip())


def test_points_of_another_method_agree_with_the_fit_to_this_one() -> None:
    """All cases are within 0.15 of the fit, by what it says of itself."""
    points, fit = REFERENCES[POINTS], REFERENCES["this_project"]
    assert (points.criterion, points.su_mode) == (fit.criterion, fit.su_mode)
    for row in zip(*points.points.values(), strict=True):
        at = conditions(**dict(zip(points.points, row, strict=True)))
        assert bool(points.applies(at))
        assert float(points.evaluate(at)) == row[-1]
        assert float(fit.evaluate(at)) == pytest.approx(row[-1], abs=0.17 + 0.15)
    assert math.isnan(points.evaluate(conditions(99.0)))


@each_reference
def test_numbers_arrays_and_labelled_arrays_agree(reference: Reference) -> None:
    indices = np.array([50.0, 100.0, 300.0])
    numbers = [float(reference.evaluate(conditions(it))) for it in indices.tolist()]
    labelled = reference.evaluate(conditions(xr.DataArray(indices, dims="rigidity_index")))
    assert reference.evaluate(conditions(indices)).values.tolist() == numbers
    assert labelled.dims == ("rigidity_index",)
    assert labelled.values.tolist() == numbers


@pytest.mark.parametrize(
    ("name", "case", "applies"),
    [
        ("lu_2004", {"Ir": 50.0, "alpha_c": 1.0}, True),
        ("lu_2004", {"Ir": 500.0}, True),
        ("lu_2004", {"Ir": 49.0}, False),
        ("lu_2004", {"Ir": 501.0}, False),
        ("lu_2004", {"apex_angle": 90.0}, False),
        ("lu_2004", {"friction": 0.1}, False),
        ("lu_2004", {"constant_su": 0.0}, False),
        ("lu_2004", {"Delta": 0.9}, True),
        ("this_project", {"Ir": 20.0}, True),
        ("this_project", {"Delta": -0.5}, True),
        ("this_project", {"Delta": 0.51}, False),
        ("this_project", {"Delta": -0.51}, False),
        ("vesic_1977", {}, True),
        ("vesic_1977", {"alpha_c": 0.5}, False),
    ],
)
def test_where_a_reference_is_valid_and_that_it_has_a_value_elsewhere_too(
    name: str, case: dict[str, float], applies: bool
) -> None:
    given = {**conditions(), **case}
    assert bool(REFERENCES[name].applies(given)) is applies
    assert np.isfinite(REFERENCES[name].evaluate(given))


def test_the_envelope_has_the_criterion_of_the_case() -> None:
    """By hand: su in triaxial compression is sqrt(3)/2 of that in pure shear, Ir 115.4701.

    Teh & Houlsby then give 9.781250; Yu et al. 9.696317, or 10.725340 if their su is in pure shear.
    """
    assert tuple(it.id for it in ENVELOPE) == IN_ENVELOPE
    rough = {"alpha_c": 0.5, "alpha_s": 0.5, **of_law("von_mises")}
    bounds = envelope({**conditions(), **rough})
    np.testing.assert_allclose(bounds, (9.696317, 10.725340), rtol=0, atol=1e-5)
    indices = np.array([25.0, 100.0, 1000.0])
    inside = envelope_applies({**conditions(indices), **rough})
    assert inside.values.tolist() == [False, True, False]


def test_one_reference_is_no_envelope() -> None:
    assert np.isnan(envelope(conditions())).all()
    assert not envelope_applies(conditions())


SPHERE = "4 / 3 * (1 + ln(Ir))"
CYLINDER = "1 + ln(Ir)"


@pytest.mark.parametrize(
    ("formula", "mode", "scene"),
    [
        (SPHERE, StrengthMode.TRIAXIAL_COMPRESSION, "cavity_sphere"),
        (CYLINDER, StrengthMode.PURE_SHEAR, "cavity_cylinder"),
        (CYLINDER, StrengthMode.PLANE_STRAIN, "cavity_cylinder"),
    ],
)
@pytest.mark.parametrize("law", ["tresca", "von_mises"])
def test_limits_of_cavities_by_another_su_are_the_exact_ones(
    formula: str, mode: StrengthMode, scene: str, law: str
) -> None:
    """Soil around a sphere is in triaxial states, around a cylinder in plane strain."""
    entry = {"label": "cavity", "source": "Hill 1950", "formula": formula, "su_mode": mode}
    value = Reference.of("cavity", entry).evaluate({**conditions(), **of_law(law)})
    cavity: Any = scene_class(scene)(rigidity_index=100.0, material=law)
    assert float(value) == pytest.approx(cavity.exact.limit(math.inf), rel=1e-12)


def test_a_test_of_su_that_is_not_stated_has_the_readings_that_differ() -> None:
    yu = REFERENCES["yu_2000"]
    assert yu.readings(conditions()) == (yu,)
    mises = {**conditions(), **of_law("von_mises")}
    shear, compression = yu.readings(mises)
    assert (shear.id, compression.id) == (
        "yu_2000_pure_shear",
        "yu_2000_triaxial_compression",
    )
    # 0.33 + 2 ln 100; 0.8660254 (0.33 + 2 ln 115.4701)
    values = [float(it.evaluate(mises)) for it in (shear, compression)]
    assert values == pytest.approx((9.540340, 8.511315), abs=1e-5)
    assert all(it.applies(mises) and not it.applies(conditions()) for it in (shear, compression))


@each_band
def test_a_band_is_the_one_calculated_by_hand_and_holds_all_within_its_ranges(band: Band) -> None:
    """It is taken from the ends of the ranges alone, so each formula has to be monotonic."""
    low, high = band.bounds
    assert (low, high) == pytest.approx(BOUNDS[band.id], abs=2e-6)
    assert band.band == f"{band.factor} {low:.1f} to {high:.1f}"
    assert (band.factor is Factor.PORE_PRESSURE) == ("pore_pressure" in band.id)
    assert band.su_mode is StrengthMode.TRIAXIAL_COMPRESSION
    assert ("%" in band.spans) == (band.scatter > 0.0)
    for values in itertools.product(*(np.linspace(*ends, 5) for ends in band.range.values())):
        factor = float(band.formula.value(dict(zip(band.range, values, strict=True))))
        assert low <= factor * (1.0 - band.scatter)
        assert factor * (1.0 + band.scatter) <= high


@pytest.mark.parametrize("name", [*REFERENCES, *BANDS])
def test_an_entry_is_told_with_where_it_comes_from(name: str) -> None:
    entry = REFERENCES.get(name) or BANDS[name]
    lines = [*all_entries().splitlines(), *one_entry(entry.id).splitlines()]
    assert max(map(len, lines)) <= WIDTH
    listed, alone = (" ".join(text.split()) for text in (all_entries(), one_entry(entry.id)))
    text = entry.text if isinstance(entry, Reference) else entry.formula.text
    for told in (entry.id, text, entry.source, entry.how_known):
        assert told in listed
        assert told in alone
    if isinstance(entry, Reference):
        only_here = [entry.definition, entry.validity, entry.method]
    else:
        only_here = [
            entry.spans,
            entry.clays,
            entry.holds,
            *(entry.chosen[it] for it in entry.range),
        ]
    assert all(told in alone for told in only_here)
    assert entry.id in {"this_project", POINTS} or "read" in entry.how_known


def test_the_command_prints_them(command: Command) -> None:
    assert command("references").out == f"{all_entries()}\n"
    assert command("references", "yu_2000").out == f"{one_entry('yu_2000')}\n"


@pytest.mark.parametrize(
    ("given", "meant"), [("lu_2005", "lu_2004"), ("karlsrud", "karlsrud_2005")]
)
def test_an_unknown_one_is_one_line(given: str, meant: str, refusal: Refusal) -> None:
    assert refusal(["references", given]).endswith(f"did you mean {meant!r}?")
