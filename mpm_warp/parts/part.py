"""What a part of a scene may know of the soil that it acts on, and how it enters a run.

A file with kernels must not have `from __future__ import annotations`: Warp reads the types of a
kernel from its annotations, and would raise a `NameError`.
"""

from __future__ import annotations

from typing import Protocol, runtime_checkable

from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.materials.material import Material
from mpm_warp.plan.plan import Plan
from mpm_warp.plan.run import Run


class Setting(Protocol):
    """The soil that a part acts on; a scene is one."""

    @property
    def grid(self) -> Grid:
        """The background grid."""

    @property
    def material(self) -> Material:
        """The soil's constitutive model."""

    def stress_at_rest_at(self, place: Floats) -> Floats:
        """Stress (rr, zz, rz, tt) of the ground before at places in it [Pa], [..., 2], [..., 4]."""

    @property
    def particles_per_side(self) -> int:
        """Particles along each side of a cell."""

    @property
    def window(self) -> object | None:
        """How the grid travels through the soil; None where it rests."""


@runtime_checkable
class NodeAction(Protocol):
    """A part that changes the new velocities of nodes: a force, a boundary, a contact.

    It acts between the momentum equation and the strain rates of cells. The array of the plan
    "node.velocities" holds (v_r, v_z, u_r, u_z), velocity after the step and before it, "node.mass"
    the mass, 0 where no particle is near.
    """

    def add_to(self, plan: Plan, setting: Setting) -> None:
        """Add arrays and launches of the part to a plan, at the end of what it has by now."""


@runtime_checkable
class FitsGrid(Protocol):
    """A part that names nodes of the grid, which a scene has it check when it is made."""

    def check(self, setting: Setting) -> None:
        """Check that the grid has the nodes.

        Raises:
            SceneError: it has not.
        """


@runtime_checkable
class FollowsWindow(Protocol):
    """A part that depends on how far a window has travelled, or on the soil that is in it."""

    def follow(self, run: Run, setting: Setting, travel: float) -> None:
        """Give the arrays of the part their values from here on; after each layer that enters.

        Args:
            run: whose arrays the part has added.
            setting: the soil.
            travel: how far the grid has travelled down through the soil [m].
        """
