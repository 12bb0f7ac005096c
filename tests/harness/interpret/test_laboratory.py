"""Tests of a laboratory: what they tell of a site, and what of them is refused."""

import math
import re
from pathlib import Path

import numpy as np
import pytest

from harness.interpret.inference.calibration import Belief, Compared, calibration
from harness.interpret.inference.real_clay import APART
from harness.interpret.inference.weights import chosen_draws
from harness.interpret.laboratory import KINDS, LaboratoryTest, read_tests
from harness.interpret.result import (
    in_words,
    laboratory_in_words,
    laboratory_points,
    laboratory_rows,
)
from harness.interpret.site import load_site
from harness.interpret.strength import interpret, laboratory_beside
from harness.interpret.tables.model_factor import (
    BETWEEN,
    DEPTH,
    MEASURED,
    SITE,
    WITHIN,
    model_causes,
    model_factor,
    with_model_factor,
)
from harness.study.distributions import sampled
from mpm_warp.grid.fitted import Floats
from tests.harness.conftest import Command, Refusal
from tests.harness.interpret.conftest import DEPTH as DEPTHS
from tests.harness.interpret.conftest import FACTOR, STRENGTH, changed

BETWEEN_SITES, WITHIN_SITE = 0.4, 0.2
MOBILISED = '"isotropic"', '"mobilised"'


def beside_cone(factors: Floats, kind: str = MEASURED, error: float = 0.0) -> Compared:
    """Tests of one kind with these ln(qnet / su) - ln Nkt, in one draw."""
    own = tuple(
        LaboratoryTest(depth=0.1 * place, strength=20.0, test=kind, error=error)
        for place in range(len(factors))
    )
    return Compared(own, np.asarray(factors, dtype=float)[:, None])


def belief(own: Compared, *others: Compared, mode: str = MEASURED) -> Belief:
    """What is known by tests, given both deviations."""
    deviations = np.array([BETWEEN_SITES]), np.array([WITHIN_SITE])
    return calibration(model_factor(), mode, deviations, own, others).belief()


def of_b(mode: str) -> tuple[float, float]:
    """Mean and variance of b of a mode."""
    mean, variance = model_factor().of_mode(mode, np.array(BETWEEN_SITES))
    return float(mean), float(variance)


@pytest.mark.parametrize(("count", "error"), [(0, 0.0), (1, 0.0), (3, 0.0), (3, 0.3), (50, 0.0)])
def test_the_deviation_of_the_site_falls_with_the_number_of_tests(count: int, error: float) -> None:
    """And its mean is that of the tests and of the other sites, by their weights."""
    seen = np.linspace(0.5, 0.9, count)
    known = belief(beside_cone(seen, error=error))
    mean, variance = of_b(MEASURED)
    weights = 1.0 / (BETWEEN_SITES**2 + variance), count / (WITHIN_SITE**2 + error**2)
    assert known.covariance[0, 0, 0] == pytest.approx(1.0 / sum(weights), rel=1e-9)
    of_tests = seen.mean() if count else 0.0
    expected = (weights[0] * mean + weights[1] * of_tests) / sum(weights)
    assert known.mean[0, 0] == pytest.approx(expected, rel=1e-9)


def test_tests_in_any_order_tell_the_same() -> None:
    one, other = (
        belief(beside_cone(np.array(seen))) for seen in ([0.1, 0.6, 0.9], [0.9, 0.1, 0.6])
    )
    for name in ("mean", "covariance", "log_likelihood"):
        np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-9)


@pytest.mark.parametrize("kind", ["CAUC", "UU", "DSS"])
def test_many_tests_of_another_mode_leave_what_is_unknown_of_b_open(kind: str) -> None:
    """They tell s as far as b of their own mode is known, and nothing of b of the mode asked."""
    known = belief(beside_cone(np.full(1000, 0.2), kind))
    own = of_b(KINDS[kind].mode)[1] + KINDS[kind].deviation ** 2
    of_site = own * BETWEEN_SITES**2 / (own + BETWEEN_SITES**2)
    assert known.covariance[0, 0, 0] == pytest.approx(of_b(MEASURED)[1] + of_site, rel=1e-2)


