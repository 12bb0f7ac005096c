"""The step that runs are measured beside is one of the method: exact where it has to be."""

from __future__ import annotations

import numpy as np

from mpm_warp.benchmark.bare_step import MATERIAL, BareStep
from mpm_warp.grid.fitted import Floats

COUNT = 400
ROUNDING = 1e-12


def yield_excess(stress: Floats) -> Floats:
    """How far stresses (rr, zz, rz, tt) are outside the cylinder of von Mises, over strength."""
    normal = stress[:, [0, 1, 3]]
    deviator = normal - normal.mean(axis=1, keepdims=True)
    j2 = 0.5 * np.sum(deviator**2, axis=1) + stress[:, 2] ** 2
    return np.asarray(np.sqrt(j2) / MATERIAL.strength - 1.0)


def state(soil: BareStep, name: str) -> Floats:
    values: Floats = soil.arrays[name].numpy()
    return values


def test_linear_flow_stays_and_strains_the_soil_by_its_gradient() -> None:
    soil, time_step = BareStep(COUNT), 1e-3
    gradient = np.array([[0.3, -0.5], [0.2, 0.4]])
    before = state(soil, "position").copy()
    state(soil, "velocity")[:] = before @ gradient.T
    state(soil, "affine")[:] = gradient
    state(soil, "stress")[:] = 0.0
    soil.take_step(time_step)
    velocity = before @ gradient.T
    np.testing.assert_allclose(state(soil, "velocity"), velocity, atol=ROUNDING * 10)
    np.testing.assert_allclose(state(soil, "affine") - gradient, 0.0, atol=ROUNDING * 10)
    moved = state(soil, "position") - before
    np.testing.assert_allclose(moved, time_step * velocity, atol=ROUNDING)
    strain = time_step * np.stack(
        [
            np.full(soil.particle_count, gradient[0, 0]),
            np.full(soil.particle_count, gradient[1, 1]),
            np.full(soil.particle_count, 0.5 * (gradient[0, 1] + gradient[1, 0])),
            velocity[:, 0] / before[:, 0],
        ],
        axis=-1,
    )
    volume = strain[:, [0, 1, 3]].sum(axis=1, keepdims=True)
    pressed = (MATERIAL.bulk_modulus - 2.0 / 3.0 * MATERIAL.shear_modulus) * volume
    trial = pressed * [1.0, 1.0, 0.0, 1.0] + 2.0 * MATERIAL.shear_modulus * strain
    elastic = yield_excess(trial) < 0.0
    assert elastic.any()
    np.testing.assert_allclose(state(soil, "stress")[elastic], trial[elastic], atol=ROUNDING)


def test_stress_gives_the_momentum_that_it_has_to_and_does_not_exceed_the_strength() -> None:
    """None along the axis; away from it what the hoop stress gives."""
    soil, time_step = BareStep(COUNT), 1e-6
    hoop = state(soil, "stress")[:, 3] / state(soil, "position")[:, 0]
    outward = -time_step * float(state(soil, "volume") @ hoop)
    soil.take_step(time_step)
    momentum = state(soil, "mass")[:, None] * state(soil, "velocity")
    given, along = momentum.sum(axis=0)
    rounding = ROUNDING * np.abs(momentum).sum()
    assert abs(given - outward) < rounding
    assert abs(along) < rounding
    assert yield_excess(state(soil, "stress")).max() < ROUNDING


def test_its_rate_counts_the_steps_that_it_takes() -> None:
    soil = BareStep(COUNT)
    assert soil.particle_count == COUNT
    assert soil.rate(1e-3) > 0.0
    assert np.abs(state(soil, "velocity")).max() > 0.0
