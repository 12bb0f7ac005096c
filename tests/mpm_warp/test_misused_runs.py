"""Misuses of a run: each ends in an exception of one line that names the argument.

They are tried in a process of their own first, as those of `test_refused_values.py`.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import cache, partial
from typing import Any

import numpy as np
import pytest

from mpm_warp import Execution, NodalLoad, SceneError, Simulation, Snapshots, SurfaceContact
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.planning import make_plan
from mpm_warp.sampling import ContactForces
from mpm_warp.scenes.blocks.sliding_block import SlidingBlock
from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.scenes.material.material_point import MaterialPoint
from mpm_warp.scenes.sounding.profile import Profile
from tests.mpm_warp.conftest import Misuse, refused, try_all

NAN, INF = float("nan"), float("inf")
CONE = ConePenetration(cells_per_radius=1.5, domain_radius=8, domain_above=3, domain_below=3)
SCENE = CONE.build()
CELLS, NODES = SCENE.grid.cell_count, SCENE.grid.node_count
CONTACT = SCENE[SurfaceContact].nodes

SLOTS = make_plan(SCENE).arrays["particle.cell"].shape[0]
NO_COLUMN = np.tile((-1, 0), (SLOTS, 1))
"""Cells of slots that have a row and no column; empty slots have neither."""

ASSIGNED: Mapping[str, list[Any]] = {
    "particle.cell": [CELLS, -2, (0, 0), NO_COLUMN, 0.0, NAN, "here"],
    "contact.nodes": [NODES, -1, CONTACT[:3], CONTACT.astype(float), CONTACT + NODES],
    "far_field.nodes": [NODES, 10**9, 2**40],
    "fixed.nodes": [NODES, -5],
    "layer.slots": [10**6, -1],
    "layer.cell": [10**6, -1],
    "particle.mass": [-1.0],
    "particle.stress": [NAN, INF, np.zeros(4), np.zeros((3, 4)), "much", 1j, None],
    "window.motion": [np.array([0.0, INF, 0.0]), np.zeros(4)],
}
"""Arrays of a run of soil, and what they must not be given."""
CALLS: Mapping[str, tuple[str, list[Any]]] = {
    "advance": ("step_count", [-1, 2.0, 1.5, NAN, INF, "3", None, True, 2**70]),
    "advance_to_step": ("step", [NAN, INF, "3", 1e300]),
    "advance_to": ("time", [NAN, INF, -INF, None, 1e300]),
    "travel_to": ("travel", [NAN, INF, "far"]),
}
"""Ways to advance a run, their argument, and what it must not be."""


@cache
def soil() -> Simulation:
    """A run with a window, a contact and a far field."""
    return Simulation(SCENE)


def assign(name: str, value: Any) -> None:
    soil().assign(name, value)
    soil().advance(3)


def assign_body(value: Any) -> None:
    simulation = Simulation(SlidingBlock().build())
    simulation.assign("particle.body", value)
    simulation.advance(3)


def take_twice() -> None:
    forces = ContactForces(soil())
    soil().advance(1)
    forces.take()
    forces.take()


def forces_of_none() -> None:
    ContactForces(Simulation(SCENE.without(SurfaceContact)))


def load_twice() -> None:
    """A second part of a kind would take the place of the arrays of the first."""
    loads = (NodalLoad(nodes=CONTACT[:n], forces=np.ones((n, 2))) for n in (4, 1))
    Simulation(replace(SCENE, parts=tuple(loads))).advance(3)


ODD = (-3, 0.5, "much", 1j, [None], [[0.0]], {"a": 1})
"""What a call may be given by mistake."""
TAKES_ONE: Mapping[str, Callable[[Any], object]] = {
    "device": lambda it: Execution(device=it),
    "execution": lambda it: Simulation(SCENE, it),
    "progress": lambda it: CONE.run(progress=it),
    "snapshots": lambda it: Snapshots(at=it),
    "profile": lambda it: Profile(depth=it, strength=it, shear_modulus=it, unit_weight=it),
    "launch": lambda it: soil().launch(it),
}
"""Calls that take none of these, by the word that a refusal tells."""


def misuses() -> Iterator[tuple[str, Misuse]]:
    for name, values in ASSIGNED.items():
        for number, value in enumerate(values):
            yield f"{name} {number}", (partial(assign, name, value), ValueError, name)
    for method, (argument, values) in CALLS.items():
        for number, value in enumerate(values):
            do = partial(lambda call, it: getattr(soil(), call)(it), method, value)
            yield f"{method} {number}", (do, ValueError, argument)
    for word, take in TAKES_ONE.items():
        for value in ODD:
            yield f"{word} {value!r}", (partial(take, value), (ValueError, KeyError), word)
    for body in (2, -1, 0.5):
        yield f"particle.body {body}", (partial(assign_body, body), ValueError, "body")
    for scene in (SCENE, SlidingBlock().build(), MaterialPoint().build()):
        kind = type(scene).__name__
        for step in (0.0, -1.0, NAN, INF):
            do = partial(make_plan, scene, time_step=step)
            yield f"{kind} time_step {step}", (do, SceneError, "time_step")
        for count in (0, -1, 1.5):
            do = partial(make_plan, scene, share_count=count)
            yield f"{kind} share_count {count}", (do, SceneError, "share_count")
    for threads in (0, -1, 1.5, "all", 3, 2**70):
        yield f"threads {threads}", (partial(Execution, threads=threads), ValueError, "threads")
    yield "take", (take_twice, ValueError, "contact forces")
    yield "no contact", (forces_of_none, SceneError, "SurfaceContact")
    yield "two loads", (load_twice, SceneError, "load.nodes")
    for number, called in enumerate((Simulation.array, Simulation.assign)):
        do = partial(
            lambda it, *given: it(soil(), "particle.stres", *given), called, *number * [0.0]
        )
        yield f"unknown {number}", (do, KeyError, "did you mean 'particle.stress'")


MISUSES = dict(misuses())


@pytest.mark.parametrize("name", MISUSES)
def test_a_misuse_ends_in_one_line_that_names_the_argument(name: str, crash: str) -> None:
    assert not crash
    refused(*MISUSES[name])


def test_values_of_a_run_may_be_given_back_to_it() -> None:
    """Else all of the above could be refused for another reason."""
    for name in soil().plan.arrays:
        soil().assign(name, soil().array(name).copy())
    soil().advance(np.int64(3))
    simulation = Simulation(SlidingBlock().build())
    assert isinstance(simulation.scene, BodyScene)
    simulation.assign("particle.body", simulation.array("particle.body").copy())


if __name__ == "__main__":
    try_all(MISUSES)
