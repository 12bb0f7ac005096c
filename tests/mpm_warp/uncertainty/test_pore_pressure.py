"""u1 and u2: the laws beside readings of the same case on several meshes, at several speeds."""

import math
from collections import defaultdict
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from mpm_warp.fields.plain_numbers import numbers_by_column
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.uncertainty import pore_pressure, shoulder
from mpm_warp.uncertainty.shoulder import EFFECTS, shoulder_pressure
from tests.mpm_warp.uncertainty.conftest import STUDIES, radial_error, readings

LAWS = replace(
    ConePenetration(stress_anisotropy=0.2).laws(penetration=30.0),
    cell_size=0.2,
    adhesion_factor=1.0,
    inertia=0.0,
    poissons_ratio=0.47,
    poissons_ratio_reduction=0.02,
)
CONFIDENCE = 0.95
OUTSIDE_LAYER = np.log([30.0, 100.0, 300.0, 600.0]), (-0.6, 0.0, 0.45, 0.62)
"""Rigidity indices, and the radial deviator outside the layer beside the shaft there."""
Row = dict[str, str]


def clay_of(row: Row) -> dict[str, float]:
    return {name: float(row[name]) for name in ("rigidity_index", "adhesion_factor")}


def over_half_width(series: list[tuple[float, float]]) -> list[float]:
    """Differences of values from the last, over the root of the squares of both half widths."""
    best, of_best = series[-1]
    return [abs(value - best) / math.hypot(own, of_best) for value, own in series[:-1]]


def test_u2_of_all_meshes_is_one_value() -> None:
    """With 95 %, by what differs between meshes alone: their scatter, speed and noise.

    Also of coarser meshes than the law is fitted to, and of clays between.
    """
    series = defaultdict(list)
    for row in readings("mesh_error_u2"):
        size, inertia, clay = (
            math.sqrt(3.0) / int(row["rows_on_face"]),
            float(row["inertia"]),
            clay_of(row),
        )
        if row["columns"] == "square" and (text := row["radial_stress_factor"]):
            reading, noise = float(text), float(shoulder.TABLE.at("noise", clay["rigidity_index"]))
            slope = float(shoulder.TABLE.at("slope", *clay.values()))
            left = [
                EFFECTS["u2_mesh"].half_width * size * reading,
                EFFECTS["u2_wide_cells"].half_width * max(0.0, size - shoulder.WIDE_CELL) * reading,
                EFFECTS["u2_inertia"].half_width * inertia,
                noise * reading,
            ]
            series[tuple(clay.values())].append((reading - slope * size, math.hypot(*left)))
    over = [it for of_clay in series.values() for it in over_half_width(of_clay)]
    assert len(over) >= 160
    assert np.mean(np.array(over) <= 1.0) >= CONFIDENCE


def test_u1_of_all_meshes_is_one_value() -> None:
    series = defaultdict(list)
    for row in readings("mesh_error_u1"):
        value, size = float(row["u1"]), math.sqrt(3.0) / int(row["rows_on_face"])
        off, half = pore_pressure.face_error(value, cell_size=size, inertia=0.0, **clay_of(row))
        series[tuple(clay_of(row).values())].append((value + float(off), float(half)))
    assert max(it for of_clay in series.values() for it in over_half_width(of_clay)) <= 1.0


def test_the_excess_at_the_filter_is_that_of_the_finest_meshes() -> None:
    """Rows change the rise by up to 9 h^1.5, and make the layer thicker by 0.5 radii over their
    number: so much more of the 0.06 radii has its deviator of -1.2, not that outside it."""
    within = []
    for row in readings("mesh_error_u2"):
        rows = int(row["rows_on_face"])
        if rows >= 56 and row["rise_to_filter"] and row["deviator_at_filter"]:
            clay = clay_of(row)
            reading = float(row["rise_to_filter"]) + float(row["deviator_at_filter"])
            known = float(shoulder.excess_at_filter(**clay))
            outside = np.interp(math.log(clay["rigidity_index"]), *OUTSIDE_LAYER)
            thicker = min(1.0, 0.5 / rows / 0.06) * (-1.2 - outside)
            left = float(shoulder.TABLE.at("half_width", *clay.values()))
            left += 9.0 * (math.sqrt(3.0) / rows) ** 1.5
            within.append(min(0.0, thicker) - left <= reading - known <= left)
    assert len(within) >= 10
    assert np.mean(within) >= CONFIDENCE


PAIRS = defaultdict(list)
for _row in readings("pressure_effects"):
    PAIRS[_row["quantity"], _row["effect"]].append(_row)


