"""The stability map: spans, margins, shares and words of results that are made up."""

from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from harness.archive.study_files import read_study, write_study
from harness.cli.main import main
from harness.pictures.drawing.caption import LINE
from harness.pictures.drawing.quantities import Values
from harness.pictures.stability import STATUSES, short_reason, stability_figure, stability_rows
from harness.pictures.tornado import tornado_figure
from tests.harness.conftest import as_collected
from tests.harness.pictures.conftest import caption_of, collected, figures, legend, texts

VELOCITY = (
    "SimulationDiverged: velocity of particle 352 at [ 0.0025, -0.1098] m is [ 30.4263, "
    "-180.8841], at step 5000, t = 0.01218 s; healthy at step 4500; try a smaller step"
)
STRESS = (
    "SimulationDiverged: stress of particle 7 at [0.1, 0.2] m is [1, 2, 3, 4], outside the yield "
    "surface by 0.02 of the strength, at step 500, t = 1 s; healthy at step 0; try a smaller step"
)
ENERGY = (
    "InaccurateRun: the transfers between material points and grid took 7.0% of the penetrometer's "
    "work, more than 5%: try a lower speed_ratio"
)
MESSAGES = {"completed": "", "diverged": VELOCITY, "inaccurate": ENERGY}
DEFAULTS = {"speed_ratio": 0.03, "poissons_ratio": 0.49, "material": "tresca"}
OUTCOMES: Sequence[tuple[dict[str, object], str]] = (
    ({}, "completed"),
    ({"speed_ratio": 0.5}, "diverged"),
    ({"speed_ratio": 0.1}, "completed"),
    ({"speed_ratio": 0.3}, "inaccurate"),
    ({"speed_ratio": 0.01}, "completed"),
    ({"speed_ratio": 0.001}, "diverged"),
    ({"poissons_ratio": 0.3}, "completed"),
    ({"poissons_ratio": 0.2}, "diverged"),
    ({"poissons_ratio": 0.0}, "completed"),
    ({"material": "von_mises"}, "completed"),
)


def made(design: str, statuses: Sequence[str], **parameters: Sequence[object]) -> xr.Dataset:
    """A result as it is collected."""
    columns = {name: ("case", np.array(values)) for name, values in parameters.items()}
    bare = xr.Dataset(coords={"case": range(len(statuses)), **columns})
    asked = {"design": design, "stability_map": 1}
    messages = [MESSAGES.get(status, "") for status in statuses]
    return as_collected(bare, "case", statuses, **asked).assign(message=("case", messages))


def one_at_a_time(outcomes: Sequence[tuple[dict[str, object], str]] = OUTCOMES) -> xr.Dataset:
    cases = [{**DEFAULTS, **changed} for changed, _ in outcomes]
    columns = {name: [case[name] for case in cases] for name in DEFAULTS}
    return made("one_at_a_time", [status for _, status in outcomes], **columns)


def row_of(dataset: xr.Dataset, name: str) -> dict[str, str]:
    """What the map says of a parameter, by its headings."""
    heading, *rows = stability_rows(dataset)
    (row,) = (row for row in rows if row[0] == name)
    return dict(zip(heading, row, strict=True))


