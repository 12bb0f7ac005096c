"""References that a study's own file defines, in the table, in the picture and on the page."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from harness.archive.study_files import read_study
from harness.cli.main import main
from harness.compare.compared import misses, stored_references
from harness.compare.result_table import result_table
from harness.report.report import page
from harness.run.collect_and_clean import collect_and_write
from harness.study.description import study_text
from harness.study.study import load_study
from tests.harness.conftest import DONE, Refusal, keep, study_in
from tests.harness.pictures.conftest import caption_of, figures, texts

STUDY = """
title = "t"
scene = "cone_penetration"
[vary]
rigidity_index = [50, 100, 200]
[fixed]
adhesion_factor = 0.5
[references.our_lab]
formula = "10 + alpha_c + apex_angle / 60"
label = "Our <laboratory> 2026"
source = "unpublished"
how_known = "measured"
range = { Ir = [80, 200] }
"""
FORMULA = '[references.it]\nformula = "Ir"\nlabel = "l"\nsource = "s"\n'


Computed = Callable[[str], xr.Dataset]
"""Makes the result of a study of three cases, given its text."""


@pytest.fixture
def computed(tmp_path: Path) -> Computed:
    """Collects a study whose cone factors are given, and reads its file; the study is gone then."""

    def made(text: str) -> xr.Dataset:
        study = study_in(tmp_path, text)
        factors = [DONE.assign(cone_factor=DONE.cone_factor + 0.35 + it) for it in range(3)]
        for it in factors:
            it.cone_factor.attrs = DONE.cone_factor.attrs
        keep(study, tmp_path, *factors)
        collect_and_write(study, tmp_path)
        study.source.unlink()
        return read_study(tmp_path / "s.nc")

    return made


def test_it_has_its_value_within_its_range_and_table_and_page_say_so(computed: Computed) -> None:
    result = computed(STUDY)
    np.testing.assert_allclose(result.reference_our_lab, [np.nan, 11.5, 11.5], rtol=1e-15)
    np.testing.assert_allclose(result.deviation_our_lab[1:], [-0.15 / 11.5, 0.85 / 11.5])
    table, (text, _) = result_table(result), page([result])
    (outside, *_), (within, *_) = (
        [line for line in table.splitlines() if line.split()[:1] == [index]]
        for index in ("50", "100")
    )
    assert "[outside]" in outside
    assert "11.50  -1.3%" in within
    assert "our_lab: unpublished; criterion not stated, test of su not stated; Ir 80" in table
    assert "measured" in table
    for told in ("Our &lt;laboratory&gt; 2026", "10 + alpha_c + apex_angle / 60", "measured"):
        assert f"<td>{told}</td>" in text


def test_one_without_a_value_anywhere_is_told(
    computed: Computed, capsys: pytest.CaptureFixture[str]
) -> None:
    """A warning of NumPy is an error of every test."""
    for text in ('"sqrt(-1 - alpha_c)"', '"Ir"\nrange = { Delta = 1 }'):
        computed(f"{STUDY}{FORMULA}".replace('"Ir"', text))
        (told,) = capsys.readouterr().err.splitlines()
        assert told.startswith("harness: reference it: has a value for none of the cases (")


def test_a_formula_that_is_0_has_no_deviation_and_no_remark(computed: Computed) -> None:
    """A warning of NumPy is an error of every test."""
    result = computed(STUDY.replace("10 + alpha_c", "0 * alpha_c - 1"))
    assert np.isinf(result.deviation_our_lab[1:]).all()


def test_the_picture_draws_it_within_its_range(computed: Computed) -> None:
    figure = figures(computed(STUDY.replace("2026", "$2026$")))["curve"]  # no mathematics
    (axes,) = figure.axes
    assert r"Our <laboratory> \$2026\$" in texts(axes.texts)
    (curve,) = (it for it in axes.lines if np.asarray(it.get_ydata()).size > 100)
    x, y = np.asarray(curve.get_xdata()), np.asarray(curve.get_ydata())
    assert x[np.isfinite(y)].min() == pytest.approx(80.0, abs=1.0)
    np.testing.assert_allclose(y[np.isfinite(y)], 11.5)
    assert "is drawn within its range: Ir 80 to 200." in caption_of(figure)


POINTS = STUDY.replace(
    'formula = "10 + alpha_c + apex_angle / 60"',
    'criterion = "tresca"\nsu_mode = "triaxial_compression"\n'
    "points = { Ir = [50, 100, 100, 150], alpha_c = [0.5, 0.5, 1, 0.5], Nc = [9, 10, 11, 12] }",
)


def test_points_are_values_of_the_cases_that_have_their_conditions(computed: Computed) -> None:
    """That of Ir 50 is outside the range; 150 is between two cases, so it is in the picture."""
    result = computed(POINTS)
    np.testing.assert_array_equal(result.reference_our_lab, [np.nan, 10.0, np.nan])
    (kept,) = stored_references(result)
    assert (kept.text, kept.su_mode) == ("4 points over Ir, alpha_c", "triaxial_compression")
    table = result_table(result)
    assert table.count("[outside]") == 2
    assert "Tresca, su in triaxial compression; Ir 80 to 200" in table
    (axes,) = figures(result)["curve"].axes
    (marks,) = (it for it in axes.lines if it.get_marker() == "D")
    shown = [point for point in np.asarray(marks.get_xydata()).tolist() if np.isfinite(point[1])]
    assert shown == [[100.0, 10.0], [150.0, 12.0]]


def test_columns_may_be_parameters_of_a_law(tmp_path: Path) -> None:
    """Their names need no quotes."""
    name = "material.swelling_slope"
    own = f"points = {{ {name} = [0.03], Nc = [9] }}\nrange = {{ {name} = [0.03, 0.04] }}"
    study = study_in(tmp_path, f"{STUDY}{FORMULA}".replace('formula = "Ir"', own))
    assert study.compared.references[1].names == {name}


def test_it_may_have_a_tolerance_which_holds_within_its_range(computed: Computed) -> None:
    text = STUDY + '[compare]\nreferences = ["lu_2004", "our_lab"]\ntolerance = { our_lab = 0.05 }'
    ((missed,),) = misses(computed(text)).values()
    assert "rigidity_index=200" in missed


def test_it_is_inherited_from_a_base_and_changed_there(tmp_path: Path) -> None:
    (tmp_path / "base.toml").write_text(STUDY)
    (tmp_path / "s.toml").write_text('base = "base.toml"\n' + FORMULA)
    study = load_study(str(tmp_path / "s.toml"))
    assert [it.id for it in study.compared.references] == ["our_lab", "it"]


def test_one_damaged_in_a_result_is_told(
    computed: Computed, tmp_path: Path, refusal: Refusal
) -> None:
    result = computed(STUDY)
    result.reference_our_lab.attrs["formula"] = "__import__('os')"
    with pytest.raises(Exception, match="reference our_lab: formula") as caught:
        result_table(result)
    assert "\n" not in str(caught.value)


def test_a_new_study_has_one_to_be_filled_in(tmp_path: Path) -> None:
    text = study_text("s", "cone_penetration")
    lines = text[text.index("#[references.") :].splitlines()
    file = tmp_path / "s.toml"
    file.write_text(text + "\n".join(line.removeprefix("#") for line in lines))
    assert main(["describe", str(file)]) == 0
    (own,) = load_study(str(file)).compared.references
    assert own.label == "Our laboratory 2026"
