"""The registry of literature cone factors, against the check values given for it."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from harness.references.cone_factors import (
    CONE_FACTORS,
    Conditions,
    ConeFactor,
    Quantity,
    envelope,
    envelope_applies,
)
from harness.references.registry import REFERENCE_IDS, cone_factor_reference

RIGIDITY_INDICES = (50, 100, 300, 500)
ADHESION_FACTORS = (0, 0.5, 1)
ROUNDING = 0.005 + 1e-9
"""The check values have two decimals."""

CHECK_VALUES = {
    "lu_2004": (
        (9.66, 10.31, 10.96),
        (10.77, 11.42, 12.07),
        (12.53, 13.18, 13.83),
        (13.34, 13.99, 14.64),
    ),
    "teh_houlsby_1991": (
        (8.35, 9.45, 10.55),
        (9.72, 10.82, 11.92),
        (12.51, 13.61, 14.71),
        (14.43, 15.53, 16.63),
    ),
    "yu_2000": (
        (8.15, 9.34, 10.52),
        (9.54, 10.73, 11.91),
        (11.74, 12.92, 14.11),
        (12.76, 13.94, 15.13),
    ),
}

# At rigidity index 100 and adhesion factor 1, by hand: ln 100 = 4.605170.
HAND_VALUES = {
    "vesic_1977": 10.043560,
    "ladanyi_johnston_1974": 9.205611,
    "baligh_1985": 10.720340,
    "yu_1993": 9.332835,
    "abu_farsakh_2003": 10.739306,
}
SLOPES = {
    "this_project": (-2.11, 0.1),
    "lu_2004": (-1.9, 0.0),
    "teh_houlsby_1991": (-1.8, -0.2),
    "yu_2000": (-1.83, 0.0),
    "abu_farsakh_2003": (-2.1, 0.0),
}
"""With the stress anisotropy and with the adhesion factor of the shaft; of others both are 0."""


def conditions(
    rigidity_index: Quantity = 100.0, adhesion: float = 0.0, **others: float
) -> Conditions:
    return Conditions(
        rigidity_index=rigidity_index, face_adhesion=adhesion, shaft_adhesion=adhesion, **others
    )


@pytest.mark.parametrize("reference_id", CHECK_VALUES)
def test_formula_gives_the_check_values(reference_id: str) -> None:
    reference = cone_factor_reference(reference_id)
    computed = [
        [float(reference.evaluate(conditions(ir, alpha))) for alpha in ADHESION_FACTORS]
        for ir in RIGIDITY_INDICES
    ]
    np.testing.assert_allclose(computed, CHECK_VALUES[reference_id], rtol=0, atol=ROUNDING)


@pytest.mark.parametrize("reference_id", HAND_VALUES)
def test_formula_gives_the_value_calculated_by_hand(reference_id: str) -> None:
    value = cone_factor_reference(reference_id).evaluate(conditions(adhesion=1.0))
    assert float(value) == pytest.approx(HAND_VALUES[reference_id], abs=2e-6)


@pytest.mark.parametrize("reference", CONE_FACTORS, ids=REFERENCE_IDS)
def test_slopes_with_stress_anisotropy_and_adhesion_of_the_shaft(reference: ConeFactor) -> None:
    start = conditions()
    slopes = [
        float(reference.evaluate(replace(start, **{name: 1.0})) - reference.evaluate(start))
        for name in ("stress_anisotropy", "shaft_adhesion")
    ]
    assert slopes == pytest.approx(SLOPES.get(reference.id, (0.0, 0.0)), abs=1e-12)


@pytest.mark.parametrize("reference", CONE_FACTORS, ids=REFERENCE_IDS)
def test_adhesion_term_is_declared_as_it_is(reference: ConeFactor) -> None:
    slope = reference.evaluate(conditions(adhesion=1.0)) - reference.evaluate(conditions())
    assert (slope > 0) == reference.has_adhesion_term


@pytest.mark.parametrize("reference", CONE_FACTORS, ids=REFERENCE_IDS)
def test_floats_numpy_and_xarray_agree(reference: ConeFactor) -> None:
    scalars = [float(reference.evaluate(conditions(ir, 0.5))) for ir in RIGIDITY_INDICES]
    array = np.array(RIGIDITY_INDICES, dtype=float)
    labelled = xr.DataArray(array, dims="rigidity_index")
    np.testing.assert_array_equal(reference.evaluate(conditions(array, 0.5)), scalars)
    assert reference.evaluate(conditions(labelled, 0.5)).values.tolist() == scalars


@pytest.mark.parametrize(
    ("reference_id", "case", "applies"),
    [
        ("lu_2004", {"rigidity_index": 50.0, "adhesion": 1.0}, True),
        ("lu_2004", {"rigidity_index": 500.0}, True),
        ("lu_2004", {"rigidity_index": 49.0}, False),
        ("lu_2004", {"rigidity_index": 501.0}, False),
        ("lu_2004", {"apex_angle": 90.0}, False),
        ("lu_2004", {"strength_stays": False}, False),
        ("lu_2004", {"stress_anisotropy": 0.9}, True),
        ("this_project", {"stress_anisotropy": -0.5}, True),
        ("this_project", {"stress_anisotropy": 0.51}, False),
        ("this_project", {"stress_anisotropy": -0.51}, False),
        ("vesic_1977", {}, True),
        ("vesic_1977", {"adhesion": 0.5}, False),
    ],
)
def test_range_of_validity(reference_id: str, case: dict[str, float], applies: bool) -> None:
    assert cone_factor_reference(reference_id).applies(conditions(**case)) is applies


def test_envelope_is_that_of_the_three_analyses_with_adhesion() -> None:
    members = {reference.id for reference in CONE_FACTORS if reference.in_envelope}
    assert members == set(CHECK_VALUES)
    alone = [values[1][1] for values in CHECK_VALUES.values()]
    bounds = envelope(conditions(adhesion=0.5))
    np.testing.assert_allclose(bounds, (min(alone), max(alone)), rtol=0, atol=ROUNDING)
    inside = envelope_applies(conditions(np.array([25.0, 100.0, 1000.0])))
    assert inside.tolist() == [False, True, False]


def test_every_entry_says_where_it_comes_from() -> None:
    for reference in CONE_FACTORS:
        if reference.id == "this_project":
            continue
        assert all((reference.source, reference.criterion, reference.method, reference.formula))
        assert "not read" in reference.how_known
        assert "50 to 500" in reference.validity
