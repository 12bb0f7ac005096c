"""Results that were computed by other sources of the simulator are kept, and never in silence."""

from collections.abc import Callable
from pathlib import Path

import pytest

from harness.archive.provenance import SOURCES, sources_digest
from harness.archive.study_files import read_study
from harness.cli.main import main
from harness.study.study import Study
from tests.harness.conftest import DONE, keep

OTHERS = (
    "harness: small: 2 of 3 results computed by other sources of the simulator, of the same "
    "version; kept: `harness run --fresh` computes them anew"
)


@pytest.fixture
def done(small: Study, tmp_path: Path) -> Callable[..., list[str]]:
    """Writes results of all cases, which say by which sources they were computed."""

    def write(*sources: str | None) -> list[str]:
        made = DONE.assign(made=1.0)
        said = [{} if digest is None else {SOURCES: digest} for digest in sources]
        keep(small, tmp_path, *(made.assign_attrs(it) for it in said))
        return [str(small.source), "--out", str(tmp_path)]

    return write


@pytest.mark.parametrize("command", ["run", "status", "collect"])
def test_results_of_other_sources_are_kept_and_told(
    command: str,
    small: Study,
    tmp_path: Path,
    done: Callable[..., list[str]],
    capsys: pytest.CaptureFixture[str],
) -> None:
    ours = sources_digest(small.parts[0].scene)
    assert main([command, *done(ours, ours, ours)]) == 0
    assert "sources" not in capsys.readouterr().err
    assert main([command, *done(ours, "earlier", None)]) == 0
    assert OTHERS in capsys.readouterr().err.splitlines()
    if command != "status":
        dataset = read_study(tmp_path / "small.nc")
        assert dataset["made"].values.tolist() == [1.0, 1.0, 1.0]
        assert dataset[SOURCES].values.tolist() == [ours, "earlier", ""]


def test_fresh_computes_them_anew(
    small: Study, tmp_path: Path, done: Callable[..., list[str]], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["run", *done("earlier", "earlier", "earlier"), "--fresh"]) == 0
    assert "sources" not in capsys.readouterr().err
    dataset = read_study(tmp_path / "small.nc")
    assert dataset.attrs[SOURCES] == sources_digest(small.parts[0].scene)
    assert "cone_factor" in dataset
