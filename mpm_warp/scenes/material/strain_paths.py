"""Material points on given strain paths, without a grid, and paths on which the stress is known.

Rotation and law are those of any run. Symbols: stress sigma; strain e and rotation R of a step; f
and k are the measure of the stress and the strength that the yield function gives.

    sigma  <- law(R sigma R', e, dt)
    excess <- max(excess, f / k - 1)

In shear of one direction the stress tau is exact: with the shear strain gamma, its plastic part xi
and the strength k

    tau = min(G gamma, k(xi)),   xi = gamma - tau / G
"""

import functools
import itertools
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy  # loads its integrators where they are first used: no other scene waits for them
import warp as wp

from mpm_warp.errors import Fault
from mpm_warp.fields.checked import Checked
from mpm_warp.fields.checks import check_array
from mpm_warp.fields.declaration import parameter
from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import kernel, maybe, one, real, vec4, vec5
from mpm_warp.materials.einav_randolph import EinavRandolph
from mpm_warp.materials.elasticity import make_stress_update, motion_of
from mpm_warp.materials.material import Law, Material, principal_stresses
from mpm_warp.materials.perfectly_plastic import UndrainedClay
from mpm_warp.materials.tresca import Tresca
from mpm_warp.plan.plan import Plan, Run
from mpm_warp.planning import SHARE_COUNT, make_plan
from mpm_warp.watch import ParticleWatch, make_watch

PATH_COUNT = 12
SIMPLE_SHEAR_STRAIN = 10.0
ELASTIC_STRAIN, PLASTIC_STRAIN = 0.5, 5.0
"""Strains of elastic and of yielding paths over su/G."""
NEWTON_STEPS = 8
"""More than needed: the slope of the falling strength is less than half that of the stress."""
RELATIVE_ERROR, ABSOLUTE_ERROR = 1e-11, 1e-13
"""Tolerances of the integration of simple shear."""


@dataclass(frozen=True, kw_only=True, eq=False)
class StrainPaths(Checked):
    """Material points, each strained and turned at a constant velocity gradient for one second."""

    material: Material
    gradient: Floats = parameter(
        meaning="velocity gradients (rr, rz, zr, zz, tt)", unit="1/s", shape=(None, 5)
    )
    stress: Floats  # stresses (rr, zz, rz, tt) at the start [Pa], shape [path_count, 4]
    step_count: int = parameter(meaning="steps into which the second is divided", minimum=1)

    def __post_init__(self) -> None:
        super().__post_init__()
        check_array("StrainPaths: stress", self.stress, (len(self.gradient), 4))
        for stress in self.stress:
            self.material.check_stress_at_rest(stress)


@make_plan.register
def plan_strain_paths(
    paths: StrainPaths, share_count: int = SHARE_COUNT, time_step: float | None = None
) -> Plan:
    """The plan of a run along strain paths; see `make_plan`."""
    material, law = paths.material, paths.material.law()
    count, no_position = len(paths.gradient), np.full(2, np.nan)
    plan = Plan(
        share_count=share_count,
        time_step=1.0 / paths.step_count if time_step is None else time_step,
        longest_time_step=math.inf,
        speed_limit=math.inf,
        particle_bounds=(no_position, no_position),
        remedy="try more steps",
        particle_count=count,
    )
    plan.add_array("particle.velocity_gradient", "vec5", paths.gradient)
    plan.add_array("particle.stress", "vec4", paths.stress)
    if law.remembers:
        state = material.state_at(paths.stress, np.zeros((count, 2)))
        plan.add_array("particle.state", f"vec{len(material.state)}", state)
    if law.yield_function is not None:
        plan.add_array("particle.yield_excess", "real", np.full(count, -1.0))
    plan.add_launch(
        _make_strain_path(law), count, properties=law.properties_type(*material.properties)
    )
    return plan


class StressWatch(ParticleWatch):
    """Ends a run where a stress is not finite."""

    def __init__(self, paths: StrainPaths, run: Run) -> None:
        super().__init__(run)
        self.particle_count = len(paths.gradient)

    def look(self) -> None:
        """Raise `Fault` where a stress is not finite."""
        finite = np.isfinite(self._run.array("particle.stress")).all(axis=1)
        if not finite.all():
            raise Fault(f"the stress of path {int(np.argmin(finite))} is not finite")


