"""What the top of the window takes off u2 and Nc: windows whose top holds the radial motion too.

By default the soil at the top is free to move along r. Over some ten radii below it the stress
then falls to next to nothing, where it is the same at every height in a window three times as
tall. With the radial motion held too u2 and Nc are those of a tall window, once the soil that was
above the cone at the start is out: after some 20 radii of slow travel more.

``python tests/held_top.py IR ADHESION DELTA`` prints what belongs into one line of
`studies/top_error.csv`: the case, the extent of the window above the shoulder over the radius, the
width of the cells over it; the radial pressure F - s at the filter over su, by default and in the
long test with the top held; the cone factor in both, less all that is known but of the top. Half a
minute at Ir 100.
"""

import math
import sys
from dataclasses import dataclass, replace

import numpy as np
import xarray as xr

from mpm_warp import ConePenetration, Scene, SurroundingGround
from mpm_warp.plan.plan import Plan
from mpm_warp.scenes.cone.defaults import DERIVED_BY_ERROR

FURTHER, LAST = 34.0, 14.0
"""Travel beyond the fast approach, and that of the mean at its end, over the radius up to Ir 100;
in proportion to the plastic zone, sqrt(Ir), beyond."""


class HeldTop(SurroundingGround):
    """Ground whose motion the soil at the top of the window has along r too, but at the shaft."""

    def add_boundary(self, plan: Plan, scene: Scene) -> None:
        super().add_boundary(plan, scene)
        free, flow = plan.initial("end.free"), plan.initial("end.flow")
        top = plan.initial("end.nodes")[-scene.grid.column_count :]
        free[-len(top) :, 0] = 0.0
        flow[-len(top) :, 0] = self.source.velocity(scene.grid.node_positions[top])[:, 0]


@dataclass(frozen=True, kw_only=True)
class HeldConePenetration(ConePenetration):
    """A cone test in such a window."""

    def build(self) -> Scene:
        scene = super().build()
        parts = [
            HeldTop(grid=part.grid, material=part.material, source=part.source)
            if isinstance(part, SurroundingGround)
            else part
            for part in scene.parts
        ]
        return replace(scene, parts=tuple(parts))


def by_default(recorded: xr.Dataset, test: ConePenetration) -> tuple[float, float]:
    """F - s over su by which u2 is stated, and Nc, both less what is known of the top."""
    pressure = recorded.pore_pressure_factor_shoulder
    pressure = pressure - recorded.pore_pressure_factor_shoulder_correction
    laws = test.laws(way=float(recorded.penetration_reached))
    factor = recorded.cone_factor + laws.top - laws.top_of_horizontal
    return float(pressure - recorded.radial_deviator_factor_shoulder), float(factor)


def at_the_end(recorded: xr.Dataset, test: ConePenetration, travel: float) -> tuple[float, float]:
    """The same as means over so much travel at the end of a long test."""
    way, strength = recorded.penetration, recorded.undrained_shear_strength
    pressure = recorded.excess_pore_pressure_shoulder - recorded.radial_deviator_shoulder
    is_last = way > way[-1] - travel
    means = (
        curve.where(is_last).mean() / strength
        for curve in (pressure, recorded.penetration_resistance)
    )
    radial, factor = map(float, means)
    laws = test.laws(way=float(way[-1]))
    return radial, factor + float(laws.correction + laws.top - laws.top_of_horizontal)


if __name__ == "__main__":
    index, adhesion, anisotropy = map(float, sys.argv[1:])
    clay = {"rigidity_index": index, "adhesion_factor": adhesion, "stress_anisotropy": anisotropy}
    test = ConePenetration(**clay)
    zone = max(1.0, 0.1 * math.sqrt(index))
    way = test.domain_above + 1.0 + FURTHER * zone
    chosen = {name: float(getattr(test, name)) for name in DERIVED_BY_ERROR}
    held = HeldConePenetration(**clay, **chosen, penetration=way, steady_tolerance=0.0)
    free, known = by_default(test.run(), test), at_the_end(held.run(), test, LAST * zone)
    pairs = (it for pair in zip(free, known, strict=True) for it in pair)
    numbers = (*clay.values(), test.domain_above, test.relative_cell_size, *pairs)
    print(",".join(f"{np.round(number, 3):g}" for number in numbers))
