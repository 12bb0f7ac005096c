"""The measured sites beside the computed factor: each is judged by the others."""

from pathlib import Path

import numpy as np
import pytest

from harness.interpret.tables import evidence as of_sites
from harness.interpret.tables.evidence import evidence, inside
from harness.interpret.tables.model_factor import measured_sites
from harness.pictures.measured.evidence import evidence_figure
from tests.harness.conftest import Command, Refusal


def test_a_site_is_told_by_its_figures() -> None:
    """Site 701: exp(3.031 -+ 1.645 0.08395) and exp(2.645 -+ 1.645 0.135)."""
    own = evidence().sel(site="701")
    np.testing.assert_allclose(own.measured, [18.05, 20.72, 23.79], rtol=1e-3)
    np.testing.assert_allclose(own.computed, [11.28, 14.08, 17.59], rtol=1e-3)
    low, middle, high = own.predicted.values
    assert low < own.computed.values[0] < own.computed.values[1] < middle < high


def test_a_site_is_no_part_of_what_it_is_judged_by(monkeypatch: pytest.MonkeyPatch) -> None:
    before = evidence()
    first, *others = measured_sites()
    moved = first._replace(measured=first.measured + 0.5, within=2.0 * first.within)
    monkeypatch.setattr(of_sites, "measured_sites", lambda: (moved, *others))
    after, name = evidence(), f"{first.site:g}"
    np.testing.assert_array_equal(after.predicted.sel(site=name), before.predicted.sel(site=name))
    rest = [it for it in before.site.values if it != name]
    moved_up = after.predicted.sel(site=rest, percentile=50.0) / before.predicted.sel(site=rest)
    assert float(moved_up.sel(percentile=50.0).min()) > 1.01


def test_the_command_prints_and_draws_the_sites(here: Path, command: Command) -> None:
    told = command("references", "--field", "--out", "seen").out
    assert told.count(" to ") >= 3 * len(measured_sites())
    assert "In the band: 4 of 15 sites as computed, 15 as" in " ".join(told.split())
    assert "CLAY/10/7490" in told
    assert told.endswith("seen/field_sites.png\n")
    assert (here / "seen/field_sites.png").stat().st_size > 10000


def test_dots_bars_and_bands_are_those_of_the_sites() -> None:
    found = evidence()
    assert [inside(found, name) for name in ("computed", "predicted")] == [4, 15]
    (axes,) = evidence_figure(found).axes
    wide, narrow, bars = axes.containers
    for drawn, name in ((wide, "predicted"), (narrow, "computed")):
        ends = [(it.get_y(), it.get_y() + it.get_height()) for it in drawn]
        np.testing.assert_allclose(ends, found[name].sel(percentile=[5.0, 95.0]))
    np.testing.assert_allclose(bars[0].get_ydata(), found.measured.sel(percentile=50.0))


@pytest.mark.parametrize("words", [["lu_2004", "--field"], ["--field", "--out", "file"]])
def test_what_cannot_be_is_refused(words: list[str], here: Path, refusal: Refusal) -> None:
    (here / "file").write_text("mine")
    assert refusal(["references", *words])
    assert (here / "file").read_text() == "mine"
