"""The command `view`: the soil of a case around its penetrometer, as pictures and for ParaView."""

from __future__ import annotations

import argparse

from harness.archive.atomic_files import prepare
from harness.archive.fields_files import ENDING, find_fields, read_fields
from harness.cli.exit_codes import DONE
from harness.pictures.drawing.plot_parts import image, write_own
from harness.pictures.soil import sections_figure, traction_figure, write_animation
from harness.pictures.vtk_files import write_vtk


def view(options: argparse.Namespace) -> int:
    """Draw the sections and the traction of the last snapshot, and a film of all of them."""
    path = find_fields(options.file, options.case)
    fields = read_fields(path)
    folder = options.out or options.file.parent
    prepare(folder)
    name = path.name.removesuffix(ENDING)
    # First what may be refused: nothing is drawn where VTK files cannot be written.
    series = write_vtk(fields, folder, name)[:1] if options.vtk else []
    written = []
    for kind, figure in (("sections", sections_figure), ("traction", traction_figure)):
        written.append(folder / f"{name}_{kind}.png")
        write_own(image(figure(fields)), written[-1])
    written += write_animation(fields, folder / f"{name}_animation.gif")
    print(*written, *series, sep="\n")
    return DONE