@pytest.mark.parametrize("kind", PAIRS, ids=" ".join)
def test_pairs_of_runs_differ_by_no_more_than_the_half_width(kind: tuple[str, str]) -> None:
    """With 95 %: of what a pair of runs differs by, what is not corrected."""
    quantity, effect = kind
    within = []
    for row in PAIRS[kind]:
        before, after, begin, end = (float(row[it]) for it in ("before", "after", "from", "to"))
        at = clay_of(row) | {"inertia": 0.0, "cell_size": math.sqrt(3.0) / int(row["rows"])}
        changed, given = after - before, {"stress_anisotropy": float(row["stress_anisotropy"])}
        if effect == "still_came":
            of_change = EFFECTS["u2_to_come"]
            noise = 100.0 * float(shoulder.TABLE.at("noise", at["rigidity_index"]))
            left = math.hypot(of_change.half_width * before, noise)
            within.append(abs(after - of_change.size * before) <= left)
            continue
        if effect == "poissons_ratio_bound":
            # F and C change at once.
            of_excess = {20.0: 0.8}.get(at["rigidity_index"], -1.2)
            gained, bound = changed / (end - begin) + of_excess, EFFECTS["u2_bound"]
            within.append(abs(gained - bound.size) <= bound.half_width)
            continue
        if effect in ("inertia", "strength_ratio", "poissons_ratio"):
            given[effect] = end
        if effect == "domain_radius":
            given["extent_ratio"] = begin / end
        if quantity == "u1":
            del given["stress_anisotropy"]
            noise = EFFECTS["u1_noise"].half_width * math.hypot(before, after)
            _, half_width = pore_pressure.face_error(after, **at | given)
            within.append(abs(changed) <= float(half_width) + noise)
            continue
        known, other = (
            shoulder_pressure(4.0, **at | {"poissons_ratio": 0.45} | it)
            for it in ({"stress_anisotropy": 0.0} if effect == "stress_anisotropy" else {}, given)
        )
        corrected = float(other[0] - known[0])
        within.append(abs(changed - corrected) <= float(other[1]))
    assert np.mean(within) >= CONFIDENCE


def test_of_softened_soil_u2_has_less_of_the_deviator_and_is_less_certain() -> None:
    at = {"cell_size": 0.35, "adhesion_factor": 0.5, "rigidity_index": 100.0}
    (whole, of_whole), (half, of_half) = (
        radial_error(4.2, **at, strength_ratio=ratio) for ratio in (1.0, 0.5)
    )
    assert half - whole == pytest.approx(-0.5 * shoulder.TABLE.at("deviator", 100.0, 0.5))
    assert of_half > of_whole


def test_of_wide_cells_the_half_width_grows_faster() -> None:
    at = {"adhesion_factor": 0.25, "rigidity_index": 100.0}
    narrow, wide, wider = (
        float(radial_error(5.3, cell_size=shoulder.WIDE_CELL + more, **at)[1])
        for more in (-0.1, 0.0, 0.1)
    )
    assert wider**2 - wide**2 > 3.0 * (wide**2 - narrow**2)


def test_beyond_the_range_the_half_width_grows_without_a_jump() -> None:
    for error in (pore_pressure.face_error, radial_error):
        indices = np.outer([20.0, 1000.0], [0.25, 0.5, 1.0 - 1e-9, 1.0 + 1e-9, 2.0, 4.0])
        of_cone = {"cell_size": 0.35, "adhesion_factor": 0.0, "inertia": 0.0}
        _, (below, above) = error(6.0, rigidity_index=indices, **of_cone)
        assert below[0] > below[1] > below[2]
        assert above[3] < above[4] < above[5]
        for half_width in (below, above):
            assert half_width[2] == pytest.approx(half_width[3])


@pytest.mark.parametrize(("adhesion_factor", "share"), [(0.0, 0.03), (0.5, 0.035), (1.0, 0.041)])
@pytest.mark.parametrize(("rows", "inertia"), [(5, 0.09), (14, 0.2)])
def test_half_width_by_default_and_fine(
    adhesion_factor: float, share: float, rows: int, inertia: float
) -> None:
    """Of u2 at Ir 100, without what is still to come."""
    radial = {0.0: 4.3, 0.5: 4.1, 1.0: 3.7}[adhesion_factor]
    off, half_width = radial_error(
        radial,
        cell_size=math.sqrt(3.0) / rows,
        adhesion_factor=adhesion_factor,
        rigidity_index=100.0,
        inertia=inertia,
    )
    assert half_width <= share * (radial + off)


