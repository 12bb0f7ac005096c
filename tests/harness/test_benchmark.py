"""The open benchmark: its cases can be run, scores tell who is wrong, bad submissions are told."""

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from harness.benchmark import cases as benchmark
from harness.benchmark.cases import META_KEYS, Result, Submission, benchmark_cases
from harness.benchmark.score import formulas, scores, summary_rows
from harness.report.plain_pages import benchmark_figure
from harness.study.tables import StudyError
from mpm_warp.scenes import scene_class

META = dict.fromkeys(META_KEYS, "told")
ROWS = "case,value,uncertainty,seconds\n"


def written(folder: Path, results: str = ROWS + "cone_100_smooth,10.5,0.1,7\n", **meta) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    lines = [f"{key} = {json.dumps(value)}" for key, value in {**META, **meta}.items() if value]
    (folder / "meta.toml").write_text("\n".join(lines))
    (folder / "results.csv").write_text(results)
    return folder


def test_each_case_is_a_scene_that_this_program_takes():
    names = [case.name for case in benchmark_cases()]
    assert len(set(names)) == len(names)
    for case in benchmark_cases():
        for settings in case.accuracy.values():
            scene_class(case.scene)(**{**case.fixed, **settings})


def test_the_cases_are_utf_8_with_or_without_a_mark(tmp_path, monkeypatch):
    shipped = (benchmark.benchmark_folder() / "cases.csv").read_bytes()
    title = benchmark_cases()[0].title
    marked = b"\xef\xbb\xbf" + shipped.replace(title.encode(), "größer".encode())
    (tmp_path / "cases.csv").write_bytes(marked)
    monkeypatch.setattr(benchmark, "benchmark_folder", lambda: tmp_path)
    assert benchmark_cases()[0].title == "größer"


def test_the_shipped_schema_is_that_of_the_keys():
    path = benchmark.benchmark_folder() / "schema.json"
    said = json.loads(path.read_text())
    assert {key: it["description"] for key, it in said["properties"].items()} == META_KEYS
    assert said["required"] == list(META_KEYS)
    assert said["additionalProperties"] is False


def test_a_wrong_case_is_found():
    cases = benchmark_cases()
    right = {case.name: Result(10.0, 0.1, 1.0) for case in cases if case.exact is None}
    right |= {case.name: Result(case.exact[0], 0.1, 1.0) for case in cases if case.exact}
    wrong = dict(right, cone_rough=Result(7.0, 0.1, 1.0), cone_rate=Result(10.5, 0.1, 1.0))
    both = [Submission("right", META, right), Submission("wrong", META, wrong)]
    outside = {
        (it.submission, it.case.name): it for it in scores(cases, both, "right") if it.distance > 1
    }
    assert set(outside) == {("wrong", "cone_rough"), ("wrong", "cone_rate")}
    # 7.0 lies 0.297 above the nearer bound, 6.703; 10.5 lies 0.5 from 10.0, and both have a U.
    assert outside["wrong", "cone_rough"].distance == pytest.approx(2.97)
    assert outside["wrong", "cone_rate"].distance == pytest.approx(0.5 / (0.1 * 2**0.5))
    inside = {row[0]: row[3] for row in summary_rows(scores(cases, both, "right"))}
    assert (inside["right"], inside["wrong"]) == ("10 of 10", "23 of 25")


@pytest.mark.parametrize(("value", "error"), [(0.0, math.nan), (-5.0, 3.0)])
def test_a_yardstick_may_be_zero_or_below(value, error):
    """A submission may state any number, and any may be the yardstick."""
    stated = {"one": value, "other": 10.0}
    given = [
        Submission(name, META, {"cone_rate": Result(number, math.nan, math.nan)})
        for name, number in stated.items()
    ]
    found = {it.submission: it.error for it in scores(benchmark_cases(), given, "one")}
    assert found["other"] == pytest.approx(error, nan_ok=True)


def test_two_submissions_of_one_name_are_told(tmp_path, refusal):
    """Their results would be counted as those of one: a folder has the name of a formula here."""
    folder = written(tmp_path / "lu_2004")
    line = refusal(["benchmark", "score", str(folder), "--out", str(tmp_path)])
    assert line == "harness: two submissions are called lu_2004; rename one of their folders"


def test_a_hidden_folder_is_no_submission(tmp_path):
    written(tmp_path / "theirs")
    (tmp_path / ".git").mkdir()
    assert [it.name for it in benchmark.read_submissions(tmp_path)] == ["theirs"]


def test_formulas_stand_where_they_hold_and_state_no_uncertainty():
    found = {it.name: it.results for it in formulas(benchmark_cases())}
    lu = found["lu_2004"]
    assert lu["cone_100_smooth"].value == pytest.approx(3.4 + 1.6 * 4.605170)
    assert "cone_rate" not in lu
    assert "cone_mises" not in lu  # of Tresca clay
    assert "yu_2000" not in found  # of von Mises clay by a test of su that is not stated
    # su in triaxial compression is sqrt(3)/2 of that in pure shear, and Ir 115.47 by it
    by_compression = 4 / 3 * (1 + 4.749011) * (1.25 + 115.4701 / 2000)
    mises = found["teh_houlsby_1991"]["cone_mises"]
    assert mises.value == pytest.approx(0.8660254 * by_compression, rel=1e-6)
    assert not any(it.uncertainty > 0 for it in lu.values())


