"""Bodies that do not fit their grid or each other are refused; those that leave it end the run."""

from typing import Any

import numpy as np
import pytest

from mpm_warp.bodies.body import Body
from mpm_warp.bodies.contact import BodyContact
from mpm_warp.bodies.grid import UniformGrid
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.errors import SceneError, SimulationDiverged
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.simulation import Simulation

MATERIAL = LinearElastic(shear_modulus=1e6, poissons_ratio=0.2, density=1000.0)
GRID = UniformGrid(lower=(0.0, 0.0), cell_size=1.0, cell_counts=(8, 8))


def square(x: float, y: float) -> Body:
    """Four particles around a place."""
    corners = np.array([[-1.0, -1.0], [1.0, -1.0], [-1.0, 1.0], [1.0, 1.0]])
    return Body(
        position=np.array([x, y]) + 0.25 * corners,
        volume=np.full(4, 0.25),
        spacing=0.5,
        material=MATERIAL,
    )


ABOVE, BELOW = square(4.0, 4.5), square(4.0, 3.5)


def test_bodies_that_touch_are_accepted() -> None:
    BodyScene(grid=GRID, bodies=(ABOVE, BELOW), contact=BodyContact())


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"bodies": (ABOVE, square(4.0, 4.2))}, "bodies 0 and 1 overlap at"),
        ({"bodies": (square(9.0, 4.0),)}, "body 0: 4 particles, one at"),
        ({"bodies": (square(0.6, 4.0),)}, "body 0: 2 particles, one at"),
        (
            {"bodies": (ABOVE,), "contact": BodyContact()},
            "contact: needs two bodies, the scene has 1",
        ),
    ],
)
def test_bodies_that_do_not_fit_are_refused_in_one_line(
    given: dict[str, Any], message: str
) -> None:
    with pytest.raises(SceneError, match=f"^{message}") as refusal:
        BodyScene(grid=GRID, **given)
    assert "\n" not in str(refusal.value)


def test_an_axis_has_no_other_side() -> None:
    with pytest.raises(SceneError, match="grid: lower r = -1 m must be >= 0"):
        UniformGrid(lower=(-1.0, 0.0), cell_size=1.0, cell_counts=(8, 8), axisymmetric=True)


def test_a_body_that_leaves_the_grid_ends_the_run_by_name() -> None:
    simulation = Simulation(BodyScene(grid=GRID, bodies=(ABOVE,)))
    simulation.array("particle.velocity")[:, 0] = 0.5 * MATERIAL.pressure_wave_speed
    with pytest.raises(SimulationDiverged, match=r"position of particle.*outside|wider grid"):
        simulation.advance(500)
