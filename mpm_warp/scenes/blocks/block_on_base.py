"""A block pressed on a base and driven along it: parameters, forces and exact motion."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from mpm_warp.fields.checked import refuse
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.scenes.catalogue_scene import CatalogueScene

BASE_CELLS = 3
"""Thickness of the base, and its length beyond the path of the block at each end, in cells."""
SAMPLE_COUNT = 100
"""Samples of the curves after the start of the drive."""
SETTLING = 40.0
"""Time in which the normal load rises and the block comes to rest, over the time in which a shear
wave crosses the height of the block."""
DRIVE_RISE = 10.0
"""Rise time of a constant driving force, over the same time."""


@dataclass(frozen=True, kw_only=True)
class SlidingMotion:
    """Motion of a rigid block, which sticks while F <= R = a A + mu N; then M dv/dt = F - R.

    F is the driving force, A the area of the base, N the normal force, a the adhesion and mu the
    friction coefficient.
    """

    mass: float  # M [kg], > 0
    driving_force: float  # final value of F, which rises linearly from zero [N], > 0
    resistance: float  # R [N], >= 0
    rise_time: float | None  # of F [s], > 0; None: F rises until the motion ends

    @property
    def slides(self) -> bool:
        """Whether the final driving force exceeds the resistance."""
        return self.driving_force > self.resistance

    def duration(self, travel: float) -> float:
        """Time [s] from the start of the drive in which a sliding block covers `travel` [m].

        Where there is a `rise_time`, the distance covered during it is not counted.
        """
        excess = 1.0 - self.resistance / self.driving_force
        unit = travel * self.mass / self.driving_force
        if self.rise_time is None:
            return math.sqrt(6.0 * unit / excess**3)
        return self.rise_time + math.sqrt(2.0 * unit / excess)

    def at(self, since: Floats) -> tuple[Floats, Floats, Floats]:
        """Velocity [m/s], displacement [m] and base shear [N] at times since the drive began [s].

        Without a `rise_time` the force rises until the last of these times.
        """
        rise = float(since[-1]) if self.rise_time is None else self.rise_time
        onset = min(self.resistance / self.driving_force, 1.0) * rise
        # Velocity is quadratic in time while the force rises, and linear afterwards.
        rising = np.clip(since, onset, rise) - onset
        steady = np.maximum(since - rise, 0.0) if self.slides else np.zeros_like(since)
        growth = self.driving_force / rise / self.mass
        final = growth * (rise - onset)
        velocity = 0.5 * growth * rising**2 + final * steady
        at_rise = 0.5 * growth * (rise - onset) ** 2
        displacement = growth * rising**3 / 6.0 + at_rise * steady + 0.5 * final * steady**2
        drive = self.driving_force * np.minimum(since / rise, 1.0)
        return velocity, displacement, np.minimum(drive, self.resistance)


@dataclass(frozen=True, kw_only=True)
class BlockOnBase(CatalogueScene):
    """A block that is pressed on a base, comes to rest and is then driven along the base.

    The coordinates follow the interface. Gravity is inclined by the slope. The grid may have any
    angle and offset to the interface.
    """

    friction: float = parameter(0.3, "friction coefficient of the interface", minimum=0, maximum=10)
    adhesion: float = parameter(500.0, "adhesion of the interface", unit="Pa", minimum=0)
    slope: float = parameter(30.0, "slope of the interface", unit="degree", minimum=0, below=90)
    gravity: float = parameter(9.81, "gravity", unit="m s-2", minimum=0)
    normal_pressure: float = parameter(
        0.0, "normal pressure on the block in addition to gravity", unit="Pa", minimum=0
    )
    drive: float = parameter(
        0.0, "driving force per area of the interface, beside gravity", unit="Pa", minimum=0
    )
    driving: str = parameter(
        "constant",
        "rise of the driving forces, gravity's included: to a constant value in ten crossing times "
        "of a shear wave, or, where the block slides, ramped until the end",
        choices=("constant", "ramped"),
    )
    grid_angle: float = parameter(
        0.0, "angle between interface and grid", unit="degree", minimum=-180, maximum=180
    )
    grid_offset: float = parameter(
        0.0, "offset to the grid along both axes over cell size", minimum=0, below=1
    )
    interface_radius: float | None = parameter(
        None,
        "radius of the interface of a ring in a sleeve (default: plane strain)",
        unit="m",
        above=0,
    )
    length: float = parameter(1.0, "length of the block", unit="m", above=0, maximum=1e6)
    height_ratio: float = parameter(
        0.3, "height of the block over its length", minimum=0.1, maximum=2
    )
    shear_modulus: float = parameter(
        4e6, "shear modulus of the softer of block and base", unit="Pa", above=0
    )
    stiffness_ratio: float | None = parameter(
        None,
        "stiffness of the base over that of the block (default: rigid base)",
        minimum=1e-6,
        maximum=1e6,
    )
    poissons_ratio: float = parameter(0.3, "Poisson's ratio", minimum=0, maximum=0.45)
    density: float = parameter(2000.0, "density of the block", unit="kg m-3", above=0)
    mass_scale: float = parameter(1.0, "factor on all masses but not on gravity's force", above=0)
    travel: float = parameter(0.4, "distance to slide over length", above=0, maximum=5)
    rest_time: float = parameter(
        None,
        "time for which a block that sticks is followed, once at rest (default: the time in "
        "which it would slide its own length without friction and adhesion)",
        unit="s",
        above=0,
    )
    damping_ratio: float = parameter(
        0.05,
        "share of critical damping of the block's slowest shear wave; 0 for none",
        minimum=0,
        maximum=2,
    )
    cells_per_length: int = parameter(10, "cells along the block", minimum=4, maximum=400)
    particles_per_cell: int = parameter(4, "material points per cell", choices=(4, 9, 16))
    time_step_fraction: float = parameter(
        0.6, "time step over the time in which a wave crosses a cell", above=0, maximum=1
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.driving_force <= 0.0:
            refuse(self, "drive", " with slope = 0 or gravity = 0: nothing drives the block")
        if self.normal_force <= 0.0:
            refuse(self, "normal_pressure", " with gravity = 0: nothing holds the block")
        if round(self.height / self.spacing) < 3 * math.isqrt(self.particles_per_cell):
            with_cells = f" with cells_per_length = {self.cells_per_length}"
            refuse(self, "height_ratio", f"{with_cells}: the block must be 3 cells high or more")
        if self.interface_radius is None:
            self._check_pressed()
        else:
            self._check_ring(self.interface_radius)

    def derived(self) -> Mapping[str, float]:
        """The time in which the block would slide its length without resistance."""
        if self.driving_force <= 0.0:
            return {}  # such a block is refused
        return {"rest_time": math.sqrt(2.0 * self.length * self.mass / self.driving_force)}

    def _check_pressed(self) -> None:
        # The moment of the base shear shifts N, which must stay in the middle third of the base.
        shear = min(self.motion.resistance, self.driving_force)
        highest = self.normal_force * self.length / (3.0 * shear) if shear > 0.0 else math.inf
        if self.height > highest:
            at_most = f"at most {highest / self.length:.3g} with these forces"
            refuse(self, "height_ratio", f": the block would lift off at its rear; {at_most}")

    def _check_ring(self, radius: float) -> None:
        if self.friction > 0.0:
            why = "the hoop stress of the ring bears part of the normal force; set friction = 0"
            refuse(self, "friction", f" with an interface_radius: {why}")
        if self.grid_angle != 0.0:
            refuse(self, "grid_angle", " with an interface_radius: must be 0")
        least = self.height + 4.0 * self.cell_size
        if radius < least:
            why = f"must be at least {least:g} m: the height of the block and four cells"
            refuse(self, "interface_radius", f": {why}")

    @property
    def cell_size(self) -> float:
        """Side of a cell [m]."""
        return self.length / self.cells_per_length

    @property
    def spacing(self) -> float:
        """Distance of the material points [m]."""
        return self.cell_size / math.isqrt(self.particles_per_cell)

    @property
    def height(self) -> float:
        """Height of the block, a whole number of spacings [m]."""
        return self.spacing * max(1, round(self.height_ratio * self.length / self.spacing))

    @property
    def area(self) -> float:
        """Area of the block's base per thickness, or per radian [m2]."""
        return self.length * (self.interface_radius or 1.0)

    @property
    def volume(self) -> float:
        """Volume of the block per thickness, or per radian [m3]."""
        mean = 1.0 if self.interface_radius is None else self.interface_radius - 0.5 * self.height
        return self.length * self.height * mean

    @property
    def mass(self) -> float:
        """Mass of the block, scaled [kg]."""
        return self.mass_scale * self.density * self.volume

    @property
    def weight(self) -> float:
        """Weight of the block, without the mass scale [N]."""
        return self.density * self.volume * self.gravity

    @property
    def normal_force(self) -> float:
        """Force that presses the block on its base [N]."""
        return self.weight * math.cos(math.radians(self.slope)) + self.normal_pressure * self.area

    @property
    def driving_force(self) -> float:
        """Final force along the interface [N]."""
        return self.weight * math.sin(math.radians(self.slope)) + self.drive * self.area

    @property
    def motion(self) -> SlidingMotion:
        """The exact motion of a rigid block under the same forces."""
        motion = SlidingMotion(
            mass=self.mass,
            driving_force=self.driving_force,
            resistance=self.adhesion * self.area + self.friction * self.normal_force,
            rise_time=DRIVE_RISE * self._crossing,
        )
        if self.driving == "ramped" and motion.slides:
            return replace(motion, rise_time=None)
        return motion

    @property
    def start(self) -> float:
        """Time of the start of the drive [s]."""
        return SETTLING * self._crossing

    @property
    def settled_time(self) -> float:
        """Time from the start of the drive until a block that sticks is at rest again [s]."""
        return (DRIVE_RISE + SETTLING) * self._crossing

    @property
    def duration(self) -> float:
        """Time from the start of the drive to the end of the run [s]."""
        if self.motion.slides:
            return self.motion.duration(self.travel * self.length)
        return self.settled_time + self.rest_time

    @property
    def _crossing(self) -> float:
        """Time in which a shear wave of the softer body crosses the height of the block [s]."""
        return self.height / math.sqrt(self.shear_modulus / (self.mass_scale * self.density))
