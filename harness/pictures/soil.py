"""Pictures of the soil around a penetrometer, from the snapshots of a case.

fields = xr.open_dataset("results/STUDY/cases/KEY.fields.nc")
sections_figure(fields).savefig("sections.png")
"""

import shutil
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import xarray as xr
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from numpy.typing import NDArray

from harness.archive.atomic_files import write_whole
from harness.pictures.drawing.plot_parts import series_colour

Floats = NDArray[np.floating]


class NodalValues:
    """What the points of one snapshot carry, averaged to the nodes of their grid.

        f_i = sum over points N_i f / sum over points N_i        N_i the shape function of node i

    A section of nodal values covers all soil, up to the surface and to the axis, where points leave
    gaps; it shows nothing smaller than a cell, as the simulation does.

    Args:
        snapshot: one of the snapshots of a case: without the dim `penetration`.

    Attributes:
        r, z: positions of the nodes [m], shape [row, column].
    """

    def __init__(self, snapshot: xr.Dataset) -> None:
        self.r = snapshot["node_r"].values.astype(float)
        self.z = snapshot["node_z"].values.astype(float)
        r, z = (snapshot[name].values.astype(float) for name in ("point_r", "point_z"))
        self._present = np.isfinite(r)
        self._nodes, self._weights = self._shape_functions(r[self._present], z[self._present])
        self._sum = self._added(np.ones(int(self._present.sum())))

    def of(self, values: Floats) -> Floats:
        """Values of the points at the nodes, [row, column]; not a number where no point is near."""
        with np.errstate(invalid="ignore"):
            averages: Floats = self._added(values[self._present]) / self._sum
        return averages

    def _added(self, values: Floats) -> Floats:
        weighted = (self._weights * values).ravel()
        sums = np.bincount(self._nodes.ravel(), weighted, self.r.size)
        return sums.reshape(self.r.shape).astype(np.float64, copy=False)

    def _shape_functions(self, r: Floats, z: Floats) -> tuple[NDArray[np.integer], Floats]:
        """The four nodes around each point, and their shape functions there: [4, point_count]."""
        rows, surface, outer = self.z[:, 0], self.r[:, 0], self.r[0, -1]
        columns = (self.r[0] - surface[0]) / (outer - surface[0])
        row, eta = _interval(rows, z)
        inner = surface[row] + eta * (surface[row + 1] - surface[row])
        column, xi = _interval(columns, (r - inner) / (outer - inner))
        first = row * self.r.shape[1] + column
        upper = first + self.r.shape[1]
        nodes = np.stack([first, first + 1, upper, upper + 1])
        weights = [(1 - xi) * (1 - eta), xi * (1 - eta), (1 - xi) * eta, xi * eta]
        return nodes, np.stack(weights)


def _interval(edges: Floats, values: Floats) -> tuple[NDArray[np.integer], Floats]:
    """In which interval between rising edges each value is, and how far in it, 0 to 1."""
    interval = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, len(edges) - 2)
    within: Floats = (values - edges[interval]) / np.diff(edges)[interval]
    return interval, np.clip(within, 0.0, 1.0)


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
    """Draw the sections of the snapshot nearest to a penetration [cone radii] into a figure."""
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
    surface_r, surface_z = (snapshot[f"surface_{axis}"].values / radius for axis in "rz")
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


MOST_CURVES = 6
"""Snapshots that are drawn, the last among them."""


def traction_figure(fields: xr.Dataset) -> Figure:
    """Normal and shear traction over the distance along the surface, a curve a snapshot.

    Raises:
        KeyError: the dataset has no snapshots of a cone test.
    """
    figure = Figure(figsize=(7.2, 5.6), dpi=150, layout="constrained")
    normal, shear = figure.subplots(2, 1, sharex=True)
    radius = fields.cone_radius.item()
    distance = _distance(fields) / radius
    parts = {part: fields.surface_part.values == part for part in ("face", "shaft")}
    shoulder = float(distance[parts["face"]].max())
    count = fields.sizes["penetration"]
    chosen = np.unique(np.linspace(0, count - 1, min(count, MOST_CURVES)).round().astype(int))
    for place, number in enumerate(chosen):
        snapshot = fields.isel(penetration=number)
        colour = series_colour(place, len(chosen))
        style = {"color": colour, "lw": 0.8 + 0.8 * (number == count - 1)}
        label = f"{snapshot.penetration.item():g} R"
        for axes, name in ((normal, "normal_traction"), (shear, "shear_traction")):
            traction = snapshot[name].values / fields.undrained_shear_strength.item()
            for part, there in parts.items():
                shown = label if part == "face" else None
                axes.plot(distance[there], traction[there], label=shown, **style)
    for axes, text in ((normal, "normal traction / su [-]"), (shear, "shear traction / su [-]")):
        axes.axvline(shoulder, color="0.5", lw=0.8, ls="--")
        axes.axhline(0.0, color="0.5", lw=0.5)
        axes.set_ylabel(text)
        axes.spines[["top", "right"]].set_visible(False)
    for x, text in ((0.5 * shoulder, "face"), (1.15 * shoulder, "shaft")):
        where = normal.get_xaxis_transform()
        normal.text(x, 1.0, text, transform=where, ha="left" if x > shoulder else "center")
    shear.set_xlabel("distance along the surface from the tip / R [-]")
    shear.set_xlim(0.0, float(distance.max()))
    normal.legend(title="penetration", fontsize=8, title_fontsize=8, frameon=False)
    figure.suptitle(caption(fields.isel(penetration=-1)), x=0.01, ha="left", fontsize=8)
    return figure


def _distance(fields: xr.Dataset) -> Floats:
    """The distance along the surface from the tip to each of its nodes [m]."""
    steps = np.hypot(np.diff(fields.surface_r.values), np.diff(fields.surface_z.values))
    distance: Floats = np.concatenate([[0.0], np.cumsum(steps)])
    return distance


FRAMES_PER_SECOND = 2
RESOLUTION = 80
"""Pixels of a frame per inch; of a tenth of an inch an even number, as MP4 needs."""


def write_animation(fields: xr.Dataset, path: Path) -> list[Path]:
    """Write the film as a GIF, and as an MP4 beside it where `ffmpeg` is installed.

    `path` is that of the GIF.

    Returns:
        The files, each written whole or not at all.

    Raises:
        ArchiveError: one cannot be written.
    """
    writers: dict[Path, AbstractMovieWriter] = {path: PillowWriter(fps=FRAMES_PER_SECOND)}
    if shutil.which("ffmpeg") is not None:
        writers[path.with_suffix(".mp4")] = FFMpegWriter(
            fps=FRAMES_PER_SECOND, extra_args=["-pix_fmt", "yuv420p"]
        )
    for file, writer in writers.items():
        write_whole(_film(fields, writer, file.suffix), file)
    return list(writers)


def _film(fields: xr.Dataset, writer: AbstractMovieWriter, ending: str) -> bytes:
    figure = Figure(figsize=frame(fields), dpi=RESOLUTION, layout="constrained")
    norms = scales(fields)
    # Matplotlib and ffmpeg write to files alone.
    with tempfile.TemporaryDirectory(prefix="harness-film-") as folder:
        film = Path(folder) / f"film{ending}"
        with writer.saving(figure, str(film), RESOLUTION):
            for penetration in fields["penetration"].values.tolist():
                figure.clear()
                draw_sections(figure, fields, penetration, norms)
                writer.grab_frame()
        return film.read_bytes()
