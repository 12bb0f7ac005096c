"""A cone pushed into the ground, from the first contact of its tip on."""

import math
from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np
import xarray as xr

from mpm_warp.fields.declaration import parameter, redefined
from mpm_warp.grid.fitted import Floats, graded
from mpm_warp.materials.tresca import Tresca
from mpm_warp.parts.boundaries import Fixed
from mpm_warp.parts.free_surface import FreeSurface
from mpm_warp.parts.window import Window
from mpm_warp.results import curves, labelled
from mpm_warp.sampling import ContactForces, Samples, evenly, follow, soil_scene
from mpm_warp.scene import Scene
from mpm_warp.scenes.catalogue_scene import CatalogueScene, Progress
from mpm_warp.scenes.clay import Clay
from mpm_warp.scenes.cone.groups import Cone
from mpm_warp.scenes.cone.penetrometer import Penetrometer, PenetrometerContact
from mpm_warp.scenes.limits import LARGEST_ERROR, Limit, Limits
from mpm_warp.scenes.run_size import RunSize, size_in_grid
from mpm_warp.scenes.verification import compared
from mpm_warp.simulation import Simulation

RADIUS = 1.0
STRENGTH = 1e3
DENSITY = 1700.0
POISSONS_RATIO = 0.49
FINAL_DEPTH = 0.6
"""Over the height of the cone. The ground that heaves beside the cone stays below the shoulder."""
FITTED_FROM = 0.3
"""Share of the final depth from which the exponent is fitted: above, the cone is in few cells."""
MEAN_DEPTH = 0.5 * (1.0 + FITTED_FROM)
"""Mean depth in the fit, over the final one."""
OF_EXPONENT = Limit(2.0 * LARGEST_ERROR, "a lower speed_ratio, or other cells_per_radius")
SAMPLE_COUNT = 60
TIME_STEP_FRACTION = 0.7


