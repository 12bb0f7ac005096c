"""The stability map: spans, margins, shares and words of results that are made up."""

from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np
import pytest
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from harness.archive.conventions import COMPLETED
from harness.archive.study_files import write_study
from harness.cli.main import main
from harness.pictures.drawing.caption import LINE
from harness.pictures.drawing.style import STATUSES
from harness.pictures.effects import tornado_figure
from harness.pictures.method.stability import (
    BAR,
    BOTTOM,
    short_reason,
    stability_figure,
    stability_rows,
)
from tests.harness.conftest import as_collected
from tests.harness.pictures.conftest import caption_of, figures, legend, texts

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
STRESS_DERIVED = made("one_at_a_time", [*["completed"] * 2, "diverged"], stress=[np.nan, 0.5, 1.0])
STRESS_FROM_0 = made("one_at_a_time", [*["completed"] * 2, "diverged"], stress=[0.0, 1.0, 1e4])
STRESS_NOT_RUN = made(
    "one_at_a_time", ["completed", "missing", "completed"], stress=[1.0, 2.0, 3.0]
)


@pytest.mark.parametrize(
    ("dataset", "name", "fails"),
    [
        (one_at_a_time(), "speed ratio (0.03)", f"below: {BELOW}; above: {ABOVE}"),
        # what completed beyond a failure is no margin
        (
            one_at_a_time(),
            "Poisson's ratio (0.49)",
            f"below: 0.2 (factor 2.45), {DIVERGED}; above: no case",
        ),
        (
            one_at_a_time(TRIED),
            "speed ratio (0.03)",
            "below: none failed down to 0.01; above: none failed up to 0.4",
        ),
        (
            one_at_a_time(NO_DEFAULT),
            "speed ratio (0.03)",
            "below: the default itself, crashed; above: the default itself, crashed",
        ),
        # a text is neither below nor above the default
        (one_at_a_time(), "material (tresca)", "none failed"),
        (one_at_a_time(NO_MISES), "material (tresca)", f"von_mises, {DIVERGED}"),
        (STRESS_DERIVED, "stress (derived)", f"1, {DIVERGED}"),  # it is no number
        # from zero there is no factor
        (STRESS_FROM_0, "stress (0)", f"below: no case; above: 10000, {DIVERGED}"),
        # what was not run says nothing
        (STRESS_NOT_RUN, "stress (1)", "below: no case; above: none failed up to 3"),
    ],
)
def test_what_fails_and_with_what_margin(dataset: xr.Dataset, name: str, fails: str) -> None:
    assert row_of(dataset, name)["what fails"] == fails


def test_what_completed_is_told_value_by_value() -> None:
    told = "0.001: 0% of 1, 0.01: 100% of 1, 0.03: 100% of 1, 0.1: 100% of 1, 0.3: 0% of 1, 0.5: 0%"
    assert row_of(one_at_a_time(), "speed ratio (0.03)")["completed"] == f"{told} of 1"


def test_a_result_is_told_as_a_share_of_its_limit_and_of_several_the_nearest_counts() -> None:
    dataset = made("one_at_a_time", ["completed"] * 2, stress=[1.0, 2.0])
    dataset["energy_error"] = "case", np.array([-0.01, 0.02]), {"limit": 0.04}
    assert row_of(dataset, "stress (1)")["limit"] == "up to 50% of the limit"
    dataset["mass_error"] = "case", np.array([0.8, 0.1]), {"limit": 1.0}
    assert row_of(dataset, "stress (1)")["limit"] == "up to 80% of the limit"
    figure = stability_figure(dataset)
    (line,) = (label for label in legend(figure) if "limit" in label)
    assert line.startswith("energy error over its limit of 0.04 or mass error over its limit of 1")
    heights = [path.vertices[0][1] for it in figure.axes[0].collections for path in it.get_paths()]
    np.testing.assert_allclose(heights, BOTTOM - BAR * np.array([0.8, 0.5]))


