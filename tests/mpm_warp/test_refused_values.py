"""Values of a scene, of soil or bodies, that are refused in one line that names the argument.

Kernels on a processor do not check the bounds of arrays: what is not refused here would end the
process. So every misuse goes as far as steps are taken, and all of them are tried in a process of
their own first: ``python tests/mpm_warp/test_refused_values.py`` tells which one ends it.
"""

import math
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
import pytest

from mpm_warp.bodies.body import Body, Load, UniformGrid
from mpm_warp.bodies.contact import BodyContact
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.errors import SceneError
from mpm_warp.fields.declaration import Parameter
from mpm_warp.fields.flat import parameters_of
from mpm_warp.grid.fitted import Grid, graded
from mpm_warp.grid.polar import PolarGrid
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.elasticity import LinearElastic
from mpm_warp.materials.tresca import Tresca
from mpm_warp.materials.variation import Variation
from mpm_warp.materials.von_mises import VonMises
from mpm_warp.parts.boundaries import FarField, Fixed
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.parts.forces import Damping, Gravity, NodalLoad
from mpm_warp.parts.free_surface import PassingSurface
from mpm_warp.parts.moving_wall import MovingWall
from mpm_warp.parts.surrounding_ground import TravellingSource
from mpm_warp.parts.window import Approach, Window
from mpm_warp.scene import Scene
from mpm_warp.scenes.material.strain_paths import StrainPaths
from mpm_warp.simulation import Simulation
from tests.mpm_warp.conftest import Misuse, refused, try_all

NAN, INF = float("nan"), float("inf")
SIDE = np.array([4, 9, 14, 19])
"""The nodes of the outer side of the grid; it has 20."""
ONES, DOWN = np.ones(4), np.tile([0.0, -1.0], (4, 1))

Values = dict[str, Any]
GRID: Values = {
    "columns": np.linspace(0.0, 1.0, 5),
    "rows": np.array([0.0, 0.5, 1.0, 1.5]),
    "surface_radius": np.zeros(4),
    "fitted_radius": 2.0,
}
ELASTIC: Values = {"shear_modulus": 1e6, "poissons_ratio": 0.3, "density": 1000.0}
CLAY = ELASTIC | {"strength": 1e4}
CONTACT: Values = {
    "nodes": SIDE - 4,
    "normals": DOWN,
    "normal_areas": ONES,
    "adhesion_forces": ONES,
    "friction": 0.1,
    "in_situ_stress": 1e3,
}
ON_SURFACE: Values = {
    "grid": Grid(**GRID | {"surface_radius": 0.1 * ONES}),
    "rows": np.array([1, 2]),
    "adhesion": 0.0,
    "in_situ_stress": 1e3,
}
CHANGING = CLAY | {
    "criterion": Tresca,
    "rate_factor": 0.1,
    "reference_strain_rate": 1.0,
    "remoulded_strength_ratio": 0.25,
    "ductility": 2.0,
}
VARIED: Values = {
    "depth": np.array([0.0, 2.0, 2.0, 5.0]),
    "strength_ratio": np.array([1.0, 2.0, 0.5, 0.5]),
    "stiffness_ratio": np.array([0.25, 0.25, 1.0, 1.0]),
}
FAR: Values = {"nodes": SIDE, "spring": ONES, "dashpot": np.ones((4, 2))}
APPROACH: Values = {"speed": 3.0, "travel": 2.0, "slowing_travel": 1.0}
WINDOW: Values = {"speed": 1.0, "ramp_travel": 0.5, "spare_fraction": 0.2}
SCENE: Values = {
    "grid": Grid(**GRID),
    "material": LinearElastic(**ELASTIC),
    "particles_per_side": 2,
    "time_step_fraction": 0.5,
}
PATHS: Values = {
    "material": Tresca(**CLAY),
    "gradient": np.zeros((3, 5)),
    "stress": np.zeros((3, 4)),
    "step_count": 10,
}
LOAD: Values = {"forces": np.ones((4, 2)), "start": 0.0, "rise_time": 1e-3}
BODY: Values = {
    "position": np.array([[2.0, 2.0], [3.0, 2.0], [2.0, 3.0], [3.0, 3.0]]),
    "volume": ONES,
    "spacing": 1.0,
    "material": LinearElastic(**ELASTIC),
}
CELLS: Values = {"lower": (0.0, 0.0), "cell_size": 1.0, "cell_counts": (8, 8)}
BODIES: Values = {"grid": UniformGrid(**CELLS), "bodies": (Body(**BODY),)}


