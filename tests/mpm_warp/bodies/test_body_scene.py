"""What a user declares for bodies, and what is refused before anything runs."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from mpm_warp.bodies.body import Body, Load
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
CONTACT = BodyContact(body=0, base=1)


def test_bodies_that_touch_are_accepted() -> None:
    BodyScene(grid=GRID, bodies=(ABOVE, BELOW), contacts=(CONTACT,))


@pytest.mark.parametrize(
    ("declare", "message"),
    [
        (lambda: BodyScene(grid=GRID, bodies=()), "bodies: there is none"),
        (
            lambda: BodyScene(grid=GRID, bodies=(ABOVE, square(4.0, 4.2))),
            "bodies 0 and 1 overlap at",
        ),
        (lambda: BodyScene(grid=GRID, bodies=(square(9.0, 4.0),)), "body 0: 4 particles, one at"),
        (lambda: BodyScene(grid=GRID, bodies=(square(0.6, 4.0),)), "body 0: 2 particles, one at"),
        (
            lambda: BodyScene(
                grid=GRID,
                bodies=(ABOVE, BELOW),
                contacts=(replace(CONTACT, friction=-0.1),),
            ),
            "BodyContact: friction = -0.1 must be >= 0",
        ),
        (
            lambda: BodyScene(
                grid=GRID,
                bodies=(ABOVE, BELOW),
                contacts=(replace(CONTACT, adhesion=float("nan")),),
            ),
            "BodyContact: adhesion = nan Pa must be a finite number >= 0",
        ),
        (
            lambda: BodyScene(
                grid=GRID, bodies=(ABOVE,), contacts=(replace(CONTACT, adhesion=1.0),)
            ),
            "contact 0: base = 1, but the scene has 1 bodies",
        ),
        (
            lambda: BodyScene(
                grid=GRID, bodies=(ABOVE, BELOW), contacts=(BodyContact(body=1, base=1),)
            ),
            "contact 0: body 1 cannot touch itself",
        ),
        (
            lambda: BodyScene(grid=GRID, bodies=(ABOVE,), time_step_fraction=0.0),
            "time_step_fraction = 0 must be > 0",
        ),
        (
            lambda: BodyScene(grid=GRID, bodies=(replace(ABOVE, retardation_time=-1.0),)),
            "Body: retardation_time = -1 s must be > 0",
        ),
        (
            lambda: BodyScene(
                grid=GRID,
                bodies=(
                    replace(
                        ABOVE, loads=(Load(forces=np.zeros((4, 2)), start=0.0, rise_time=0.0),)
                    ),
                ),
            ),
            "Load: rise_time = 0 s must be > 0",
        ),
        (
            lambda: UniformGrid(lower=(0.0, 0.0), cell_size=0.0, cell_counts=(8, 8)),
            "grid: cell_size = 0 m must be > 0",
        ),
        (
            lambda: UniformGrid(lower=(0.0, 0.0), cell_size=1.0, cell_counts=(2, 8)),
            "grid: cell_counts",
        ),
        (
            lambda: UniformGrid(
                lower=(-1.0, 0.0), cell_size=1.0, cell_counts=(8, 8), axisymmetric=True
            ),
            "grid: lower r = -1 m must be >= 0",
        ),
    ],
)
def test_what_can_not_be_run_is_refused_in_one_line(
    declare: Callable[[], object], message: str
) -> None:
    with pytest.raises(SceneError) as refusal:
        declare()
    assert message in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_body_that_leaves_the_grid_ends_the_run_by_name() -> None:
    simulation = Simulation(BodyScene(grid=GRID, bodies=(ABOVE,)))
    simulation.array("particle.velocity")[:, 0] = 0.5 * MATERIAL.pressure_wave_speed
    with pytest.raises(SimulationDiverged, match=r"position of particle.*outside|wider grid"):
        simulation.advance(500)
