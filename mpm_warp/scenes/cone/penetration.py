"""Results of a penetration: curves of resistance, their steady means, and snapshots of the soil."""

import math
from functools import partial

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.parts.window import Window
from mpm_warp.results import Drawn, Quantity, curves, labelled, parameter_variables, variable
from mpm_warp.sampling import ContactForces, soil_scene
from mpm_warp.scenes.cone.penetrometer import (
    SLEEVE_LENGTH,
    PenetrometerContact,
    PenetrometerForces,
    sleeve_mean,
)
from mpm_warp.simulation import Simulation
from mpm_warp.snapshots import Snapshots, Variables, grid_places, soil_fields
from mpm_warp.uncertainty.steadiness import (
    SAMPLE_SPACING,
    STEADY_SAMPLES,
    is_steady,
    last_part,
    steady_mean,
)

PUSHED = 0.5
"""Penetration after the approach over which the inertia of the soil still acts, in radii."""
FROM_REST = 2.0
"""Least penetration from which, without an approach, the resistance may be steady, in radii."""
RESISTANCE_OVER_STRENGTH = Drawn(picture="resistance", divided_by="undrained_shear_strength")
"""The picture of a resistance over penetration."""


class PenetrationCurves:
    """Samples the forces on a penetrometer every `SAMPLE_SPACING` radii of penetration.

    `forces` has the mean forces over the interval of each sample, `nodal_forces` those on the nodes
    in the last sample [N], shape [node_count, 2].

    Args:
        simulation: a run of a scene with a window, whose contact is a `PenetrometerContact`.
        radius: of the penetrometer [m].
        transient: penetration over which an approach still acts after its end, over the radius.
        tolerance: change of the resistance over two radii at which it counts as steady; 0: never.
    """

    def __init__(
        self,
        simulation: Simulation,
        *,
        radius: float,
        transient: float = 0.0,
        tolerance: float = 0.0,
    ) -> None:
        scene = soil_scene(simulation)
        self.simulation, self.radius = simulation, radius
        self.contact, self._window = scene[PenetrometerContact], scene[Window]
        heights = scene.grid.node_positions[self.contact.nodes, 1]
        self._above_shoulder = heights / radius - 1.0 / math.tan(self.contact.half_angle)
        approach = self._window.approach
        self._steady_from = FROM_REST if approach is None else approach.travel / radius + transient
        self._tolerance = tolerance
        self._contact_forces = ContactForces(simulation)
        self._travels = [0.0]  # travel at the start of each sample and the end of the last [m]
        self._sleeve: list[float] = []  # shear stress in each sample [Pa]
        self.forces: list[PenetrometerForces] = []

    def sample(self) -> None:
        """Record the mean forces since the previous sample."""
        if self.simulation.travel > self._travels[-1]:  # one step may pass several samples
            self.nodal_forces = self._contact_forces.take()
        self.forces.append(self.contact.forces(self.nodal_forces))
        shaft_stress = self.contact.shaft_shear_stress(self.nodal_forces)
        self._sleeve.append(sleeve_mean(self._above_shoulder, shaft_stress))
        self._travels.append(self.simulation.travel)

    @property
    def work(self) -> float:
        """Work of the penetrometer so far, per radian [J]."""
        parts = zip(self.forces, np.diff(self._travels).tolist(), strict=True)
        return math.fsum(force.upward * moved for force, moved in parts)

    def is_steady(self) -> bool:
        """Whether the mean resistance over the last two radii equals that over the two before."""
        earliest = len(self.forces) - 2 * STEADY_SAMPLES
        if (earliest + 0.5) * SAMPLE_SPACING < self._steady_from:
            return False
        resistance = [force.on_face for force in self.forces[earliest:]]
        return is_steady(resistance, STEADY_SAMPLES, self._tolerance)

    def dataset(self) -> xr.Dataset:
        """Resistance, its shear part, friction of shaft and sleeve, and contact."""
        base_area, net = 0.5 * self.radius**2, "net cone resistance"
        normal, shear, shaft, share = np.array(self.forces).reshape(-1, 4).T
        resistance = without_slowing((normal + shear) / base_area, self._window, self.radius)
        simulated = "as simulated: not corrected for mesh, speed and window"
        given = f"{simulated}; not a number where the penetrometer slows down after its approach"
        shaft_stress = shaft / self.contact.shaft_areas.sum()
        sleeve = np.array(self._sleeve)
        force = sleeve * (2.0 * math.pi * SLEEVE_LENGTH * self.radius**2)
        above = "mean shear stress on a standard sleeve; not a number if it ends above the window"
        return curves(
            "penetration",
            penetration_axis(len(self.forces)),
            penetration_resistance=(resistance, "Pa", net, given, RESISTANCE_OVER_STRENGTH),
            penetration_resistance_shear=(shear / base_area, "Pa", f"{net}, shear part", simulated),
            shaft_friction=(shaft_stress, "Pa", "mean shear stress on the shaft"),
            sleeve_friction=(sleeve, "Pa", "mean sleeve friction", above),
            sleeve_force=(force, "N", "total sleeve friction"),
            contact_share=(share, "1", "share of cone and shaft in contact"),
        )


def penetration_axis(count: int, over: str = "cone radius") -> Quantity:
    """The axis of samples, each at the middle of its interval; `over` names the unit of length."""
    return (np.arange(count) + 0.5) * SAMPLE_SPACING, "1", f"penetration over {over}"