def test_rows_of_random_cases_tell_shares_and_name_the_worst_part() -> None:
    """Those first over which they differ most; few values have a part each."""
    heading, *rows = stability_rows(random_cases())
    assert [dict(zip(heading, row, strict=True)) for row in rows] == [
        {
            "parameter": "stiffness",
            "completed": "1 to 4: 100% of 4, 5 to 8: 75% of 4, 9 to 12: 50% of 4, "
            "13 to 16: 25% of 4, 17 to 20: 0% of 4",
            "what fails": f"0% complete at 17 to 20: {DIVERGED}",
            "limit": "",
        },
        {
            "parameter": "strength",
            "completed": "1: 40% of 10, 2: 60% of 10",
            "what fails": f"40% complete at 1: {DIVERGED}",
            "limit": "",
        },
    ]
    sound = made("latin_hypercube", ["completed"] * 6, stress=[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    assert row_of(sound, "stress")["what fails"] == "all 6 complete"


def colour_of(status: str) -> str:
    return to_hex(STATUSES[status][0])


def bars(figure: Figure, row: int) -> list[tuple[str, float, float]]:
    """Colour, bottom and height of each bar of a row, from the left."""
    found = [bar for bar in figure.axes[0].patches if bar.get_gid() == row]
    return [
        (to_hex(bar.get_facecolor()), row + BOTTOM - bar.get_y(), -bar.get_height())
        for bar in cast("list[Rectangle]", found)
    ]


def test_each_value_has_a_bar_in_the_colour_of_its_status_and_the_default_a_frame() -> None:
    figure = stability_figure(one_at_a_time())
    statuses = ["diverged", "completed", "completed", "completed", "inaccurate", "diverged"]
    assert bars(figure, 0) == [(colour_of(status), 0.0, BAR) for status in statuses]
    frames = [bar for bar in figure.axes[0].patches if not bar.get_fill()]
    assert len(frames) == 3
    centre = frames[0].get_x() + 0.5 * frames[0].get_width()
    assert centre == pytest.approx(2.5 / 6.0)
    assert set(legend(figure)) == {"completed", "inaccurate", "diverged", "default"}
    written = texts(figure.axes[0].texts)
    assert written[:6] == ["0.001", "0.01", "0.03", "0.1", "0.3", "0.5"]
    assert "above: 0.3 (factor 10), inaccurate" in written[6]


def test_bars_of_the_shares_add_up_to_a_full_one() -> None:
    figure = stability_figure(random_cases())
    drawn = bars(figure, 0)
    assert [status for status, *_ in drawn].count(colour_of("diverged")) == 4
    heights = [height for status, _, height in drawn if status == colour_of(COMPLETED)]
    np.testing.assert_allclose(heights, BAR * np.array([1.0, 0.75, 0.5, 0.25]))
    assert sum(height for *_, height in drawn) == pytest.approx(5 * BAR)
    stacked = [bottom for status, bottom, _ in drawn if status == colour_of("diverged")]
    np.testing.assert_allclose(stacked, [0.75 * BAR, 0.5 * BAR, 0.25 * BAR, 0.0])


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
    assert "<td>below: 0.001 (factor 30), diverged: velocity of particle 352; above: 0.3" in text


@pytest.mark.parametrize("order", ["stiffness speed_ratio", "speed_ratio stiffness"])
def test_a_case_belongs_to_the_parameter_that_the_study_changes(order: str) -> None:
    """The default speed falls with the stiffness: the strip of the speed has no such case."""
    stiffness, speed = [100.0, 5000.0, 100.0], [0.03, 0.004, 0.1]
    statuses = ["completed", "unfinished", "completed"]
    silent = made("one_at_a_time", statuses, speed_ratio=speed, stiffness=stiffness)
    silent.attrs["stability_map"] = order
    result = silent.assign(changed=("case", ["", "stiffness", "speed_ratio"]))
    rows = [row[0].partition(" (")[0].replace(" ", "_") for row in stability_rows(result)[1:]]
    assert rows == order.split()
    of_stiffness, of_speed = "stiffness (100)", "speed ratio (0.03)"
    failed = "below: no case; above: 5000 (factor 50), unfinished"
    assert row_of(result, of_stiffness)["what fails"] == failed
    assert row_of(result, of_speed)["what fails"] == "below: no case; above: none failed up to 0.1"
    silent_row = row_of(silent, of_stiffness)["what fails"]  # it cannot be told
    assert silent_row == "below: no case; above: no case"


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
    assert texts(axes.get_yticklabels()) == ["profile: derived, 1, 2"]
    assert "1 of 3 cases did not complete." in caption_of(figure)
    assert axes.get_xlabel() == "cone factor over strength at the tip, at\nthe end [-]"


def test_the_caption_says_what_numbers_of_long_texts_are() -> None:
    few, many = (stability_figure(of_profiles(count)) for count in (4, 5))
    key = "; ".join(f'{it}: "{GROUND.format(it)}"' for it in range(1, 5))
    assert f"Profile is {key}." in caption_of(few)
    assert "Profile is numbered in the order of cases." in caption_of(many)
    assert few.get_figheight() - many.get_figheight() == pytest.approx(LINE)


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
