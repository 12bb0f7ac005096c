"""`harness view`: the commands of its page, its pictures, and VTK files in another reader."""

import shlex
from pathlib import Path

import numpy as np
import pytest
import pyvista as pv
import xarray as xr
from PIL import Image

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
            assert image.width > 1000
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
    assert grid["displacement"].shape == (grid.n_points, 3)
    assert set(surface.point_data) == {"normal_traction", "shear_traction", "on_shaft"}


def test_the_traction_in_another_reader_integrates_to_the_resistance(seen: Path) -> None:
    """Of traction and radius, linear along each line, Simpson's rule is exact."""
    for file in seen.glob("**/surface_*.vtu"):
        surface = pv.read(file)
        force = 0.0
        for cell in surface.cell:
            ends = cell.point_ids
            if surface["on_shaft"][ends].any():
                continue
            normal, shear = surface["normal_traction"][ends], surface["shear_traction"][ends]
            # The length times the sine of half the apex angle, and times its cosine.
            (d_r, _, d_z), radius = np.diff(cell.points, axis=0)[0], cell.points[:, 0]
            upward = normal * d_r + shear * d_z
            middle = upward.mean() * radius.mean()
            force += (upward[0] * radius[0] + 4.0 * middle + upward[1] * radius[1]) / 6.0
        resistance = force / (0.5 * surface.field_data["cone_radius"][0] ** 2)
        assert resistance == pytest.approx(surface.field_data["resistance"][0], rel=1e-9)


def test_without_snapshots_there_is_nothing_to_view(
    seen: Path, tmp_path: Path, refusal: Refusal
) -> None:
    assert "no such file" in refusal(["view", str(tmp_path / "a.nc")])
    (result,) = seen.glob("results/*.nc")
    copy = tmp_path / result.name
    copy.write_bytes(result.read_bytes())
    assert "no case has snapshots; run" in refusal(["view", str(copy)])
    (case,) = (it for it in seen.glob("results/*/cases/*.nc") if not it.name.endswith("fields.nc"))
    alone = tmp_path / case.name
    alone.write_bytes(case.read_bytes())
    assert refusal(["view", str(alone)]).endswith(".fields.nc: no such file")
