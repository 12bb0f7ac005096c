"""The model factor: what measured sites tell of real clay, and what is stated without them."""

import math
from pathlib import Path

import numpy as np
import pytest

from harness.interpret.result import in_words
from harness.interpret.site import MODES, load_site
from harness.interpret.strength import interpret
from harness.interpret.tables.model_factor import (
    BETWEEN,
    DEPTH,
    MEASURED,
    OF_PRACTICE,
    SITE,
    ModelFactor,
    SiteFigures,
    fitted,
    measured_sites,
    model_causes,
    model_factor,
    pressure_factor,
    with_model_factor,
)
from harness.pictures.drawing.style import FAILED
from harness.pictures.measured.interpreted import interpretation_figure
from harness.study.distributions import sampled
from mpm_warp.grid.fitted import Floats
from tests.harness.interpret.conftest import DEPTH as DEPTHS
from tests.harness.interpret.conftest import FACTOR, STRENGTH, changed, measured_rows

MEAN, BETWEEN_SITES, WITHIN_SITE = 0.3, 0.4, 0.25
"""Of the sites that are drawn here."""


def sites_of_a_model(rng: np.random.Generator, count: int) -> list[SiteFigures]:
    """Figures of sites with ten depths each, drawn from the model."""
    found = []
    for number in range(count):
        own = MEAN + rng.normal(0.0, BETWEEN_SITES) + rng.normal(0.0, WITHIN_SITE, 10)
        of_nkt = 2.6, 0.0  # without an error by the inputs
        measured = own.mean() + of_nkt[0], own.std(ddof=1)
        found.append(
            SiteFigures(number, 10, *measured, *of_nkt, own.std(ddof=1), 1.5, 0.6, 30.0, 0.4)
        )
    return found


def drawn(known: ModelFactor, mode: str = MEASURED) -> Floats:
    """Draws of ln of the model factor of a depth at a site without a test of its own."""
    shares = sampled(model_causes(known), 2048, 1)
    inputs = with_model_factor(shares, *known.of_site(mode, shares[BETWEEN]))
    return np.log(inputs[SITE] * inputs[DEPTH])


def test_a_site_drawn_from_the_model_is_covered() -> None:
    """In the band of 90 % of draws that know the model by fifteen other sites."""
    rng, inside = np.random.default_rng(1), []
    for _ in range(200):
        low, high = np.quantile(drawn(fitted(sites_of_a_model(rng, 15))), [0.05, 0.95])
        true = MEAN + rng.normal(0.0, BETWEEN_SITES) + rng.normal(0.0, WITHIN_SITE, 20)
        inside.append(np.mean((true >= low) & (true <= high)))
    assert np.mean(inside) == pytest.approx(0.90, abs=0.03)


def test_many_sites_tell_the_model() -> None:
    known = fitted(sites_of_a_model(np.random.default_rng(2), 1500))
    between = known.between_at(np.array(0.5))
    assert between == pytest.approx(BETWEEN_SITES, rel=0.05)
    mean, variance = known.of_mode(MEASURED, between)
    assert mean == pytest.approx(MEAN, abs=3.0 * math.sqrt(variance))
    assert variance == pytest.approx(BETWEEN_SITES**2 / 1500, rel=0.15)
    assert np.median(known.within) == pytest.approx(WITHIN_SITE, rel=0.05)


def test_the_figures_of_the_measured_sites_give_b_and_deviations() -> None:
    """By moments: the variance of the means of sites is that between them and that of each."""
    sites = measured_sites()
    assert len(sites) == 15
    assert sum(site.depths for site in sites) == 219
    own = np.array([site.measured - site.computed for site in sites])
    of_mean = [site.within**2 / site.depths + site.computed_deviation**2 for site in sites]
    known = model_factor()
    between = known.between[1 + np.argmax(np.diff(known.probability))]  # the most probable
    assert between == pytest.approx(math.sqrt(own.var(ddof=1) - np.mean(of_mean)), rel=0.05)
    mean, variance = known.of_mode(MEASURED, between)
    assert mean == pytest.approx(own.mean(), abs=0.01)
    assert math.sqrt(variance) == pytest.approx(own.std(ddof=1) / math.sqrt(15), rel=0.1)
    assert known.within.tolist() == sorted(site.within for site in sites)


def test_the_median_strength_is_that_of_the_measured_sites() -> None:
    """The factor of a depth has the mean of all sites; two thirds to three times are usual."""
    low, middle, high = np.exp(np.quantile(drawn(model_factor()), [0.05, 0.5, 0.95]))
    assert middle == pytest.approx(1.42, abs=0.02)
    assert high / middle == pytest.approx(2.4, abs=0.2)
    assert middle / low == pytest.approx(2.4, abs=0.2)


def test_compression_has_the_factors_of_practice() -> None:
    """Mayne & Peuchen 2018 found 8 to 25 in 62 clays; the band of 90 % is as wide."""
    typical = np.mean([site.computed for site in measured_sites()]) + math.log(0.758)
    low, high = np.exp(typical + np.quantile(drawn(model_factor(), OF_PRACTICE), [0.05, 0.95]))
    assert 4.0 < low < 8.0
    assert 22.0 < high < 28.0