def test_results_without_an_uncertainty_are_drawn_hollow():
    found = [Result(11.0, 0.1, 1.0), Result(11.0, math.nan, 1.0), Result(10.0, 0.1, 1.0)]
    given = [
        Submission(name, META, {"cone_100_smooth": it})
        for name, it in zip(("told", "not", "yardstick"), found, strict=True)
    ]
    figure = benchmark_figure(scores(benchmark_cases(), given, "yardstick"), "yardstick")
    marks = [it for it in figure.axes[1].lines if len(it.get_xdata())]
    assert [it.get_markerfacecolor() == "white" for it in marks] == [False, True]
    assert "yardstick, which is not exact" in figure.get_supxlabel()


@pytest.mark.parametrize(
    ("results", "told"),
    [
        ("", "its first row must be case,value,uncertainty,seconds"),
        ("case,value\n", "its first row must be"),
        (ROWS, "has no results"),
        (ROWS + "cone_100_smoth,10.5,,\n", "is unknown; did you mean 'cone_100_smooth'"),
        (ROWS + "cone_100_smooth,10.5\n", "row 2: has 2 cells, must have 4"),
        (ROWS + "cone_100_smooth,,,\n", "value = '' must be a finite number"),
        (ROWS + "cone_100_smooth,nan,,\n", "value = 'nan' must be a finite number"),
        (ROWS + "cone_100_smooth,inf,,\n", "value = 'inf' must be a finite number"),
        (ROWS + "cone_100_smooth,10.5,-0.1,\n", "uncertainty = -0.1 must be > 0"),
        (ROWS + "cone_100_smooth,10.5,0.1,0\n", "seconds = 0 must be > 0"),
        (ROWS + "cone_100_smooth,10.5,1 %,\n", "uncertainty = '1 %' must be a finite number"),
        (ROWS + 2 * "cone_100_smooth,10.5,,\n", "row 3: case cone_100_smooth is listed twice"),
        (ROWS + "cone_100_smooth;10.5;;\n", "row 2: has 1 cells, must have 4"),
    ],
)
def test_malformed_results_are_told_in_one_line(results, told, tmp_path, refusal):
    folder = written(tmp_path / "theirs", results)
    line = refusal(["benchmark", "score", str(folder), "--out", str(tmp_path)])
    assert "results.csv" in line
    assert told in line


@pytest.mark.parametrize(
    ("meta", "told"),
    [
        ({"author": None}, "author: is missing; who computed"),
        ({"author": 7}, "author = 7 is not allowed: must be a text of one line"),
        ({"autor": "a", "author": None}, "unknown key; did you mean 'author'"),
        ({"code": "a\u0007b"}, "must be a text of one line"),
        ({"code": " "}, "must be a text of one line"),
    ],
)
def test_malformed_descriptions_are_told_in_one_line(meta, told, tmp_path):
    with pytest.raises(StudyError) as caught:
        benchmark.read_submission(written(tmp_path / "theirs", **meta))
    assert told in str(caught.value)


def test_missing_files_and_folders_are_told(tmp_path):
    with pytest.raises(StudyError, match="has no submission"):
        benchmark.read_submissions(tmp_path)
    folder = written(tmp_path / "theirs")
    (folder / "results.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(StudyError, match="not UTF-8"):
        benchmark.read_submissions(tmp_path)
    (folder / "results.csv").unlink()
    with pytest.raises(StudyError, match="cannot be read"):
        benchmark.read_submissions(folder)


def test_scores_are_printed_and_written(tmp_path, command):
    folder = written(tmp_path / "theirs", ROWS + "cone_smooth,5.0,0.1,7\n")
    out = tmp_path / "out"
    options = ["--out", out, "--against"]
    told = command("benchmark", "score", folder, *options, "mpm_warp_quick").out
    assert "theirs" in told
    assert {it.suffix for it in out.glob("benchmark.*")} == {".csv", ".png", ".html"}
    assert "theirs" in (out / "benchmark.html").read_text()
    assert "cone_smooth,theirs,5,0.1,+12.3%,5.48,7" in (out / "benchmark.csv").read_text()
    command("benchmark", "score", *options, "nobody", code=2)


@pytest.mark.slow
def test_a_run_keeps_each_case_and_goes_on(tmp_path, monkeypatch, capsys):
    of = {case.name: case for case in benchmark_cases()}
    short = replace(of["cone_smooth"], fixed={"displacement": 0.5})  # the load still rises
    wave = of["standing_wave"]
    monkeypatch.setattr(benchmark, "benchmark_cases", lambda: (short, wave))
    folder = tmp_path / "ours"
    assert benchmark.run_benchmark(folder, "quick") == 1
    assert "no plateau" in capsys.readouterr().err
    alone = scene_class(wave.scene)(**{**wave.fixed, **wave.accuracy["quick"]}).run()
    found = benchmark.read_submission(folder).results
    assert found["standing_wave"].value == pytest.approx(
        float(alone.displacement.interp(phase=9.25)), rel=1e-6
    )
    before = (folder / "results.csv").read_bytes()
    assert benchmark.run_benchmark(folder, "quick") == 1
    assert (folder / "results.csv").read_bytes() == before
    with pytest.raises(StudyError, match="name a new folder"):
        benchmark.run_benchmark(folder, "fine")


def test_a_description_of_another_encoding_is_told_before_anything_runs(tmp_path):
    (tmp_path / "meta.toml").write_bytes('author = "Jürgen"\n'.encode("latin-1"))
    with pytest.raises(StudyError, match=r"meta\.toml: not UTF-8 at byte 11"):
        benchmark.run_benchmark(tmp_path, "quick")
