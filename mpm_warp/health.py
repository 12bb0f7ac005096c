"""The watch on a run: one that diverges ends with a named error, not with wrong numbers."""

from __future__ import annotations

import numpy as np

from mpm_warp.grids import Floats


class SimulationDiverged(RuntimeError):
    """The run became unstable; the message is one line and names what, where and when.

    Attributes:
        status: how a harness files the case.
    """

    status = "diverged"


class WindowOverfull(RuntimeError):
    """More soil stays in the travelling window than it has places for; the message is one line."""


class ParticleOutside(RuntimeError):
    """A particle has left the grid; the message is one line."""


def check_inside(
    *, position: Floats, bounds: tuple[Floats, Floats], step: int, time: float
) -> None:
    """Check that particles are where the grid has all the nodes that they need.

    Args:
        position: coordinates [m], shape [particle_count, 2].
        bounds: lowest and highest coordinates allowed [m], each of shape [2].
        step: number of steps taken.
        time: simulated time [s].

    Raises:
        ParticleOutside: one is not.
    """
    outside = ~np.all((position >= bounds[0]) & (position <= bounds[1]), axis=1)
    if outside.any():
        particle = int(np.argmax(outside))
        raise ParticleOutside(
            f"particle {particle} has left the grid: {np.array2string(position[particle])} m is "
            f"not within {bounds[0]} to {bounds[1]} m at step {step}, t = {time:.4g} s; "
            "make the grid wider or the run shorter"
        )


def check_particles(
    *,
    position: Floats,
    velocity: Floats,
    stress: Floats,
    speed_limit: float,
    step: int,
    healthy_step: int,
    time: float,
) -> None:
    """Check that particles are finite and slower than the waves that they carry.

    Args:
        position: (r, z) [m], shape [particle_count, 2].
        velocity: (r, z) [m/s], shape [particle_count, 2].
        stress: (rr, zz, rz, tt) [Pa], shape [particle_count, 4].
        speed_limit: pressure wave speed [m/s].
        step: number of steps taken.
        healthy_step: step of the last check that passed.
        time: simulated time [s].

    Raises:
        SimulationDiverged: a particle is not finite or too fast.
    """
    speed = np.abs(velocity).max(axis=1)
    sound = {
        "stress": np.isfinite(stress).all(axis=1),
        "position": np.isfinite(position).all(axis=1),
        # NaN is not below the limit either.
        "velocity": speed < speed_limit,
    }
    for quantity, healthy in sound.items():
        if healthy.all():
            continue
        worst = int(np.argmin(healthy))
        values = {"stress": stress, "position": position, "velocity": velocity}[quantity][worst]
        place = f"(r, z) = ({position[worst, 0]:.4g}, {position[worst, 1]:.4g}) m"
        raise SimulationDiverged(
            f"{quantity} of particle {worst} at {place} is {np.array2string(values, precision=4)} "
            f"at step {step}, t = {time:.4g} s; healthy at step {healthy_step}; "
            "try a smaller time_step_fraction"
        )
