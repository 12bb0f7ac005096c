"""Values of bodies and their scenes that the library refuses, in one line that names the argument.

They are tried in a process of their own first, as those of `../test_refused_values.py`.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import Any

import numpy as np
import pytest

from mpm_warp.bodies.body import Body
from mpm_warp.bodies.contact import BodyContact
from mpm_warp.bodies.grid import UniformGrid
from mpm_warp.bodies.loads import Load
from mpm_warp.bodies.scene import BodyScene
from mpm_warp.errors import SceneError
from mpm_warp.materials.linear_elastic import LinearElastic
from mpm_warp.materials.tresca import Tresca
from mpm_warp.simulation import Simulation

NAN, INF = float("nan"), float("inf")
NUMBERS = [0.0, -1.0, NAN, INF, "1", None]
"""What no number > 0 may be."""
ONES = np.ones(4)
ELASTIC = LinearElastic(shear_modulus=1e6, poissons_ratio=0.3, density=1000.0)
CLAY = Tresca(shear_modulus=1e6, poissons_ratio=0.3, density=1000.0, strength=1e4)

Values = dict[str, Any]
LOAD: Values = {"forces": np.ones((4, 2)), "start": 0.0, "rise_time": 1e-3}
BODY: Values = {
    "position": np.array([[2.0, 2.0], [3.0, 2.0], [2.0, 3.0], [3.0, 3.0]]),
    "volume": ONES,
    "spacing": 1.0,
    "material": ELASTIC,
}
CELLS: Values = {"lower": (0.0, 0.0), "cell_size": 1.0, "cell_counts": (8, 8)}
BODIES: Values = {"grid": UniformGrid(**CELLS), "bodies": (Body(**BODY),)}

MADE: list[tuple[Callable[..., object], Values, Mapping[str, list[Any]]]] = [
    (
        Body,
        BODY,
        {
            "position": [BODY["position"][:3], np.full((4, 2), NAN)],
            "volume": [np.array([1.0, 1.0, NAN, 1.0]), -ONES, np.ones(0)],
            "spacing": [0.0, NAN],
            "material": [CLAY],
            "held": [ONES, np.ones(3, dtype=bool)],
            "retardation_time": [0.0, NAN],
            "loads": [(Load(**LOAD | {"forces": np.ones((3, 2))}),), Load(**LOAD)],
        },
    ),
    (Load, LOAD, {"forces": [ONES], "start": [-1.0, NAN], "rise_time": [0.0, INF]}),
    (
        BodyContact,
        {"body": 0, "base": 1},
        {"body": [-1, 0.5], "base": [1.0], "friction": [-1.0, NAN], "adhesion": [INF]},
    ),
    (
        UniformGrid,
        CELLS,
        {
            "lower": [(NAN, 0.0), (0.0, INF), (0.0, 0.0, 0.0)],
            "cell_size": NUMBERS,
            "cell_counts": [(8, 2), (8.0, 8), 8],
        },
    ),
    (
        BodyScene,
        BODIES,
        {
            "grid": [None],
            "bodies": [(), [Body(**BODY)], ("one",)],
            "time_step_fraction": [NAN, 0.0],
            "contacts": [(BodyContact(body=0, base=7),)],
        },
    ),
]
"""What makes a value, what it takes, and what each argument must not be."""
Misuse = tuple[Callable[[], object], str]
"""What is done, and the word of the message that tells the argument."""
Refused = Callable[[Callable[[], object], type[Exception], str], None]
"""Does what is to be refused so, with this word."""


def run(made: object) -> None:
    """Go on with what should have been refused as a user would."""
    if isinstance(made, BodyScene):
        Simulation(made).advance(3)


def misuses() -> Iterator[tuple[str, Misuse]]:
    for make, given, wrong in MADE:
        for argument, values in wrong.items():
            for number, value in enumerate(values):
                changed_so = given | {argument: value}
                do = functools.partial(lambda make, given: run(make(**given)), make, changed_so)
                yield f"{make.__name__}.{argument} {number}", (do, argument.removesuffix("s"))


MISUSES = dict(misuses())


@pytest.fixture(scope="module")
def crash(tried_alone: Callable[[str], str]) -> str:
    return tried_alone(__file__)


@pytest.mark.parametrize("name", MISUSES)
def test_a_value_is_refused_in_one_line_that_names_the_argument(
    name: str, crash: str, refused: Refused
) -> None:
    assert not crash
    do, word = MISUSES[name]
    refused(do, SceneError, word)


def test_what_is_allowed_is_not_refused() -> None:
    """Else all of the above could be refused for another reason."""
    for make, given, _ in MADE:
        run(make(**given))


if __name__ == "__main__":
    for known, (attempt, _) in MISUSES.items():
        print(known, flush=True)
        with suppress(Exception):
            attempt()
