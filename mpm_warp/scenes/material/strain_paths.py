"""Material points on given strain paths, without a grid: a material by itself.

Rotation and law are those of any other run. Symbols: sigma stress, e strain
and R rotation in a step, (f, k) measure of the stress and strength of the yield function.

    sigma  <- law(R sigma R', e, dt)
    excess <- max(excess, f / k - 1)
"""

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp

from mpm_warp.arguments import FROM_ONE, check_array, check_kind, check_whole
from mpm_warp.errors import Fault
from mpm_warp.grid.fitted import Floats
from mpm_warp.kernel_types import kernel, maybe, one, real, vec4, vec5
from mpm_warp.materials.elasticity import make_stress_update, motion_of
from mpm_warp.materials.material import Law, Material
from mpm_warp.plan.plan import Plan, Run
from mpm_warp.planning import SHARE_COUNT, make_plan
from mpm_warp.watch import ParticleWatch, make_watch

NOWHERE = np.full(2, np.nan)
"""Of material points that have no position."""


@dataclass(frozen=True, kw_only=True, eq=False)
class StrainPaths:
    """Material points, each strained and turned at a constant velocity gradient for one second."""

    material: Material  # of all points, with or without memory
    gradient: Floats  # velocity gradients (rr, rz, zr, zz, tt) [1/s], shape [path_count, 5]
    stress: Floats  # stresses (rr, zz, rz, tt) at the start [Pa], shape [path_count, 4]
    step_count: int  # steps into which the second is divided, >= 1

    def __post_init__(self) -> None:
        check_kind("strain paths: material", self.material, Material)
        count = len(np.atleast_1d(self.gradient))
        check_array("strain paths: gradient", self.gradient, (count, 5))
        check_array("strain paths: stress", self.stress, (count, 4))
        for stress in self.stress:
            self.material.check_stress_at_rest(stress)
        check_whole("strain paths: step_count", self.step_count, FROM_ONE)


@make_plan.register
def plan_strain_paths(
    paths: StrainPaths, share_count: int = SHARE_COUNT, time_step: float | None = None
) -> Plan:
    """The plan of a run along strain paths, see `make_plan`; a step is a part of the second."""
    material, law = paths.material, paths.material.law()
    count = len(paths.gradient)
    plan = Plan(
        share_count=share_count,
        time_step=1.0 / paths.step_count if time_step is None else time_step,
        longest_time_step=math.inf,
        speed_limit=math.inf,
        particle_bounds=(NOWHERE, NOWHERE),
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
        _make_strain_path(law),
        count,
        properties=law.properties_type(*material.properties),
    )
    return plan


class StressWatch(ParticleWatch):
    """Looks whether stresses are finite."""

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
    """The kernel, launched over paths.

    `particle_yield_excess` is how far the stress has been beyond the yield surface at most, over
    the strength.
    """
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
