"""What a steady run would leave behind, at once; the law of u2 over a radial stress."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from mpm_warp.scenes.cone.cone_penetration import ConePenetration
from mpm_warp.uncertainty.shoulder import RADIAL_FACTOR, shoulder_pressure
from mpm_warp.uncertainty.tables import Value

STUDIES = Path(__file__).parents[3] / "studies"


def readings(name: str) -> list[dict[str, str]]:
    """The rows of a table in `studies`, without the comments that say how they were measured."""
    with (STUDIES / f"{name}.csv").open() as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def steady_run(test: ConePenetration, factor: float, *, rise: float = 0.0) -> xr.Dataset:
    """Of a cone test, of a cone factor; its mean over two radii has risen so much, in su."""
    resistance = factor * np.ones(60)
    resistance[:-20] -= rise
    return xr.Dataset(
        {
            "penetration_resistance": ("penetration", test.undrained_shear_strength * resistance),
            "cone_factor_simulated": factor,
            "cone_factor_shear": 0.0,
            RADIAL_FACTOR: 4.0,
            "penetration_reached": test.penetration,
        }
    )


def radial_error(factor: Value, *, inertia: Value = 0.0, **of_cone: Any) -> tuple[Value, Value]:
    """What makes a radial stress u2, and its half width: nu 0.47, and slow if nothing is said."""
    of_cone = {"poissons_ratio": 0.47} | of_cone
    pressure, half_width = shoulder_pressure(factor, inertia=inertia, **of_cone)
    return pressure - factor, half_width
