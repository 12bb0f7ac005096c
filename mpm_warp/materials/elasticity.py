"""The stress of a step: elastic at large rotations, then what the law of the material makes of it.

Symbols: sigma stress (rr, zz, rz, tt), L velocity gradient, D its symmetric part, R rotation by the
spin in a step, K bulk modulus, G shear modulus.

    sigma <- law(R sigma R' + dt (K tr D + 2 G dev D))

Where the material varies from place to place, G and K are those of the material times the stiffness
ratio of the point.
"""

import functools
from typing import Any

import warp as wp

from mpm_warp.materials.material import Law
from mpm_warp.precision import Precision


@functools.cache
def make_stress_increment(precision: Precision) -> Any:
    """The function (L, time step, G, K) -> what a step at the velocity gradient L does to stress.

    L is (rr, rz, zr, zz, tt); the result holds the elastic increment (rr, zz, rz, tt) and the
    squares and the product of cosine and sine of the rotation, in this order.
    """
    real, vec5, vec7 = precision.real, precision.vec5, precision.vec7
    quarter, one, two, three = (wp.constant(real(x)) for x in (0.25, 1.0, 2.0, 3.0))

    @wp.func
    def stress_increment(L: vec5, time_step: real, shear_modulus: real, bulk_modulus: real) -> vec7:
        two_shear = two * shear_modulus * time_step
        pressure = (bulk_modulus * time_step - two_shear / three) * (L[0] + L[3] + L[4])
        # Rotation by the angle of the spin, orthogonal whatever the size of the step (Cayley).
        t = quarter * time_step * (L[1] - L[2])
        scale = one / (one + t * t)
        cosine = (one - t * t) * scale
        sine = two * t * scale
        return vec7(
            two_shear * L[0] + pressure,
            two_shear * L[3] + pressure,
            shear_modulus * time_step * (L[1] + L[2]),
            two_shear * L[4] + pressure,
            cosine * cosine,
            sine * sine,
            cosine * sine,
        )

    return stress_increment


@functools.cache
def make_elastic_trial(precision: Precision) -> Any:
    """The function (stress, stress increment) -> R sigma R' + dt (K tr D + 2 G dev D)."""
    vec4, vec7 = precision.vec4, precision.vec7
    two = wp.constant(precision.real(2.0))

    @wp.func
    def elastic_trial(stress: vec4, increment: vec7) -> vec4:
        rr, zz, rz = stress[0], stress[1], stress[2]
        cc, ss, cs = increment[4], increment[5], increment[6]
        return vec4(
            cc * rr + ss * zz + two * cs * rz + increment[0],
            ss * rr + cc * zz - two * cs * rz + increment[1],
            (cc - ss) * rz + cs * (zz - rr) + increment[2],
            stress[3] + increment[3],
        )

    return elastic_trial


@functools.cache
def _make_strain_increment(precision: Precision) -> Any:
    """The function (stress increment, G, K) -> dt D that has made it, (rr, zz, rz, tt)."""
    real, vec4, vec7 = precision.real, precision.vec4, precision.vec7
    third, half = wp.constant(real(1.0 / 3.0)), wp.constant(real(0.5))

    @wp.func
    def strain_increment(increment: vec7, shear_modulus: real, bulk_modulus: real) -> vec4:
        mean = third * (increment[0] + increment[1] + increment[3])
        volume = mean * (third / bulk_modulus)
        in_shear = half / shear_modulus  # divisions take longest
        return vec4(
            (increment[0] - mean) * in_shear + volume,
            (increment[1] - mean) * in_shear + volume,
            increment[2] * in_shear,
            (increment[3] - mean) * in_shear + volume,
        )

    return strain_increment


@functools.cache
def make_increment_of_point(law: Law, precision: Precision) -> Any:
    """The function (stress increment of the cell, properties of a point) -> that of the point."""
    vec7, properties_type, varies = precision.vec7, law.properties_type, law.varies

    @wp.func
    def increment_of_point(increment: vec7, properties: properties_type) -> vec7:
        own = increment
        if wp.static(varies):
            for k in range(4):  # what follows is rotation
                own[k] = properties[0] * increment[k]
        return own

    return increment_of_point


@functools.cache
def make_stress_update(law: Law, precision: Precision) -> Any:
    """The function (stress, stress increment, G, K, time step, properties, state) after a step.

    It gives stress and state; properties and state are those of the law. The increment is that of
    the cell, G and K are the moduli that it is for.
    """
    real, vec4, vec7 = precision.real, precision.vec4, precision.vec7
    properties_type, state_type = law.properties_type, law.state_type
    elastic_trial, strain_increment = (
        make_elastic_trial(precision),
        _make_strain_increment(precision),
    )
    increment_of_point, update = make_increment_of_point(law, precision), law.update

    @wp.func
    def stress_update(
        stress: vec4,
        increment: vec7,
        shear_modulus: real,
        bulk_modulus: real,
        time_step: real,
        properties: properties_type,
        state: state_type,
    ):
        trial = elastic_trial(stress, increment_of_point(increment, properties))
        strain = strain_increment(increment, shear_modulus, bulk_modulus)
        sigma, remembered = update(trial, strain, time_step, properties, state)
        return sigma, remembered

    return stress_update


@functools.cache
def make_plastic_step(law: Law, precision: Precision) -> Any:
    """The function of the arguments of `make_stress_update` -> what plastic strain follows from.

    It gives stress, trial stress less stress, and the stiffness ratio of the point.
    """
    real, vec4, vec7 = precision.real, precision.vec4, precision.vec7
    properties_type, state_type, varies = law.properties_type, law.state_type, law.varies
    elastic_trial, increment_of_point, stress_update = (
        make_elastic_trial(precision),
        make_increment_of_point(law, precision),
        make_stress_update(law, precision),
    )

    @wp.func
    def plastic_step(
        stress: vec4,
        increment: vec7,
        shear_modulus: real,
        bulk_modulus: real,
        time_step: real,
        properties: properties_type,
        state: state_type,
    ):
        trial = elastic_trial(stress, increment_of_point(increment, properties))
        sigma, _ = stress_update(
            stress, increment, shear_modulus, bulk_modulus, time_step, properties, state
        )
        ratio = real(1.0)
        if wp.static(varies):
            ratio = properties[0]
        return sigma, trial - sigma, ratio

    return plastic_step
