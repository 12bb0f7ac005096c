"""The stability map: spans, margins, shares and words of results that are made up."""

from collections.abc import Sequence
from pathlib import Path
from typing import cast

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from harness.archive.conventions import FORMAT_VERSION
from harness.archive.study_files import write_study
from harness.cli.main import main
from harness.pictures.drawing.quantities import Values
from harness.pictures.stability import (
    Strip,
    shares,
    short_reason,
    stability_figure,
    stability_rows,
    strips,
)
from tests.harness.pictures.conftest import figures

BAD_VELOCITY = (
    "SimulationDiverged: velocity of particle 352 at [ 0.0025, -0.1098] m is [ 30.4263, "
    "-180.8841], at step 5000, t = 0.01218 s; healthy at step 4500; try a smaller step"
)
BAD_ENERGY = (
    "InaccurateRun: the transfers between material points and grid took 7.0% of the penetrometer's "
    "work, more than 5%: try a lower speed_ratio"
)
MESSAGES = {"completed": "", "diverged": BAD_VELOCITY, "inaccurate": BAD_ENERGY}
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
    messages = [MESSAGES.get(status, "") for status in statuses]
    return xr.Dataset(
        {
            "status": ("case", np.array(statuses)),
            "message": ("case", np.array(messages)),
            "case_key": ("case", np.array([f"key {place}" for place in range(len(statuses))])),
        },
        coords={
            "case": range(len(statuses)),
            **{name: ("case", np.array(values)) for name, values in parameters.items()},
        },
        attrs={
            "design": design,
            "scene": "cone_penetration",
            "scene_version": 1,
            "study": "made",
            "title": "Made up",
            "format_version": FORMAT_VERSION,
        },
    )


def one_at_a_time(outcomes: Sequence[tuple[dict[str, object], str]] = OUTCOMES) -> xr.Dataset:
    cases = [{**DEFAULTS, **changed} for changed, _ in outcomes]
    columns = {name: [case[name] for case in cases] for name in DEFAULTS}
    return made("one_at_a_time", [status for _, status in outcomes], **columns)


def strip_of(dataset: xr.Dataset, name: str) -> Strip:
    return next(strip for strip in strips(dataset) if strip.values.name == name)


