"""The sections of all snapshots one after the other, as a film."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

import xarray as xr
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter, PillowWriter
from matplotlib.figure import Figure

from harness.archive.atomic_files import write_whole
from harness.pictures.fields.sections import draw_sections, frame, scales

FRAMES_PER_SECOND = 2
RESOLUTION = 80
"""Pixels of a frame per inch; of a tenth of an inch an even number, as MP4 needs."""


def write_animation(fields: xr.Dataset, path: Path) -> list[Path]:
    """Write the film as a GIF, and as an MP4 beside it where `ffmpeg` is installed.

    Args:
        fields: the snapshots of a case.
        path: of the GIF; the MP4 has the ending `.mp4` instead.

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
