"""The page that reports results: what is in it, and the commands that write it."""

import re
import shlex
from html.parser import HTMLParser
from pathlib import Path

import pytest
import xarray as xr

from harness.archive.conventions import DISTRIBUTION
from harness.archive.provenance import SOURCES
from harness.archive.study_files import write_study
from harness.compare.compared import with_tolerances
from harness.pictures.spread import spread_figure
from harness.report.report import page, write_report
from harness.report.tables import case_columns, comparisons
from mpm_warp.provenance import sources_digest
from tests.conftest import blocks
from tests.harness.conftest import Command

LARGEST_PAGE = 5_000_000


class Elements(HTMLParser):
    """The elements of a page: their names and attributes, and those that are never closed."""

    VOID = ("meta", "img")

    def __init__(self, text: str) -> None:
        super().__init__()
        self.found: list[tuple[str, dict[str, str | None]]] = []
        self.open: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.found.append((tag, dict(attrs)))
        if tag not in self.VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_needs_nothing_else(page_file: Path) -> None:
    text = page_file.read_text(encoding="utf-8")
    elements = Elements(text)
    assert elements.open == []
    for tag, attributes in elements.found:
        for name in ("src", "href"):
            assert re.match(r"data:image/png;base64,|#", attributes.get(name) or "#"), (tag, name)
    assert "@import" not in text
    assert "url(" not in text
    assert "default-src 'none'" in text  # the browser fetches nothing, whatever is in the page
    assert page_file.stat().st_size < LARGEST_PAGE
    assert [it.name for it in page_file.parent.iterdir()] == [page_file.name]


def test_links_lead_to_what_is_on_the_page(page_file: Path) -> None:
    elements = Elements(page_file.read_text(encoding="utf-8")).found
    anchors = {it["id"] for _, it in elements if it.get("id")}
    links = {(it["href"] or "").removeprefix("#") for _, it in elements if it.get("href")}
    assert links == {"summary", "compared", "study-1", "study-2"}
    assert links <= anchors


def test_markup_in_what_a_file_says_stays_text(page_file: Path) -> None:
    text = page_file.read_text(encoding="utf-8")
    assert "<script" not in text
    assert "velocity of &lt;particle 3&gt;" in text
    assert "&lt;b&gt;unknown&lt;/b&gt;" in text
    assert "Nc &lt; 12 &amp; &lt;script&gt;" in text


def test_the_same_results_give_the_same_page(results: list[xr.Dataset], page_file: Path) -> None:
    assert page(results) == (page_file.read_text(encoding="utf-8"), {})


def test_numbers_have_sensible_digits_and_units(results: list[xr.Dataset]) -> None:
    columns = {column.title: column for column in case_columns(results[0])}
    assert columns["cone factor"].cells == ["9.00", "10.5", "12.0", "-"]
    assert (columns["peak memory"].unit, columns["peak memory"].cells[0]) == ("MB", "300")
    assert str(columns["rigidity index"].symbol) == "I<sub>r</sub>"
    # check value of the formula at Ir 50 and adhesion factor 0.5: 10.31
    deviation, *_, of_failed = columns["deviation from the cone factor of Lu et al. 2004"].cells
    assert (deviation, of_failed) == ("-12.7 %", "-")
    assert [columns[it].is_number for it in ("cone factor", "outcome")] == [True, False]


def test_studies_are_compared_where_they_share_parameters(results: list[xr.Dataset]) -> None:
    (found,) = comparisons(results)
    assert found["studies"] == ["coarse", "fine"]
    assert found["differing"] == [["cells per radius", "2", "4"]]
    assert found["varied"] == ["rigidity index"]
    assert found["shared"] == [
        ["50", "9", "9.2", "+2.2 %"],
        ["100", "10.5", "10.7", "+1.9 %"],
        ["200", "12", "12.2", "+1.7 %"],
    ]


def test_the_order_of_the_parameters_in_results_does_not_matter(
    results: list[xr.Dataset],
) -> None:
    one, other = (it.assign(apex_angle=((), 60.0, {"role": "parameter"})) for it in results)
    turned = other[list(other.data_vars)[::-1]]
    (found,), (expected,) = comparisons([one, turned]), comparisons(results)
    assert found["shared"] == expected["shared"]


def test_studies_of_other_parameters_share_cases_two_by_two(
    results: list[xr.Dataset],
) -> None:
    """As those of two versions of the simulator."""
    later = [it.assign(ductility=((), 15.0, {"role": "parameter"})) for it in results]
    (found,) = comparisons([*results, *later])
    assert found["varied"] == ["rigidity index"]
    assert found["shared"][0] == ["50", "9", "9.2", "-", "-", "+2.2 %"]
    assert found["shared"][3] == ["50", "-", "-", "9", "9.2", "+2.2 %"]
    softer = [it.assign(ductility=it.ductility + 5.0) for it in later]
    (found,) = comparisons([*later, *softer, *results])
    assert set(found["varied"]) == {"rigidity index", "ductility"}
    assert [{*row[:2]} for row in found["shared"][::3]] == [{"50", "15"}, {"50", "20"}, {"50", "-"}]


