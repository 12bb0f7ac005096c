"""Small scenes to take apart."""

import dataclasses
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

import numpy as np
import pytest
import warp as wp

from mpm_warp.grid.fitted import Floats, Grid, Integers, graded
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.kernel_types import one, real, vec2, vec4, vector
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.elasticity import LinearElastic, elastic_increment
from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic
from mpm_warp.materials.tresca import Tresca
from mpm_warp.materials.variation import Variation
from mpm_warp.parts.boundaries import FarField, Fixed
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.energy import EnergyAudit
from mpm_warp.parts.interpolation import ConservativeInterpolation
from mpm_warp.parts.moving_wall import MovingWall
from mpm_warp.parts.window import Window
from mpm_warp.sampling import soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.simulation import Simulation
from tests.conftest import finished

vec6 = vector(6)
SMALL_WINDOW: dict[str, Any] = {"domain_radius": 8, "domain_above": 3, "domain_below": 3}
"""Costs next to nothing; a resistance in it is no good cone factor."""
MEASURABLE: dict[str, Any] = SMALL_WINDOW | {
    "uncertainty": "measured",
    "cells_per_radius": 2.31,
    "domain_below": 4,
    "penetration": 1,
    "steady_tolerance": 0,
}
"""A short cone test to which its further runs belong."""
SHORT_BAR: dict[str, Any] = {
    "cells_per_radius": 3,
    "domain_extent": 4,
    "penetration": 5,
    "speed_ratio": 0.06,
    "poissons_ratio": 0.48,
}
"""A T-bar in a small window, fast and not far."""
STRENGTHS = {
    "strength_compression": 20e3,
    "strength_extension": 10e3,
    "strength_simple_shear": 15e3,
}
DIRECTED: dict[str, Any] = {"material": {"law": "anisotropic", **STRENGTHS}}
"""Clay whose strength depends on direction."""


@dataclasses.dataclass(frozen=True, kw_only=True)
class Recording(LinearElastic):
    """Remembers what its law is told: the strain of the last step, how many steps, how long [s]."""

    @property
    def state(self) -> tuple[str, ...]:
        return ("rr", "zz", "rz", "tt", "steps", "age")

    def update(self) -> Any:
        return recording


@wp.func
def recording(stress: vec4, e: vec4, time_step: real, properties: vec2, state: vec6):
    trial = stress + elastic_increment(e, properties[0], properties[1])
    return trial, vec6(e[0], e[1], e[2], e[3], state[4] + one, state[5] + time_step)


def changing_clay(criterion: type[PerfectlyPlastic] = Tresca, **given: Any) -> EinavRandolph:
    """Clay whose strength nothing changes but what is given."""
    unchanging = {
        "rate_factor": 0.0,
        "reference_strain_rate": 1.0,
        "remoulded_strength_ratio": 1.0,
        "ductility": 1.0,
    }
    return EinavRandolph(criterion=criterion, **{**unchanging, **given})


def layers(*rows: tuple[float, float, float], **given: Any) -> Variation:
    """Ground of rows of (depth, strength ratio, stiffness ratio)."""
    depth, strength, stiffness = np.array(rows, dtype=float).T
    return Variation(depth=depth, strength_ratio=strength, stiffness_ratio=stiffness, **given)


def principal(stress: Floats) -> Floats:
    """Principal stresses, of (rr, zz, rz, tt), in rising order, shape [n, 3]."""
    centre = 0.5 * (stress[:, 0] + stress[:, 1])
    radius = np.hypot(0.5 * (stress[:, 0] - stress[:, 1]), stress[:, 2])
    return np.sort(np.stack([centre - radius, centre + radius, stress[:, 3]], axis=1), axis=1)


def greatest_shear(stress: Floats) -> Floats:
    """Half the difference of the extreme ones, shape [n]."""
    return np.asarray(0.5 * np.ptp(principal(stress), axis=1))


def cells_of(simulation: Simulation) -> Integers:
    """Numbers of the cells that the points of a run are in."""
    column, row = simulation.array("particle.cell").T
    return np.asarray(column + row * soil_scene(simulation).grid.column_count)


def nodal_forces(grid: Grid, stress: Floats) -> Floats:
    """Minus the divergence of stresses of cells, (rr, zz, rz, tt), at the nodes [N], [n, 2]."""
    rr, zz, rz, tt = stress.T[..., None]
    r, z, hoop = np.moveaxis(grid.gradient_integrals, -1, 0)
    force = np.zeros((grid.node_count, 2))
    pull = np.stack([rr * r + rz * z + tt * hoop, rz * r + zz * z], axis=-1)
    np.add.at(force, grid.cell_nodes, -pull)
    return force


def axis_and_ends(grid: Grid) -> Fixed:
    """No radial velocity on the axis, none at all at the bottom, no vertical one at the top."""
    return Fixed.on(grid, radial=["axis", "bottom"], vertical=["bottom", "top"])


def assert_same_bits(one: Simulation, other: Simulation) -> None:
    """All arrays of a run are those of another, which may have more."""
    for name in one.plan.arrays:
        np.testing.assert_array_equal(other.array(name), one.array(name), err_msg=name)


@pytest.fixture
def fitted() -> Grid:
    """A grid fitted to a cone of 60 degrees and unit radius, its tip at z = 0, and to its shaft."""
    row = np.arange(-3, 7)
    return Grid(
        columns=graded(0.5, 5.0, 1.4) / 5.0,
        rows=row / np.sqrt(3.0),
        surface_radius=np.clip(row / 3.0, 0.0, 1.0),
        fitted_radius=6.0,
    )


