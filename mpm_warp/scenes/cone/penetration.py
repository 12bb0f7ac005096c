"""A penetration: curves of the resistance and their steady values, snapshots of the soil around."""

import math

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import Quantity, curves, labelled
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

Slowing = tuple[float, float]
"""Begin and end of the penetration in which the penetrometer slows down, over its radius."""


class PenetrationCurves:
    """Samples the forces on a penetrometer, at every `SAMPLE_SPACING` radii of penetration.

    `forces` are means over each sample so far, `nodal_forces` those at the nodes over the last one
    [N], shape [node_count, 2].

    Args:
        simulation: a run of a scene with a window, whose contact is a `PenetrometerContact`.
        radius: of the penetrometer [m].
        unsteady: penetration before which no resistance counts as steady, over the radius.
        tolerance: change of the resistance over two radii at which it counts as steady.
        slowing: penetration between which the resistance is not given, over the radius: the
            penetrometer slows down there, and the inertia of the soil pushes it; or none.
    """

    def __init__(
        self,
        simulation: Simulation,
        *,
        radius: float,
        unsteady: float,
        tolerance: float,
        slowing: Slowing | None = None,
    ) -> None:
        scene = soil_scene(simulation)
        self._simulation = simulation
        self._contact = scene[PenetrometerContact]
        heights = scene.grid.node_positions[self._contact.nodes, 1]
        self._above_shoulder = heights / radius - 1.0 / math.tan(self._contact.half_angle)
        self.radius = radius
        self._unsteady = unsteady
        self._slowing = slowing
        self._tolerance = tolerance
        self._contact_forces = ContactForces(simulation)
        self._moved: list[float] = []  # in each sample [m]
        self._sleeve: list[float] = []  # shear stress in each sample [Pa]
        self.forces: list[PenetrometerForces] = []
        self._sampled_at = 0.0

    def sample(self) -> None:
        """Record the mean forces since the sample before."""
        reached = self._simulation.travel
        if reached > self._sampled_at:  # one step may go past several samples
            self.nodal_forces = self._contact_forces.take()
        self.forces.append(self._contact.forces(self.nodal_forces))
        shaft_stress = self._contact.shaft_shear_stress(self.nodal_forces)
        self._sleeve.append(sleeve_mean(self._above_shoulder, shaft_stress))
        self._moved.append(reached - self._sampled_at)
        self._sampled_at = reached

    @property
    def work(self) -> float:
        """Of the penetrometer so far, per radian [J]."""
        parts = zip(self.forces, self._moved, strict=True)
        return math.fsum(force.upward * moved for force, moved in parts)

    def is_steady(self) -> bool:
        """Whether the resistance is steady: the mean over two radii is that over two before."""
        earliest = len(self._moved) - 2 * STEADY_SAMPLES
        if (earliest + 0.5) * SAMPLE_SPACING < self._unsteady:
            return False
        resistance = [force.face_normal + force.face_shear for force in self.forces[earliest:]]
        return is_steady(resistance, STEADY_SAMPLES, self._tolerance)

    def dataset(self) -> xr.Dataset:
        """Resistance, its shear part, friction of shaft and sleeve, and contact."""
        base_area, net = 0.5 * self.radius**2, "net cone resistance"
        normal, shear, shaft, share = (
            np.array([getattr(force, name) for force in self.forces])
            for name in ("face_normal", "face_shear", "shaft_shear", "contact_share")
        )
        sleeve = np.array(self._sleeve)
        sleeve_area = 2.0 * math.pi * SLEEVE_LENGTH * self.radius**2
        return curves(
            "penetration",
            penetration_axis(len(self._moved)),
            penetration_resistance=(
                without_slowing((normal + shear) / base_area, self._slowing),
                "Pa",
                net,
                "not a number where the penetrometer slows down at the end of its approach",
            ),
            penetration_resistance_shear=(shear / base_area, "Pa", f"{net}, shear part"),
            shaft_friction=(
                shaft / self._contact.shaft_area,
                "Pa",
                "mean shear stress on the shaft",
            ),
            sleeve_friction=(
                sleeve,
                "Pa",
                "mean sleeve friction",
                "mean shear stress on a standard sleeve; not a number if it ends above the window",
            ),
            sleeve_force=(sleeve * sleeve_area, "N", "total sleeve friction"),
            contact_share=(share, "1", "share of cone and shaft in contact"),
        )


def penetration_axis(count: int, over: str = "cone radius") -> Quantity:
    """The axis of `count` samples, each of which stands in its middle, over a length."""
    middles = (np.arange(count) + 0.5) * SAMPLE_SPACING
    return middles, "1", f"penetration over {over}"


def without_slowing(values: Floats, slowing: Slowing | None) -> Floats:
    """A curve that is not a number where the penetrometer slows down, shape [sample_count]."""
    if slowing is None:
        return values
    penetration = (np.arange(len(values)) + 0.5) * SAMPLE_SPACING
    slowed = (penetration > slowing[0]) & (penetration < slowing[1])
    return np.where(slowed, np.nan, values)


