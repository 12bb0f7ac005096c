"""A ground, a cone test in it whose strength is known, and its site file."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from harness.interpret.tables.factors import cone_factor
from harness.pictures.drawing.plot_parts import image
from mpm_warp.grid.fitted import Floats

DEPTH = np.arange(1.0, 12.0, 0.1)
STRENGTH = (8.0 + 1.5 * DEPTH) * 1e3
"""Of the ground of all tests here [Pa]."""
FACTOR = float(cone_factor(rigidity_index=120, adhesion_factor=0.4, stress_anisotropy=0.2)[0])
"""Of this ground, by the table."""
LAYER = """
[[layer]]
from = 2
to = 10
rigidity_index = 120
adhesion_factor = 0.4
stress_anisotropy = 0.2
rate_factor = 0
sensitivity = 1
ductility = 20
laboratory_rate = 1e-6
strength = "isotropic"
"""
SITE = """
title = "A site"
[test]
file = "test.csv"
area_ratio = 0.8
water_level = 1.0
unit_weight = 17
accuracy = { qc = 0, fs = 0, u2 = 0 }
"""


def measured_rows(depth: Floats, net: Floats, friction: Floats, share: float = 0.5) -> str:
    """A test in ground as the site file has it, by its net resistance and sleeve friction [Pa].

    `share` is Bq.
    """
    u2 = 9.81e3 * np.maximum(0.0, depth - 1.0) + share * net
    qc = net + 17e3 * depth - 0.2 * u2
    rows = zip(depth, qc / 1e6, friction / 1e3, u2 / 1e3, strict=True)
    lines = [",".join(f"{value:.9g}" for value in row) for row in rows]
    return "\n".join(["depth [m],qc [MPa],fs [kPa],u2 [kPa]", *lines]) + "\n"


def write_site(folder: Path) -> Path:
    """Write a measured test whose factor is that of the table, and its site file."""
    (folder / "test.csv").write_text(measured_rows(DEPTH, FACTOR * STRENGTH, 0.4 * STRENGTH))
    (folder / "site.toml").write_text(SITE + LAYER)
    return folder


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a measured test whose factor is that of the table, and its site file."""
    return write_site(tmp_path)


@pytest.fixture
def here(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """That folder, which a command is run in."""
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures are empty: to draw them takes longer than all else that a command does."""

    def empty(figure: Figure, form: str = "png", dpi: float | None = None) -> bytes:
        return image(Figure(), form)

    for user in ("harness.pictures.drawing.plot_parts", "harness.report.plain_pages"):
        monkeypatch.setattr(f"{user}.image", empty)


def changed(folder: Path, *changes: tuple[str, str], file: str = "site.toml") -> Path:
    """The site file, after changes of a text of a file."""
    text = (folder / file).read_text()
    for old, new in changes:
        assert text.count(old) >= 1, old
        text = text.replace(old, new, 1)
    (folder / file).write_text(text)
    return folder / "site.toml"