def test_a_kind_is_converted_by_its_ratio() -> None:
    """UU tests with 0.81 of the strength of CAUC tests tell the same mean."""
    cauc = belief(beside_cone(np.full(3, 0.2), "CAUC"), mode="triaxial_compression")
    kind = KINDS["UU"]
    factors = np.full(3, 0.2 - kind.mean)  # a lower strength has a higher factor
    uu = belief(beside_cone(factors, "UU"), mode="triaxial_compression")
    centre = of_b("triaxial_compression")[0]
    assert math.exp(kind.mean) == pytest.approx(0.81, abs=0.01)
    assert np.sign(uu.mean[0, 0] - centre) == np.sign(cauc.mean[0, 0] - centre)
    assert abs(uu.mean[0, 0] - centre) < abs(cauc.mean[0, 0] - centre)
    assert uu.covariance[0, 0, 0] > cauc.covariance[0, 0, 0]


def test_tests_of_another_layer_tell_less_by_what_its_inputs_leave_open() -> None:
    inputs = np.array([-0.2, 0.2])
    seen = Compared(beside_cone(np.zeros(3)).tests, np.tile(inputs, (3, 1)))
    deviations = np.full(2, BETWEEN_SITES), np.full(2, WITHIN_SITE)
    known = calibration(
        model_factor(), MEASURED, deviations, beside_cone(np.zeros(0)), [seen]
    ).belief()
    prior = BETWEEN_SITES**2 + of_b(MEASURED)[1]
    of_layer = WITHIN_SITE**2 / 3 + 0.2**2
    expected = 1.0 / (1.0 / prior + 1.0 / of_layer)
    np.testing.assert_allclose(known.covariance[:, 0, 0], expected, rtol=1e-9)


def test_a_site_drawn_from_the_model_is_covered_with_three_tests() -> None:
    known = model_factor()
    drawn = sampled(model_causes(known), 2048, 1)
    rng, inside, width = np.random.default_rng(3), [], []
    for row in rng.integers(0, 2048, 150):
        mean, variance = known.of_site(MEASURED, drawn[BETWEEN][row])
        site = mean + math.sqrt(variance) * rng.normal()
        depths = site + drawn[WITHIN][row] * rng.normal(size=13)
        own = Compared(beside_cone(depths[:3]).tests, np.repeat(depths[:3, None], 2048, axis=1))
        told = calibration(known, MEASURED, (drawn[BETWEEN], drawn[WITHIN]), own, ()).belief()
        inputs = with_model_factor(drawn, told.mean[:, 0], told.covariance[:, 0, 0])
        chosen, _ = chosen_draws(told.log_likelihood, 1)
        low, high = np.quantile(np.log(inputs[SITE] * inputs[DEPTH])[chosen], [0.05, 0.95])
        inside.append(np.mean((depths[3:] >= low) & (depths[3:] <= high)))
        width.append(high - low)
    assert np.mean(inside) == pytest.approx(0.90, abs=0.03)
    assert np.mean(width) < 1.2  # 1.8 without a test


def laboratory(share: float, depths: tuple[float, ...], kind: str = "mobilised") -> str:
    """Tables of tests with a share of the strength of the ground of `conftest`."""
    rows = ((depth, share * float(np.interp(depth, DEPTHS, STRENGTH)) / 1e3) for depth in depths)
    return "".join(
        f'[[laboratory]]\ndepth = {depth}\nstrength = {strength:.4f}\ntest = "{kind}"\n'
        for depth, strength in rows
    )


def with_laboratory(folder: Path, text: str) -> Path:
    """The site file with tables of tests."""
    path = changed(folder, MOBILISED)
    path.write_text(path.read_text() + text)
    return path


def test_tests_at_a_site_tell_its_strength(folder: Path) -> None:
    """The strength of this ground is half of that of simulated clay."""
    depths = tuple(np.linspace(2.5, 9.5, 10))
    site = load_site(with_laboratory(folder, laboratory(0.5, depths)))
    found = interpret(site)
    used = found.reason.values == 0
    low, middle, high = found.strength.values[used].T / STRENGTH[used]
    np.testing.assert_allclose(middle, 0.5, rtol=0.05)
    assert np.all(high / low < 1.5)
    before, after = (
        found[f"input_{time}"].sel(cause="site_factor").values[0] for time in ("before", "after")
    )
    assert before[2] / before[0] > 3.0
    assert after[1] == pytest.approx(2.0, rel=0.05)
    assert after[2] / after[0] < 1.3
    assert "by 10 laboratory tests of this site. It is found by tip" in in_words(site, found)[0]
    nkt, factor = laboratory_in_words(site, found)
    mean = 2.0 * FACTOR
    assert nkt == (
        f"Nkt of the site by mobilised: mean {mean:.1f}, standard deviation 0.0, "
        "10 laboratory tests."
    )
    assert re.match(
        r"2 to 10 m: the model factor of the site, real over computed, is (2\.0|1\.9)", factor
    )
    assert {row[-2] for row in laboratory_rows(found)[1:]} == {"inside"}


