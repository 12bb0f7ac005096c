"""Snapshots for ParaView: points, grid and surface of each in VTK files, and a file that lists all.

Coordinates are (r, 0, z), so that z points up; all units are SI. The files are written by PyVista,
an optional dependency that uses the library VTK, as ParaView does.
"""

import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from harness.archive.atomic_files import prepare, write_whole
from harness.archive.nodal_values import NodalValues
from harness.errors import HarnessError
from mpm_warp.grid.fitted import Floats

VECTORS = ("displacement", "velocity")
PARTS = ("points", "grid", "surface")
OF_CASE = ("cone_radius", "undrained_shear_strength", "apex_angle", "resistance", "penetration")
"""Numbers that every surface has, so that its traction can be integrated."""


def write_vtk(fields: xr.Dataset, folder: Path, name: str) -> list[Path]:
    """Write the snapshots of a case: ``NAME.pvd``, which lists the files in ``NAME_vtk/``.

    Points have their variables in the snapshots; nodes of the grid have averages of these, and
    their own velocities. Between the nodes of the surface the traction is linear.
    """
    subfolder = folder / f"{name}_vtk"
    prepare(subfolder)
    about = {"type": "Collection", "version": "1.0", "byte_order": "LittleEndian"}
    series = ET.Element("VTKFile", about)
    collection = ET.SubElement(series, "Collection")
    written = []
    for number, penetration in enumerate(fields["penetration"].values.tolist()):
        meshes = _meshes(fields.isel(penetration=number))
        for part, (kind, mesh) in enumerate(zip(PARTS, meshes, strict=True)):
            path = subfolder / f"{kind}_{number:03}.vtu"
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
    variables = {
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
    values = {name: values[present] for name, values in variables.items()}
    points = mesh(pv.CellType.VERTEX, np.arange(len(r))[:, None], r, z, values)

    nodal = NodalValues(snapshot)
    node = np.arange(nodal.r.size).reshape(nodal.r.shape)
    corners = node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]
    cells = np.stack([corner.ravel() for corner in corners], axis=-1)
    values = {name: nodal.of(values).ravel() for name, values in variables.items()}
    for axis in "rz":
        values[f"velocity_{axis}"] = snapshot[f"node_velocity_{axis}"].values.ravel()
    grid = mesh(pv.CellType.QUAD, cells, nodal.r, nodal.z, values)

    r, z = (snapshot[f"surface_{axis}"].values for axis in "rz")
    part = snapshot.surface_part.values
    # No line connects the last node of the face and the first of the shaft, which coincide.
    first = np.flatnonzero(part[1:] == part[:-1])
    values = {name: snapshot[name].values for name in ("normal_traction", "shear_traction")}
    values["on_shaft"] = (part == "shaft").astype(np.uint8)
    surface = mesh(pv.CellType.LINE, np.stack([first, first + 1], axis=-1), r, z, values)
    for name in OF_CASE:
        surface.field_data[name] = np.array([snapshot[name].item()])
    return points, grid, surface


def _in_space(r: Floats, z: Floats) -> Floats:
    """Vectors (r, 0, z), shape [count, 3]."""
    vectors: Floats = np.stack([r.ravel(), np.zeros(r.size), z.ravel()], axis=-1)
    return vectors


def _content(mesh: Any) -> bytes:
    """The file of a mesh, made in memory: where a disk is full, VTK ends the process."""
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridWriter  # comes with PyVista

    writer = vtkXMLUnstructuredGridWriter()
    writer.SetDataModeToBinary()
    writer.WriteToOutputStringOn()
    writer.SetInputData(mesh)
    writer.Write()
    content: str = writer.GetOutputString()
    return content.encode()
