"""Tables and results kept in this repository that a scene of another version made.

A table tells its origin in a comment, ``# scene NAME, version N: COMMAND``; where its numbers are
of several versions N is the least of them, and "and later" follows. A result tells its own. A
version rises with every change of a scene's results, be it in few cases: what is out of date need
not be wrong.

``out_of_date`` prints each file, its scene, the version behind it, the version now, and the command
that makes it again.
"""

import re
from pathlib import Path
from typing import NamedTuple

from harness.archive.netcdf_files import read_attributes
from mpm_warp import scene_class

ROOT = Path(__file__).parents[2]
ORIGIN = re.compile(r"^# scene (\w+), version (\d+)(?: and later)?: (.+)$", re.MULTILINE)
KEPT = ("studies/*.csv", "studies/*.nc", "mpm_warp/uncertainty/**/*.csv")


class Origin(NamedTuple):
    """What made a file."""

    scene: str
    version: int
    command: str


def origin_of(path: Path) -> Origin | None:
    """What made a file, none where it does not tell."""
    if path.suffix == ".nc":
        of = read_attributes(path)
        return Origin(of["scene"], int(of["scene_version"]), f"harness run {of['study']}")
    told = ORIGIN.search(path.read_text(encoding="utf-8"))
    return Origin(told[1], int(told[2]), told[3]) if told else None


def kept() -> list[Path]:
    """All files of numbers that were computed once and kept."""
    return [path for pattern in KEPT for path in sorted(ROOT.glob(pattern))]


def line(path: Path, origin: Origin | None) -> str:
    """What is told of a file; nothing where it is of the version of now."""
    name = str(path.relative_to(ROOT))
    if origin is None:
        return f"{name:50} does not tell its version"
    now = scene_class(origin.scene).version
    if origin.version == now:
        return ""
    return f"{name:50} {origin.scene} {origin.version}, now {now}: {origin.command}"


if __name__ == "__main__":
    lines = [line(path, origin_of(path)) for path in kept()]
    print(*filter(None, lines), sep="\n")
    print(f"{sum(map(bool, lines))} of {len(lines)} files")
