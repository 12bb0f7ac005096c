"""A run that diverges keeps its curves up to there, in every scene that records any."""

from typing import Any

import numpy as np
import pytest
import xarray as xr

from mpm_warp.errors import SimulationDiverged
from mpm_warp.scenes import scene_class

pytestmark = pytest.mark.slow

KEPT = 7
"""Samples before the run diverges."""
RECORDING: list[tuple[str, dict[str, Any], str]] = [
    ("cavity_cylinder", {"cells_per_radius": 2, "rigidity_index": 10.0}, "expansion"),
    ("cone_bearing", {"cells_per_radius": 4}, "displacement"),
    (
        "cone_penetration",
        {"cells_per_radius": 1.0, "penetration": 3.0, "steady_tolerance": 0.0},
        "penetration",
    ),
    ("cone_self_similar", {"cells_per_radius": 5}, "depth"),
    ("elastic_column_wave", {"cell_count": 10, "excitation": "standing_wave"}, "phase"),
    ("elastic_column_wave", {"cell_count": 10, "excitation": "sudden_load"}, "phase"),
    ("flying_block", {"step_count": 2000, "travel": 1.0}, "progress"),
    ("sliding_block", {"cells_per_length": 10}, "progress"),
    ("stretched_bar", {"stretch": 1.5}, "progress"),
]


@pytest.mark.parametrize(("name", "parameters", "axis"), RECORDING)
def test_curves_up_to_the_failure_are_those_of_the_whole_run(
    name: str, parameters: dict[str, Any], axis: str
) -> None:
    scene = scene_class(name)(**parameters)
    whole = scene.run()
    samples: list[float] = []

    def diverge(fraction: float) -> None:
        if fraction > 0.0:
            samples.append(fraction)
        if len(samples) == KEPT:
            raise SimulationDiverged("on purpose")

    with pytest.raises(SimulationDiverged) as end:
        scene.run(diverge)
    kept_curves = end.value.curves
    assert kept_curves is not None
    assert kept_curves.sizes[axis] == KEPT
    curves = [str(curve) for curve, values in whole.items() if values.dims == (axis,)]
    kept = [curve for curve in curves if curve in kept_curves]
    assert kept
    assert set(kept) == set(kept_curves.data_vars)
    for curve in kept:
        np.testing.assert_array_equal(kept_curves[curve], whole[curve][:KEPT])
        assert kept_curves[curve].attrs == whole[curve].attrs
    xr.testing.assert_identical(kept_curves[axis].variable, whole[axis][:KEPT].variable)