def random_cases() -> xr.Dataset:
    """Of each fifth of the stiffness 0, 1, 2, 3, 4 in 4 diverge; the strength has no say."""
    stiffness = np.arange(1.0, 21.0)
    status = np.where((stiffness - 1) % 4 < (stiffness - 1) // 4, "diverged", "completed")
    strength = np.tile([1.0, 2.0], 10)
    return made(
        "latin_hypercube", status.tolist(), strength=strength.tolist(), stiffness=stiffness.tolist()
    )


def test_stable_is_what_completed_up_to_the_first_failure_on_either_side() -> None:
    strip = strip_of(one_at_a_time(), "speed_ratio")
    assert strip.default == 0.03
    assert strip.stable.tolist() == [0.01, 0.03, 0.1]
    assert strip.stable_text == "0.01 to 0.1"


def test_the_margin_is_a_factor_where_values_span_decades() -> None:
    strip = strip_of(one_at_a_time(), "speed_ratio")
    assert strip.margin(-1) == "0.001 (factor 30), diverged: velocity of particle 352"
    assert strip.margin(1) == (
        "0.3 (factor 10), inaccurate: the transfers between material points and grid took 7.0% of "
        "the penetrometer's work"
    )


def test_the_margin_is_a_difference_elsewhere_and_values_beyond_a_failure_are_not_stable() -> None:
    strip = strip_of(one_at_a_time(), "poissons_ratio")
    assert strip.margin(-1) == "0.2 (difference -0.29), diverged: velocity of particle 352"
    assert strip.margin(1) == "no case"
    assert strip.stable_text == "0.3 to 0.49"


def test_a_side_without_failure_tells_how_far_it_was_tried() -> None:
    outcomes = [*OUTCOMES[:1], *(({"speed_ratio": it}, "completed") for it in (0.1, 0.4, 0.01))]
    strip = strip_of(one_at_a_time(outcomes), "speed_ratio")
    assert strip.margin(1) == "none failed up to 0.4"
    assert strip.margin(-1) == "none failed down to 0.01"


def test_where_the_default_itself_fails_nothing_is_stable() -> None:
    strip = strip_of(one_at_a_time([({}, "crashed"), *OUTCOMES[1:]]), "speed_ratio")
    assert strip.stable_text == "none"
    assert strip.margin(-1) == strip.margin(1) == "the default itself, crashed"


def test_texts_are_told_apart_from_numbers() -> None:
    strip = strip_of(one_at_a_time(), "material")
    assert (strip.stable_text, strip.margin(1)) == ("tresca, von_mises", "none failed")
    failed = strip_of(one_at_a_time([*OUTCOMES[:-1], (OUTCOMES[-1][0], "diverged")]), "material")
    assert failed.stable_text == "tresca"
    assert failed.margin(1) == "von_mises, diverged: velocity of particle 352"


def test_a_default_that_the_scene_derives_is_no_number() -> None:
    dataset = made(
        "one_at_a_time", ["completed", "completed", "diverged"], adhesion=[np.nan, 0.5, 1]
    )
    strip = strip_of(dataset, "adhesion")
    assert strip.stable_text == "derived, 0.5"
    assert strip.margin(1) == "1, diverged: velocity of particle 352"


def test_a_margin_from_zero_is_a_difference() -> None:
    dataset = made("one_at_a_time", ["completed", "completed", "diverged"], stress=[0.0, 1.0, 1e4])
    assert strip_of(dataset, "stress").margin(1).startswith("10000 (difference +1e+04), diverged")


def test_cases_that_were_not_run_are_left_out() -> None:
    statuses = ["completed", "missing", "completed"]
    dataset = made("one_at_a_time", statuses, stress=[1.0, 2.0, 3.0])
    assert strip_of(dataset, "stress").margin(1) == "none failed up to 3"
    assert strip_of(dataset, "stress").stable.tolist() == [1.0, 3.0]


def test_a_result_is_told_as_a_share_of_its_limit() -> None:
    dataset = made("one_at_a_time", ["completed"] * 3, stress=[1.0, 2.0, 3.0])
    dataset["energy_error"] = "case", np.array([-0.01, 0.02, -0.03]), {"limit": 0.04}
    assert strip_of(dataset, "stress").outcomes.limit_share == pytest.approx([0.25, 0.5, 0.75])
    assert stability_rows(dataset)[1][-1] == "up to 75% of the limit"


def test_of_several_limits_the_nearest_counts() -> None:
    dataset = made("one_at_a_time", ["completed"] * 2, stress=[1.0, 2.0])
    dataset["energy_error"] = "case", np.array([0.01, 0.01]), {"limit": 0.04}
    dataset["mass_error"] = "case", np.array([0.1, 0.4]), {"limit": 1.0}
    assert strip_of(dataset, "stress").outcomes.limit_share == pytest.approx([0.25, 0.4])
    label = stability_figure(dataset).axes[-1].get_xlabel()
    assert label.startswith("energy error over its limit of 0.04 or mass error over its limit of 1")


def test_a_result_without_a_limit_has_no_scale() -> None:
    dataset = one_at_a_time()
    dataset["energy_error"] = "case", np.full(len(OUTCOMES), 0.01)
    assert np.isnan(strip_of(dataset, "speed_ratio").outcomes.limit_share).all()
    assert len(stability_figure(dataset).axes) == len(DEFAULTS)


def test_shares_of_random_cases_over_equally_many() -> None:
    first, second = shares(random_cases())
    assert (first.values.name, second.values.name) == ("stiffness", "strength")
    assert first.case_count.tolist() == [4, 4, 4, 4, 4]
    assert first.completed.tolist() == [1.0, 0.75, 0.5, 0.25, 0.0]
    assert first.spread == 1.0
    assert [first.text(part) for part in range(5)] == [
        "1 to 4",
        "5 to 8",
        "9 to 12",
        "13 to 16",
        "17 to 20",
    ]
    assert first.failures(0) == "none"
    assert first.failures(4) == "4 diverged: velocity of particle 352"


def test_few_values_have_a_part_each() -> None:
    second = shares(random_cases())[1]
    assert second.bounds.tolist() == [[1.0, 1.0], [2.0, 2.0]]
    assert second.case_count.tolist() == [10, 10]
    assert second.completed.tolist() == [0.4, 0.6]


def test_rows_of_random_cases_name_the_worst_part() -> None:
    heading, row, _ = stability_rows(random_cases())
    assert dict(zip(heading, row, strict=True)) == {
        "parameter": "stiffness",
        "completed": "1 to 4: 100% of 4, 5 to 8: 75% of 4, 9 to 12: 50% of 4, 13 to 16: 25% of 4, "
        "17 to 20: 0% of 4",
        "spread": "100%",
        "least": "17 to 20",
        "what gives way there": "4 diverged: velocity of particle 352",
    }


def marks(figure: Figure, row: int) -> list[tuple[float, str]]:
    """Place and status of each mark of a strip."""
    lines = [line for line in figure.axes[row].lines if line.get_marker() != "None"]
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
    (legend,) = figure.legends
    told = [text.get_text() for text in legend.get_texts()]
    assert told == ["completed", "inaccurate", "diverged", "default", "stable"]


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
    ticks = [text.get_text() for text in axes.get_xticklabels()]
    assert ticks == ["1", "5", "9", "13", "17", "20"]


def test_where_all_complete_no_least_share_is_told() -> None:
    sound = made("latin_hypercube", ["completed"] * 6, stress=[1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    (axes,) = stability_figure(sound).axes
    assert [text.get_text() for text in axes.texts] == ["all 6 complete"]


def test_nothing_is_drawn_without_a_failure_or_a_limit() -> None:
    sound = made("one_at_a_time", ["completed", "completed"], stress=[1.0, 2.0])
    assert figures(sound) == {}
    energy = sound.assign(energy_error=("case", [0.01, 0.02], {"limit": 0.05}))
    assert list(figures(energy)) == ["stability"]
    assert list(figures(one_at_a_time())) == ["stability"]


@pytest.mark.parametrize(
    "attributes", [{"design": "full"}, {"design": "list"}, {"scene": "cone_bearing thick_cylinder"}]
)
def test_nothing_is_drawn_of_other_designs_and_several_scenes(attributes: dict[str, str]) -> None:
    assert figures(one_at_a_time().assign_attrs(attributes)) == {}


def test_nothing_is_drawn_where_nothing_varies_or_nothing_was_run() -> None:
    assert figures(made("one_at_a_time", ["diverged"])) == {}
    assert figures(made("one_at_a_time", ["missing"] * 2, stress=[1.0, 2.0])) == {}


def test_picture_and_table_come_out_of_plot_and_report(tmp_path: Path) -> None:
    file, page = tmp_path / "made.nc", tmp_path / "page.html"
    write_study(file, one_at_a_time())
    assert main(["plot", str(file)]) == 0
    assert (tmp_path / "made_stability.png").read_bytes().startswith(b"\x89PNG")
    assert main(["report", str(file), "-o", str(page)]) == 0
    text = page.read_text()
    assert text.count("<img") == 2  # the summary has it in small
    assert "<td>0.001 (factor 30), diverged: velocity of particle 352</td>" in text


VELOCITY = (
    "SimulationDiverged: velocity of particle 12 at [ 0.01, -0.1] m is [ 3, -4], at step 500, "
    "t = 1 s; healthy at step 0; try a smaller step"
)
STRESS = (
    "SimulationDiverged: stress of particle 7 at [0.1, 0.2] m is [1, 2, 3, 4], outside the yield "
    "surface by 0.02 of the strength, at step 500, t = 1 s; healthy at step 0; try a smaller step"
)


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


@pytest.mark.parametrize(
    ("message", "short"),
    [
        (VELOCITY, "velocity of particle 12"),
        (
            STRESS,
            "stress of particle 7, outside the yield surface by 0.02 of the strength",
        ),
        ("worker killed by SIGSEGV, at 45% of the case", "worker killed by SIGSEGV"),
        ("ended after 200 s, at 4% of the case", "ended after 200 s"),
        ("", ""),
    ],
)
def test_a_reason_is_what_gave_way(message: str, short: str) -> None:
    assert short_reason(message) == short