def changed(values: np.ndarray, place: Any, value: float) -> np.ndarray:
    """An array with another value at a place."""
    other = values.copy()
    other[place] = value
    return other


NODES = [
    [0, 5, 10, 15],  # no array
    changed(SIDE, 1, 20),
    changed(SIDE, 1, -1),
    changed(SIDE, 1, 4),  # twice
    changed(SIDE, 1, 2**31),
    SIDE.astype(float),
    SIDE[:3],
    SIDE.reshape(2, 2),
]


def beyond(declared: Parameter, right: Any) -> list[Any]:
    """Values that a declared number or array may not have; `right` is one that it may."""
    bounds = declared.bounds
    outside = [bounds.above, bounds.below, bounds.minimum - 1.0, bounds.maximum + 1.0]
    numbers = [NAN, INF, *(it for it in outside if math.isfinite(it))]
    if declared.shape is None:
        return [*numbers, "1", True, *([] if declared.default is None else [None])]
    first = (0,) * right.ndim
    # a length that no other array has to agree with may be another
    shorter = [] if declared.shape[0] in (None, declared.name) else [right[:-1]]
    return [*(changed(right, first, it) for it in numbers), *shorter, right[None], right.tolist()]


def made(
    make: Callable[..., object], given: Values, **wrong: list[Any]
) -> tuple[Callable[..., object], Values, Values]:
    """What makes a value, what it takes, and what each argument must not be.

    What is beyond its declaration is added for every declared field.
    """
    declared = parameters_of(make) if isinstance(make, type) else {}
    for name, field in declared.items():
        if name in given or field.shape is None:
            wrong[name] = [*wrong.get(name, []), *beyond(field, given.get(name))]
    return make, given, wrong


