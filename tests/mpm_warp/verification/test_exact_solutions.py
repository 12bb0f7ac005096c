"""Ready scenes at small size against their exact solutions, tolerances from the methods' orders."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
import xarray as xr
from mpm_warp.scenes.cavity_sphere import CavitySphere
from mpm_warp.scenes.circular_footing import CircularFooting
from mpm_warp.scenes.cone_bearing import ConeBearing
from mpm_warp.scenes.cone_self_similar import ConeSelfSimilar
from mpm_warp.scenes.elastic_column_wave import ElasticColumnWave
from mpm_warp.scenes.families.footing import Footing
from mpm_warp.scenes.full_flow_cylinder import FullFlowCylinder
from mpm_warp.scenes.gravity_column import GravityColumn
from mpm_warp.scenes.material_point import MaterialPoint
from mpm_warp.scenes.strip_footing import StripFooting
from mpm_warp.scenes.thick_cylinder import ThickCylinder


def error(dataset: xr.Dataset) -> float:
    return float(dataset["error"])


def order(run: Callable[[int], xr.Dataset], resolution: int) -> float:
    return math.log2(error(run(resolution)) / error(run(2 * resolution)))


def test_stress_on_strain_paths() -> None:
    steps = 1000
    result = MaterialPoint(step_count=steps).run()
    # Cayley's angle of a step t is 2 atan(t/2), short by t^3/12; the circle of the stress that is
    # turned has the radius su/2 and is passed at twice the angle.
    assert error(result) <= (2 * math.pi) ** 3 / (12 * steps**2)
    assert float(result["yield_excess"]) <= 1e-9


def test_rotation_is_of_second_order() -> None:
    assert order(lambda n: MaterialPoint(step_count=n).run(), 500) == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("rigidity_index", [2, 50, 500])
@pytest.mark.parametrize("poissons_ratio", [0.0, 0.3, 0.499])
def test_stress_whatever_the_stiffness(rigidity_index: float, poissons_ratio: float) -> None:
    scene = MaterialPoint(rigidity_index=rigidity_index, poissons_ratio=poissons_ratio)
    result = scene.run()
    assert error(result) <= 1e-6
    assert float(result["yield_excess"]) <= 1e-9


def test_sudden_load_arrives_with_the_wave() -> None:
    cells = 50
    # A front is as sharp as a cell, which it passes twice on its way up and down.
    result = ElasticColumnWave(excitation="sudden_load", cell_count=cells).run()
    assert error(result) <= 1 / cells


def test_standing_wave() -> None:
    cells, periods = 10, 10
    result = ElasticColumnWave(cell_count=cells, period_count=periods).run()
    # Lumped masses on linear cells lower the frequency by (kh)^2/24.
    assert error(result) <= 2 * math.pi * (math.pi / (2 * cells)) ** 2 / 24
    # Within a period energy swings by omega dt; its mean over one may lack a step of that.
    steps = float(result["step_count"]) / periods
    assert float(result["energy_drift"]) <= 2 * math.pi / steps**2


def test_standing_wave_is_of_second_order() -> None:
    assert order(lambda n: ElasticColumnWave(cell_count=n).run(), 20) == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("settlement_ratio", [1e-4, 1e-5])
def test_gravity_column_is_exact_for_small_strain(settlement_ratio: float) -> None:
    # Linear cells give the stress of their middle exactly; what is left is the strain at the base.
    result = GravityColumn(cell_count=8, settlement_ratio=settlement_ratio).run()
    assert error(result) <= 2 * settlement_ratio


@pytest.mark.parametrize("poissons_ratio", [0.0, 0.3, 0.49])
def test_thick_cylinder_is_of_second_order(poissons_ratio: float) -> None:
    def run(cells: int) -> xr.Dataset:
        return ThickCylinder(cell_count=cells, poissons_ratio=poissons_ratio).run()

    assert order(run, 10) == pytest.approx(2, abs=0.1)
    assert error(run(10)) <= (2 / 10) ** 2  # (h/a)^2


@pytest.mark.parametrize("adhesion_factor", [0.0, 0.5, 1.0])
def test_cone_at_the_surface(adhesion_factor: float) -> None:
    def run(cells: int) -> xr.Dataset:
        return ConeBearing(cells_per_radius=cells, adhesion_factor=adhesion_factor).run()

    assert order(run, 4) >= 1
    # Where the rim is, is known to half a cell.
    assert error(run(8)) <= (1 + 1 / 16) ** 2 - 1


@pytest.mark.parametrize("adhesion_factor", [0.0, 1.0])
@pytest.mark.parametrize("footing", [CircularFooting, StripFooting])
def test_footing(footing: type[Footing], adhesion_factor: float) -> None:
    def run(cells: int) -> xr.Dataset:
        return footing(cells_per_radius=cells, adhesion_factor=adhesion_factor).run()

    assert order(run, 4) == pytest.approx(1, abs=0.25)
    assert error(run(8)) <= (1 + 1 / 16) ** 2 - 1


def test_a_load_that_still_rises_has_no_limit() -> None:
    result = ConeBearing(cells_per_radius=4, displacement=3).run()
    assert np.isnan(result["bearing_capacity"])
    assert np.isnan(result["error"])


def test_ring_in_plane_strain() -> None:
    """Of second order in a cell, which here is a tenth of the wall and of a quarter turn."""
    result = ThickCylinder(section="plane_strain", cell_count=10).run()
    assert error(result) <= 1 / 10**2


def test_order_of_the_ring_in_plane_strain() -> None:
    rate = order(lambda n: ThickCylinder(section="plane_strain", cell_count=n).run(), 5)
    assert rate == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize("adhesion_factor", [0.0, 1.0])
def test_force_on_a_cylinder_in_full_flow(adhesion_factor: float) -> None:
    cells = 4
    # A limit load is of first order: the mechanism is as sharp as a cell, over its own length.
    result = FullFlowCylinder(cells_per_radius=cells, adhesion_factor=adhesion_factor).run()
    assert error(result) <= 1 / (cells * result.bearing_capacity_exact)


def test_pressure_of_a_spherical_cavity() -> None:
    """The soil's compressibility lowers the limit by 0.018, half a cell at the wall the rest."""
    cells, index = 4, 50.0
    result = CavitySphere(cells_per_radius=cells, rigidity_index=index, expansion=2.0).run()
    limit = 4 / 3 * (1 + math.log(index))
    # The wall cell stands for the soil half a cell away: 4 su times the strain over it.
    assert error(result) <= (0.018 + 4 / (2 * cells) / 4) / limit
    assert float(result.departure) <= 1 / cells**2


def test_load_of_a_cone_from_first_touch() -> None:
    """The depth is known to a cell at worst, of the cells that the cone is in on average."""
    cells = 10
    scene = ConeSelfSimilar(cells_per_radius=cells)
    mean_depth = 0.4 * cells * math.sqrt(3.0)
    assert error(scene.run()) <= 2.0 / mean_depth