def test_a_test_is_in_the_picture_in_the_mode_of_the_layer(folder: Path) -> None:
    """One of the mode asked as it is; of compression, lower, by the ratio that tests let expect."""
    text = laboratory(0.5, (4.0,)) + laboratory(0.7, (5.0,), "CAUC")
    found = interpret(load_site(with_laboratory(folder, text)))
    (_, first), (_, second) = laboratory_points(found)
    own = found.laboratory_strength.values
    assert first == pytest.approx(own[0], rel=1e-12)
    assert 0.5 < second / own[1] < 0.85


def test_a_test_that_the_others_contradict_is_marked(folder: Path) -> None:
    text = laboratory(0.7, (3.0, 4.0, 5.0, 6.0, 7.0)) + laboratory(3.0, (8.0,))
    rows = laboratory_rows(interpret(load_site(with_laboratory(folder, text))))
    assert [row[-2] for row in rows[1:]] == ["inside"] * 5 + ["outside"]


def test_a_test_between_two_rows_has_the_resistance_between_them(folder: Path) -> None:
    site = load_site(with_laboratory(folder, laboratory(0.5, (5.05,))))
    (beside,) = laboratory_beside(site)
    # The error of the table is all that is left.
    assert np.median(beside.factor) == pytest.approx(math.log(2.0), abs=1e-3)


def two_layers(folder: Path, depths: tuple[float, ...]) -> Path:
    """The layer parted at 6 m, the upper part with a wide range, and tests at depths."""
    path = with_laboratory(folder, laboratory(0.5, depths))
    text = path.read_text()
    layer = text[text.index("[[layer]]") : text.index("[[laboratory]]")]
    second = layer.replace("from = 2", "from = 6")
    text = text.replace("to = 10", "to = 6", 1).replace("= 120", "= { low = 50, high = 300 }", 1)
    path.write_text(text.replace("[[laboratory]]", f"{second}\n[[laboratory]]", 1))
    return path


def test_tests_in_one_layer_count_less_in_another(folder: Path) -> None:
    found = interpret(load_site(two_layers(folder, (3.0, 4.0, 5.0))))
    assert found.laboratory_tests.values.tolist() == [3.0, 3.0]
    before, after = (
        found[f"input_{time}"].sel(cause="site_factor").values for time in ("before", "after")
    )
    widths = [np.log(it[:, 2] / it[:, 0]) for it in (before, after)]
    assert widths[1][0] < widths[1][1] < 0.7 * widths[0][1]


def test_a_test_on_a_border_counts_once_in_the_lower_layer(folder: Path) -> None:
    site = load_site(two_layers(folder, (6.0,)))
    assert [len(it.tests) for it in laboratory_beside(site)] == [0, 1]
    assert interpret(site).laboratory_tests.values.tolist() == [1.0, 1.0]


@pytest.mark.usefixtures("undrawn")
def test_soundings_of_a_site_share_its_tests(here: Path, command: Command) -> None:
    site = with_laboratory(here, laboratory(0.5, (5.0,)))
    alone = site.read_text()
    (here / "other.toml").write_text(alone[: alone.index("[[laboratory]]")])
    told = command("interpret", "site.toml", "other.toml").out
    assert told.count("by 1 laboratory test of this site") == 2
    assert "without a laboratory test of this site" in command("interpret", "other.toml").out


def test_a_test_in_two_site_files_is_refused(here: Path, refusal: Refusal) -> None:
    site = with_laboratory(here, laboratory(0.5, (5.0,)))
    (here / "other.toml").write_text(site.read_text())
    line = refusal(["interpret", "site.toml", "other.toml"])
    assert line.startswith("harness: other.toml: [[laboratory]]: the test mobilised of 7.75 kPa")
    assert "is in site.toml too, and would count twice" in line


def test_a_test_without_a_strength_beside_it_is_told(folder: Path) -> None:
    """Outside all layers, or further than allowed from a depth with a strength."""
    text = laboratory(0.5, (5.0, 11.0))
    found = interpret(load_site(with_laboratory(folder, text)))
    assert "the laboratory test at 11 m is not used" in found.attrs["notes"]
    rows = (folder / "test.csv").read_text().splitlines()
    kept = [row for row in rows[1:] if abs(float(row.split(",")[0]) - 5.0) > APART]
    (folder / "test.csv").write_text("\n".join([rows[0], *kept]))
    notes = interpret(load_site(folder / "site.toml")).attrs["notes"]
    assert "the laboratory test at 5 m is not used" in notes


