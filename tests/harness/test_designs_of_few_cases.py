"""Every command on every design with one and two cases, all of which, one or none completed."""

from pathlib import Path

import pytest
import xarray as xr

from harness.archive.case_files import write_case
from harness.archive.own_files import MAKER
from harness.cli.main import main
from harness.pictures import pictures
from tests.harness.conftest import HEAD, keep, study_in

pytestmark = pytest.mark.slow

AT_RANDOM = """design = "latin_hypercube"
samples = {}
seed = 1
[vary]
adhesion_factor = {{ from = 0, to = 1 }}"""
MESHES = """design = "list"
[[case]]
cells_per_radius = 1
[[case]]
cells_per_radius = 2
adhesion_factor = 0.5"""
DESIGNS = {
    "fixed alone": ("[fixed]\nadhesion_factor = 0.5", 1),
    "one value": ("[vary]\nadhesion_factor = [0.5]", 1),
    "two values": ("[vary]\nadhesion_factor = [0.5, 1]", 2),
    "one text": ('[vary]\nmaterial = ["tresca"]', 1),
    "two meshes": ("[vary]\ncells_per_radius = [1, 2]", 2),
    "start alone": ('design = "one_at_a_time"', 1),
    "start and one": ('design = "one_at_a_time"\n[vary]\nadhesion_factor = [0.5]', 2),
    "list of one": ('design = "list"\n[[case]]\nadhesion_factor = 0.5', 1),
    "list of meshes": (MESHES, 2),
    "one at random": (AT_RANDOM.format(1), 1),
    "two at random": (AT_RANDOM.format(2), 2),
    "two scenes": ("", 2),
}
"""What a study says beside its scene, and how many cases it has."""
OUTCOMES = [
    *((design, count) for design, (_, count) in DESIGNS.items()),
    *((design, 1) for design, (_, count) in DESIGNS.items() if count == 2),
    *((design, 0) for design in ("two values", "two at random", "two scenes")),
]
"""Designs, and how many of their cases have completed: all, one of two, none."""
FAILED = "diverged"


def result(number: int) -> xr.Dataset:
    """What a case gives: a cone factor and its cost."""
    headline = {"role": "headline", "units": "1", "long_name": "cone factor"}
    measured = {"role": "measured", "units": "s"}
    return xr.Dataset(
        {
            "cone_factor": ((), 10.0 + number, headline),
            "cone_factor_uncertainty": ((), 0.1, {"role": "uncertainty", "units": "1"}),
            "run_time": ((), 1.0 + number, measured),
            "particle_updates": ((), 1e6 * (1.0 + number), {"units": "1"}),
            "penetration_resistance": (
                "penetration",
                [1e5, 2e5],
                {"units": "Pa", "long_name": "penetration resistance"},
            ),
        },
        coords={"penetration": [1.0, 2.0]},
    )


@pytest.mark.parametrize(("design", "completed"), OUTCOMES)
def test_every_command_ends_well(
    design: str,
    completed: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    text = HEAD + DESIGNS[design][0]
    if design == "two scenes":
        text = text.replace('"cone_penetration"', '["cone_penetration", "t_bar_penetration"]')
    own = '\n[references.own]\nformula = "10"\nlabel = "We"\nsource = "here"\n'
    study = study_in(tmp_path, text + own)
    file = study.source
    assert len(study.cases) == DESIGNS[design][1]
    folder = keep(study, tmp_path, *map(result, range(len(study.cases))))
    for case in study.cases[completed:]:
        write_case(folder, case, xr.Dataset(), FAILED, "velocity of particle 3")
    is_whole = completed == len(study.cases)
    stored = str(tmp_path / "s.nc")
    page = str(tmp_path / "page.html")
    assert main(["describe", str(file)]) == 0
    assert main(["collect", str(file), "--out", str(tmp_path)]) == (0 if is_whole else 1)
    assert main(["status", str(file), "--out", str(tmp_path)]) == (0 if is_whole else 1)
    assert main(["status", stored]) == (0 if is_whole else 1)
    assert main(["report", stored, "-o", page]) == 0
    assert main(["compare", stored]) == (0 if completed else 2)
    assert main(["compare", stored, stored]) == (0 if completed else 2)
    # The report has drawn the same pictures, which takes the most of all this.
    monkeypatch.setattr(pictures, "image", lambda *_, **__: MAKER.encode())
    assert main(["plot", stored]) in (0, 2)
    remarks = capsys.readouterr().err.splitlines()
    known = ("nothing to", "1 case: ", "2 cases: ", "computed by other sources")
    assert [line for line in remarks if not any(it in line for it in known)] == []
    rows = Path(page).read_text(encoding="utf-8").count('<tr class="bad">')
    assert rows == len(study.cases) - completed