@dataclass(frozen=True, kw_only=True)
class ConeSelfSimilar(CatalogueScene):
    """The depth is the only length of the problem, so the load is proportional to its square.

    The grid travels down with the cone, through the surface of the ground, which cuts its cells.

    Example:
        >>> ConeSelfSimilar(apex_angle=60, rigidity_index=200).run_size().cell_count
        13566
    """

    summary = "load of a cone against its depth, from first touch"
    version = 4
    verifications = compared("cells_per_radius", (12, 16), error=0.05)
    limits: ClassVar[Limits] = {"error": OF_EXPONENT}

    rigidity_index: float = redefined(Clay, "rigidity_index", minimum=10, maximum=1000)
    adhesion_factor: float = redefined(
        Cone, "adhesion_factor", meaning="adhesion factor of the cone"
    )
    apex_angle: float = redefined(Cone, "apex_angle", maximum=120)
    cells_per_radius: int = parameter(
        16, "cells per radius of the cone's base", minimum=4, maximum=40
    )
    speed_ratio: float = parameter(0.03, "speed over shear wave speed", minimum=1e-3, maximum=0.1)

    def build(self) -> Scene:
        """The ground with its surface in the window; soil enters at the bottom, none leaves."""
        size = RADIUS / self.cells_per_radius
        fitted = self._penetrometer.fitted_grid(
            cell_size=size,
            columns=graded(size, 19.0 * RADIUS, 1.0 + 0.8 * size / RADIUS),
            depth_below=12.0 * RADIUS,
            height_above=RADIUS,
        )
        grid = replace(fitted, ground_level=0.0)
        clay = Tresca(
            shear_modulus=self.rigidity_index * STRENGTH,
            poissons_ratio=POISSONS_RATIO,
            density=DENSITY,
            strength=STRENGTH,
        )
        speed = self.speed_ratio * clay.shear_wave_speed
        return Scene(
            grid=grid,
            material=clay,
            time_step_fraction=TIME_STEP_FRACTION,
            bulk_viscosity=0.2,
            parts=(
                Fixed.on(grid, radial=["axis", "bottom", "side"], vertical=["bottom", "side"]),
                PenetrometerContact.of(
                    self._penetrometer,
                    grid,
                    face_adhesion=self.adhesion_factor * STRENGTH,
                    in_situ_stress=0.0,
                ),
                Window(speed=speed, ramp_travel=0.1 * RADIUS, spare_fraction=1.0),
                FreeSurface(),
            ),
        )

    @property
    def limits_of_run(self) -> Limits:
        """The depth is known to a cell at worst, of those that the cone is in on average.

        On more than 22 cells a radius waves grow in soil that crosses the grid, and the error is
        larger than that: 0.26 on 24 cells, 0.04 at half the speed.
        """
        rows = self._final_depth / (RADIUS / self.cells_per_radius)
        of_cells = 2.0 / (MEAN_DEPTH * rows)
        limit = replace(OF_EXPONENT, size=min(OF_EXPONENT.size, of_cells))
        return {"error": limit}

    def run_size(self) -> RunSize:
        """All cells of the grid, also those above the ground, and the steps to the final depth."""
        scene = self.build()
        size = size_in_grid(scene, scene[Window].time_to(self._final_depth))
        share_of_soil = float((scene.grid.rows[1:] <= 0.0).mean())
        return replace(size, particle_count=math.ceil(share_of_soil * size.particle_count))

    @property
    def _penetrometer(self) -> Penetrometer:
        return Penetrometer(radius=RADIUS, apex_angle=math.radians(self.apex_angle))

    @property
    def _final_depth(self) -> float:
        """Depth of the tip at the end [m]."""
        return FINAL_DEPTH * self._penetrometer.cone_height

    def record(self, simulation: Simulation, progress: Progress) -> xr.Dataset:
        """Push the cone in, and fit the exponent of the depth in its load."""
        contact = soil_scene(simulation)[PenetrometerContact]
        contact_forces = ContactForces(simulation)
        reached = [0.0]

        def sample() -> tuple[float, float]:
            """Depth, and mean load since the previous sample."""
            forces = contact.forces(contact_forces.take())
            reached.append(simulation.travel)
            return reached[-1], 2.0 * math.pi * forces.on_face

        def load_curve(reached: Floats, load: Floats) -> xr.Dataset:
            # A mean over an interval of travel belongs to its middle.
            middles = 0.5 * (reached + np.append(0.0, reached[:-1]))
            return curves("depth", (middles, "m", "depth of the tip"), load=(load, "N", "load"))

        samples = Samples(sample, load_curve)
        depths = evenly(self._final_depth, SAMPLE_COUNT)
        recorded = follow(simulation, depths, simulation.travel_to, [samples], progress)
        return recorded.assign(self._fitted(recorded, np.array(reached)))

    def _fitted(self, recorded: xr.Dataset, reached: Floats) -> dict[str, xr.Variable]:
        """Exponent of the depth, its error, and the load over the section of the cone."""
        depth, load = recorded.depth.values, recorded["load"].values
        late = depth > FITTED_FROM * self._final_depth
        # The work has an exponent greater by one, and averages out the noise of the load.
        work = np.cumsum(load * np.diff(reached))
        exponent = float(np.polyfit(np.log(reached[1:][late]), np.log(work[late]), 1)[0]) - 1.0
        factor = load / (
            STRENGTH * math.pi * (depth * math.tan(math.radians(self.apex_angle) / 2)) ** 2
        )
        error = (abs(exponent - 2.0), "1", "error of the exponent of the depth")
        fitted = (
            "that in the work less 1, by least squares of logarithms from "
            f"{FITTED_FROM:.0%} of the final depth; exactly 2 where nothing has a length"
        )
        over = "load over su and the cone's section at the ground's first level"
        return labelled(role="headline", error=error) | labelled(
            exponent=(exponent, "1", "exponent of the depth in the load", fitted),
            load_factor=(float(factor[late].mean()), "1", over),
        )
