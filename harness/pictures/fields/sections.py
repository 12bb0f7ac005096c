"""Mirrored sections of the soil around a penetrometer: what it has done to the soil, side by side.

fields = xr.open_dataset("results/STUDY/cases/KEY.fields.nc")
sections_figure(fields).savefig("sections.png")
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from harness.pictures.fields.nodal_values import Floats, NodalValues

BESIDE, BELOW, ABOVE = 6.0, 6.0, 9.0
"""What is shown of the soil: beside the axis, below the tip and above it, in cone radii."""
WIDTH = 13.0
"""Of a figure [inch]."""
YIELDS = 0.9999
"""Shear stress over shear strength from which on soil yields; it is stored in single precision."""
LEAST_PLASTIC_STRAIN = 0.01
"""Where the scale of the plastic shear strain begins: what is elastic has the same colour."""


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """What one section shows.

    Attributes:
        label: name and unit, for the colour bar.
        values: of a snapshot, in each slot of points; without dimension.
        colours: name of a colour map whose brightness rises or falls all along, for print in grey.
        norm: colour scale of a greatest value.
        lines: values of contour lines, or how many of them.
    """

    label: str
    values: Callable[[xr.Dataset], Floats]
    colours: str
    norm: Callable[[float], Normalize]
    lines: int | Sequence[float] = 5


def _magnitude(snapshot: xr.Dataset, vector: str) -> Floats:
    magnitude: Floats = np.hypot(snapshot[f"{vector}_r"].values, snapshot[f"{vector}_z"].values)
    return magnitude


def _from_zero(greatest: float) -> Normalize:
    return Normalize(0.0, greatest)


QUANTITIES = (
    Quantity(
        label="displacement / R [-]",
        values=lambda it: _magnitude(it, "displacement") / it.cone_radius.item(),
        colours="viridis",
        norm=_from_zero,
        lines=(0.1, 0.2, 0.5, 1.0, 2.0),
    ),
    Quantity(
        label="plastic shear strain [-]",
        values=lambda it: np.maximum(it.plastic_shear_strain.values, LEAST_PLASTIC_STRAIN),
        colours="magma_r",
        norm=lambda greatest: LogNorm(LEAST_PLASTIC_STRAIN, max(1.0, greatest)),
        lines=(0.1, 1.0),
    ),
    Quantity(
        label="increase of mean pressure / su [-]",
        values=lambda it: -it.mean_stress.values / it.undrained_shear_strength.item(),
        colours="cividis",
        norm=_from_zero,
    ),
    Quantity(
        label="velocity / penetration speed [-]",
        values=lambda it: _magnitude(it, "velocity") / it.speed.item(),
        colours="viridis",
        norm=lambda greatest: Normalize(0.0, 1.0),
        lines=(0.02, 0.05, 0.1, 0.2, 0.5),
    ),
    Quantity(
        label="yielding zone: share of points [-]",
        values=lambda it: (it.deviatoric_stress.values >= YIELDS).astype(float),
        colours="Greys",
        norm=lambda greatest: Normalize(0.0, 1.0),
        lines=(0.5,),
    ),
)


def sections_figure(fields: xr.Dataset, penetration: float | None = None) -> Figure:
    """The sections of one snapshot; colours mean the same in those of all snapshots of a case.

    Args:
        fields: the snapshots of a case.
        penetration: over the cone radius; the nearest snapshot is drawn. Default: the last one.

    Raises:
        KeyError: the dataset has no snapshots of a cone test.
    """
    figure = Figure(figsize=frame(fields), dpi=150, layout="constrained")
    last = float(fields["penetration"][-1])
    draw_sections(figure, fields, last if penetration is None else penetration, scales(fields))
    return figure


def frame(fields: xr.Dataset) -> tuple[float, float]:
    """Width and height of a figure that its sections fill [inch]."""
    radius = fields.cone_radius.item()
    beside = min(BESIDE, float(fields.node_r.max()) / radius)
    below = min(BELOW, -float(fields.node_z.min()) / radius)
    above = min(ABOVE, float(fields.node_z.max()) / radius)
    return WIDTH, round(0.5 * (below + above) / beside * WIDTH / len(QUANTITIES) + 1.3, 1)


def scales(fields: xr.Dataset) -> list[Normalize]:
    """The colour scale of each quantity, up to its greatest nodal value over all snapshots."""
    greatest = [0.0] * len(QUANTITIES)
    for number in range(fields.sizes["penetration"]):
        snapshot = fields.isel(penetration=number)
        nodal = NodalValues(snapshot)
        for place, quantity in enumerate(QUANTITIES):
            here = float(np.nanmax(nodal.of(quantity.values(snapshot))))
            greatest[place] = max(greatest[place], here)
    return [it.norm(value) for it, value in zip(QUANTITIES, greatest, strict=True)]


def draw_sections(
    figure: Figure, fields: xr.Dataset, penetration: float, norms: Sequence[Normalize]
) -> None:
    """Draw the sections of the snapshot nearest to a penetration into an empty figure.

    Args:
        figure: where they are drawn.
        fields: the snapshots of a case.
        penetration: over the cone radius.
        norms: the colour scales, see `scales`.
    """
    snapshot = fields.sel(penetration=penetration, method="nearest")
    nodal = NodalValues(snapshot)
    all_axes = figure.subplots(1, len(QUANTITIES), sharex=True, sharey=True)
    for axes, quantity, norm in zip(all_axes, QUANTITIES, norms, strict=True):
        _draw(axes, quantity, norm, snapshot, nodal)
    all_axes[0].set_ylabel("height above the tip / R [-]")
    since = "displacement and plastic strain since the soil entered the window"
    figure.suptitle(f"{caption(snapshot)}; {since}", x=0.01, ha="left", fontsize=9)


def caption(snapshot: xr.Dataset) -> str:
    """What is shown: penetration and resistance of a snapshot, and what makes its case."""
    resistance = snapshot.resistance.item() / snapshot.undrained_shear_strength.item()
    return (
        f"penetration {snapshot.penetration.item():g} R, net resistance {resistance:.2f} su "
        f"(R {1e3 * snapshot.cone_radius.item():.4g} mm, su "
        f"{1e-3 * snapshot.undrained_shear_strength.item():.4g} kPa)\n"
        f"Ir = {snapshot.rigidity_index.item():g}, adhesion factor "
        f"{snapshot.adhesion_factor.item():g}, {snapshot.material.item().replace('_', ' ')}, "
        f"apex {snapshot.apex_angle.item():g}°, {snapshot.cells_per_radius.item():g} cells per "
        "radius"
    )


def _draw(
    axes: Axes, quantity: Quantity, norm: Normalize, snapshot: xr.Dataset, nodal: NodalValues
) -> None:
    radius = snapshot.cone_radius.item()
    values, r, z = nodal.of(quantity.values(snapshot)), nodal.r / radius, nodal.z / radius
    for side in (-1.0, 1.0):
        image = axes.pcolormesh(
            side * r,
            z,
            np.ma.masked_invalid(values),
            shading="gouraud",
            cmap=quantity.colours,
            norm=norm,
            rasterized=True,
        )
        lines = axes.contour(
            side * r, z, values, levels=quantity.lines, colors="0.5", linewidths=0.5
        )
    axes.clabel(lines, fmt="%g", fontsize=6, colors="0.5")
    surface_r, surface_z = (snapshot[f"surface_{it}"].values / radius for it in "rz")
    outline = np.concatenate(
        [np.stack([-surface_r[::-1], surface_z[::-1]]), [surface_r, surface_z]], axis=1
    )
    axes.add_patch(Polygon(outline.T, facecolor="0.85", edgecolor="black", lw=0.8, zorder=3))
    axes.set_xticks(np.arange(-6, 7, 3))
    axes.set_xlim(-min(BESIDE, r.max()), min(BESIDE, r.max()))
    axes.set_ylim(max(-BELOW, z.min()), min(ABOVE, z.max()))
    axes.set_aspect("equal")
    axes.set_xlabel("radius / R [-]")
    figure = axes.get_figure()
    assert isinstance(figure, Figure)
    figure.colorbar(image, ax=axes, orientation="horizontal", label=quantity.label, pad=0.02)