MADE = [
    made(
        Grid,
        GRID,
        columns=[np.array([0.0]), np.array([0.0, 0.6, 0.4, 1.0]), np.array([0.0, 0.5, 2.0])],
        rows=[np.zeros(4), np.array([2.0, 1.0, 0.0, -1.0])],
        surface_radius=[np.zeros(3), np.full(4, 2.0), np.full(4, -0.1), np.full(4, NAN)],
        planar=["no"],
        ground_level=[NAN, -1.0],
        soil_radius=[NAN, 0.0],
    ),
    made(
        PolarGrid,
        GRID | {"surface_radius": ONES},
        rows=[GRID["rows"] + 3.0],
        surface_radius=[np.linspace(0.5, 1.0, 4)],
    ),
    made(
        graded,
        {"first": 0.1, "length": 1.0, "growth": 1.2},
        first=[0.0, NAN],
        length=[0.05],
        growth=[1.0],
    ),
    made(LinearElastic, ELASTIC),
    made(Tresca, CLAY),
    made(VonMises, CLAY),
    made(EinavRandolph, CHANGING, ductility=[0.001]),  # too brittle
    made(Variation, VARIED, depth=[np.array([0.0, 2.0, 1.0, 5.0])]),
    made(SurfaceContact, CONTACT, normals=[2.0 * DOWN, 0.0 * DOWN], normal_areas=[0.0 * ONES]),
    made(
        SurfaceContact.on,
        ON_SURFACE,
        rows=[[1, 2], range(1, 3), 1, None, np.array([1, 4]), np.array([-1, 2]), np.ones(2)],
        adhesion=[NAN, -1.0, "rough"],
    ),
    made(FarField, FAR),
    made(Fixed, {"nodes": SIDE, "free": np.zeros((4, 2))}, free=[np.full((4, 2), 0.5)]),
    made(NodalLoad, {"nodes": SIDE, "forces": np.ones((4, 2))}),
    made(Gravity, {"acceleration": 9.81}),
    made(Damping, {"rate": 1.0}),
    made(MovingWall, {"speed": 1.0, "ramp_travel": 1.0}),
    made(Approach, APPROACH, travel=[1.0, NAN]),
    made(Window, WINDOW, approach=[Approach(**APPROACH | {"speed": 0.5}), 3.0]),
    made(PassingSurface, {"level": 0.0, "layer": 1.0, "pic_fraction": 0.02}),
    made(
        Scene,
        SCENE,
        grid=[None, GRID],
        material=[None, "tresca", Tresca(shear_modulus=1e6, poissons_ratio=0.3, density=1e3)],
        particles_per_side=[1.5],
        stress_at_rest=[np.zeros(3), np.array([0.0, NAN, 0.0, 0.0])],
        parts=[[Gravity(9.81)], (9.81,), Gravity(9.81)],
    ),
    made(
        StrainPaths,
        PATHS,
        material=["tresca"],
        gradient=[np.zeros((3, 4))],
        stress=[np.zeros((2, 4)), np.zeros(12)],
        step_count=[2.5],
    ),
    made(
        Body,
        BODY,
        position=[BODY["position"][:3], np.full((4, 2), NAN)],
        volume=[np.ones(0)],
        material=[Tresca(**CLAY)],
        held=[ONES, np.ones(3, dtype=bool)],
        loads=[(Load(**LOAD | {"forces": np.ones((3, 2))}),), Load(**LOAD)],
    ),
    made(TravellingSource, {"radius": 1.0, "height": 0.0, "shear_modulus": 1.0}),
    made(Load, LOAD),
    made(BodyContact, {}),
    made(
        UniformGrid,
        CELLS,
        lower=[(NAN, 0.0), (0.0, INF), (0.0, 0.0, 0.0)],
        cell_counts=[(8, 2), (8.0, 8), 8],
    ),
    made(UniformGrid, CELLS | {"axisymmetric": True}, lower=[(-1.0, 0.0)]),
    made(
        BodyScene,
        BODIES,
        grid=[None],
        bodies=[(), [Body(**BODY)], ("one",)],
        contact=[BodyContact(), "rough"],
    ),
]
IN_A_SCENE: list[tuple[str, Callable[..., object], Values]] = [
    ("SurfaceContact", SurfaceContact, CONTACT),
    ("FarField", FarField, FAR),
    ("Fixed", Fixed, {"free": np.zeros((4, 2))}),
    ("NodalLoad", NodalLoad, {"forces": np.ones((4, 2))}),
]
"""Parts with nodes, which are checked when a scene is made of them, and their word for them."""


def run(made: object) -> None:
    """Go on with what should have been refused as a user would."""
    if isinstance(made, (BodyScene, Scene, StrainPaths)):
        Simulation(made).advance(3)


def with_part(make: Callable[..., object], given: Values) -> None:
    run(Scene(**SCENE | {"parts": (make(**given),)}))


def misuses() -> Iterator[tuple[str, Misuse]]:
    for make, given, wrong in MADE:
        for argument, values in wrong.items():
            for number, value in enumerate(values):
                name, misused = f"{make.__name__}.{argument} {number}", given | {argument: value}
                do = partial(lambda make, given: run(make(**given)), make, misused)
                yield name, (do, SceneError, argument.removesuffix("s"))
    for word, make, given in IN_A_SCENE:
        for number, nodes in enumerate(NODES):
            do = partial(with_part, make, given | {"nodes": nodes})
            yield f"Scene, {word} {number}", (do, SceneError, word)


MISUSES = dict(misuses())


@pytest.mark.parametrize("name", MISUSES)
def test_a_value_is_refused_in_one_line_that_names_the_argument(name: str, crash: str) -> None:
    assert not crash
    refused(*MISUSES[name])


def test_the_values_given_are_not_refused() -> None:
    """Else all of the above could be refused for another reason."""
    for make, given, _ in MADE:
        run(make(**given))
    for _, make, given in IN_A_SCENE:
        with_part(make, given | {"nodes": SIDE})


if __name__ == "__main__":
    try_all(MISUSES)
