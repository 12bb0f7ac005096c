"""Element tests of one material point.

An element test shears soil of uniform stress and strain, undrained, in a given mode. Symbols,
compression positive: s1 and s3 greatest and least total principal stress, gamma difference of the
extreme principal strains, e deviator of the strain since the start, t = (s1 - s3) / 2.

    G = (change of stress : e) / (2 e : e)            secant shear modulus from the start
    strength = t at the end,   t = G gamma in elastic soil from an isotropic start

Strains are taken as small, so directions do not turn. The volume is constant. The pore pressure is
that at constant mean total stress, so it is the part due to shear.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np
import xarray as xr

from mpm_warp.fields.declaration import group, parameter, redefined
from mpm_warp.grid.fitted import Floats
from mpm_warp.materials.material import (
    EFFECTIVE_STRESS,
    PORE_PRESSURE,
    Material,
    principal_stresses,
)
from mpm_warp.results import Drawn, Quantity, curves, labelled
from mpm_warp.sampling import Samples, follow
from mpm_warp.scenes.catalogue_scene import Progress
from mpm_warp.scenes.clay import STRAIN_RATE
from mpm_warp.scenes.clay_scene import StressAtRest
from mpm_warp.scenes.limits import limited
from mpm_warp.scenes.material.material_point import PointScene
from mpm_warp.scenes.material.strain_paths import StrainPaths
from mpm_warp.scenes.run_size import RunSize
from mpm_warp.scenes.verification import compared
from mpm_warp.simulation import Simulation

TESTS: Mapping[str, tuple[float, ...]] = {
    "triaxial_compression": (1 / 3, 0.0, 0.0, -2 / 3, 1 / 3),
    "triaxial_extension": (-1 / 3, 0.0, 0.0, 2 / 3, -1 / 3),
    "simple_shear": (0.0, 0.5, 0.5, 0.0, 0.0),
    "plane_strain": (0.5, 0.0, 0.0, -0.5, 0.0),
    "pressuremeter": (-0.5, 0.0, 0.0, 0.0, 0.5),
}
"""Velocity gradient (rr, rz, zr, zz, tt) of each mode at a rate of 1 of gamma; z is vertical."""
SAMPLE_COUNT = 200
"""Samples of a test, at geometrically spaced steps; fewer in a test of few steps."""
OVER_STRAIN = partial(Drawn, picture="element_tests", to_rest=True)
STRESS_PATH = Drawn(
    picture="element_tests",
    panel=2,
    over=EFFECTIVE_STRESS,
    slope="material.critical_state_ratio",
)
"""The panels of the picture of element tests; the dashed line is the critical state."""


@dataclass(frozen=True, kw_only=True, init=False)
class ElementTest(PointScene):
    """A strain-controlled laboratory test of one material point of any law.

    Example:
        >>> test = ElementTest(test="triaxial_extension", material="von_mises")
        >>> round(test.soil.undrained_strength(test.test))  # [Pa]
        17321
    """

    summary = "undrained element test: strength and stiffness of a law, by mode"
    method = ("step_count",)
    verifications = compared(
        "step_count",
        (1000, 10_000),
        *({"material": "von_mises", "test": test} for test in TESTS),
        *({"material": "modified_cam_clay", "test": test} for test in TESTS),
        error=1e-6,
    )
    limits = limited(error="more step_count")

    test: str = parameter(
        "triaxial_compression",
        "mode: vertical compression or extension, shear of horizontal planes, vertical compression "
        "in plane strain, or horizontal shear around a pressuremeter",
        choices=tuple(TESTS),
    )
    stress: StressAtRest = group()
    greatest_shear_strain: float = parameter(
        1.0, "difference of the extreme principal strains at the end", minimum=1e-6, maximum=100
    )
    strain_rate: float = parameter(
        3e-6, "shear strain rate of the real test; usual: 1 % per hour", **STRAIN_RATE
    )
    step_count: int = redefined(
        PointScene, "step_count", meaning="equal strain steps of the test", minimum=2
    )

    @property
    def stress_at_rest(self) -> Floats:
        """See `ClayScene`."""
        return self.stress.at_rest(self.clay.undrained_shear_strength)

    @property
    def soil(self) -> Material:
        """The clay, with strain rates as in the real test; a run takes one second."""
        return self.clay.built(
            density=1.0,
            speed_up=self.greatest_shear_strain / self.strain_rate,
            stress_at_rest=self.stress_at_rest,
        )

    def run_size(self) -> RunSize:
        """See `CatalogueScene`."""
        return RunSize(cell_count=0, particle_count=1, step_count=self.step_count)

    def build(self) -> StrainPaths:
        """The point and its path."""
        return StrainPaths(
            material=self.soil,
            gradient=self.greatest_shear_strain * np.array([TESTS[self.test]]),
            stress=self.stress_at_rest[None],
            step_count=self.step_count,
        )

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Shear the point, and take strength and stiffness from its curves."""
        names = self.soil.state

        def take() -> list[float]:
            stress = simulation.array("particle.stress")[0]
            state = simulation.array("particle.state")[0] if names else ()
            return [simulation.step_count / self.step_count, *stress, *state]

        def labelled_curves(share: Floats, *rows: Floats) -> xr.Dataset:
            stress, state = np.stack(rows[:4], axis=-1), dict(zip(names, rows[4:], strict=True))
            return self._curves(self.greatest_shear_strain * share, stress, state)

        marks = np.geomspace(1, self.step_count, SAMPLE_COUNT).round().astype(int)
        steps = np.unique(marks).tolist()
        samples = Samples(take, labelled_curves)
        recorded = follow(simulation, steps, simulation.advance_to_step, [samples], progress)
        return recorded.assign(self._strength_and_stiffness(recorded))

    def _curves(self, strain: Floats, stress: Floats, state: Mapping[str, Floats]) -> xr.Dataset:
        """Curves over the shear strain, from stresses [n, 4] and the state of the law."""
        principal = principal_stresses(stress)
        mean = principal.mean(axis=1, keepdims=True)
        shear = 0.5 * np.ptp(principal, axis=1)
        deviator = np.sqrt(1.5 * ((principal - mean) ** 2).sum(axis=1))
        change = stress - self.stress_at_rest
        # Strain at gamma = 1; the double contraction counts the shear stress twice.
        of_rr, of_rz, of_zr, of_zz, of_tt = TESTS[self.test]
        direction = np.array([of_rr, of_zz, 0.5 * (of_rz + of_zr), of_tt])
        twice = np.array([1.0, 1.0, 2.0, 1.0])
        along = (change * direction * twice).sum(axis=1)
        along /= 2.0 * float(direction @ (direction * twice))
        shown: dict[str, Quantity] = {
            "shear_stress": (shear, "Pa", "shear stress, half of s1 - s3", OVER_STRAIN()),
            "mobilised_stress": (along, "Pa", "change of the shear stress along the strain"),
            "deviator_stress": (deviator, "Pa", "deviator stress q"),
        }
        if EFFECTIVE_STRESS in state:
            shown[EFFECTIVE_STRESS] = (state[EFFECTIVE_STRESS], "Pa", "effective mean stress p'")
            shown["deviator_stress"] = (deviator, "Pa", "deviator stress q", STRESS_PATH)
        if PORE_PRESSURE in state:
            of_shear = state[PORE_PRESSURE] + change[:, [0, 1, 3]].mean(axis=1)
            what = "excess pore pressure due to shear"
            shown[PORE_PRESSURE] = (of_shear, "Pa", what, OVER_STRAIN(panel=3))
        return curves("shear_strain", (strain, "1", "shear strain, e1 - e3"), **shown)

    def _strength_and_stiffness(self, recorded: xr.Dataset) -> dict[str, xr.Variable]:
        """Strength and stiffness, and the exact strength where it is known."""
        strain = np.append(0.0, recorded.shear_strain.values)
        mobilised = np.append(0.0, recorded.mobilised_stress.values)
        stress = recorded.shear_stress.values
        strength, peak = stress[-1], stress[int(np.argmax(mobilised[1:]))]
        at_first, halfway = mobilised[1] / strain[1], np.nan
        half = 0.5 * mobilised[-1]
        if half > 0.0:
            beyond = int(np.argmax(mobilised >= half))
            before = beyond - 1
            share = (half - mobilised[before]) / (mobilised[beyond] - mobilised[before])
            halfway = half / (strain[before] + share * (strain[beyond] - strain[before]))
        is_half = "shear modulus at 50 % of the strength"
        is_half_of = "shear strength, half of s1 - s3"
        of_end = (strength, "Pa", f"{is_half_of} at the end")
        found = labelled(role="headline", strength=of_end) | labelled(
            peak_strength=(peak, "Pa", f"{is_half_of} at the peak"),
            small_strain_shear_modulus=(at_first, "Pa", "shear modulus at small strain"),
            half_strength_shear_modulus=(halfway, "Pa", is_half, "secant from the start"),
            small_strain_rigidity_index=(at_first / strength, "1", "G at small strain over su"),
            half_strength_rigidity_index=(halfway / strength, "1", "G at 50 % over su"),
        )
        exact = self.soil.undrained_strength(self.test)
        if exact is not None:
            error = (abs(strength / exact - 1.0), "1", "error of the strength")
            found |= labelled(strength_exact=(exact, "Pa", "shear strength, exact"))
            found |= labelled(role="error", error=error)
        return found
