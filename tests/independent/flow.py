"""Soil that flows through a mesh which stays: stress along the flow, and equilibrium."""

from collections.abc import Callable

import numpy as np
from scipy.linalg import solveh_banded

from tests.independent.clay import Array, Clay, rotated
from tests.independent.elements import SHAPE, Elements, Nodes, interpolated

SLIP = 0.02
"""Velocity of slip at which friction has 0.7 of its size, over that of the wall."""
TOLERANCE = 1e-4
"""Forces out of balance over the reactions of all boundaries."""
MOST = 10
"""Newton's steps in an increment: the first increments from rest are not solved to the end."""
DAMPING = 0.01
"""Share of the elastic stiffness that the tangent is raised by: a mechanism has none."""


class Boundary:
    """What holds at the nodes: velocity or force, each (n, 2), in axes of their own.

    The first axis of a wall is its tangent, the second its normal; elsewhere they are r and z.
    Friction against a wall that moves at V along itself is -grip (v - V) / sqrt((v - V)^2 + s^2).
    """

    def __init__(self, count: int) -> None:
        self.axes = np.tile(np.eye(2), (count, 1, 1))  # columns
        self.held = np.zeros((count, 2), dtype=bool)
        self.velocity, self.force = np.zeros((count, 2)), np.zeros((count, 2))
        self.grip, self.wall = np.zeros(count), np.zeros(count)

    def hold(self, nodes: Nodes, velocity: Array, component: slice | int = slice(None)) -> None:
        self.held[nodes, component] = True
        self.velocity[nodes, component] = velocity

    def friction(self, velocity: Array) -> tuple[Array, Array]:
        """Force along the tangent, (n), and how much it falls by velocity."""
        slip = velocity[:, 0] - self.wall
        size = np.hypot(slip, SLIP)
        return -self.grip * slip / size, self.grip * SLIP**2 / size**3


