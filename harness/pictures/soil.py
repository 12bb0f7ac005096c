"""Pictures of the soil around a penetrometer, from the snapshots of a case.

fields = xr.open_dataset("results/STUDY/cases/KEY.fields.nc")
sections_figure(fields).savefig("sections.png")
"""

import functools
import math
import shutil
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
import xarray as xr
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.patheffects import withStroke
from matplotlib.ticker import MaxNLocator

from harness.archive.atomic_files import write_whole
from harness.archive.nodal_values import NodalValues
from harness.pictures.drawing.caption import caption
from harness.pictures.drawing.plot_parts import series
from harness.pictures.drawing.style import BOLD, GREY, INK, PAGE, PALE, PAPER, STYLED, TALL
from mpm_warp.grid.fitted import Floats, nodal_areas

BESIDE, BELOW, ABOVE = 6.0, 6.0, 9.0
"""Extent of the soil that is shown beside the axis, below and above the tip, in cone radii."""
MARGIN = 1.1
"""Ratio of the shown extent to that of a zone that is shown as a whole."""
COLUMNS = 3
"""Number of sections side by side."""
YIELDS = 0.9999
"""Ratio of shear stress to strength above which soil is shown as yielding; single precision."""
LEAST_PLASTIC_STRAIN = 0.01
"""Lowest value of the scale of plastic shear strain; elastic soil has its colour."""


class _Quantity(NamedTuple):
    """The quantity that one section shows."""

    label: str  # name and unit, for the colour bar
    colours: str  # a colour map of monotonic brightness, for print in grey
    values: Callable[[xr.Dataset], Floats]  # of all points of a snapshot; dimensionless
    norm: Callable[[float], Normalize] = functools.partial(Normalize, 0.0)  # by the greatest value
    lines: int | Sequence[float] = 5  # values of contour lines, or their number
    whole: float = math.inf  # all soil with at least this value is shown


def _magnitude(snapshot: xr.Dataset, vector: str) -> Floats:
    magnitude: Floats = np.hypot(*(snapshot[f"{vector}_{axis}"].values for axis in "rz"))
    return magnitude


QUANTITIES = (
    _Quantity(
        "displacement / R [-]",
        "viridis",
        lambda it: _magnitude(it, "displacement") / it.cone_radius.item(),
        lines=(0.1, 0.2, 0.5, 1.0, 2.0),
    ),
    _Quantity(
        "plastic shear strain [-]",
        "magma_r",
        lambda it: np.maximum(it.plastic_shear_strain.values, LEAST_PLASTIC_STRAIN),
        lambda greatest: LogNorm(LEAST_PLASTIC_STRAIN, max(1.0, greatest)),
        lines=(0.1, 1.0),
    ),
    _Quantity(
        "increase of mean pressure / su [-]",
        "cividis",
        lambda it: -it.mean_stress.values / it.undrained_shear_strength.item(),
    ),
    _Quantity(
        "velocity / penetration speed [-]",
        "viridis",
        lambda it: _magnitude(it, "velocity") / it.speed.item(),
        lambda greatest: Normalize(0.0, 1.0),
        lines=(0.02, 0.1, 0.5),
    ),
    _Quantity(
        "yielding zone: share of points [-]",
        "Greys",
        lambda it: (it.deviatoric_stress.values >= YIELDS).astype(float),
        lambda greatest: Normalize(0.0, 1.0),
        lines=(0.5,),
        whole=0.5,
    ),
)
ROWS = math.ceil(len(QUANTITIES) / COLUMNS)