def test_a_csv_has_the_same_tests(folder: Path) -> None:
    """With another mark and blanks, and a column for errors."""
    in_file = load_site(with_laboratory(folder, laboratory(0.5, (5.0, 7.0), "DSS"))).laboratory
    for mark in (", ", " , ", ";", ","):
        rows = [mark.join(["depth [m]", "strength [kPa]", "test", "error"])]
        rows += [mark.join([f"{it.depth}", f"{it.strength}", it.test, "0.1"]) for it in in_file]
        (folder / "lab.csv").write_text("\n".join(rows))
        read = load_site(folder / "site.toml", folder / "lab.csv").laboratory
        assert [(it.depth, it.strength, it.test) for it in read] == [
            (it.depth, it.strength, it.test) for it in in_file
        ]
        assert {it.error for it in read} == {0.1}


@pytest.mark.parametrize(
    ("heading", "row"),
    [
        ("z (m);cu (kPa);type;error [%]", "5,0;20,5;field vane;10"),
        ("Site A;;;\nsample;Depth [ft];Su [MPa];Method;error", "B1;16.4041995;0.0205;FVT;0.1"),
        ("depth_m,su_kPa,test,strength ratio,error", "5,20.5,vane,0.3,0.1"),
        ("test\tundrained shear strength [kN/m2]\tdepth [cm]\terror", "Vane\t20.5\t500\t0.1"),
    ],
)
def test_a_csv_may_have_the_usual_names_and_units(tmp_path: Path, heading: str, row: str) -> None:
    (tmp_path / "lab.csv").write_text(f"{heading}\n{row}\n")
    (test,) = read_tests(tmp_path / "lab.csv")
    assert (test.test, test.depth) == ("vane", pytest.approx(5.0))
    assert (test.strength, test.error) == (pytest.approx(20.5), pytest.approx(0.1))


HEAD = "depth [m],strength [kPa],test\n"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            "depth,strength,test\n5,15,UU",
            "column 'depth': must be CSV with columns as depth [m], su [kPa], test, and error",
        ),
        ("depth [m],su [kPa]\n5,15", "has no column 'test' among depth [m], su [kPa]: must be"),
        ("z [m],su [kPa],metod\n5,1,UU", "column 'metod': must be CSV with columns as depth [m]"),
        ("z [m],su [kPa],cu [kPa],test\n5,1,1,UU", "column 'cu [kPa]': must be"),
        (f"{HEAD}5,15,UU\n6,-1,UU", "line 3: strength = -1.0 is not allowed: must be a number > 0"),
        (f"{HEAD}5,nan,UU", "line 2: strength = 'nan' is not allowed: must be a number"),
        (f"{HEAD}5,15", "line 2: test: is missing"),
        (f"{HEAD}5,15,CUAC", "line 2: test = 'CUAC' is not allowed: must be one of 'CAUC'"),
        (f"{HEAD}5,15,UU,3", "line 2: has more values than the header"),
        (f"{HEAD}{'5' * 200_000},1,UU", "is no table: field larger"),
        (
            f"{HEAD}5,15,UU\n6,15,UU\n5,15,UU",
            "line 4: the test UU of 15 kPa at 5 m is there before, and would count twice",
        ),
        (HEAD + "5,15,UU\n" * 101, "line 102: a site has at most 100 tests"),
    ],
    ids=[
        "titles",
        "lacks",
        "near",
        "twice",
        "below 0",
        "no number",
        "no value",
        "kind",
        "more",
        "long",
        "same",
        "many",
    ],
)
def test_a_csv_that_cannot_be_is_one_line(
    text: str, told: str, here: Path, refusal: Refusal
) -> None:
    Path("lab.csv").write_text(text, encoding="utf-8")
    line = refusal(["interpret", "site.toml", "--laboratory", "lab.csv"])
    assert line.startswith("harness: lab.csv: ")
    assert told in line


def test_a_csv_is_of_one_sounding(here: Path, refusal: Refusal) -> None:
    Path("lab.csv").write_text(HEAD, encoding="utf-8")
    line = refusal(["interpret", "site.toml", "site.toml", "--laboratory", "lab.csv"])
    assert "--laboratory is of one sounding" in line


def test_numbers_and_kinds_of_a_csv_are_checked(folder: Path) -> None:
    (folder / "lab.csv").write_text(f"{HEAD}5, 15, vane\n")
    (test,) = read_tests(folder / "lab.csv")
    assert (test.depth, test.strength, test.test, test.error) == (5.0, 15.0, "vane", 0.0)