def random_cases() -> xr.Dataset:
    """Of each fifth of the stiffness 0, 1, 2, 3, 4 in 4 diverge; the strength has no say."""
    stiffness = np.arange(1.0, 21.0)
    status = np.where((stiffness - 1) % 4 < (stiffness - 1) // 4, "diverged", "completed")
    strength = np.tile([1.0, 2.0], 10)
    return made(
        "latin_hypercube", status.tolist(), strength=strength.tolist(), stiffness=stiffness.tolist()
    )


DIVERGED = "diverged: velocity of particle 352"
INACCURATE = (
    "inaccurate: the transfers between material points and grid took 7.0% of the penetrometer's "
    "work"
)
TRIED = [OUTCOMES[0], *(({"speed_ratio": it}, "completed") for it in (0.1, 0.4, 0.01))]
NO_DEFAULT = [({}, "crashed"), *OUTCOMES[1:]]
NO_MISES = [*OUTCOMES[:-1], (OUTCOMES[-1][0], "diverged")]
BELOW, ABOVE = f"0.001 (factor 30), {DIVERGED}", f"0.3 (factor 10), {INACCURATE}"


@pytest.mark.parametrize(
    ("outcomes", "name", "stable", "below", "above"),
    [
        (OUTCOMES, "speed ratio", "0.01 to 0.1", BELOW, ABOVE),
        (
            OUTCOMES,  # what completed beyond a failure is not stable
            "Poisson's ratio",
            "0.3 to 0.49",
            f"0.2 (difference -0.29), {DIVERGED}",
            "no case",
        ),
        (TRIED, "speed ratio", "0.01 to 0.4", "none failed down to 0.01", "none failed up to 0.4"),
        (NO_DEFAULT, "speed ratio", "none", *["the default itself, crashed"] * 2),
        (OUTCOMES, "material", "tresca, von_mises", "", "none failed"),
        (NO_MISES, "material", "tresca", "", f"von_mises, {DIVERGED}"),
    ],
)
def test_what_is_stable_and_what_is_the_margin(
    outcomes: Sequence[tuple[dict[str, object], str]],
    name: str,
    stable: str,
    below: str,
    above: str,
) -> None:
    row = row_of(one_at_a_time(outcomes), name)
    told = row["stable"], row["first failure below"], row["first failure above"]
    assert told == (stable, below, above)


@pytest.mark.parametrize(
    ("statuses", "values", "stable", "above"),
    [
        # A default that the scene derives is no number.
        (["completed", "completed", "diverged"], [np.nan, 0.5, 1.0], "derived, 0.5", "1, "),
        # From zero there is no factor.
        (["completed", "completed", "diverged"], [0.0, 1.0, 1e4], "0 to 1", "10000 (difference"),
        # What was not run says nothing.
        (["completed", "missing", "completed"], [1.0, 2.0, 3.0], "1 to 3", "none failed up to 3"),
    ],
)
def test_values_of_any_kind(
    statuses: list[str], values: list[float], stable: str, above: str
) -> None:
    row = row_of(made("one_at_a_time", statuses, stress=values), "stress")
    assert row["stable"] == stable
    assert row["first failure above"].startswith(above)


def test_a_result_is_told_as_a_share_of_its_limit_and_of_several_the_nearest_counts() -> None:
    dataset = made("one_at_a_time", ["completed"] * 2, stress=[1.0, 2.0])
    dataset["energy_error"] = "case", np.array([-0.01, 0.02]), {"limit": 0.04}
    assert row_of(dataset, "stress")["limit"] == "up to 50% of the limit"
    dataset["mass_error"] = "case", np.array([0.8, 0.1]), {"limit": 1.0}
    assert row_of(dataset, "stress")["limit"] == "up to 80% of the limit"
    label = stability_figure(dataset).axes[-1].get_xlabel()
    assert label.startswith("energy error over its limit of 0.04 or mass error over its limit of 1")


def test_a_result_without_a_limit_has_no_scale() -> None:
    dataset = one_at_a_time()
    dataset["energy_error"] = "case", np.full(len(OUTCOMES), 0.01)
    assert row_of(dataset, "speed ratio")["limit"] == ""
    assert len(stability_figure(dataset).axes) == len(DEFAULTS)


def test_rows_of_random_cases_tell_shares_and_name_the_worst_part() -> None:
    """Those first over which they differ most; few values have a part each."""
    heading, *rows = stability_rows(random_cases())
    assert [dict(zip(heading, row, strict=True)) for row in rows] == [
        {
            "parameter": "stiffness",
            "completed": "1 to 4: 100% of 4, 5 to 8: 75% of 4, 9 to 12: 50% of 4, "
            "13 to 16: 25% of 4, 17 to 20: 0% of 4",
            "spread": "100%",
            "least": "17 to 20",
            "what fails there": f"4 {DIVERGED}",
        },
        {
            "parameter": "strength",
            "completed": "1: 40% of 10, 2: 60% of 10",
            "spread": "20%",
            "least": "1",
            "what fails there": f"6 {DIVERGED}",
        },
    ]


def marks(figure: Figure, row: int) -> list[tuple[float, str]]:
    """Place and status of each mark of a strip."""
    lines = [line for line in figure.axes[row].lines if line.get_gid() in STATUSES]
    return [(float(line.get_xdata()[0]), str(line.get_gid())) for line in lines]


def test_the_picture_has_a_mark_for_each_case_and_a_bar_where_it_is_stable() -> None:
    figure = stability_figure(one_at_a_time())
    (bar,) = (line for line in figure.axes[0].lines if line.get_gid() == "stable")
    (default,) = (line for line in figure.axes[0].lines if line.get_gid() == "default")
    assert bar.get_xdata().tolist() == [0.01, 0.1]
    assert default.get_xdata()[0] == 0.03
    assert sorted(marks(figure, 0)) == [
        (0.001, "diverged"),
        (0.01, "completed"),
        (0.03, "completed"),
        (0.1, "completed"),
        (0.3, "inaccurate"),
        (0.5, "diverged"),
    ]
    assert figure.axes[0].get_xscale() == "log"
    assert figure.axes[1].get_xscale() == "linear"
    (text,) = figure.axes[0].texts
    assert "above: 0.3 (factor 10), inaccurate" in text.get_text()
    assert legend(figure) == ["completed", "inaccurate", "diverged", "default", "stable"]


def test_the_share_of_the_limit_colours_what_completed() -> None:
    dataset = one_at_a_time()
    energy = np.where(dataset["status"] == "completed", 0.025, np.nan)
    figure = stability_figure(dataset.assign(energy_error=("case", energy, {"limit": 0.05})))
    assert len(figure.axes) == len(DEFAULTS) + 1
    colours: dict[str, set[str]] = {}
    for line in figure.axes[0].lines:
        colours.setdefault(str(line.get_gid()), set()).add(str(line.get_color()))
    assert len({*colours["completed"], *colours["inaccurate"], *colours["diverged"]}) == 3


def test_bars_of_the_shares_add_up_to_one() -> None:
    axes = stability_figure(random_cases()).axes[0]
    bars = cast("list[Rectangle]", list(axes.patches))
    heights = np.array([bar.get_height() for bar in bars]).reshape(2, 5)
    np.testing.assert_allclose(heights[0], [1.0, 0.75, 0.5, 0.25, 0.0])
    np.testing.assert_allclose(heights.sum(axis=0), 1.0)
    bottoms = np.array([bar.get_y() for bar in bars]).reshape(2, 5)
    np.testing.assert_allclose(bottoms, [np.zeros(5), heights[0]])
    ticks = texts(axes.get_xticklabels())
    assert ticks == ["1", "5", "9", "13", "17", "20"]


def test_where_all_complete_no_least_share_is_told() -> None:
    sound = made("latin_hypercube", ["completed"] * 6, stress=[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    (axes,) = stability_figure(sound).axes
    assert texts(axes.texts) == ["all 6 complete"]


SOUND = made("one_at_a_time", ["completed", "completed"], stress=[1.0, 2.0])


@pytest.mark.parametrize(
    ("dataset", "is_drawn"),
    [
        (SOUND, True),
        (one_at_a_time(), True),
        (one_at_a_time().assign_attrs(stability_map=0), False),
        (made("one_at_a_time", ["diverged"]), False),
        (made("one_at_a_time", ["missing"] * 2, stress=[1.0, 2.0]), False),
    ],
    ids=["sound", "failures", "not asked for", "nothing varies", "not run"],
)
def test_which_results_have_a_map(dataset: xr.Dataset, is_drawn: bool) -> None:
    assert list(figures(dataset)) == ["stability"] * is_drawn


def test_picture_and_table_come_out_of_plot_and_report(tmp_path: Path) -> None:
    file, page = tmp_path / "made.nc", tmp_path / "page.html"
    write_study(file, one_at_a_time())
    assert main(["plot", str(file)]) == 0
    assert (tmp_path / "made_stability.png").read_bytes().startswith(b"\x89PNG")
    assert main(["report", str(file), "-o", str(page)]) == 0
    text = page.read_text()
    assert text.count("<img") == 1  # a page of one study has no summary
    assert "<td>0.001 (factor 30), diverged: velocity of particle 352</td>" in text


@pytest.mark.parametrize(
    ("numbers", "logarithmic"),
    [
        ([1.0, 10.0], True),
        ([1.0, 9.0], False),
        ([0.0, 1.0, 10.0], True),
        ([-1.0, 1.0, 10.0], False),
        ([0.0], False),
    ],
)
def test_an_axis_is_logarithmic_over_a_decade(numbers: list[float], logarithmic: bool) -> None:
    values = Values(name="stress", unit="Pa", numbers=np.array(numbers))
    assert values.logarithmic == logarithmic


@pytest.mark.parametrize("order", ["stiffness speed_ratio", "speed_ratio stiffness"])
def test_a_case_belongs_to_the_parameter_that_the_study_changes(order: str) -> None:
    """The default speed falls with the stiffness: the strip of the speed has no such case."""
    stiffness, speed = [100.0, 5000.0, 100.0], [0.03, 0.004, 0.1]
    statuses = ["completed", "unfinished", "completed"]
    silent = made("one_at_a_time", statuses, speed_ratio=speed, stiffness=stiffness)
    silent.attrs["stability_map"] = order
    result = silent.assign(changed=("case", ["", "stiffness", "speed_ratio"]))
    rows = [row[0].replace(" ", "_") for row in stability_rows(result)[1:]]
    assert rows == order.split()
    assert row_of(result, "stiffness")["first failure above"] == "5000 (factor 50), unfinished"
    assert row_of(result, "speed ratio")["first failure below"] == "no case"
    assert row_of(silent, "stiffness")["first failure above"] == "no case"  # it cannot be told
    assert row_of(silent, "speed ratio")["first failure below"] == "no case"


@pytest.mark.parametrize(
    "vary",
    ["rigidity_index = [20]\nspeed_ratio = [0.1]", "speed_ratio = [0.1]\nrigidity_index = [20]"],
)
def test_a_bar_has_the_cases_that_change_its_parameter_alone(vary: str, tmp_path: Path) -> None:
    """The default speed follows the rigidity index; the order in the study says nothing."""
    text = f'design = "one_at_a_time"\nstability_map = true\n[vary]\n{vary}\n'
    factors = {"": 11.0, "rigidity_index": 8.0, "speed_ratio": 11.5}
    in_turn = ["", *(line.partition(" ")[0] for line in vary.splitlines())]
    results = [
        xr.Dataset({"resistance_factor": ((), factors[name], {"role": "headline"})})
        for name in in_turn
    ]
    dataset = collected(tmp_path, "ball_penetration", text, *results)
    assert dataset["changed"].values.tolist() == in_turn
    write_study(tmp_path / "s.nc", dataset)
    for result in (dataset, read_study(tmp_path / "s.nc")):
        assert texts(tornado_figure(result).axes[0].texts) == ["20", "0.1"]
        found = {row[0]: row for row in stability_rows(result)}
        assert found["rigidity index"][2] == "20 to 100"
        assert found["speed ratio"][2] == "0.03 to 0.1"


GROUND = "depth [m], strength [kPa]; 0, 20; 99, {}"


def of_profiles(count: int) -> xr.Dataset:
    """A case without a profile, and one of each; the last fails."""
    profiles = ["", *(GROUND.format(place) for place in range(1, count + 1))]
    return made("one_at_a_time", [*["completed"] * count, "diverged"], profile=profiles)


def test_long_texts_have_room_in_a_tornado() -> None:
    result = of_profiles(2)
    name = "cone factor over strength at the tip, at the end"
    result["factor"] = "case", [10.0, 12.0, np.nan], {"role": "headline", "long_name": name}
    figure = tornado_figure(result)
    (axes,) = figure.axes
    assert texts(axes.texts) == ["1"]
    assert "Not completed: profile = 2." in caption_of(figure)
    assert axes.get_xlabel() == "cone factor over strength at the tip, at\nthe end [-]"


def test_a_value_without_room_on_an_axis_is_told_by_its_number() -> None:
    ground = GROUND.format(20)
    values = Values.of(made("list", ["completed"] * 3, it=["", "von_mises", ground]), "it")
    axes = Figure().subplots()
    values.dress(axes, room=6)
    labels = [label.get_text() for label in axes.get_xticklabels()]
    assert labels == ["derived", "von mises", "1"]
    assert values.of_case(2) == "1"


def test_the_caption_says_what_numbers_of_long_texts_are() -> None:
    few, many = (stability_figure(of_profiles(count)) for count in (4, 5))
    key = "; ".join(f'{it}: "{GROUND.format(it)}"' for it in range(1, 5))
    assert f"Profile is {key}." in caption_of(few)
    assert "Profile is numbered in the order of cases." in caption_of(many)
    lines = few.get_supxlabel().count("\n") - many.get_supxlabel().count("\n")
    assert few.get_figheight() - many.get_figheight() == pytest.approx(lines * LINE)
    assert lines > 0


def test_beside_texts_stands_what_failed_neither_below_nor_above() -> None:
    figure = stability_figure(of_profiles(2))
    assert texts(figure.axes[0].texts) == [f"2, {DIVERGED}"]


@pytest.mark.parametrize(
    ("message", "short"),
    [
        (VELOCITY, "velocity of particle 352"),
        (STRESS, "stress of particle 7, outside the yield surface by 0.02 of the strength"),
        ("worker killed by SIGSEGV, at 45% of the case", "worker killed by SIGSEGV"),
        ("ended after 200 s, at 4% of the case", "ended after 200 s"),
        ("", ""),
    ],
)
def test_a_reason_is_what_gave_way(message: str, short: str) -> None:
    assert short_reason(message) == short
