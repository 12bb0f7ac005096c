"""Single precision: half the memory."""

import dataclasses

from mpm_warp.planning import make_plan
from mpm_warp.scene import Scene


def test_single_precision_halves_every_array_of_real_numbers(cone: Scene) -> None:
    single = make_plan(dataclasses.replace(cone, precision="float32")).arrays
    double = make_plan(cone).arrays
    same = {"particle.cell", "layer.cell", "layer.slots", "window.motion", "yield.particle"}
    same |= {"fixed.nodes", "contact.nodes", "far_field.nodes"}
    assert same <= set(double)
    for name, array in double.items():
        half = 1 if name in same else 2
        assert array.byte_count == half * single[name].byte_count, name