@pytest.fixture
def partly_upright(fitted: Grid) -> Grid:
    """The same grid with two columns of cells more, beyond the fitted radius."""
    return dataclasses.replace(fitted, columns=np.append(fitted.columns, [1.5, 2.2]))


@pytest.fixture
def rectilinear() -> Grid:
    """A grid without a surface."""
    return Grid(
        columns=np.linspace(0.0, 1.0, 5) ** 1.5,
        rows=np.array([0.0, 0.3, 1.0, 1.4]),
        surface_radius=np.zeros(4),
        fitted_radius=2.0,
    )


@pytest.fixture
def elastic() -> LinearElastic:
    """Soil that never yields."""
    return LinearElastic(shear_modulus=1e6, poissons_ratio=0.3, density=1000.0)


@pytest.fixture
def floating(rectilinear: Grid, elastic: LinearElastic) -> Scene:
    """Elastic soil that floats freely: nothing but grid and material."""
    return Scene(grid=rectilinear, material=elastic, particles_per_side=2, time_step_fraction=0.5)


@pytest.fixture
def cone(fitted: Grid) -> Scene:
    """Clay in a window that travels with a cone and its shaft: a scene with most of the parts."""
    clay = Tresca(shear_modulus=2e6, poissons_ratio=0.3, density=1700.0, strength=20e3)
    row = np.flatnonzero(fitted.rows >= 0.0)  # from the tip upward
    return Scene(
        grid=fitted,
        material=clay,
        particles_per_side=2,
        time_step_fraction=0.85,
        bulk_viscosity=0.2,
        parts=(
            axis_and_ends(fitted),
            FarField.around(fitted, clay),
            SurfaceContact.on(fitted, row, adhesion=0.5 * clay.strength, in_situ_stress=400e3),
            Window(speed=1.0, ramp_travel=0.5, spare_fraction=0.15),
            ConservativeInterpolation(),
            EnergyAudit(),
        ),
    )


@pytest.fixture
def empty(cone: Scene) -> Scene:
    """That window without a penetrometer in it."""
    grid = dataclasses.replace(cone.grid, surface_radius=np.zeros_like(cone.grid.surface_radius))
    fixed = axis_and_ends(grid)
    return dataclasses.replace(cone.without(SurfaceContact).with_parts(fixed), grid=grid)


@pytest.fixture(scope="session")
def short_test() -> ConePenetration:
    """A cone test of next to no cost, in a small window: its curves are no good cone factors."""
    return ConePenetration(
        **SMALL_WINDOW, adhesion_factor=0.5, cells_per_radius=1.5, penetration=2, steady_tolerance=0
    )


@pytest.fixture
def cavity() -> Scene:
    """Clay around a cylindrical cavity of unit radius that expands: one row between smooth ends."""
    clay = Tresca(shear_modulus=1e5, poissons_ratio=0.495, density=1700.0, strength=1e3)
    grid = Grid(
        columns=graded(0.5, 2.0, 1.25) / 2.0,
        rows=np.array([0.0, 0.5]),
        surface_radius=np.ones(2),
        fitted_radius=3.0,
    )
    vertical = np.ones((2, grid.column_count + 1), dtype=bool)
    far_field = FarField.around(grid, clay)
    return Scene(
        grid=grid,
        material=clay,
        particles_per_side=2,
        time_step_fraction=0.85,
        bulk_viscosity=0.2,
        parts=(
            Fixed.where(radial=~vertical, vertical=vertical),
            # Springs alone: dashpots would push against soil that flows outward without end.
            dataclasses.replace(far_field, dashpot=0.0 * far_field.dashpot),
            MovingWall(speed=0.02, ramp_travel=0.3),
        ),
    )


@pytest.fixture
def spherical(cavity: Scene) -> Scene:
    """Clay around a spherical cavity, on rays that nothing holds."""
    grid = PolarGrid(
        columns=cavity.grid.columns,
        rows=np.linspace(0.0, 0.5 * np.pi, 6),
        surface_radius=np.ones(6),
        fitted_radius=cavity.grid.outer_radius,
    )
    return dataclasses.replace(cavity.without(Fixed, FarField), grid=grid)


@pytest.fixture(scope="module")
def crash(request: pytest.FixtureRequest) -> str:
    """What ends a file of tests before its end, run as a script, in a process of its own.

    No other test shares its end; "" where nothing ends it.
    """
    tried = finished([sys.executable, "-X", "faulthandler", str(request.path)])
    last = tried.stdout.splitlines()[-1:]
    return f"ended by {last}: {tried.stderr[-2000:]}" if tried.returncode else ""


Errors = type[Exception] | tuple[type[Exception], ...]
Misuse = tuple[Callable[[], object], Errors, str]
"""What is done, the exception that it ends in, and the word that tells the argument."""


def try_all(misuses: Mapping[str, Misuse]) -> None:
    """What a file of misuses does as a script: the last name that it prints is what ended it."""
    for name, (attempt, *_) in misuses.items():
        print(name, flush=True)
        with suppress(Exception):
            attempt()


def refused(do: Callable[[], object], error: Errors, word: str) -> None:
    """Do what is to be refused: in one short line that has a word."""
    with pytest.raises(error) as refusal:
        do()
    message = str(refusal.value)
    assert word in message
    assert "\n" not in message
    assert len(message) < 300