def test_u2_of_random_cases_is_that_of_finer_runs() -> None:
    """With 95 %, within the half widths of both; the law is fitted to other runs."""
    cases = numbers_by_column((STUDIES / "held_out_u2.csv").read_text())
    half_width = np.hypot(cases["u2_uncertainty"], cases["u2_fine_uncertainty"])
    assert len(cases["u2"]) == 24
    assert np.mean(np.abs(cases["u2"] - cases["u2_fine"]) <= half_width) >= CONFIDENCE


def test_in_very_stiff_clay_u1_on_three_rows_has_no_half_width() -> None:
    for index, rows, word in ((0.9, 3, ""), (1.1, 3, "mesh"), (1.1, 4, "")):
        stated = stated_of(
            why_none="",
            rigidity_index=index * 500.0,
            cell_size=math.sqrt(3.0) / rows,
        )
        name = "pore_pressure_factor_face"
        assert str(stated[f"{name}_why_no_uncertainty"].values).partition(":")[0] == word
        assert math.isnan(float(stated[f"{name}_uncertainty"].values)) == bool(word)
        assert not str(stated["pore_pressure_factor_shoulder_why_no_uncertainty"].values)


@pytest.mark.parametrize(
    ("is_known", "is_corrected"), [(True, True), (False, True), (False, False)]
)
def test_stated_pressures(is_known: bool, is_corrected: bool) -> None:
    """What is still to come goes with the last change; without U the correction goes on.

    What a bound of Poisson's ratio takes off is another of u1 and u2.
    """
    at = {"cell_size": 0.2, "adhesion_factor": 1.0, "rigidity_index": 100.0, "inertia": 0.1}
    why_none = "" if is_known else "law: of one's own"
    stated = stated_of(why_none=why_none, is_corrected=is_corrected, **at)
    of_soil = {"poissons_ratio": 0.47, "stress_anisotropy": 0.2}
    pressure, of_pressure = shoulder_pressure(4.0, **at, **of_soil)
    errors = pore_pressure.face_error(5.0, **at), (pressure - 5.0, of_pressure)
    noise = {"face": 0.006, "shoulder": 0.013}
    of_place = {"face": "u1", "shoulder": "u2"}
    for place, (of_mesh, of_laws) in zip(("face", "shoulder"), errors, strict=True):
        to_come, bound = (EFFECTS[f"{of_place[place]}_{it}"] for it in ("to_come", "bound"))
        off = of_mesh + 0.02 * bound.size - 0.2 * to_come.size
        name = f"pore_pressure_factor_{place}"
        value, correction, half_width = (
            float(stated[it].values) for it in (name, f"{name}_correction", f"{name}_uncertainty")
        )
        assert value == pytest.approx(5.0 + (off if is_corrected else 0.0))
        assert correction == pytest.approx(off if is_corrected else 0.0)
        read = {"face": 5.0, "shoulder": 4.0}[place]
        of_mean = math.hypot(to_come.half_width * 0.2, read * noise[place])
        expected = math.hypot(of_laws, of_mean, 0.02 * bound.half_width) if is_known else math.nan
        assert half_width == pytest.approx(expected, nan_ok=True)
        why = str(stated[f"{name}_why_no_uncertainty"].values)
        assert why == why_none


def stated_of(
    *, why_none: str, is_corrected: bool = True, **of_cone: float
) -> dict[str, xr.Variable]:
    """What is stated of a run whose pressures have fallen from 5.2 to 5 su."""
    curve = ("penetration", np.append(np.full(20, 5.2e4), np.full(20, 5.0e4)))
    recorded = xr.Dataset(
        {f"excess_pore_pressure_{it}": curve for it in ("face", "shoulder")}
        | {f"pore_pressure_factor_{it}": 5.0 for it in ("face", "shoulder")}
        | {shoulder.RADIAL_STRESS: curve, shoulder.RADIAL_FACTOR: 4.0}
    )
    laws = replace(LAWS, **of_cone)
    return pore_pressure.stated_pressures(
        recorded,
        laws,
        strength=1e4,
        shaft_adhesion=float(laws.adhesion_factor),
        why_none=why_none,
        is_corrected=is_corrected,
    )


def test_the_sleeve_friction_may_be_as_low_as_beside_remoulded_clay() -> None:
    recorded = xr.Dataset({"sleeve_friction_factor": 0.3})
    stated = pore_pressure.stated_sleeve(recorded, remoulded=0.2 * 0.5)
    assert float(stated["sleeve_friction_factor_uncertainty"].values) == pytest.approx(0.2)