def steady_values(recorded: xr.Dataset, strength: float) -> dict[str, xr.Variable]:
    """What `PenetrationCurves` come to at the end over su [Pa], each as a `steady_mean`."""
    resistance, over = steady_mean(recorded.penetration_resistance)
    shear, _ = steady_mean(recorded.penetration_resistance_shear)
    sleeve, _ = steady_mean(recorded.sleeve_friction)
    return labelled(
        cone_factor_simulated=(
            resistance / strength,
            "1",
            "cone factor, as simulated",
            f"mean resistance {over}, over su: before any correction",
        ),
        cone_factor_shear=(
            shear / strength,
            "1",
            "cone factor, shear part",
            f"what the shear traction on the face adds to Nc, mean {over}",
        ),
        cone_factor_variation=(
            np.ptp(last_part(recorded.penetration_resistance)) / resistance,
            "1",
            "variation of the cone factor",
            f"range {over} of penetration, over the mean",
        ),
        sleeve_friction_factor=(
            sleeve / strength,
            "1",
            "sleeve friction factor",
            f"mean sleeve friction over su, mean {over}",
        ),
        penetration_reached=(
            recorded.sizes["penetration"] * SAMPLE_SPACING,
            "1",
            "penetration reached over cone radius",
            "where the resistance was steady, or the greatest penetration",
        ),
    )


AXIS = "penetration"
"""What the moments of a cone test are called; the parameter of that name bounds them."""


class PenetrationSnapshots:
    """Takes snapshots at samples of a penetration, which are over the radius of the penetrometer.

    The scene has a window, a `History` and a `PenetrometerContact`; each time, `curves` has sampled
    the forces on it before.
    """

    def __init__(
        self,
        simulation: Simulation,
        snapshots: Snapshots,
        curves: PenetrationCurves,
        parameters: Variables,
    ) -> None:
        scene = soil_scene(simulation)
        contact = scene[PenetrometerContact]
        self._simulation = simulation
        self._snapshots = snapshots
        self._curves = curves
        self._contact = contact
        self._sample_count = 0
        places = surface_places(contact, scene.grid.node_positions[contact.nodes])
        same = {**parameters, **grid_places(simulation), **places}
        snapshots.begin(AXIS, ("1", "penetration over cone radius"), same)

    @property
    def _penetration(self) -> float:
        return round(self._sample_count * SAMPLE_SPACING, 9)

    def sample(self) -> None:
        """Take the snapshots that are due."""
        self._sample_count += 1
        self._snapshots.take(self._penetration, self._fields)

    def finish(self) -> None:
        """At the end of a run take one for all that it has not reached."""
        self._snapshots.take(self._penetration, self._fields, is_last=True)

    def dataset(self) -> xr.Dataset:
        """Nothing: fields are no curves; the snapshots have them."""
        return xr.Dataset()

    def _fields(self) -> Variables:
        nodal = self._curves.nodal_forces
        forces = self._contact.forces(nodal)
        base_area = 0.5 * self._curves.radius**2
        resistance = (forces.face_normal + forces.face_shear) / base_area
        over = "over the tenth of a radius before, as the traction on the surface is"
        scalars = labelled(
            time=(self._simulation.time, "s", "time"),
            travel=(self._simulation.travel, "m", "penetration"),
            speed=(self._simulation.array("window.motion")[1], "m s-1", "penetration speed"),
            resistance=(resistance, "Pa", "net cone resistance", f"mean {over}"),
        )
        traction = surface_traction(self._contact, nodal)
        return scalars | soil_fields(self._simulation) | traction


def surface_places(contact: PenetrometerContact, position: Floats) -> dict[str, xr.Variable]:
    """Places on the surface: nodes of the face from the tip on, then of the shaft.

    The shoulder is among both, for the shear traction is another on either side of it. `position`
    is that of the contact's nodes (r, z) [m], shape [node_count, 2].
    """
    face, shaft = contact.face_areas > 0.0, contact.shaft_areas > 0.0
    r, z = np.concatenate([position[face], position[shaft]]).T
    number = np.arange(len(r), dtype=np.int32)
    part = np.repeat(["face", "shaft"], [face.sum(), shaft.sum()])
    labels = {"long_name": "part of the surface"}
    return {
        "surface": xr.Variable("surface", number, {"long_name": "number of the surface's node"}),
        "surface_part": xr.Variable("surface", part, labels),
    } | labelled(
        dims=("surface",),
        surface_r=(r, "m", "radius of the surface's node"),
        surface_z=(z, "m", "height of the surface's node"),
    )


def surface_traction(contact: PenetrometerContact, nodal: Floats) -> dict[str, xr.Variable]:
    """Traction along the surface, at the places that `surface_places` gives.

    It is linear between nodes: with the radius as weight it integrates to the forces exactly.
    `nodal` are normal and tangential forces from the soil at the nodes [N], [node_count, 2].
    """
    face, shaft = contact.face_areas > 0.0, contact.shaft_areas > 0.0
    pressure = nodal[:, 0] / contact.normal_areas
    shear_on_face = contact.shear_on_face(nodal)
    on_face = shear_on_face[face] / contact.face_areas[face]
    on_shaft = (nodal[:, 1] - shear_on_face)[shaft] / contact.shaft_areas[shaft]
    return labelled(
        dims=("surface",),
        normal_traction=(
            np.concatenate([pressure[face], pressure[shaft]]),
            "Pa",
            "normal traction on the penetrometer",
            "that over the in-situ stress, pressing positive",
        ),
        shear_traction=(
            np.concatenate([on_face, on_shaft]),
            "Pa",
            "shear traction on the penetrometer",
            "upward positive",
        ),
    )
