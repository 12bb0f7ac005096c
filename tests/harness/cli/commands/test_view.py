"""`harness view`: the commands of its page, its pictures, and VTK files in another reader."""

import shlex
import tempfile
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
import xarray as xr
from PIL import Image

from harness.archive.case_files import read_fields
from harness.archive.vtk_files import write_vtk
from harness.cli.main import main
from tests.conftest import blocks
from tests.harness.conftest import Refusal

pytestmark = pytest.mark.slow

PAGE = Path(__file__).parents[4] / "harness" / "README.md"
SHORT = ("penetration=1", "steady_tolerance=0", "cells_per_radius=1", "adhesion_factor=0.5")


def told(language: str) -> str:
    """What the section on the soil has in a language, as a reader would copy it."""
    section = PAGE.read_text().partition("\n## Seeing the soil")[2].partition("\n## ")[0]
    return "".join(blocks(section, language))


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder in which the commands of the page were run, on cones of next to no cost."""
    folder = tmp_path_factory.mktemp("seen")
    short = [word for setting in SHORT for word in ("--set", setting)]
    commands = [shlex.split(line, comments=True)[1:] for line in told("sh").splitlines()]
    assert [command[0] for command in commands] == ["run", "view", "view"]
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for command in commands:
            assert main([*command, *(short if command[0] == "run" else [])]) == 0
    return folder


def test_the_python_of_the_page_runs(seen: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(seen)
    exec(told("python"), {})
    assert (seen / "sections.png").stat().st_size > 0


def test_pictures_and_film_are_written(seen: Path) -> None:
    (results,) = seen.glob("results")
    for kind in ("sections", "traction"):
        (picture,) = results.glob(f"*_{kind}.png")
        with Image.open(picture) as image:
            assert image.width > 800
    (film,) = results.glob("*_animation.gif")
    with Image.open(film) as image:
        assert getattr(image, "n_frames", 1) == 2


def test_the_series_leads_to_points_grid_and_surface(seen: Path) -> None:
    (series,) = seen.glob("**/*.pvd")
    reader = pv.get_reader(series)
    assert reader.time_values == [0.5, 1.0]
    reader.set_active_time_value(1.0)
    points, grid, surface = reader.read()
    (file,) = seen.glob("results/*/cases/*.fields.nc")
    with xr.open_dataset(file) as fields:
        last = fields.isel(penetration=-1)
        present = last.point_r.notnull().values
        np.testing.assert_array_equal(points["mean_stress"], last.mean_stress.values[present])
        np.testing.assert_array_equal(points.points[:, 2], last.point_z.values[present])
        assert grid.n_cells == (last.sizes["row"] - 1) * (last.sizes["column"] - 1)
        np.testing.assert_array_equal(grid["velocity"][:, 2], last.node_velocity_z.values.ravel())
        # Its traction integrates to the resistance, see `test_snapshots.py`.
        np.testing.assert_array_equal(surface.points[:, 0], last.surface_r)
        np.testing.assert_array_equal(surface.points[:, 2], last.surface_z)
        for name in ("normal_traction", "shear_traction"):
            np.testing.assert_array_equal(surface[name], last[name])
        np.testing.assert_array_equal(surface["on_shaft"], last.surface_part == "shaft")
        ends = np.array([it.point_ids for it in surface.cell])
        np.testing.assert_array_equal(np.diff(ends), 1)
        assert len(ends) == surface.n_points - 2  # none from face to shaft, which part at one place
        for name in ("cone_radius", "resistance"):
            assert surface.field_data[name][0] == last[name].item()
    assert grid["displacement"].shape == (grid.n_points, 3)


def test_vtk_needs_no_temporary_file(
    seen: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """VTK ends the process where the disk of temporary files is full."""
    (file,) = seen.glob("results/*/cases/*.fields.nc")
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "nowhere"))
    listed, *written = write_vtk(read_fields(file), tmp_path, "soil")
    assert listed.exists()
    assert pv.read(written[0]).n_points > 0


def test_without_snapshots_nothing_is_viewed(seen: Path, tmp_path: Path, refusal: Refusal) -> None:
    assert "no such file" in refusal(["view", str(tmp_path / "a.nc")])
    (result,) = seen.glob("results/*.nc")
    copy = tmp_path / result.name
    copy.write_bytes(result.read_bytes())
    searched = tmp_path / result.stem / "cases"
    assert f"no case has snapshots in {searched}; run" in refusal(["view", str(copy)])
    (case,) = (it for it in seen.glob("results/*/cases/*.nc") if not it.name.endswith("fields.nc"))
    alone = tmp_path / case.name
    alone.write_bytes(case.read_bytes())
    assert refusal(["view", str(alone)]).endswith(".fields.nc: no such file")
