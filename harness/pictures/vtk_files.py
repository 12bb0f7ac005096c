"""Snapshots for ParaView: points, grid and surface of each in VTK files, and one that lists all.

Coordinates are (r, 0, z), so that z points up; all units are SI. Pyvista writes the files, an
optional dependency: it stands on VTK itself, which ParaView reads with.
"""

import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from harness.archive.atomic_files import prepare, write_whole
from harness.errors import HarnessError
from harness.pictures.soil import NodalValues
from mpm_warp.grid.fitted import Floats

VECTORS = ("displacement", "velocity")
PARTS = ("points", "grid", "surface")
OF_CASE = ("cone_radius", "undrained_shear_strength", "apex_angle", "resistance", "penetration")
"""Numbers that stand with every surface, by which its traction can be integrated."""


def write_vtk(fields: xr.Dataset, folder: Path, name: str) -> list[Path]:
    """Write the snapshots of a case: ``NAME.pvd``, which lists the files in ``NAME_vtk/``.

    Points carry what they carry in the snapshots; the nodes of the grid have averages of it, and
    their own velocities. Between the nodes of the surface the traction is linear.
    """
    beside = folder / f"{name}_vtk"
    prepare(beside)
    about = {"type": "Collection", "version": "1.0", "byte_order": "LittleEndian"}
    series = ET.Element("VTKFile", about)
    collection = ET.SubElement(series, "Collection")
    written = []
    for number, penetration in enumerate(fields["penetration"].values.tolist()):
        meshes = _meshes(fields.isel(penetration=number))
        for part, (kind, mesh) in enumerate(zip(PARTS, meshes, strict=True)):
            path = beside / f"{kind}_{number:03}.vtu"
            write_whole(_content(mesh), path)
            written.append(path)
            where = {"timestep": f"{penetration:g}", "part": f"{part}", "name": kind}
            file = {"file": path.relative_to(folder).as_posix()}
            ET.SubElement(collection, "DataSet", where | file)
    listed = folder / f"{name}.pvd"
    write_whole(ET.tostring(series, xml_declaration=True, encoding="utf-8"), listed)
    return [listed, *written]


def _meshes(snapshot: xr.Dataset) -> tuple[Any, Any, Any]:
    try:
        import pyvista as pv
    except ModuleNotFoundError as error:
        raise HarnessError(f"--vtk: {error}: pip install 'mpm-warp[view]'") from None
    carried = {
        str(name): variable.values
        for name, variable in snapshot.data_vars.items()
        if variable.dims == ("point",)
    }

    def mesh(kind: Any, cells: np.ndarray, r: Floats, z: Floats, values: dict[str, Any]) -> Any:
        made = pv.UnstructuredGrid({kind: cells}, _in_space(r, z))
        for vector in VECTORS:
            if f"{vector}_r" in values:
                components = (values.pop(f"{vector}_{axis}") for axis in "rz")
                made.point_data[vector] = _in_space(*components)
        made.point_data.update(values)
        return made

    present = np.isfinite(snapshot.point_r.values)
    r, z = (snapshot[f"point_{axis}"].values[present] for axis in "rz")
    of_points = {name: values[present] for name, values in carried.items()}
    points = mesh(pv.CellType.VERTEX, np.arange(len(r))[:, None], r, z, of_points)

    nodal = NodalValues(snapshot)
    node = np.arange(nodal.r.size).reshape(nodal.r.shape)
    corners = node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]
    cells = np.stack([corner.ravel() for corner in corners], axis=-1)
    averages = {name: nodal.of(values).ravel() for name, values in carried.items()}
    own = {f"velocity_{axis}": snapshot[f"node_velocity_{axis}"].values.ravel() for axis in "rz"}
    grid = mesh(pv.CellType.QUAD, cells, nodal.r, nodal.z, averages | own)

    r, z = (snapshot[f"surface_{axis}"].values for axis in "rz")
    of_part = snapshot.surface_part.values
    # None leads from the shoulder of the face to that of the shaft, which are at one place.
    first = np.flatnonzero(of_part[1:] == of_part[:-1])
    tractions = {name: snapshot[name].values for name in ("normal_traction", "shear_traction")}
    of_nodes = {**tractions, "on_shaft": (of_part == "shaft").astype(np.uint8)}
    surface = mesh(pv.CellType.LINE, np.stack([first, first + 1], axis=-1), r, z, of_nodes)
    for name in OF_CASE:
        surface.field_data[name] = np.array([snapshot[name].item()])
    return points, grid, surface


def _in_space(r: Floats, z: Floats) -> Floats:
    """Vectors (r, 0, z), shape [count, 3]."""
    vectors: Floats = np.stack([r.ravel(), np.zeros(r.size), z.ravel()], axis=-1)
    return vectors


def _content(mesh: Any) -> bytes:
    """The file of a mesh, which VTK writes to a disk alone."""
    with tempfile.TemporaryDirectory(prefix="harness-vtk-") as folder:
        path = Path(folder) / "mesh.vtu"
        mesh.save(path)
        return path.read_bytes()
