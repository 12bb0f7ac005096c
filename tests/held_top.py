"""What the top of the window takes off u2, by windows whose top holds the radial motion too.

By default the soil at the top is free to move along r. Over some ten radii below it the stress
then falls to next to nothing, where it is the same at every height in a window three times as
tall. With the radial motion held too u2 is that of a tall window, once the soil that was above the
cone at the start is out: after some 20 radii of slow travel more.

``python tests/held_top.py IR ADHESION DELTA`` prints what belongs into one line of
`studies/top_error_u2.csv`: the case, the extent of the window above the shoulder over the radius,
the width of the cells over it, and the radial pressure F - s at the filter over su, first by
default and then in the long test with the top held. Half a minute at Ir 100.
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


def radial_pressure(recorded: xr.Dataset, travel: float = 0.0) -> float:
    """F - s over su: as u2 is stated by, or its mean over so much travel at the end."""
    if travel == 0.0:
        factor = recorded.pore_pressure_factor_shoulder
        simulated = factor - recorded.pore_pressure_factor_shoulder_correction
        return float(simulated - recorded.radial_deviator_factor_shoulder)
    curve = recorded.excess_pore_pressure_shoulder - recorded.radial_deviator_shoulder
    way = recorded.penetration
    return float(curve.where(way > way[-1] - travel).mean() / recorded.undrained_shear_strength)


if __name__ == "__main__":
    index, adhesion, anisotropy = map(float, sys.argv[1:])
    clay = {"rigidity_index": index, "adhesion_factor": adhesion, "stress_anisotropy": anisotropy}
    test = ConePenetration(**clay)
    zone = max(1.0, 0.1 * math.sqrt(index))
    way = test.domain_above + 1.0 + FURTHER * zone
    chosen = {name: float(getattr(test, name)) for name in DERIVED_BY_ERROR}
    held = HeldConePenetration(**clay, **chosen, penetration=way, steady_tolerance=0.0)
    by_default = radial_pressure(test.run())
    in_held = radial_pressure(held.run(), LAST * zone)
    numbers = (*clay.values(), test.domain_above, test.relative_cell_size, by_default, in_held)
    print(",".join(f"{np.round(number, 3):g}" for number in numbers))