def without_slowing(values: Floats, window: Window, radius: float) -> Floats:
    """A curve, [n], NaN where the penetrometer slows down: inertia changes it by up to 1.3 su."""
    approach = window.approach
    if approach is None:
        return values
    begin = (approach.travel - approach.slowing_travel) / radius
    end = approach.travel / radius + PUSHED
    penetration = (np.arange(len(values)) + 0.5) * SAMPLE_SPACING
    return np.where((penetration > begin) & (penetration < end), np.nan, values)


def steady_values(recorded: xr.Dataset, strength: float) -> dict[str, xr.Variable]:
    """Steady means of `PenetrationCurves` over the strength su [Pa]; see `steady_mean`."""
    resistance, over = steady_mean(recorded.penetration_resistance)
    shear, _ = steady_mean(recorded.penetration_resistance_shear)
    sleeve, _ = steady_mean(recorded.sleeve_friction)
    variation = np.ptp(last_part(recorded.penetration_resistance)) / resistance
    reached = recorded.sizes["penetration"] * SAMPLE_SPACING
    simulated = f"mean resistance {over}, over su: before any correction"
    of_shear = f"what the shear traction on the face adds to Nc, mean {over}"
    of_range = f"range {over} of penetration, over the mean"
    of_sleeve = f"mean sleeve friction over su, mean {over}"
    end = "where the resistance was steady, or the greatest penetration"
    return labelled(
        cone_factor_simulated=(resistance / strength, "1", "cone factor, as simulated", simulated),
        cone_factor_shear=(shear / strength, "1", "cone factor, shear part", of_shear),
        cone_factor_variation=(variation, "1", "variation of the cone factor", of_range),
        sleeve_friction_factor=(sleeve / strength, "1", "sleeve friction factor", of_sleeve),
        penetration_reached=(reached, "1", "penetration reached over cone radius", end),
    )


AXIS = "penetration"
"""Name of the coordinate of snapshots, and of the parameter with the greatest penetration."""


class PenetrationSnapshots:
    """Takes snapshots of a test with a `History` after `curves` has sampled the forces.

    The coordinate is the penetration over the radius. Places on the surface are the nodes of the
    face, from the tip upward, then those of the shaft. The shoulder belongs to both, because the
    shear traction jumps there.
    """

    def __init__(self, test: object, curves: PenetrationCurves, snapshots: Snapshots) -> None:
        self._curves, self._snapshots = curves, snapshots
        areas = curves.contact.face_areas, curves.contact.shaft_areas
        self._face, self._shaft = (np.flatnonzero(them) for them in areas)
        places = grid_places(curves.simulation) | self._surface_places()
        same = parameter_variables(test, [AXIS]) | places
        snapshots.begin(AXIS, ("1", "penetration over cone radius"), same)

    def sample(self, *, is_last: bool = False) -> None:
        """Take the snapshots that are due; the last sample stands for all that remain."""
        penetration = round(len(self._curves.forces) * SAMPLE_SPACING, 9)
        self._snapshots.take(penetration, self._fields, is_last=is_last)

    def dataset(self) -> xr.Dataset:
        """An empty dataset: the fields are in the snapshots."""
        return xr.Dataset()

    def _surface_places(self) -> dict[str, xr.Variable]:
        part = np.repeat(["face", "shaft"], [self._face.size, self._shaft.size])
        nodes = self._curves.contact.nodes[np.concatenate([self._face, self._shaft])]
        r, z = soil_scene(self._curves.simulation).grid.node_positions[nodes].T
        number = np.arange(part.size, dtype=np.int32)
        node_variable = partial(variable, unit=None, dims=("surface",))
        return {
            "surface": node_variable(number, meaning="number of the surface's node"),
            "surface_part": node_variable(part, meaning="part of the surface"),
        } | labelled(
            dims=("surface",),
            surface_r=(r, "m", "radius of the surface's node"),
            surface_z=(z, "m", "height of the surface's node"),
        )

    def _fields(self) -> Variables:
        simulation = self._curves.simulation
        resistance = self._curves.forces[-1].on_face / (0.5 * self._curves.radius**2)
        mean = "mean over the tenth of a radius before, as the traction on the surface is"
        scalars = labelled(
            time=(simulation.time, "s", "time"),
            travel=(simulation.travel, "m", "penetration"),
            speed=(simulation.array("window.motion")[1], "m s-1", "penetration speed"),
            resistance=(resistance, "Pa", "net cone resistance", mean),
        )
        return scalars | soil_fields(simulation) | self._surface_traction()

    def _surface_traction(self) -> dict[str, xr.Variable]:
        """Tractions at the nodes; their integral, weighted by radius, is exactly the force."""
        contact, nodal = self._curves.contact, self._curves.nodal_forces
        numbers = np.concatenate([self._face, self._shaft])
        pressure = nodal[numbers, 0] / contact.normal_areas[numbers]
        on_face = contact.shear_on_face(nodal)[self._face] / contact.face_areas[self._face]
        shear = np.concatenate([on_face, contact.shaft_shear_stress(nodal)[self._shaft]])
        over = "that over the in-situ stress, pressing positive"
        return labelled(
            dims=("surface",),
            normal_traction=(pressure, "Pa", "normal traction on the penetrometer", over),
            shear_traction=(shear, "Pa", "shear traction on the penetrometer", "upward positive"),
        )