class Flow:
    """Soil in motion: velocity of the nodes, (n, 2) in their axes, stress of the points, (e, 4, 4).

    Args:
        velocity: about the one at the beginning, in r and z.
        frame: velocity of the mesh; None: soil moves so little that it takes the mesh along.
        inflow: stress of soil that comes in, by its place; soil begins with it, or yields.
    """

    def __init__(
        self,
        mesh: Elements,
        clay: Clay,
        boundary: Boundary,
        velocity: Array,
        frame: Array | None,
        inflow: Callable[[Array], Array],
        tolerance: float = TOLERANCE,
    ) -> None:
        self.mesh, self.clay, self.boundary = mesh, clay, boundary
        self.frame, self.inflow, self.tolerance = frame, inflow, tolerance
        own = np.einsum("ncd,nc->nd", boundary.axes, velocity)
        self.velocity = np.where(boundary.held, boundary.velocity, own)
        self.stress = clay.respond(inflow(mesh.place).reshape(-1, 4))[0].reshape(-1, 4, 4)
        axes = boundary.axes[mesh.members]
        rates = np.einsum("egkac,eacd->egkad", mesh.rates, axes).reshape(-1, 4, 5, 16)
        self.spin, strain = rates[:, :, 4], np.ascontiguousarray(rates[:, :, :4])
        self.strain = strain.reshape(-1, 16, 16)  # 4 components at 4 points
        self.members = (2 * mesh.members[:, :, None] + np.arange(2)).reshape(-1, 16)

        self.free = ~boundary.held.ravel()
        number = np.where(self.free, self.free.cumsum() - 1, -1)[self.members]
        row, column = number[:, :, None], number[:, None, :]
        self.pairs = (row >= 0) & (row <= column)
        self.width = (column - row)[self.pairs].max()
        self.band = (column * self.width + self.width + row)[self.pairs]
        self.damping = DAMPING * self._stiffness(np.tile(clay.stiffness, (len(strain), 4, 1, 1)))

    def advance(self, time: float) -> None:
        """Carry the stress along the flow for a time, then find the velocities in equilibrium.

        The increment has a convex potential, as plastic flow is associated: steps of Newton's
        method are shortened where the work along them has changed its sign.
        """
        carried = self._carried(time)
        forces, tangent = self._balance(carried, time)
        for _ in range(MOST):
            if self.unbalanced < self.tolerance:
                break
            stiffness = self._banded(time * (self._stiffness(tangent) + self.damping))
            step = np.zeros(self.free.size)
            step[self.free] = solveh_banded(stiffness, forces[self.free], check_finite=False)
            start, work, share = self.velocity, float(step @ forces), 1.0
            for _ in range(6):
                self.velocity = start + share * step.reshape(-1, 2)
                forces, tangent = self._balance(carried, time)
                if step @ forces >= -0.5 * work:
                    break
                share *= work / (work - float(step @ forces))

    def _balance(self, carried: Array, time: float) -> tuple[Array, Array]:
        """Forces that are out of balance at the velocity, and the tangent of each point."""
        trial = carried + time * self._strain_rate() @ self.clay.stiffness
        stress, tangent = self.clay.respond(trial.reshape(-1, 4))
        self.stress = stress.reshape(-1, 4, 4)
        weighted = (self.stress * self.mesh.volume[:, :, None]).reshape(-1, 1, 16)
        inside = np.bincount(self.members.ravel(), (weighted @ self.strain).ravel())
        self.friction, self.fall = self.boundary.friction(self.velocity)
        self.reaction = inside.reshape(-1, 2) - self.boundary.force
        self.reaction[:, 0] -= self.friction
        forces = np.where(self.free, -self.reaction.ravel(), 0.0)
        self.unbalanced = float(np.linalg.norm(forces) / np.linalg.norm(self.reaction))
        return forces, tangent.reshape(-1, 4, 4, 4)

    def _stiffness(self, tangent: Array) -> Array:
        """Stiffness of each element, integral of B^T D B, by the tangents D of its points."""
        weighted = tangent * self.mesh.volume[:, :, None, None]
        stress = (weighted @ self.strain.reshape(-1, 4, 4, 16)).reshape(-1, 16, 16)
        return self.strain.transpose(0, 2, 1) @ stress

    def _banded(self, stiffness: Array) -> Array:
        """The upper triangle of what is free, as LAPACK stores a band."""
        length = self.width + 1
        count = self.free.sum() * length
        band = np.asarray(np.bincount(self.band, stiffness[self.pairs], count), dtype=np.float64)
        fall = np.stack([self.fall, np.zeros_like(self.fall)], axis=1)
        band[self.width :: length] += fall.ravel()[self.free]
        return band.reshape(-1, length).T

    def _strain_rate(self) -> Array:
        own = self.velocity.ravel()[self.members]
        return (self.strain @ own[:, :, None]).reshape(-1, 4, 4)

    def _carried(self, time: float) -> Array:
        """Stress of the soil that arrives at the points, turned by the spin.

        It comes from the foot of its path, x - t w(x - t w(x) / 2), w being the velocity through
        the mesh: by cubic polynomials along the columns, linear ones across them.
        """
        if self.frame is None:
            return self.stress
        mesh, lines = self.mesh, self.mesh.lines()
        own = np.einsum("ncd,nd->nc", self.boundary.axes, self.velocity) - self.frame
        through = SHAPE @ own[mesh.members]
        crossed = np.einsum("egcd,egc->egd", mesh.to_element, through)[:, :, ::-1] / 2.0
        speed = mesh.in_rows(crossed)  # (rows, columns) of elements in a unit of time
        here = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 2)
        first, last = np.array([[it[0], it[-1]] for it in lines]).T

        middle = np.clip(here - time / 2.0 * speed.reshape(-1, 2), first, last)
        foot = here - time * interpolated(speed, lines, middle, (2, 2))
        stress = interpolated(mesh.in_rows(self.stress), lines, np.clip(foot, first, last), (4, 2))
        origin = mesh.in_rows(mesh.place - time * through).reshape(-1, 2)
        stress = np.where(foot[:, :1] < first[0], self.inflow(origin), stress)
        spin = np.einsum("ega,ea->eg", self.spin, self.velocity.ravel()[self.members])
        return mesh.of_elements(rotated(stress, time * mesh.in_rows(spin).ravel()))
