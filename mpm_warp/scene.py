"""A scene: soil in a grid, and the parts that act on it.

The list has the stages of a step and the places at which parts act, in order. At one place parts
act in the order of the tuple. A part that is not in the tuple has no kernel, no array, no branch.

    material points                 add_to_points       arrays of points, options of stages
    1 particles to grid
    2 stress of cells
    3 momentum of nodes
    4 on nodes                      add_forces          loads, gravity, damping
                                    add_boundary        conditions at the edges of the grid
                                    add_contact         a rigid body, after all others
    5 rates of cells
    6 grid to particles
    after the motion                add_after_motion    motion of the grid
    every 16th step                 add_records         further records of this step
    between steps, by the host      between_steps       soil enters: `enter`, then `follow`
"""

from dataclasses import dataclass, replace
from typing import ClassVar, Protocol, Self, TypeVar

import numpy as np

from mpm_warp.errors import SceneError
from mpm_warp.fields.checked import Checked
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.materials.material import Material
from mpm_warp.plan.plan import Plan, Run

KindOfPart = TypeVar("KindOfPart", bound="Part")


class BetweenSteps(Protocol):
    """Actions of the host between the steps of a run."""

    @property
    def steps_ahead(self) -> int:
        """Steps to take before the next call of `act`, at least 1."""

    def act(self) -> None:
        """Act, if it is time."""


class Part(Checked):
    """A part of a scene: a force, a boundary, a contact, a window, a record.

    A part overrides a method for each place at which it acts. At the places on nodes the array
    "node.velocities" holds (v_r, v_z, u_r, u_z), velocity after the step and before it, and
    "node.mass" the mass, 0 where no particle is near.

    Attributes:
        needs: classes of parts that the scene must have too.
        not_beside: classes of parts that the scene must not have, each with a remedy, or "".
        cell_bytes, point_bytes: memory for a cell with its share of nodes, and for a slot [byte].

    Example:
        >>> class Wind(Part):
        ...     pass
        >>> GravityColumn().build().with_parts(Wind()).find(Wind) is not None
        True
    """

    needs: "ClassVar[tuple[type[Part], ...]]" = ()
    not_beside: "ClassVar[tuple[tuple[type[Part], str], ...]]" = ()
    cell_bytes: ClassVar[float] = 0.0
    point_bytes: ClassVar[float] = 0.0

    def check(self, scene: "Scene") -> None:
        """Raise `SceneError` if the part does not suit grid and material."""

    def add_to_points(self, plan: Plan, scene: "Scene") -> None:
        """Add arrays of points, or arrays that stages look for; before the first stage."""

    def add_forces(self, plan: Plan, scene: "Scene") -> None:
        """Add launches that change the new velocities of nodes, after the momentum equation."""

    def add_boundary(self, plan: Plan, scene: "Scene") -> None:
        """The same, after all forces."""

    def add_contact(self, plan: Plan, scene: "Scene") -> None:
        """The same, after all boundaries and before the rates of cells."""

    def add_after_motion(self, plan: Plan, scene: "Scene") -> None:
        """Add launches to the end of a step, after points have moved."""

    def add_records(self, plan: Plan, scene: "Scene") -> None:
        """Add launches to the audited step, a copy of the complete step, or between steps."""

    def between_steps(self, run: Run, scene: "Scene") -> BetweenSteps | None:
        """Actions of the host between steps; None, the default: there are none."""
        return None

    def enter(self, run: Run, scene: "Scene", position: Floats, travel: float) -> None:
        """Set values of a layer of soil that enters, in the arrays "layer.x" of each "particle.x".

        `position` is that of its points in the grid [m], shape [point_count, 2].
        """

    def follow(self, run: Run, scene: "Scene", travel: float, *, by_a_row: bool) -> None:
        """Update the arrays of the part by the travel [m], after a layer has entered.

        `by_a_row`: the soil has risen into the next row of cells.
        """


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene(Checked):
    """Soil in a grid and the parts that act on it. SI units; stress is in excess of in-situ stress.

    Attributes:
        grid: the background grid, full of soil up to its ground level and its soil radius.
        material: the law of the soil.
        parts: all that acts on the soil, moves the grid or is recorded.

    Raises:
        SceneError: a value is not allowed, or two parts exclude each other.

    Example:
        >>> column = GravityColumn(cell_count=4).build()
        >>> [type(part).__name__ for part in column.parts]
        ['Gravity', 'Damping', 'Fixed']
        >>> column.without(Damping).find(Damping) is None
        True
    """

    grid: Grid
    material: Material
    particles_per_side: int = parameter(2, "particles along each side of a cell", minimum=1)
    time_step_fraction: float = parameter(0.85, "time step over the critical one", above=0)
    bulk_viscosity: float | None = parameter(
        None, "coefficient of the viscous pressure; None: there is none", above=0
    )
    # in equilibrium if it has no shear, if its radial and hoop parts are equal, and if fixed nodes
    # or the surrounding ground hold it; 0 where the material varies: the variation has the stress
    stress_at_rest: Floats = parameter(
        np.zeros(4), "initial stress (rr, zz, rz, tt) of the soil", unit="Pa", shape=(4,)
    )
    parts: tuple[Part, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
        self.material.check_complete("Scene: material")
        self.material.check_stress_at_rest(self.stress_at_rest)
        refuse_together(
            "stress_at_rest",
            np.any(self.stress_at_rest) and self.material.variation is not None,
            "a material that varies",
        )
        for part in self.parts:
            self._check_beside_others(part)
            part.check(self)

    def find(self, kind: type[KindOfPart]) -> KindOfPart | None:
        """The first part of a class; None if there is none."""
        return next((part for part in self.parts if isinstance(part, kind)), None)

    def __getitem__(self, kind: type[KindOfPart]) -> KindOfPart:
        """The first part of a class; `SceneError` if there is none."""
        part = self.find(kind)
        if part is None:
            raise SceneError(f"the scene has no {kind.__name__}")
        return part

    def with_parts(self, *parts: Part) -> Self:
        """The scene with these parts; each replaces the part of its class or is appended."""
        own = list(self.parts)
        for part in parts:
            places = [k for k, other in enumerate(own) if type(other) is type(part)]
            if places:
                own[places[0]] = part
            else:
                own.append(part)
        return replace(self, parts=tuple(own))

    def without(self, *kinds: type[Part]) -> Self:
        """The scene without its parts of these classes."""
        return replace(
            self, parts=tuple(part for part in self.parts if not isinstance(part, kinds))
        )

    def stress_at_rest_at(self, place: Floats) -> Floats:
        """Initial stress (rr, zz, rz, tt) at places (r, z) in the ground, see `Variation` [Pa]."""
        stress = np.tile(self.stress_at_rest, (*place.shape[:-1], 1))
        ground = self.material.variation
        if ground is not None and ground.horizontal_stress is not None:
            stress[..., [0, 3]] += ground.at(place, ground.horizontal_stress)[..., None]
        return stress

    def _check_beside_others(self, part: Part) -> None:
        name = type(part).__name__
        for kind in part.needs:
            if self.find(kind) is None:
                raise SceneError(f"{name}: not without a {kind.__name__}")
        for kind, instead in part.not_beside:
            remedy = f"; {instead}" if instead else ""
            refuse_together(name, self.find(kind), f"a {kind.__name__}{remedy}")


def refuse_together(name: str, is_there: object, what: str) -> None:
    """Raise `SceneError` if `name` is given together with `what` and this is not allowed."""
    if is_there:
        raise SceneError(f"{name}: not together with {what}")