def test_a_mode_without_evidence_has_the_widest_band() -> None:
    widths = {mode: np.std(drawn(model_factor(), mode)) for mode in MODES[:-1]}
    known = max(widths[MEASURED], widths[OF_PRACTICE])
    assert all(
        width > 1.05 * known
        for mode, width in widths.items()
        if mode not in (MEASURED, OF_PRACTICE)
    )


@pytest.mark.parametrize(
    ("mode", "told"),
    [
        ("mobilised", "with 90 %, without a laboratory test of this site. It is found by tip"),
        ("simple_shear", "this site, with a model factor not measured in this mode. It"),
        ("triaxial_compression", "of this site, with a model factor as in practice. It is"),
        ("isotropic", "for simulated clay, from which real clay departs. It is"),
    ],
)
def test_a_sentence_says_what_the_band_rests_on(folder: Path, mode: str, told: str) -> None:
    site = load_site(changed(folder, ('"isotropic"', f'"{mode}"')))
    found = interpret(site)
    assert told in in_words(site, found)[0]
    causes = {"site_factor", "depth_factor"} & set(found.cause.values.tolist())
    assert len(causes) == (0 if mode == "isotropic" else 2)


def test_the_pore_pressure_of_real_clay_is_that_of_the_sites() -> None:
    """Bq is 1.48 times the computed one, and tells nothing of the factor of the tip."""
    sites = measured_sites()
    shift, deviation = pressure_factor()
    pressures = np.array([site.pressure for site in sites])
    assert shift == pytest.approx(pressures.mean(), rel=1e-9)
    assert deviation == pytest.approx(pressures.std(ddof=1) * math.sqrt(16 / 15), rel=1e-9)
    assert shift == pytest.approx(0.39, abs=0.01)
    factors = [site.factor for site in sites]
    # Of 15 pairs without any correlation 95 % are within 0.51.
    assert abs(np.corrcoef(factors, pressures)[0, 1]) < 0.51


@pytest.mark.parametrize(
    ("measure", "times", "told"),
    [
        ("fs", 1.0, "fs is 6.8 kPa, within what the inputs allow, "),
        ("fs", 3.0, "fs is 20.4 kPa, above what the inputs allow, "),
        ("u2", 1.0, "Bq is 0.50, within what the inputs allow, "),
        ("u2", 0.15, "Bq is 0.08, below what the inputs allow, "),
    ],
)
def test_what_the_inputs_allow_is_said(folder: Path, measure: str, times: float, told: str) -> None:
    """And marked in the picture at all depths of the layer, or at none."""
    friction = 0.4 * STRENGTH * (times if measure == "fs" else 1.0)
    share = 0.5 * (times if measure == "u2" else 1.0)
    rows = measured_rows(DEPTHS, FACTOR * STRENGTH, friction, share)
    (folder / "test.csv").write_text(rows)
    site = load_site(changed(folder, ('"isotropic"', '"mobilised"')))
    found = interpret(site)
    (sentence,) = in_words(site, found)
    assert told in sentence
    assert sentence.count("within what the inputs allow") == (2 if times == 1.0 else 1)
    lines = [
        line for line in interpretation_figure(found).axes[0].lines if line.get_color() == FAILED
    ]
    marked = sum(np.isfinite(line.get_xdata()).sum() for line in lines)
    assert marked == (0 if times == 1.0 else (found.reason == 0).sum())


def test_the_sleeve_does_not_tell_the_model_factor(folder: Path) -> None:
    """How far fs of real clay is from that of simulated clay is not measured."""
    mode = ('"isotropic"', '"mobilised"')
    use = ('title = "A site"', 'title = "A"\nuse = ["tip", "sleeve"]')
    site = load_site(changed(folder, mode, use))
    found = interpret(site)
    both = found.input_before, found.input_after
    before, after = (it.sel(cause="site_factor").values[0] for it in both)
    np.testing.assert_allclose(after, before, rtol=0.03)


@pytest.mark.parametrize(
    ("change", "mode", "told"),
    [
        (("[test]", 'use = ["tip", "sleeve"]\n[test]'), "mobilised", "by tip, sleeve with Nkt"),
        (("= 0.4", '= "sleeve"'), "mobilised", "by tip, adhesion by the sleeve with Nkt"),
        (("= 0.4", '= "sleeve"'), "isotropic", ""),
        (("= 0.4", "= 0.4"), "mobilised", ""),
    ],
)
def test_a_sleeve_that_counts_is_said_to_be_unchecked(
    folder: Path, change: tuple[str, str], mode: str, told: str
) -> None:
    site = load_site(changed(folder, change, ("isotropic", mode)))
    (sentence,) = in_words(site, interpret(site))
    assert told in sentence
    assert (". The sleeve is not checked on real ground. " in sentence) == bool(told)