class _Sections:
    """The sections of all snapshots of a case, with common scales of colours."""

    def __init__(self, fields: xr.Dataset) -> None:
        radius = fields.cone_radius.item()
        count = fields.sizes["penetration"]
        self._snapshots = [fields.isel(penetration=number) for number in range(count)]
        nodal = [NodalValues(snapshot) for snapshot in self._snapshots]
        self._r = np.stack([nodes.r for nodes in nodal]) / radius
        self._z = np.stack([nodes.z for nodes in nodal]) / radius
        # For each quantity: values, colours, and the enlargement of the shown extent.
        self._shown = []
        for quantity in QUANTITIES:
            pairs = zip(nodal, self._snapshots, strict=True)
            values = np.stack([nodes.of(quantity.values(snapshot)) for nodes, snapshot in pairs])
            inside = values >= quantity.whole
            r, z = self._r[inside], self._z[inside]
            reach = np.max([r / BESIDE, -z / BELOW, z / ABOVE], initial=1.0 / MARGIN)
            norm = quantity.norm(float(np.nanmax(values)))
            self._shown.append((values, norm, MARGIN * float(reach)))
        beside = min(BESIDE, float(fields.node_r.max()) / radius)
        below = min(BELOW, -float(fields.node_z.min()) / radius)
        above = min(ABOVE, float(fields.node_z.max()) / radius)
        height = 0.4 * (below + above) / beside * PAGE / COLUMNS + 1.1
        self.height = round(ROWS * height + 0.5, 1)  # of the figure [inch]

    def draw(self, figure: Figure, number: int) -> None:
        """Draw the sections of one snapshot into an empty figure."""
        panels = figure.subplots(ROWS, COLUMNS)
        for axes in panels.flat[len(QUANTITIES) :]:
            axes.remove()
        for place, axes in enumerate(panels.flat[: len(QUANTITIES)]):
            self._draw_one(axes, number, place)
        for axes in panels[:, 0]:
            axes.set_ylabel("height above the tip / R [-]")
        note = "Displacement and plastic strain are since the soil entered the window."
        caption(figure, f"{_said(self._snapshots[number])}. {note}")

    def _draw_one(self, axes: Axes, number: int, place: int) -> None:
        quantity, (all_values, norm, scale) = QUANTITIES[place], self._shown[place]
        r, z, values = self._r[number], self._z[number], all_values[number]
        known = np.ma.masked_invalid(values)
        for x in (-r, r):
            image = axes.pcolormesh(
                x, z, known, shading="gouraud", cmap=quantity.colours, norm=norm, rasterized=True
            )
            lines = axes.contour(x, z, values, quantity.lines, colors=GREY)
        axes.set(xlim=(-BESIDE * scale, BESIDE * scale), ylim=(-BELOW * scale, ABOVE * scale))
        for label in axes.clabel(lines, fmt="%g", colors=INK):
            label.set_path_effects([withStroke(linewidth=BOLD, foreground=PAPER)])
        snapshot = self._snapshots[number]
        radius = snapshot.cone_radius.item()
        right, height = (snapshot[f"surface_{axis}"].values / radius for axis in "rz")
        outline = np.stack([[*-right[::-1], *right], [*height[::-1], *height]], axis=-1)
        axes.add_patch(Polygon(outline, facecolor=PALE, edgecolor=INK, zorder=3))
        axes.xaxis.set_major_locator(MaxNLocator(5, integer=True, symmetric=True))
        axes.set_aspect("equal")
        axes.grid(visible=False)
        axes.set_xlabel("radius / R [-]")
        bar = axes.figure.colorbar(image, ax=axes, orientation="horizontal", pad=0.02)
        bar.set_label(quantity.label)


@STYLED
def sections_figure(fields: xr.Dataset, penetration: float | None = None) -> Figure:
    """Sections of the snapshot nearest to a penetration in cone radii, by default of the last.

    All snapshots of a case have the same scales of colours.
    """
    sections, number = _Sections(fields), -1
    if penetration is not None:
        (number,) = fields.indexes["penetration"].get_indexer([penetration], method="nearest")
    figure = Figure(figsize=(PAGE, sections.height))
    sections.draw(figure, number)
    return figure


