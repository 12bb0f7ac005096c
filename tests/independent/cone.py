"""The cone factor by steady flow past a cone: `python -m tests.independent.cone --help`.

Lengths are over the radius of the cone, velocities over its speed, stresses over su. The tip lies
at the origin, soil flows upwards; far away it moves as around a source that travels with the cone
and makes the room that cone and shaft take.
"""

import argparse
from dataclasses import dataclass, fields

import numpy as np

from tests.independent.clay import Array, Clay
from tests.independent.elements import Elements, Nodes, areas, force_of, graded, halved
from tests.independent.flow import TOLERANCE, Boundary, Flow

HALF_ANGLE = np.pi / 6.0
HEIGHT = 1.0 / np.tan(HALF_ANGLE)
SOURCE = 2.0 / 3.0 * HEIGHT
"""Height of the source: the mean of where the cone widens."""
UPWARDS = np.array([0.0, 1.0])
AXIAL = np.array([0.0, 1.0, 0.0, 0.0])


def far_velocity(place: Array) -> Array:
    """Velocity around the source, x / (4 |x|^3)."""
    apart = place - SOURCE * UPWARDS
    return apart / (4.0 * np.linalg.norm(apart, axis=-1, keepdims=True) ** 3)


@dataclass(frozen=True)
class Cone:
    """A cone in uniform clay, and the mesh around it.

    `shoulder` is the normal of the node between face and shaft: of one of them, or the mean.
    """

    rigidity_index: float = 100.0
    poissons_ratio: float = 0.49
    criterion: str = "tresca"
    adhesion_factor: float = 0.0  # of face and shaft
    stress_anisotropy: float = 0.0  # (sigma_v0 - sigma_h0) / (2 su)
    element: float = 0.12  # length at tip and shoulder
    growth: float = 1.2  # from element to element
    shoulder: str = "mean"  # or face, shaft
    extent: float = 5.0  # of the soil to the side over sqrt(Ir); half of it below and above

    def factors(self) -> tuple[float, float]:
        """Steady cone factor, and the one a radius before, each the mean over a radius."""
        clay = Clay(self.rigidity_index, self.poissons_ratio, self.criterion)
        mesh = self._mesh()
        face, shaft = self._walls(mesh)
        boundary = self._boundary(mesh)
        flow = Flow(mesh, clay, boundary, far_velocity(mesh.x), -UPWARDS, self.far_stress)
        shoulder = [np.linalg.norm(areas(mesh.x, it)[face[-1]]) for it in (face, shaft)]
        found = []
        for increment in [0.5] * round(5.0 * self.rigidity_index**0.5) + [0.2] * 15 + [0.1] * 20:
            flow.advance(increment)
            force = flow.reaction[face]
            force[:, 0] += flow.friction[face]
            force[-1, 0] -= flow.friction[face[-1]] * shoulder[1] / sum(shoulder)
            upwards = (boundary.axes[face][:, 1] * force).sum()
            found.append(-2.0 * upwards - 2.0 * self.stress_anisotropy)
        if flow.unbalanced > TOLERANCE:
            raise RuntimeError("no equilibrium was found")
        return float(np.mean(found[-10:])), float(np.mean(found[-20:-10]))

    def far_stress(self, place: Array) -> Array:
        """Stress around a travelling source, from displacements

        u_r = (1 + z / d) / (4 r),  u_z = -1 / (4 d),  d^2 = r^2 + z^2,

        which keep the volume; z is from the source.
        """
        r, z = np.moveaxis(place - SOURCE * UPWARDS, -1, 0)
        distance = np.hypot(r, z)
        hoop = 1.0 / (distance * (distance - z))
        axial, shear = z / distance**3, r / distance**3
        strain = np.stack([-hoop - axial, axial, shear, hoop], axis=-1) / 4.0
        return 2.0 * self.rigidity_index * strain - 2.0 * self.stress_anisotropy * AXIAL

    def _mesh(self) -> Elements:
        """Elements whose columns follow the flow.

        Along a column r^2 = A + f(z, A): f is the square of the radius of the cone where A = 0, and
        smoother the greater A is,

            f = tan^2 integral of x (1 + (z - x) / sqrt((z - x)^2 + l^2)) over the cone's height,

        with l = A / sqrt(1 + A).
        """
        extent = self.extent * np.sqrt(self.rigidity_index)
        column = graded(extent, self.element, self.growth) ** 2
        beyond = graded(extent / 2.0, self.element, self.growth)
        face = graded(HEIGHT / 2.0, self.element, self.growth)
        z = np.concatenate([-beyond[:0:-1], face, HEIGHT - face[-2::-1], HEIGHT + beyond[1:]])
        length = column / np.sqrt(1.0 + column) + 1e-9

        def primitive(u: Array) -> Array:
            root = np.hypot(u, length)
            half = (u * root - length**2 * np.arcsinh(u / length)) / 2.0
            return z[:, None] * root - half

        made = primitive(z[:, None]) - primitive(z[:, None] - HEIGHT)
        squared = column + 0.5 + made / HEIGHT**2
        squared[:, 0] = np.clip(z / HEIGHT, 0.0, 1.0) ** 2
        r = np.sqrt(squared)
        place = np.stack(np.broadcast_arrays(r, z[:, None]), axis=-1)
        return Elements(halved(halved(place, 0), 1))

    def _walls(self, mesh: Elements) -> tuple[Nodes, Nodes]:
        """Nodes of the face, from the tip, and of the shaft; both have that of the shoulder."""
        wall = mesh.nodes[:, 0]
        tip, shoulder = (np.argmin(np.abs(mesh.x[wall, 1] - it)) for it in (0.0, HEIGHT))
        return wall[tip : shoulder + 1], wall[shoulder:]

    def _boundary(self, mesh: Elements) -> Boundary:
        face, shaft = self._walls(mesh)
        wall = np.concatenate([face, shaft[1:]])
        angle = np.repeat([HALF_ANGLE, 0.0], [len(face), len(shaft) - 1])
        angle[len(face) - 1] *= {"face": 1.0, "mean": 0.5, "shaft": 0.0}[self.shoulder]
        sin, cos = np.sin(angle), np.cos(angle)
        boundary = Boundary(len(mesh.x))
        boundary.axes[wall] = np.array([[sin, cos], [cos, -sin]]).transpose(2, 0, 1)

        ends, side, axis = mesh.nodes[[0, -1]].ravel(), mesh.nodes[:, -1], mesh.nodes[:, 0]
        far = far_velocity(mesh.x[ends])
        boundary.hold(ends, np.einsum("ncd,nc->nd", boundary.axes[ends], far))
        boundary.force[side] = force_of(self.far_stress(mesh.x[side]), areas(mesh.x, side)[side])
        boundary.hold(axis[~np.isin(axis, wall)], 0.0, 0)
        boundary.hold(wall, sin, 1)
        boundary.hold(wall[:1], -cos[:1], 0)
        boundary.wall[wall] = -cos
        for chain in (face, shaft):
            boundary.grip += self.adhesion_factor * np.linalg.norm(areas(mesh.x, chain), axis=1)
        return boundary


def main() -> None:
    """Print the cone factor of the options."""
    choices = {"criterion": ("tresca", "von_mises"), "shoulder": ("face", "mean", "shaft")}
    parser = argparse.ArgumentParser(description="Cone factor by steady flow past a cone.")
    for field in fields(Cone):
        name = "--" + field.name.replace("_", "-")
        kind = type(field.default)
        parser.add_argument(name, type=kind, default=field.default, choices=choices.get(field.name))
    factor, before = Cone(**vars(parser.parse_args())).factors()
    print(f"Nc {factor:.3f}, {before:.3f} a radius before")


if __name__ == "__main__":
    main()
