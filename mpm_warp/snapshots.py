"""Snapshots of the soil of a run: its material points and the nodes of its grid."""

from collections.abc import Callable, Iterable, Mapping

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from mpm_warp.fields.checks import POSITIVE, check_kind, check_number
from mpm_warp.parts.history import PLASTIC_STRAIN, displacement
from mpm_warp.parts.window import MovingGrid
from mpm_warp.results import Quantity, labelled, variable
from mpm_warp.sampling import soil_scene
from mpm_warp.simulation import Simulation

ROUNDING = 1e-9
"""Distance to a moment, over the moment, that counts as rounding: the moment is reached."""

Variables = Mapping[str, xr.Variable]


class Snapshots:
    """The state of the soil at some moments of a run, in single precision.

    Args:
        at: the moments in the unit of the scene: in a cone test penetration over cone radius. Each
            is taken at the first sample that has reached it. All beyond the end of a run are taken
            once, at its end.

    Attributes:
        at: the moments, rising, each once.

    Raises:
        ValueError: there is no moment, or one is not a number > 0.

    Example:
        >>> Snapshots([5.0, 0.5]).at
        (0.5, 5.0)
    """

    def __init__(self, at: Iterable[float]) -> None:
        check_kind("snapshots: at", at, Iterable)
        moments = list(at)
        for moment in moments:
            check_number("snapshots: moment", moment, POSITIVE, error=ValueError)
        if not moments:
            raise ValueError("snapshots: no moment is given, must be one at least")
        self.at: tuple[float, ...] = tuple(sorted({float(moment) for moment in moments}))
        self._left = list(self.at)
        self._axis: tuple[str, xr.Variable] | None = None
        self._same: dict[str, xr.Variable] = {}
        self._taken: list[tuple[float, Variables]] = []

    def begin(self, axis: str, quantity: tuple[str, str], same: Variables) -> None:
        """Begin a run and forget the snapshots of another.

        `axis` names the moments, with a unit and a meaning. `same` are variables without moments.
        """
        unit, meaning = quantity
        self._axis = axis, variable([], unit=unit, meaning=meaning, dims=(axis,))
        self._same = dict(same)
        self._left, self._taken = list(self.at), []

    def take(
        self, moment: float, fields: Callable[[], Variables], *, is_last: bool = False
    ) -> None:
        """Record fields of a run if it has reached a moment that has not been taken.

        The fields have the same names each time. At the end of a run all moments are reached.
        """
        left = [mark for mark in self._left if moment < mark * (1.0 - ROUNDING)]
        is_new = not (self._taken and self._taken[-1][0] == moment)
        if len(left) < len(self._left) or (is_last and left and is_new):
            self._taken.append((moment, fields()))
        self._left = left

    def dataset(self) -> xr.Dataset:
        """The snapshots so far; empty before the first moment.

        Arrays over material points have the dim `point`, one for each slot, NaN if the slot is
        empty. A slot holds the same soil until the soil has left the window.
        """
        if self._axis is None or not self._taken:
            return xr.Dataset()
        axis, labels = self._axis
        moments = xr.Variable(axis, [moment for moment, _ in self._taken], labels.attrs)
        fields = {
            name: xr.Variable(
                (axis, *first.dims),
                np.stack([fields[name].values for _, fields in self._taken]),
                first.attrs,
            )
            for name, first in self._taken[0][1].items()
        }
        variables = {axis: moments, **self._same, **fields}
        return xr.Dataset(variables).set_coords(PLACES & variables.keys())


PLACES = {"point_r", "point_z", "node_r", "node_z"}
"""Positions of points and nodes in the coordinates of the scene."""