make_watch.register(StrainPaths, StressWatch)


@functools.cache
def _make_strain_path(law: Law) -> Any:
    """The kernel, launched over paths; `particle_yield_excess` is the greatest so far."""
    stress_update = make_stress_update(law)

    @kernel
    def strain_path(
        offset: int,
        time_step: real,
        properties: law.properties_type,
        particle_velocity_gradient: wp.array[vec5],
        particle_stress: wp.array[vec4],
        particle_state: maybe(law.state_type),
        particle_yield_excess: maybe(real),
    ):
        p = offset + wp.tid()
        own, remembered = law.of_point(properties, particle_state, p)
        motion = motion_of(particle_velocity_gradient[p], time_step)
        sigma, remembered = stress_update(particle_stress[p], motion, time_step, own, remembered)
        particle_stress[p] = sigma
        if wp.static(law.remembers):
            particle_state[p] = remembered
        if wp.static(law.yield_function is not None):
            measured = law.yield_function(sigma, properties, remembered)
            excess = measured[0] / measured[1] - one
            particle_yield_excess[p] = wp.max(particle_yield_excess[p], excess)

    return strain_path


class StrainPath(NamedTuple):
    """A constant velocity gradient for one second, and the exact stress at its end."""

    name: str
    gradient: tuple[float, ...]  # velocity gradient (rr, rz, zr, zz, tt) [1/s]
    start: tuple[float, ...]  # stress (rr, zz, rz, tt) at the start over the strength
    exact: tuple[float, ...]  # stress at the end over the strength


@functools.cache
def known_paths(clay: UndrainedClay) -> tuple[StrainPath, ...]:
    """Proportional strain, reversed strain, rotation and simple shear."""
    yield_strain = clay.strength / clay.shear_modulus
    small, large = ELASTIC_STRAIN * yield_strain, PLASTIC_STRAIN * yield_strain
    proportional = {
        "uniaxial strain, elastic": (0, 0, 0, small, 0),
        "uniaxial strain, yielding at a corner": (0, 0, 0, -large, 0),
        "shear, elastic": (0, small, small, 0, 0),
        "pure shear, on an edge": (large, 0, 0, -large, 0),
        "hoop stress greatest": (-large, 0, 0, 0, large),
        "hoop stress least": (0, 0, 0, large, -large),
        "axial extension, at a corner": (-large, 0, 0, 2 * large, -large),
        "hoop compression, at a corner": (large, 0, 0, large, -2 * large),
    }
    back = (large, 0, 0, -large, 0)
    half, full = 0.25 * math.pi, 2 * math.pi
    rest, held = (0.0, 0.0, 0.0, 0.0), (0.9, 0.1, 0.3, 0.4)
    # After a rotation by 45 degrees from r towards z, rr' = mean - rz, zz' = mean + rz.
    at_half = (0.5 - 0.3, 0.5 + 0.3, 0.5 * (0.9 - 0.1), 0.4)
    strain = SIMPLE_SHEAR_STRAIN
    along, across = (stress / clay.strength for stress in simple_shear(clay, strain, strain))
    parts = (
        *((name, value, rest, _proportional(clay, value)) for name, value in proportional.items()),
        # The strain that takes the stress back to 0 is elastic and leaves the clay intact.
        ("pure shear, turned back", back, (-1, 1, 0, 0), _proportional(clay, back, yield_strain)),
        ("turn by 45 degrees", (0, -half, half, 0, 0), held, at_half),
        ("turn by 360 degrees", (0, -full, full, 0, 0), held, held),
        ("simple shear to strain 10", (0, strain, 0, 0, 0), rest, (along, -along, across, 0)),
    )
    return tuple(itertools.starmap(StrainPath, parts))


def _proportional(
    clay: UndrainedClay, gradient: tuple[float, ...], unloading: float = 0.0
) -> tuple[float, ...]:
    """Stress over strength after one second of strain without spin.

    The deviators of stress and strain are parallel: at a corner of Tresca's hexagon, in the middle
    of its side, or anywhere on the cylinder of von Mises. `unloading` is the shear strain that
    takes the initial stress back to 0.
    """
    rr, rz, zr, zz, tt = gradient
    volume = rr + zz + tt
    strain = np.array([rr, zz, 0.5 * (rz + zr), tt])
    deviator = strain - volume / 3.0 * np.array([1.0, 1.0, 0.0, 1.0])
    measure = _measure(clay, deviator)
    shear_strain = np.array([2.0 * measure])
    (shear,) = shear_stress(clay, shear_strain - unloading, shear_strain)
    mean = clay.bulk_modulus * volume * np.array([1.0, 1.0, 0.0, 1.0])
    return tuple(((mean + shear * deviator / measure) / clay.strength).tolist())