def test_studies_that_share_no_case_say_so(results: list[xr.Dataset]) -> None:
    other = results[1].copy()
    other["adhesion_factor"] = (), 1.0, results[1]["adhesion_factor"].attrs
    (found,) = comparisons([results[0], other])
    assert found["shared"] == []


@pytest.fixture
def blank(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are drawn but not rendered, which takes the most."""
    monkeypatch.setattr("harness.report.report.image", lambda *_, **__: b"")


@pytest.mark.usefixtures("blank")
def test_main_pictures_of_several_studies_are_in_the_summary_too(
    results: list[xr.Dataset],
) -> None:
    alone, both = (page(given)[0].count("<img") for given in (results[:1], results))
    assert both == 2 * (alone + 1)


def test_a_deviation_outside_the_validity_is_in_brackets(
    results: list[xr.Dataset],
) -> None:
    """Lu et al. give factors for Ir 50 to 500."""
    soft = results[0].assign_coords(rigidity_index=results[0].rigidity_index / 2.0)
    columns = {column.title: column for column in case_columns(soft)}
    first, second, *_ = columns["deviation from the cone factor of Lu et al. 2004"].cells
    assert (first, second) == ("[-12.7 %]", "-8.0 %")


@pytest.mark.usefixtures("blank")
@pytest.mark.parametrize(
    ("tolerances", "told"),
    [({"lu_2004": 0.01}, "1 tolerance missed"), ({"lu_2004": 0.01, "eror": 1}, "2 tolerances")],
)
def test_the_summary_counts_the_tolerances_that_are_missed_not_the_cases(
    results: list[xr.Dataset], tolerances: dict[str, float], told: str
) -> None:
    text, _ = page([with_tolerances(results[0], tolerances), results[1]])
    assert text.count("Tolerance missed: lu_2004: ") == 3  # Lu holds to Ir 500
    assert f'class="bad">{told}' in text


def test_a_page_is_written_again_but_no_other_file(
    results: list[xr.Dataset], tmp_path: Path, command: Command, caplog: pytest.LogCaptureFixture
) -> None:
    file, out = tmp_path / "coarse.nc", tmp_path / "new" / "report.html"
    ours = {SOURCES: f"mpm_warp {sources_digest('mpm_warp')}"}
    write_study(file, results[0].assign_attrs(ours, title="\u6f22"))  # no letter of the font
    report = ("report", file, "-o", out)
    for _ in range(2):
        assert command(*report) == (f"{out}\n", "")
    assert caplog.text == ""
    out.write_text("<p>my own page</p>")
    (line,) = command(*report, code=2).err.splitlines()
    assert f"{out}: was not written by this program" in line
    assert out.read_text() == "<p>my own page</p>"


@pytest.mark.usefixtures("blank")
def test_every_kind_of_result_has_a_page(two_soils: xr.Dataset, tmp_path: Path) -> None:
    exact = two_soils.drop_vars(["cone_factor", "error_finest"]).assign_attrs(
        scene="thick_cylinder"
    )
    exact["error"] = exact["run_time"] * 0.01
    write_report([two_soils, exact], tmp_path / "page.html")
    assert Elements((tmp_path / "page.html").read_text()).open == []


@pytest.mark.usefixtures("blank")
def test_distributions_of_few_cases_have_a_table_and_a_picture(results: list[xr.Dataset]) -> None:
    few = results[0].copy(deep=True)
    few.rigidity_index.attrs[DISTRIBUTION] = "low 50, high 1000"
    text, failed = page([few])
    assert "<td>unknown: 6 samples are needed</td>" in text
    assert failed == {}
    figure = spread_figure(few)
    assert figure is not None
    (words,) = figure.axes[1].texts
    area, inside = figure.axes[1].get_window_extent(), words.get_window_extent()
    assert area.contains(*inside.min)
    assert area.contains(*inside.max)


README = Path(__file__).parents[3] / "harness" / "README.md"


@pytest.mark.parametrize("section", ["Pictures", "The report"])
def test_its_commands_run(
    section: str, results: list[xr.Dataset], here: Path, command: Command
) -> None:
    (text,) = re.findall(rf"^## {section}\n(.*?)^## ", README.read_text(), re.MULTILINE | re.DOTALL)
    (commands,) = blocks(text, "sh")
    (here / "results").mkdir()
    for name, dataset in zip(("adhesion_factor", "rigidity_index"), results, strict=True):
        write_study(Path(f"results/{name}.nc"), dataset.assign_attrs(study=name))
    lines = commands.splitlines()
    told = "".join(command(*shlex.split(line)[1:]).out for line in lines)
    paths = [Path(line) for line in told.splitlines()]
    assert all(path.stat().st_size > 0 for path in paths)
    names = {path.name for path in paths}
    expected = {f"adhesion_factor_curve.{form}" for form in ("png", "pdf", "svg")}
    assert names == (expected if section == "Pictures" else {"report.html"})
