"""Snapshots of a cone test: the soil around the penetrometer, and the traction on its surface."""

import numpy as np
import xarray as xr

from mpm_warp.grid.fitted import Floats
from mpm_warp.results import labelled
from mpm_warp.sampling import soil_scene
from mpm_warp.scenes.cone.penetration import PenetrationCurves
from mpm_warp.scenes.cone.penetrometer import PenetrometerContact
from mpm_warp.simulation import Simulation
from mpm_warp.snapshots import Snapshots, Variables, grid_places, soil_fields
from mpm_warp.uncertainty.steadiness import SAMPLE_SPACING

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