def _said(snapshot: xr.Dataset) -> str:
    """Penetration and resistance of a snapshot, and the main parameters of its case."""
    it = {name: snapshot[name].item() for name in snapshot.variables if not snapshot[name].ndim}
    strength = it["undrained_shear_strength"]
    return (
        f"Penetration {it['penetration']:g} R, net resistance {it['resistance'] / strength:.2f} su "
        f"(R {1e3 * it['cone_radius']:.4g} mm, su {1e-3 * strength:.4g} kPa), "
        f"Ir = {it['rigidity_index']:g}, adhesion factor {it['adhesion_factor']:g}, "
        f"{it['material'].replace('_', ' ')}, apex {it['apex_angle']:g}°, "
        f"{it['cells_per_radius']:g} cells per radius"
    )


AT_TIP = (
    "The first two nodes have their mean normal traction. The node of the tip also bears the soil "
    "ahead of it, so that its force over its own small area would be too large."
)
MOST_CURVES = 6
"""Largest number of snapshots that are drawn; the last one is among them."""


@STYLED
def traction_figure(fields: xr.Dataset) -> Figure:
    """Normal and shear traction over the distance along the surface, a curve for each snapshot.

    The first two nodes have their mean normal traction; at the tip shear has no direction.
    """
    figure = Figure()
    figure.set_figheight(TALL)
    normal, shear = figure.subplots(2, 1, sharex=True)
    radius = fields.cone_radius.item()
    steps = np.hypot(np.diff(fields.surface_r.values), np.diff(fields.surface_z.values))
    distance = np.cumsum([0.0, *steps]) / radius
    around_tip = nodal_areas(fields.surface_r.values, steps)[:2]
    parts = [fields.surface_part.values == part for part in ("face", "shaft")]
    shoulder, last = float(distance[parts[0]].max()), fields.sizes["penetration"] - 1
    for axes, kind in ((normal, "normal"), (shear, "shear")):
        for number, line in series(range(last, -1, -1), MOST_CURVES):
            snapshot = fields.isel(penetration=number)
            traction = snapshot[f"{kind}_traction"].values / fields.undrained_shear_strength.item()
            if kind == "shear":
                traction[0] = np.nan
            else:
                traction[:2] = np.average(traction[:2], weights=around_tip)
            label = f"{snapshot.penetration.item():g} R"
            for part, named in zip(parts, (label, None), strict=True):
                axes.plot(distance[part], traction[part], **line.line, label=named)
        axes.axvline(shoulder, color=GREY)
        axes.axhline(0.0, color=GREY)
        axes.set_ylabel(f"{kind} traction / su [-]")
    for x, text in ((0.5 * shoulder, "face"), (1.15 * shoulder, "shaft")):
        where = normal.get_xaxis_transform()
        normal.text(x, 1.0, text, transform=where, ha="left" if x > shoulder else "center")
    shear.set_xlabel("distance along the surface from the tip / R [-]")
    shear.set_xlim(0.0, float(distance.max()))
    normal.legend(title="penetration")
    caption(figure, f"{_said(fields.isel(penetration=-1))}. {AT_TIP}")
    return figure


FRAMES_PER_SECOND = 2


@STYLED
def write_animation(fields: xr.Dataset, path: Path) -> list[Path]:
    """Write the film as GIF, and as MP4 too if `ffmpeg` is installed; return the files."""
    writers: dict[Path, AbstractMovieWriter] = {path: PillowWriter(fps=FRAMES_PER_SECOND)}
    if shutil.which("ffmpeg") is not None:
        writers[path.with_suffix(".mp4")] = FFMpegWriter(
            fps=FRAMES_PER_SECOND, extra_args=["-pix_fmt", "yuv420p"]
        )
    sections = _Sections(fields)
    figure = Figure(figsize=(PAGE, sections.height))
    for file, writer in writers.items():
        # Matplotlib and ffmpeg can only write to files.
        with tempfile.TemporaryDirectory(prefix="harness-film-") as folder:
            film = Path(folder) / f"film{file.suffix}"
            with writer.saving(figure, str(film), figure.dpi):
                for number in range(fields.sizes["penetration"]):
                    figure.clear()
                    sections.draw(figure, number)
                    writer.grab_frame()
            write_whole(film.read_bytes(), file)
    return list(writers)
