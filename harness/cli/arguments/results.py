"""Commands on results of studies: their options."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from harness.cli.arguments.values import finite_number, html_file, share

if TYPE_CHECKING:
    from harness.cli.arguments.parser import Commands


def add_results(commands: Commands) -> None:
    """The commands that take results of studies."""
    references = commands.add_parser("references", help="list what results are compared with")
    references.add_argument(
        "id", nargs="?", metavar="ID", help="name of one reference or band; default: all"
    )

    compare = commands.add_parser(
        "compare", help="compare a result with references, or with another result"
    )
    compare.add_argument("file", type=Path, metavar="FILE", help="result of a study, netCDF")
    compare.add_argument(
        "other", type=Path, nargs="?", metavar="OTHER", help="a result to set beside it"
    )
    compare.add_argument(
        "--tolerance",
        type=finite_number("a number >= 0", lambda it: it >= 0),
        metavar="X",
        help="largest relative difference allowed between FILE and OTHER; default: 0",
    )

    plot = commands.add_parser("plot", help="draw the pictures of a result")
    plot.add_argument("file", type=Path, metavar="FILE", help="result of a study, netCDF")
    plot.add_argument("--out", type=Path, metavar="DIR", help="default: the folder of FILE")
    plot.add_argument(
        "--format",
        nargs="+",
        choices=("png", "pdf", "svg"),
        default=["png"],
        metavar="FORMAT",
        help="png, the default, pdf or svg; several are allowed",
    )

    view = commands.add_parser("view", help="draw the soil of a case around its penetrometer")
    view.add_argument("file", type=Path, metavar="FILE", help="result of a study, or of a case")
    view.add_argument("case", nargs="?", metavar="CASE", help="its key, where FILE has many")
    view.add_argument("--out", type=Path, metavar="DIR", help="default: the folder of FILE")
    view.add_argument(
        "--vtk", action="store_true", help="write points, grid and surface for ParaView too"
    )

    report = commands.add_parser("report", help="write one page of HTML on results")
    report.add_argument("file", type=Path, nargs="+", metavar="FILE", help="result of a study")
    report.add_argument(
        "-o",
        "--out",
        type=html_file,
        default=Path("report.html"),
        metavar="HTML",
        help="default: report.html",
    )

    recommend = commands.add_parser("recommend", help="name the cheapest settings for an error")
    recommend.add_argument("scene", metavar="SCENE", help="name of a scene, as cone_penetration")
    recommend.add_argument(
        "--error",
        type=share,
        required=True,
        metavar="X",
        help="largest relative error, as 1%% or 0.01",
    )
    recommend.add_argument(
        "--results", type=Path, default=Path("results"), metavar="DIR", help="default: results"
    )
