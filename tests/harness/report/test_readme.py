"""The commands of the harness's page on pictures and the report, as they stand there."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
import xarray as xr

from harness.archive.study_files import write_study

README = Path(__file__).parents[3] / "harness" / "README.md"


@pytest.mark.parametrize("section", ["Pictures", "The report"])
def test_its_commands_run(section: str, results: list[xr.Dataset], tmp_path: Path) -> None:
    (text,) = re.findall(rf"^## {section}\n(.*?)^## ", README.read_text(), re.MULTILINE | re.DOTALL)
    (commands,) = re.findall(r"^```sh\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    (tmp_path / "results").mkdir()
    for name, dataset in zip(("adhesion_factor", "rigidity_index"), results, strict=True):
        write_study(tmp_path / "results" / f"{name}.nc", dataset.assign_attrs(study=name))
    program = f'set -e; harness() {{ "{sys.executable}" -m harness "$@"; }}\n{commands}'
    done = subprocess.run(
        ["bash", "-c", program], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    for line in done.stdout.splitlines():
        assert (tmp_path / line).stat().st_size > 0
    names = {Path(line).name for line in done.stdout.splitlines()}
    expected = {f"adhesion_factor_curve.{form}" for form in ("png", "pdf", "svg")}
    assert names == (expected if section == "Pictures" else {"report.html"})
