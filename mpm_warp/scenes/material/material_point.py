"""One material point on strain paths whose stress has a closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.materials.tresca import Tresca
from mpm_warp.parameters import parameter
from mpm_warp.plan.plan import Plan
from mpm_warp.results import labelled
from mpm_warp.sampling import even_steps, follow
from mpm_warp.scenes.catalogue import CatalogueScene, Progress, Verification
from mpm_warp.scenes.material.strain_paths import StrainPaths
from mpm_warp.scenes.run_size import RunSize
from mpm_warp.simulation import Simulation

RANDOM_PATHS = 200
"""Paths in random directions, on which the stress must stay within the yield surface."""
SHEAR_STRAIN = 10.0


@dataclass(frozen=True, kw_only=True)
class StrainPath:
    """A constant velocity gradient over a unit of time, and what the stress is at its end.

    Attributes:
        name: what the point goes through.
        gradient: velocity gradient (rr, rz, zr, zz, tt) [1/s].
        start: stress (rr, zz, rz, tt) at the start, over the strength.
        exact: stress at the end, over the strength.
    """

    name: str
    gradient: tuple[float, ...]
    start: tuple[float, ...]
    exact: tuple[float, ...]


@dataclass(frozen=True, kw_only=True)
class MaterialPoint(CatalogueScene):
    """Tresca soil strained and turned through the stress update of the simulator, without a grid.

    Simple shear far beyond yield has the steady state of the Jaumann rate with perfect plasticity:
    half difference of the stresses and shear stress stand at the angle asin(su / G), at which the
    spin turns it as fast as the strain turns it back.
    """

    summary: ClassVar[str] = "one material point on strain paths, against closed forms"
    version: ClassVar[int] = 1
    verifications: ClassVar[tuple[Verification, ...]] = (
        Verification(
            resolution="step_count",
            resolutions=(1000, 10_000),
            bounds={"error": 1e-6, "yield_excess": 1e-9},
            least_order=1.9,
        ),
    )

    rigidity_index: float = parameter(
        100.0, unit="1", meaning="rigidity index G/su", minimum=2, maximum=5000
    )
    poissons_ratio: float = parameter(
        0.49, unit="1", meaning="Poisson's ratio", minimum=0, maximum=0.4999
    )
    undrained_shear_strength: float = parameter(
        20e3, unit="Pa", meaning="undrained shear strength su", minimum=1e-3, maximum=1e9
    )
    step_count: int = parameter(
        10_000, unit="1", meaning="strain steps of each path", minimum=1, maximum=1_000_000
    )

    def paths(self) -> tuple[StrainPath, ...]:
        """The paths that have a closed form."""
        bulk = 2 * (1 + self.poissons_ratio) / (3 * (1 - 2 * self.poissons_ratio))
        rest = (0.0, 0.0, 0.0, 0.0)
        # Elastic paths end at half the strain of yielding; G times strain is in units of su here.
        small, large = 0.5 / self.rigidity_index, 5.0 / self.rigidity_index
        pressure = bulk * self.rigidity_index * large
        lateral = bulk - 2 / 3
        turned = math.asin(1 / self.rigidity_index)
        shear = (math.sin(turned), -math.sin(turned), math.cos(turned), 0.0)
        half, full = 0.25 * math.pi, 2 * math.pi
        stress = (0.9, 0.1, 0.3, 0.4)
        # After a turn by 45 degrees from r towards z, rr' = mean - rz, zz' = mean + rz.
        at_half = (0.5 - 0.3, 0.5 + 0.3, 0.5 * (0.9 - 0.1), 0.4)
        compression, edge = 4 / 3, 1.0
        return tuple(
            StrainPath(name=name, gradient=gradient, start=start, exact=exact)
            for name, gradient, start, exact in (
                (
                    "uniaxial strain, elastic",
                    (0, 0, 0, small, 0),
                    rest,
                    (lateral / 2, (lateral + 2) / 2, 0, lateral / 2),
                ),
                (
                    "uniaxial strain, yielding at a corner",
                    (0, 0, 0, -large, 0),
                    rest,
                    (-pressure + 2 / 3, -pressure - compression, 0, -pressure + 2 / 3),
                ),
                ("shear, elastic", (0, small, small, 0, 0), rest, (0, 0, 2 * 0.5, 0)),
                ("pure shear, on an edge", (large, 0, 0, -large, 0), rest, (edge, -edge, 0, 0)),
                ("hoop stress greatest", (-large, 0, 0, 0, large), rest, (-edge, 0, 0, edge)),
                ("hoop stress least", (0, 0, 0, large, -large), rest, (0, edge, 0, -edge)),
                (
                    "axial extension, at a corner",
                    (-large, 0, 0, 2 * large, -large),
                    rest,
                    (-2 / 3, compression, 0, -2 / 3),
                ),
                (
                    "hoop compression, at a corner",
                    (large, 0, 0, large, -2 * large),
                    rest,
                    (2 / 3, 2 / 3, 0, -compression),
                ),
                ("turn by 45 degrees", (0, -half, half, 0, 0), stress, at_half),
                ("turn by 360 degrees", (0, -full, full, 0, 0), stress, stress),
                ("simple shear to strain 10", (0, SHEAR_STRAIN, 0, 0, 0), rest, shear),
            )
        )

    def run_size(self) -> RunSize:
        """A point on each path."""
        return RunSize(
            cell_count=0,
            particle_count=len(self.paths()) + RANDOM_PATHS,
            step_count=self.step_count,
        )

    def build(self) -> StrainPaths:
        """The paths that have a closed form, then random ones that start without stress."""
        paths, strength = self.paths(), self.undrained_shear_strength
        random = np.random.default_rng(0).uniform(-1.0, 1.0, (RANDOM_PATHS, 5))
        gradient = np.concatenate([[path.gradient for path in paths], random])
        start = np.zeros((len(gradient), 4))
        start[: len(paths)] = [path.start for path in paths]
        return StrainPaths(
            material=Tresca(
                shear_modulus=self.rigidity_index * strength,
                poissons_ratio=self.poissons_ratio,
                density=1.0,
                strength=strength,
            ),
            gradient=gradient,
            stress=start * strength,
            step_count=self.step_count,
        )

    def step_count_bound(self, plan: Plan) -> int:
        """The strain steps of a path."""
        return self.step_count

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Follow the paths to their ends, and hold the stress there against the closed forms."""
        steps = even_steps(self.step_count)
        recorded = follow(simulation, steps, simulation.advance_to_step, [], progress)
        return recorded.merge(self._at_the_end(simulation))

    def _at_the_end(self, simulation: Simulation) -> xr.Dataset:
        """Stresses at the ends of the paths, and how far any was beyond the yield surface."""
        paths = self.paths()
        stress = simulation.array("particle.stress")[: len(paths)] / self.undrained_shear_strength
        exact = np.array([path.exact for path in paths])
        error = (
            np.abs(stress - exact).max(),
            "1",
            "error of stress",
            "greatest difference of a component from the closed form, over su",
        )
        excess = (
            simulation.array("particle.yield_excess").max(),
            "1",
            "stress beyond the yield surface",
            "greatest (sigma_1 - sigma_3) / (2 su) - 1 on any path at any step",
        )
        variables = {
            **labelled(
                dims=("path", "component"),
                stress=(stress, "1", "stress over strength"),
                stress_exact=(exact, "1", "stress over strength, closed form"),
            ),
            **labelled(role="headline", error=error),
            **labelled(yield_excess=excess),
        }
        axes = {"path": [path.name for path in paths], "component": ["rr", "zz", "rz", "tt"]}
        return xr.Dataset(variables, coords=axes)
