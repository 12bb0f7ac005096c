"""`clean` and `run` remove nothing outside the results, and nothing but what was listed."""

from pathlib import Path

import pytest

from harness.archive.atomic_files import ArchiveError, partial_ending, prepare
from harness.archive.case_files import case_file, discard
from harness.cli.main import main
from harness.run.collect_and_clean import remove_stray, stray_files
from harness.study.study import Study
from tests.harness.conftest import Refusal, prepared


@pytest.fixture
def outside(tmp_path: Path, small: Study) -> Path:
    """A folder beside the results, with files that `clean` would remove among its own."""
    outside = tmp_path / "outside"
    (outside / "cases").mkdir(parents=True)
    for place in (outside, outside / "cases"):
        (place / "precious.nc").write_bytes(b"noise")
        case_file(place, small.cases[0]).write_bytes(b"noise")
        (place / f".x.nc{partial_ending(2**22 + 1)}").touch()
    return outside


def content(folder: Path) -> set[Path]:
    return set(folder.rglob("*"))


@pytest.mark.parametrize("command", ["clean --yes", "run", "run --fresh"])
@pytest.mark.parametrize("link", ["small", "small/cases"])
def test_a_linked_folder_is_refused_and_left_as_it_is(
    link: str, command: str, outside: Path, small: Study, tmp_path: Path, refusal: Refusal
) -> None:
    place = tmp_path / "out" / link
    prepare(place.parent)
    place.symlink_to(outside)
    before = content(outside)
    name, *more = command.split()
    line = refusal([name, str(small.source), "--out", str(tmp_path / "out"), *more])
    assert line.startswith(f"harness: {place}: is a link, and no file is removed outside")
    assert content(outside) == before


def test_the_folder_of_results_itself_may_be_a_link(
    small: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = prepared(small, tmp_path / "real")
    (folder / "noise.nc").write_bytes(b"noise")
    (tmp_path / "out").symlink_to(tmp_path / "real")
    assert main(["clean", str(small.source), "--out", str(tmp_path / "out"), "--yes"]) == 0
    assert capsys.readouterr().err == "harness: 1 file removed\n"
    assert not list(folder.iterdir())


def test_links_go_and_what_they_lead_to_stays_and_a_folder_stops_nothing(
    outside: Path, small: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = prepared(small, tmp_path / "out")
    links = {
        folder / "file.nc": outside / "precious.nc",
        folder / "folder.nc": outside / "cases",
        folder / "nowhere.nc": outside / "none",
        case_file(folder, small.cases[1]): outside / "precious.nc",
    }
    for link, end in links.items():
        link.symlink_to(end)
    half = folder / f".half.nc{partial_ending(2**22 + 1)}"
    for kept in (case_file(folder, small.cases[0]), folder / "a.nc", half):
        kept.mkdir()
        (kept / "inside.nc").touch()
    before, folders = content(outside), {it for it in folder.iterdir() if not it.is_symlink()}
    assert main(["clean", str(small.source), "--out", str(tmp_path / "out"), "--yes"]) == 0
    captured = capsys.readouterr()
    assert {Path(line.partition(": ")[0]) for line in captured.out.splitlines()} == links.keys()
    assert captured.err.count("is a folder, where only files belong; kept") == 2
    assert captured.err.endswith("harness: 4 files removed\n")
    assert content(outside) == before
    assert set(folder.iterdir()) == folders


def test_what_was_written_anew_since_it_was_listed_is_kept(
    small: Study, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = prepared(small, tmp_path)
    path = case_file(folder, small.cases[0])
    path.write_bytes(b"noise")
    (folder / "noise.nc").write_bytes(b"noise")
    found = stray_files(small, tmp_path)
    assert len(found) == 2
    path.write_bytes(b"a result that another run has written")
    assert remove_stray(found) == 1
    assert capsys.readouterr().err == f"harness: {path}: was written anew meanwhile; kept\n"
    assert list(folder.iterdir()) == [path]


def test_a_folder_called_like_a_case_file_is_not_discarded(small: Study, tmp_path: Path) -> None:
    folder = case_file(tmp_path, small.cases[0])
    folder.mkdir()
    with pytest.raises(ArchiveError, match="is a folder, where only files belong"):
        discard(tmp_path, small.cases)
    assert folder.is_dir()