def grid_places(simulation: Simulation) -> dict[str, xr.Variable]:
    """Positions of the nodes of a grid that keeps its shape; numbers of points, rows, columns."""
    grid = soil_scene(simulation).grid
    shape = (grid.row_count + 1, grid.column_count + 1)
    radius, height = np.moveaxis(grid.node_positions.reshape(*shape, 2), -1, 0)
    (slot_count,) = simulation.plan.arrays["particle.mass"].shape
    counts = {"point": slot_count, "row": shape[0], "column": shape[1]}
    numbers = {
        dim: xr.Variable(dim, np.arange(count, dtype=np.int32), {"long_name": f"number of {dim}"})
        for dim, count in counts.items()
    }
    return numbers | _single(
        labelled(
            dims=("row", "column"),
            node_r=(radius, "m", "radius of the node"),
            node_z=(height, "m", "height of the node"),
        )
    )


def soil_fields(simulation: Simulation) -> dict[str, xr.Variable]:
    """Material points and nodal velocities of a run at present.

    Raises:
        TypeError: the scene is not soil in a grid.
        KeyError: the scene has no `History`, so the place of entry is unknown.

    Example:
        >>> simulation = Simulation(GravityColumn(cell_count=2).build().with_parts(History()))
        >>> soil_fields(simulation)["point_z"].attrs["units"]
        'm'
    """
    scene, array = soil_scene(simulation), simulation.array
    travel = simulation.travel if scene.find(MovingGrid) else 0.0
    moved = displacement(simulation, travel)
    stress, velocity = array("particle.stress"), array("particle.velocity")
    position, node_velocity = array("particle.position"), array("node.velocities")
    absent = array("particle.cell")[:, 0] < 0

    def of_points(values: NDArray[np.floating]) -> NDArray[np.float32]:
        kept = values.astype(np.float32)
        kept[absent] = np.nan
        return kept

    rr, zz, rz, tt = (of_points(component) for component in stress.T)
    shape = (2, scene.grid.row_count + 1, scene.grid.column_count + 1)
    excess = "that over the vertical in-situ stress, tension positive"
    ground = "relative to soil at rest far away"
    of_soil: dict[str, Quantity] = {
        "point_r": (of_points(position[:, 0]), "m", "radius of the material point"),
        "point_z": (of_points(position[:, 1]), "m", "height of the material point"),
        "displacement_r": (of_points(moved[:, 0]), "m", "radial displacement", "since entry"),
        "displacement_z": (of_points(moved[:, 1]), "m", "upward displacement", "since entry"),
        "velocity_r": (of_points(velocity[:, 0]), "m s-1", "radial velocity", ground),
        "velocity_z": (of_points(velocity[:, 1]), "m s-1", "upward velocity", ground),
        "stress_rr": (rr, "Pa", "radial stress", excess),
        "stress_zz": (zz, "Pa", "vertical stress", excess),
        "stress_rz": (rz, "Pa", "shear stress", excess),
        "stress_tt": (tt, "Pa", "hoop stress", excess),
        "mean_stress": ((rr + zz + tt) / 3.0, "Pa", "mean stress", excess),
        "plastic_shear_strain": (
            of_points(array(PLASTIC_STRAIN)),
            "1",
            "plastic shear strain",
            "added up since entry; engineering shear strain in pure shear",
        ),
    }
    if (launch := simulation.plan.between_steps.get("yield_share")) is not None:
        simulation.launch(launch)
        of_soil["deviatoric_stress"] = (
            of_points(array("yield.share")),
            "1",
            "shear stress over shear strength",
            "as the yield criterion measures them; 1 where soil yields",
        )
    radial, upward = node_velocity[:, :2].T.reshape(shape)
    of_grid = labelled(
        dims=("row", "column"),
        node_velocity_r=(radial, "m s-1", "radial velocity", ground),
        node_velocity_z=(upward, "m s-1", "upward velocity", ground),
    )
    return _single(labelled(dims=("point",), role=None, **of_soil) | of_grid)


def _single(variables: Variables) -> dict[str, xr.Variable]:
    return {name: values.astype(np.float32) for name, values in variables.items()}
