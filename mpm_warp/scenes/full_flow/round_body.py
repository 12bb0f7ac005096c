"""A ball below a thin shaft, or a cylinder: its outline, grid, contact and resistance."""

import math
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats, Grid, nodal_areas
from mpm_warp.parts.contact import SurfaceContact
from mpm_warp.results import curves
from mpm_warp.sampling import ContactForces, soil_scene
from mpm_warp.scenes.cone.penetration import RESISTANCE_OVER_STRENGTH, penetration_axis
from mpm_warp.simulation import Simulation
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING

FITTED_RADIUS = 3.0
"""Approximate radius up to which the columns of nodes follow the surface, over that of the body.
The mechanism reaches about as far."""
POLE_ROW = 0.5
"""Height of the rows beside the poles over that of the rows beyond the body. Full rows would leave
one long chord at a pole, and an error of first order in their height."""


@dataclass(frozen=True, kw_only=True)
class RoundBody:
    """A ball below a thin smooth shaft, or a cylinder in plane strain, with its centre at z = 0."""

    radius: float  # R [m], > 0
    shaft_radius: float = 0.0  # [m], 0 (no shaft) to less than R
    planar: bool = False  # True: a cylinder in plane strain; False: a ball

    def surface_radius(self, height: Floats) -> Floats:
        """Radius of the surface at heights [m]; 0 above and below the body."""
        body = np.sqrt(np.clip(self.radius**2 - height**2, 0.0, None))
        return np.maximum(body, np.where(height > 0.0, self.shaft_radius, 0.0))

    def fitted_grid(self, *, cells_per_radius: int, columns: Floats, extent: int) -> Grid:
        """A grid whose rows meet both poles and whose first column follows the surface.

        Columns far from the body are upright, so that the cells near it do not depend on the size
        of the grid. Columns are at given distances from the equator, rising from 0 [m]. The grid
        reaches `extent` radii above and below the centre, >= 2.
        """
        size = self.radius / cells_per_radius
        at_body = np.linspace(0.0, self.radius - POLE_ROW * size, cells_per_radius + 1)
        beyond = self.radius + size * np.arange((extent - 1) * cells_per_radius + 1)
        above = np.append(at_body, beyond)
        rows = np.append(-above[:0:-1], above)
        last_fitted = int(np.argmin(np.abs(columns - (FITTED_RADIUS - 1.0) * self.radius)))
        fitted, upright = np.split(columns, [last_fitted + 1])
        fitted_radius = self.radius + float(fitted[-1])
        return Grid(
            columns=np.append(fitted / fitted[-1], (self.radius + upright) / fitted_radius),
            rows=rows,
            surface_radius=self.surface_radius(rows),
            fitted_radius=fitted_radius,
            planar=self.planar,
        )

    def contact(self, grid: Grid, *, adhesion: float, in_situ_stress: float) -> SurfaceContact:
        """Contact at all nodes of the surface of a fitted grid, from the lower pole upward.

        The nodes of the poles are on the axis too: both hold the soil there, of which the flow
        leaves few material points. The adhesion of ball or bar and the in-situ stress are in Pa,
        >= 0; the shaft is smooth.
        """
        off_axis = np.flatnonzero(grid.surface_radius > 0.0)
        upper_end = min(off_axis[-1] + 1, grid.row_count)
        rows = np.arange(off_axis[0] - 1, upper_end + 1, dtype=np.int32)
        radius, height = grid.surface_radius[rows], grid.rows[rows]
        rise, lean = np.diff(height), np.diff(radius)
        of_body = np.where(lean != 0.0, np.hypot(lean, rise), 0.0)
        areas = nodal_areas(grid.weight(radius), of_body)
        contact = SurfaceContact.on(grid, rows, in_situ_stress=in_situ_stress)
        return replace(contact, adhesion_forces=adhesion * areas)


class ResistanceSamples:
    """Samples the resistance every `SAMPLE_SPACING` radii, each the mean since the sample before.

    `forces` are those of the soil on half a cylinder of unit length or on a radian of a ball,
    upward positive [N], shape [sample_count].
    """

    def __init__(self, simulation: Simulation, body: RoundBody) -> None:
        self._contact = soil_scene(simulation)[SurfaceContact]
        self._radius = body.radius
        self._area = body.radius if body.planar else 0.5 * body.radius**2
        self._contact_forces = ContactForces(simulation)
        self.forces: list[float] = []

    def sample(self) -> None:
        """Append the mean force since the sample before."""
        self.forces.append(self._contact.upward_force(self._contact_forces.take()))

    @property
    def resistance(self) -> Floats:
        """Force over projected area [Pa], shape [sample_count]."""
        return np.array(self.forces) / self._area

    @property
    def work(self) -> float:
        """Work of the body so far [J], per radian or of half a cylinder of unit length."""
        return math.fsum(self.forces) * SAMPLE_SPACING * self._radius

    def dataset(self) -> xr.Dataset:
        """The curve of resistance over penetration."""
        what = "resistance over projected area"
        over = "excess over the in-situ stress, as simulated: not corrected for mesh and speed"
        return curves(
            "penetration",
            penetration_axis(len(self.forces), over="radius of the body"),
            penetration_resistance=(self.resistance, "Pa", what, over, RESISTANCE_OVER_STRENGTH),
        )
