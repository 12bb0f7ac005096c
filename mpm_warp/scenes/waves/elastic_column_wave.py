"""Pressure waves along a confined elastic column."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

from mpm_warp.parameters import parameter
from mpm_warp.scenes.base import Progress, ReadyScene, Verification

if TYPE_CHECKING:
    import numpy as np
    import xarray

    from mpm_warp.column import Column
    from mpm_warp.execution.execution import Execution
    from mpm_warp.scene import Scene
    from mpm_warp.simulation import Simulation

    Curves = dict[str, tuple[np.ndarray, str, str]]
    """By name: values, unit, meaning."""
    Scalars = dict[str, tuple[float, str, str]]
    """By name: value, meaning, description."""

HEIGHT = 1.0
CONSTRAINED_MODULUS = 1e7
POISSONS_RATIO = 0.3
DENSITY = 1700.0
STRAIN = 1e-5
"""Greatest strain: small, since the exact solutions are those of small strain."""
MOST_SAMPLED_PERIODS = 10
"""Periods of which curves are kept, the first and the last among them."""


@dataclass(frozen=True, kw_only=True)
class ElasticColumnWave(ReadyScene):
    """A column on a fixed base, its top free or under a pressure that is there at once.

    With c the wave speed, H the height, M the constrained modulus, s the pressure: behind the
    front the velocity is s/(rho c); the stress at the base is 2 s from H/c to 3 H/c, else none.
    The standing wave is u = U sin(k z) sin(c k t), k = pi/(2 H); its energy does not change.
    """

    summary: ClassVar[str] = "pressure waves along a column: sudden load, standing wave"
    version: ClassVar[int] = 4
    verifications: ClassVar[tuple[Verification, ...]] = (
        Verification(
            resolution="cell_count",
            resolutions=(50, 100, 200),
            bounds={"error": 0.02},
            settings={"excitation": "sudden_load"},
        ),
        Verification(
            resolution="cell_count",
            resolutions=(10, 20, 40),
            bounds={"error": 0.02, "energy_drift": 0.01},
            least_order=1.0,
            settings={"excitation": "standing_wave"},
        ),
        Verification(
            resolution="cell_count",
            resolutions=(10,),
            bounds={"error": 0.02, "energy_drift": 0.01},
            settings={"period_count": 10_000},
            extreme=True,
        ),
    )

    excitation: str = parameter(
        "standing_wave",
        unit="1",
        meaning="what moves the column",
        choices=("sudden_load", "standing_wave"),
    )
    cell_count: int = parameter(
        40, unit="1", meaning="cells along the height", minimum=4, maximum=1000
    )
    period_count: int = parameter(
        10, unit="1", meaning="periods of the standing wave", minimum=2, maximum=1_000_000
    )

    def build(self) -> tuple[Scene, Column]:
        """The scene and its column."""
        from mpm_warp.column import Column
        from mpm_warp.materials.materials import LinearElastic
        from mpm_warp.scene import Scene

        nu = POISSONS_RATIO
        column = Column(height=HEIGHT, cell_count=self.cell_count)
        sudden = self.excitation == "sudden_load"
        scene = Scene(
            grid=column.grid,
            material=LinearElastic(
                shear_modulus=CONSTRAINED_MODULUS * (1 - 2 * nu) / (2 * (1 - nu)),
                poissons_ratio=nu,
                density=DENSITY,
            ),
            particles_per_side=2,
            time_step_fraction=0.85,
            load=column.pressure_on_top(CONSTRAINED_MODULUS * STRAIN) if sudden else None,
            fixed=column.fixed,
            consistent_mass=True,
        )
        return scene, column

    def simulated_scene(self) -> Scene:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        return self.build()[0]

    def run(
        self, progress: Progress | None = None, execution: Execution | None = None
    ) -> xarray.Dataset:
        """See :class:`~mpm_warp.scenes.base.ReadyScene`."""
        import numpy as np

        from mpm_warp.results import cost, curves_kept, variable
        from mpm_warp.simulation import Simulation

        scene, column = self.build()
        simulation = Simulation(scene, execution)
        start = time.perf_counter()
        if self.excitation == "standing_wave":
            self._set_off(simulation)
        period = 4 * HEIGHT / scene.material.pressure_wave_speed
        phase = self._sampled_phases(simulation.plan.time_step / period)
        samples: list[tuple[float, ...]] = []
        with curves_kept(lambda: self._curves(phase, samples)):
            for step in np.rint(phase * period / simulation.plan.time_step).astype(int):
                simulation.advance(step - simulation.step_count)
                samples.append(self._sample(simulation, column))
                if progress is not None:
                    progress(simulation.time / (phase[-1] * period))
            simulation.check()
        run_time = time.perf_counter() - start

        curves = self._curves(phase, samples)
        errors = {"sudden_load": _sudden_load_error, "standing_wave": _standing_wave_errors}
        scalars = {
            name: variable(value, unit="1", meaning=meaning, description=description)
            for name, (value, meaning, description) in errors[self.excitation](curves).items()
        }
        return curves.assign(scalars).assign(cost(simulation, run_time=run_time))

    def _curves(self, phase: np.ndarray, samples: list[tuple[float, ...]]) -> xarray.Dataset:
        """What was sampled so far, beside the exact solution."""
        import numpy as np
        import xarray as xr

        from mpm_warp.results import variable

        phase = phase[: len(samples)]
        names = ("displacement", "velocity", "stress", "energy")
        computed = dict(zip(names, np.array(samples).reshape(-1, 4).T, strict=True))
        compare = {"sudden_load": _sudden_load, "standing_wave": _standing_wave}
        variables = {
            name: variable(values, unit=unit, meaning=meaning, dims=("phase",))
            for name, (values, unit, meaning) in compare[self.excitation](phase, computed).items()
        }
        axis = variable(phase, unit="1", meaning="time over period", dims=("phase",))
        return xr.Dataset(variables, coords={"phase": axis})

    def _sampled_phases(self, step: float) -> np.ndarray:
        """Time over period of the steps that are sampled; `step` is that of a step."""
        import numpy as np

        period_count = self.period_count if self.excitation == "standing_wave" else 1
        phase = step * np.arange(round(period_count / step) + 1)
        kept = np.linspace(0, period_count - 1, min(period_count, MOST_SAMPLED_PERIODS)).round()
        sampled: np.ndarray = phase[np.isin(_period(phase, period_count), kept)]
        return sampled

    def _set_off(self, simulation: Simulation) -> None:
        """Give the particles the velocity of the standing wave; there is no stress as yet."""
        import numpy as np

        wave_number = math.pi / (2 * HEIGHT)
        position = simulation.array("particle.position")
        velocity = np.zeros_like(position)
        greatest = STRAIN * simulation.scene.material.pressure_wave_speed
        velocity[:, 1] = greatest * np.sin(wave_number * position[:, 1])
        simulation.arrays["particle.velocity"].assign(velocity)

    def _sample(self, simulation: Simulation, column: Column) -> tuple[float, ...]:
        """Displacement of the top, velocity at half height, stress at the base, energy."""
        import numpy as np

        mass = simulation.array("particle.mass")
        stress = simulation.array("particle.stress")
        velocity = simulation.array("particle.velocity")[:, 1]
        height = column.mean_over_sections(simulation.array("particle.position")[:, 1], mass)
        # Particles stand at a quarter of a cell below the top; strain vanishes there.
        top = height[-1] - HEIGHT * (1 - 0.25 / self.cell_count)
        middle = column.mean_over_sections(velocity, mass)[self.cell_count]
        strain_energy = np.sum(mass * stress[:, 1] ** 2) / (2 * CONSTRAINED_MODULUS * DENSITY)
        energy = 0.5 * np.sum(mass * velocity**2) + strain_energy
        return float(top), float(middle), float(stress[0, 1]), float(energy)


def _sudden_load(phase: np.ndarray, computed: Mapping[str, np.ndarray]) -> Curves:
    """Stress at the base and velocity at half height; the period is 4 H/c."""
    import numpy as np

    pressure, speed = _plateaus()
    # Down, back from the base with the soil behind it at rest, back from the top rising.
    edges = np.array([0.125, 0.375, 0.625, 0.875])
    exact_velocity = np.array([0.0, -speed, 0.0, speed, 0.0])[np.searchsorted(edges, phase)]
    exact_stress = np.where((phase > 0.25) & (phase < 0.75), -2 * pressure, 0.0)
    return {
        "base_stress": (computed["stress"], "Pa", "stress at the base"),
        "base_stress_exact": (exact_stress, "Pa", "stress at the base, exact"),
        "velocity": (computed["velocity"], "m s-1", "velocity at half height"),
        "velocity_exact": (exact_velocity, "m s-1", "velocity at half height, exact"),
    }


def _sudden_load_error(curves: xarray.Dataset) -> Scalars:
    """Plateaus, arrival and reflection beside the exact ones."""
    import numpy as np

    pressure, speed = _plateaus()
    phase = curves["phase"].values
    stress, velocity = curves["base_stress"].values, curves["velocity"].values
    plateaus = (
        (stress, 0.25, 0.75, -2 * pressure),
        (velocity, 0.125, 0.375, -speed),
        (velocity, 0.625, 0.875, speed),
    )
    plateau_error = max(
        abs(_plateau(phase, values, start, end) / exact - 1)
        for values, start, end, exact in plateaus
    )
    crossings = phase[np.flatnonzero(np.diff(stress < -pressure))]
    arrival_error = float(np.abs(crossings[[0, -1]] / [0.25, 0.75] - 1).max())
    return {
        "error": (
            max(plateau_error, arrival_error),
            "error of plateaus and arrivals",
            (
                "greatest relative error of the plateaus of stress at the base and of velocity at "
                "half height, each a mean over its middle half, and of the times at which the "
                "stress at the base passes half its plateau"
            ),
        )
    }


def _plateaus() -> tuple[float, float]:
    """Pressure on the top [Pa] and the speed behind its front [m/s]."""
    speed = STRAIN * math.sqrt(CONSTRAINED_MODULUS / DENSITY)
    return CONSTRAINED_MODULUS * STRAIN, speed


def _period(phase: np.ndarray, period_count: int) -> np.ndarray:
    """Number of the period that a time over period is in; its end is still in the last."""
    import numpy as np

    period: np.ndarray = np.minimum(np.floor(phase), period_count - 1)
    return period


def _plateau(phase: np.ndarray, values: np.ndarray, start: float, end: float) -> float:
    quarter = 0.25 * (end - start)
    return float(values[(phase > start + quarter) & (phase < end - quarter)].mean())


def _standing_wave(phase: np.ndarray, computed: Mapping[str, np.ndarray]) -> Curves:
    """Displacement of the top, and energy."""
    import numpy as np

    amplitude = STRAIN * 2 * HEIGHT / math.pi
    exact = amplitude * np.sin(2 * math.pi * phase)
    return {
        "displacement": (computed["displacement"], "m", "displacement of the top"),
        "displacement_exact": (exact, "m", "displacement of the top, exact"),
        "energy": (computed["energy"], "J", "kinetic and strain energy per radian"),
    }


def _standing_wave_errors(curves: xarray.Dataset) -> Scalars:
    """Of the displacement over the first period, and of the energy over all."""
    import numpy as np

    phase, energy = curves["phase"].values, curves["energy"].values
    exact = curves["displacement_exact"].values
    first = phase <= 1.0
    difference = np.linalg.norm((curves["displacement"].values - exact)[first])
    # Over whole periods: kinetic and strain energy are those of times half a step apart.
    period = _period(phase, round(phase[-1]))
    energies = np.array([energy[period == number].mean() for number in np.unique(period)])
    return {
        "error": (
            float(difference / np.linalg.norm(exact[first])),
            "error of displacement",
            "L2 norm over a period of the error of the top's displacement, over that of the exact",
        ),
        "energy_drift": (
            float(np.abs(energies / energies[0] - 1).max()),
            "change of energy",
            "mean over a period, over that of the first, less 1; the greatest of those sampled",
        ),
    }
