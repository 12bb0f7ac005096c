"""Exact solutions for the method of `cone.py`: `python -m tests.independent.verify`.

Cavities grow from nothing in soil that keeps its volume. By places over the radius of the cavity
the flow is steady: the mesh grows with the cavity, and time is the logarithm of its radius. With
y = (a / r)^n, n = 2 around a cylinder and 3 around a sphere, the limit pressure over su is

    p = c (Ir Li2(y_p) - ln(y_p)),  y_p = 1 - exp(-1 / Ir),  c = 1 (cylinder) or 4 / 3 (sphere),

Li2(y) = y + y^2 / 4 + y^3 / 9 + ... being the dilogarithm, y_p where soil yields; where strains
before yield are small it is c (1 + ln(Ir)). A circular footing, smooth or rough, bears 5.69 or
6.05 su.

Backward steps along the flow make the error of a cavity of first order in their length, here that
of its elements; the singular edge makes that of a footing of first order in its elements. So
2 p(s / 2) - p(s) is better than both.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.special import spence

from tests.independent.clay import Array, Clay
from tests.independent.elements import Elements, areas, force_of, graded, halved
from tests.independent.flow import Boundary, Flow

CLAY = Clay(rigidity_index=100.0, poissons_ratio=0.4999)
FACTOR = {2: 1.0, 3: 4.0 / 3.0}


@dataclass(frozen=True)
class Check:
    """An exact value, and what is computed with elements of a size."""

    exact: float
    computed: Callable[[float], float]
    size: float

    def pair(self) -> tuple[float, float]:
        """Computed with elements of the size, and of half of it."""
        return self.computed(self.size), self.computed(self.size / 2.0)


def limit_pressure(dimensions: int) -> float:
    """Exact, over su."""
    yielding = -np.expm1(-1.0 / CLAY.rigidity_index)
    dilogarithm = spence(1.0 - yielding)
    return float(FACTOR[dimensions] * (CLAY.rigidity_index * dilogarithm - np.log(yielding)))


def elastic_stress(place: Array, dimensions: int) -> Array:
    """Stress around a cavity, where soil has not yielded."""
    ray = place * [1.0, 1.0 if dimensions == 3 else 0.0]
    r = np.linalg.norm(ray, axis=-1)
    cos, sin = np.moveaxis(ray, -1, 0) / r
    y = r ** -float(dimensions)
    radial = -FACTOR[dimensions] * CLAY.rigidity_index * spence(1.0 - y)
    hoop = radial - 2.0 * CLAY.rigidity_index * np.log1p(-y)
    across = hoop if dimensions == 3 else (radial + hoop) / 2.0
    zz, rr = radial * sin**2 + across * cos**2, radial * cos**2 + across * sin**2
    return np.stack([rr, zz, (radial - across) * sin * cos, hoop], axis=-1)


def cavity(dimensions: int, element: float) -> float:
    """Limit pressure over su, when the cavity is exp(4) times as large as at the beginning."""
    radius = halved(1.0 + graded(29.0, element, 1.0 + element))[::-1, None]
    if dimensions == 3:
        angle = np.linspace(0.0, np.pi / 2.0, 9)  # from the equator to the pole
        grid = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1)
    else:
        grid = np.stack(np.broadcast_arrays(radius, np.linspace(0.0, 0.1, 3)), axis=-1)
    mesh = Elements(grid)
    boundary = Boundary(len(mesh.x))
    ray = mesh.x * [1.0, 1.0 if dimensions == 3 else 0.0]
    velocity = ray / np.linalg.norm(ray, axis=1)[:, None] ** dimensions
    boundary.hold(mesh.nodes[:, 0], 0.0, 1)
    boundary.hold(mesh.nodes[:, -1], 0.0, 0 if dimensions == 3 else 1)
    wall = mesh.nodes[-1]
    boundary.hold(wall, velocity[wall])
    far = mesh.nodes[0]
    stress = elastic_stress(mesh.x[far], dimensions)
    boundary.force[far] = force_of(stress, areas(mesh.x, far)[far])
    inflow = partial(elastic_stress, dimensions=dimensions)
    # Most of the reaction is not that of the cavity.
    flow = Flow(mesh, CLAY, boundary, velocity, ray, inflow, tolerance=1e-6)
    for _ in range(round(4.0 / element)):
        flow.advance(element)
    size = np.linalg.norm(areas(mesh.x, wall), axis=1).sum()
    return float((flow.reaction * ray)[wall].sum() / size)


def footing(rough: bool, element: float) -> float:
    """Limit load over su of a footing of radius 1, its elements at the edge `element` wide."""
    growth = 1.2 ** (element / 0.06)
    under, beside = graded(1.0, element, growth), graded(7.0, element, growth)
    r = halved(np.concatenate([1.0 - under[::-1], 1.0 + beside[1:]]))
    z = halved(-graded(8.0, element, growth)[::-1])
    mesh = Elements(np.stack(np.meshgrid(r, z), axis=-1))
    boundary = Boundary(len(mesh.x))
    boundary.hold(mesh.nodes[:, 0], 0.0, 0)
    boundary.hold(mesh.nodes[:, -1], 0.0, 0)
    boundary.hold(mesh.nodes[0], 0.0)
    base = mesh.nodes[-1, r <= 1.0 + 1e-9]
    boundary.hold(base, -1.0, 1)
    if rough:
        boundary.hold(base, 0.0, 0)
    flow = Flow(
        mesh, CLAY, boundary, boundary.velocity, None, lambda it: np.zeros((*it.shape[:-1], 4))
    )
    for _ in range(20):
        flow.advance(0.01)
    return float(-2.0 * flow.reaction[base, 1].sum())


CHECKS = {
    "cylindrical cavity": Check(limit_pressure(2), partial(cavity, 2), 0.1),
    "spherical cavity": Check(limit_pressure(3), partial(cavity, 3), 0.1),
    "smooth footing": Check(5.69, partial(footing, False), 0.06),
    "rough footing": Check(6.05, partial(footing, True), 0.06),
}


def main() -> None:
    """Print what is computed with two sizes, the limit, what is exact, and the error."""
    for name, check in CHECKS.items():
        coarse, fine = check.pair()
        limit = 2.0 * fine - coarse
        error = 100.0 * (limit / check.exact - 1.0)
        print(f"{name}: {coarse:.3f} {fine:.3f} -> {limit:.3f}, {check.exact:.3f}: {error:+.2f} %")


if __name__ == "__main__":
    main()
