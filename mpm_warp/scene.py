"""What a user declares: soil in a grid, and the parts that act on it.

A step and the places in it at which parts act, in order; where several act at one place they do so
in the order of the tuple. A part that is not in the tuple has no kernel, no array and no branch.

    material points                 add_to_points       what points carry, options of stages
    1 particles to grid
    2 stress of cells
    3 momentum of nodes
    4 on nodes                      add_forces          loads, gravity, damping
                                    add_boundary        what holds nodes at the edges of the grid
                                    add_contact         a rigid body, when all else is known
    5 rates of cells
    6 grid to particles
    after the motion                add_after_motion    what moves the grid
    every 16th step                 add_records         what this step records besides
    between steps, by the host      between_steps       soil enters: `enter`, then `follow`
"""

from dataclasses import dataclass, field, replace
from typing import ClassVar, Protocol, Self, TypeVar

import numpy as np

from mpm_warp.arguments import FROM_ONE, POSITIVE, Checked, array_of, checked
from mpm_warp.errors import SceneError
from mpm_warp.grid.fitted import Floats, Grid
from mpm_warp.materials.material import Material
from mpm_warp.plan.plan import Plan, Run

KindOfPart = TypeVar("KindOfPart", bound="Part")


class BetweenSteps(Protocol):
    """What the host does between the steps of a run."""

    @property
    def steps_ahead(self) -> int:
        """Steps that can be taken before it may have to act, at least 1."""

    def act(self) -> None:
        """Act, if it is time."""


class Part(Checked):
    """A part of a scene: a force, a boundary, a contact, a window, a record.

    A part has a method for each place of a step at which it acts; what it does not override adds
    nothing. At the places on nodes the array "node.velocities" holds (v_r, v_z, u_r, u_z), velocity
    after the step and before it, and "node.mass" the mass, 0 where no particle is near.

    Attributes:
        needs: kinds of parts without which there is none of this kind.
        not_beside: kinds of parts that a scene cannot have beside one of this kind, each with what
            to do instead, or "".
        cell_bytes, point_bytes: memory that it adds for a cell with its share of nodes, and for a
            slot of a point [byte].
    """

    needs: "ClassVar[tuple[type[Part], ...]]" = ()
    not_beside: "ClassVar[tuple[tuple[type[Part], str], ...]]" = ()
    cell_bytes: ClassVar[float] = 0.0
    point_bytes: ClassVar[float] = 0.0

    def check(self, scene: "Scene") -> None:
        """Raise `SceneError` where the part does not fit grid and material."""

    def add_to_points(self, plan: Plan, scene: "Scene") -> None:
        """Add arrays of the material points, or what stages look for; before the first stage."""

    def add_forces(self, plan: Plan, scene: "Scene") -> None:
        """Add launches that change the new velocities of nodes, after the momentum equation."""

    def add_boundary(self, plan: Plan, scene: "Scene") -> None:
        """The same, after all forces."""

    def add_contact(self, plan: Plan, scene: "Scene") -> None:
        """The same, after all boundaries; the strain rates of cells are next."""

    def add_after_motion(self, plan: Plan, scene: "Scene") -> None:
        """Add launches to the end of a step, when points have moved."""

    def add_records(self, plan: Plan, scene: "Scene") -> None:
        """Add launches to the audited step of a plan whose step is complete, or between steps."""

    def between_steps(self, run: Run, scene: "Scene") -> BetweenSteps | None:
        """What the host does for the part between steps of a run; none by default."""
        return None

    def enter(self, run: Run, scene: "Scene", position: Floats, travel: float) -> None:
        """Give a layer of soil that is about to enter what it has by this part.

        The run has its values in the arrays "layer.x", for each "particle.x". Its points are at
        positions [m] of shape [point_count, 2] in the grid, which has travelled so far [m].
        """

    def follow(self, run: Run, scene: "Scene", travel: float, *, by_a_row: bool) -> None:
        """Give the arrays of the part their values after a layer has entered, so far down [m].

        With it the soil may have come into the next row of cells: `by_a_row`.
        """


@dataclass(frozen=True, kw_only=True, eq=False)
class Scene(Checked):
    """Soil in a grid, and what acts on it. SI units; stress is the excess over in-situ.

    Attributes:
        grid: the background grid; every cell that it says holds soil is full of it.
        material: the soil's constitutive model.
        particles_per_side: particles along each side of a cell, >= 1; default: 2.
        time_step_fraction: time step over the critical one, dimensionless, > 0; default: 0.85.
        bulk_viscosity: coefficient of the viscous pressure, dimensionless, > 0, or none.
        stress_at_rest: stress (rr, zz, rz, tt) of the soil at the start [Pa], shape [4]; none by
            default. It rests where it has no shear, its radial part is the hoop part, and what
            bounds the grid holds it: fixed nodes, or the surroundings, which start with it. Where
            the material varies it is none: the variation has the horizontal stress.
        parts: all that acts on the soil, moves the grid or is recorded.

    Raises:
        SceneError: a value is not allowed, or two parts do not go together.
    """

    grid: Grid
    material: Material
    particles_per_side: int = checked(FROM_ONE, default=2)
    time_step_fraction: float = checked(POSITIVE, default=0.85)
    bulk_viscosity: float | None = checked(POSITIVE, default=None)
    stress_at_rest: Floats = field(default_factory=lambda: np.zeros(4), metadata=array_of(4))
    parts: tuple[Part, ...] = ()

    def __post_init__(self) -> None:
        super().__post_init__()
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
        """The first part of a kind; None where there is none."""
        return next((part for part in self.parts if isinstance(part, kind)), None)

    def __getitem__(self, kind: type[KindOfPart]) -> KindOfPart:
        """The first part of a kind; `SceneError` where there is none."""
        part = self.find(kind)
        if part is None:
            raise SceneError(f"the scene has no {kind.__name__}")
        return part

    def with_parts(self, *parts: Part) -> Self:
        """The scene with parts more, each in the place of the one of its type where it has one."""
        own = list(self.parts)
        for part in parts:
            places = [k for k, other in enumerate(own) if type(other) is type(part)]
            if places:
                own[places[0]] = part
            else:
                own.append(part)
        return replace(self, parts=tuple(own))

    def without(self, *kinds: type[Part]) -> Self:
        """The scene without its parts of some kinds."""
        return replace(
            self, parts=tuple(part for part in self.parts if not isinstance(part, kinds))
        )

    def stress_at_rest_at(self, place: Floats) -> Floats:
        """Stress (rr, zz, rz, tt) of the ground before [Pa], at places (r, z) in it [m], [..., 4].

        Of places see `Variation`.
        """
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
    """Raise `SceneError` where a value or a part is beside something that it does not go with."""
    if is_there:
        raise SceneError(f"{name}: not together with {what}")
