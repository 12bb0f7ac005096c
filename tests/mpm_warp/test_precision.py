"""Single precision: half the memory."""

from __future__ import annotations

import dataclasses

from mpm_warp.planning import make_plan
from mpm_warp.scenes.cone_penetration import ConePenetration

CONE = ConePenetration(cells_per_radius=4, domain_radius=10, domain_above=4, domain_below=4)


def test_single_precision_halves_every_array_of_real_numbers() -> None:
    single = make_plan(dataclasses.replace(CONE, precision="float32").build()[0]).arrays
    double = make_plan(CONE.build()[0]).arrays
    same = {"particle.cell", "layer.cell", "layer.places", "window.motion"}
    same |= {"fixed.nodes", "contact.nodes", "far_field.nodes"}
    for name, array in double.items():
        half = 1 if name in same else 2
        assert array.byte_count == half * single[name].byte_count, name