def _measure(clay: UndrainedClay, deviator: Floats) -> float:
    """The measure of the yield criterion for a deviator (rr, zz, rz, tt)."""
    criterion = clay.criterion if isinstance(clay, EinavRandolph) else type(clay)
    if criterion is Tresca:
        return 0.5 * float(np.ptp(principal_stresses(deviator)))
    rr, zz, rz, tt = deviator
    return math.sqrt(0.5 * (rr * rr + zz * zz + tt * tt) + rz * rz)


def _strength_and_slope(
    clay: UndrainedClay, plastic_strain: Floats, rate: Floats
) -> tuple[Floats, Floats]:
    """Shear strength k and its slope dk/dxi [Pa], at plastic shear strains and rates [1/s]."""
    shape = np.zeros(np.broadcast(plastic_strain, rate).shape)
    if not isinstance(clay, EinavRandolph):
        return clay.strength + shape, shape
    cycles = np.log10(np.maximum(rate / clay.reference_strain_rate, 1.0))
    intact = clay.strength * (1.0 + clay.rate_factor * cycles)
    fall, remoulded = 3.0 / clay.ductility, clay.remoulded_strength_ratio * intact
    lost = (intact - remoulded) * np.exp(-fall * plastic_strain)
    return remoulded + lost + shape, -fall * lost + shape


def shear_stress(clay: UndrainedClay, strain: Floats, rate: Floats) -> Floats:
    """Shear stress [Pa] at shear strains gamma of one direction, with the rates there [1/s]."""
    stiffness = clay.shear_modulus
    intact, _ = _strength_and_slope(clay, 0.0 * strain, rate)
    plastic = np.maximum(strain - intact / stiffness, 0.0)
    for _ in range(NEWTON_STEPS):
        k, slope = _strength_and_slope(clay, plastic, rate)
        missing = stiffness * (strain - plastic) - k
        plastic = np.maximum(plastic + missing / (stiffness + slope), 0.0)
    return np.minimum(stiffness * strain, _strength_and_slope(clay, plastic, rate)[0])


def simple_shear(clay: UndrainedClay, strain: float, rate: float) -> tuple[float, float]:
    """Half difference of the normal stresses, and shear stress, at the end of simple shear [Pa].

    By the Jaumann rate the radius tau of the circle of stress and its rotation phi follow

        dtau/dgamma = G cos(phi) - G dxi/dgamma,   dphi/dgamma = 1 - G sin(phi) / tau

    So tau = 2 G sin(gamma / 2) and phi = gamma / 2 up to yield, and tau = k(xi) from then on. With
    perfect plasticity phi ends at asin(k / G). The strain must be far beyond yield; rate in 1/s.
    """
    stiffness = clay.shear_modulus
    if not isinstance(clay, EinavRandolph):
        phi = math.asin(clay.strength / stiffness)
        return clay.strength * math.sin(phi), clay.strength * math.cos(phi)

    def law(plastic: float) -> tuple[float, float]:
        k, slope = _strength_and_slope(clay, np.array(plastic), np.array(rate))
        return float(k), float(slope)

    def change(_gamma: float, state: Floats) -> list[float]:
        (k, slope), phi = law(state[0]), state[1]
        return [
            stiffness * math.cos(phi) / (stiffness + slope),
            1.0 - stiffness * math.sin(phi) / k,
        ]

    yielding = 2.0 * math.asin(min(1.0, 0.5 * law(0.0)[0] / stiffness))
    path = scipy.integrate.solve_ivp(
        change,
        (yielding, strain),
        [0.0, 0.5 * yielding],
        method="Radau",
        rtol=RELATIVE_ERROR,
        atol=ABSOLUTE_ERROR,
    )
    plastic, phi = path.y[:, -1]
    tau = law(plastic)[0]
    return tau * math.sin(phi), tau * math.cos(phi)
