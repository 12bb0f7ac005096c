"""Cone factors with other treatments of the node at the shoulder.

The node belongs to face and shaft. By default it has the mean of their normals, by area, and its
normal traction acts on both. ``shoulder TREATMENT ROWS...`` prints the factor of a smooth cone as
simulated (Ir 100, all else as in studies/mesh_error.toml) for each number of rows beside the face:

    mean            as by default
    extrapolated    on the face its pressure is that of the two nodes before, extrapolated
    face, shaft     the normal of one of them
    two_nodes       a node on each side at one place: soil can leave neither, so it moves with both
"""

import math
import sys
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from harness.study.study import load_study
from mpm_warp import ConePenetration, Grid, Scene, parameter
from mpm_warp.errors import InaccurateRun
from mpm_warp.grid.fitted import Floats
from mpm_warp.scenes.cone.penetrometer import PenetrometerContact, PenetrometerForces

TREATMENTS = ("mean", "extrapolated", "face", "shaft", "two_nodes")


class ExtrapolatedContact(PenetrometerContact):
    """A contact whose face has its own pressure at the shoulder."""

    def forces(self, nodal: Floats) -> PenetrometerForces:
        """As in `PenetrometerContact`, with the other pressure of the face."""
        shoulder = shoulder_of(self)
        before = (
            nodal[shoulder - 2 : shoulder + 1, 0] / self.normal_areas[shoulder - 2 : shoulder + 1]
        )
        more = 2.0 * before[1] - before[0] - before[2]
        upward = more * float(self.face_areas[shoulder]) * math.sin(self.half_angle)
        found = super().forces(nodal)
        return found._replace(face_normal=found.face_normal + upward)


class TwoNodesContact(PenetrometerContact):
    """A contact of which the shoulder bears two forces; a smooth shaft bears no vertical one."""

    def forces(self, nodal: Floats) -> PenetrometerForces:
        """As in `PenetrometerContact`; all that the shoulder bears upward is of the face."""
        shoulder = shoulder_of(self)
        across, upward = self.normals[shoulder]
        on_shoulder = nodal[shoulder] @ np.array([upward, -across])
        others = nodal.copy()
        others[shoulder] = 0.0
        found = super().forces(others)
        return found._replace(face_normal=found.face_normal + float(on_shoulder))


def shoulder_of(contact: PenetrometerContact) -> int:
    """The node that belongs to face and shaft, counted from the tip."""
    return int(np.flatnonzero((contact.face_areas > 0.0) & (contact.shaft_areas > 0.0))[0])


def treated(contact: PenetrometerContact, treatment: str) -> PenetrometerContact:
    """A contact with a treatment of the shoulder."""
    shoulder, half = shoulder_of(contact), contact.half_angle
    if treatment in ("face", "shaft"):
        normals = contact.normals.copy()
        normals[shoulder] = (
            (-math.cos(half), math.sin(half)) if treatment == "face" else (-1.0, 0.0)
        )
        return replace(contact, normals=normals)
    values: dict[str, Any] = {name: getattr(contact, name) for name in contact.__dataclass_fields__}
    if treatment == "extrapolated":
        return ExtrapolatedContact(**values)
    if treatment == "two_nodes":
        adhesion = contact.adhesion_forces.copy()
        adhesion[shoulder] = sys.float_info.max
        return TwoNodesContact(**values | {"adhesion_forces": adhesion})
    return contact


@dataclass(frozen=True, kw_only=True, init=False)
class OtherShoulderCone(ConePenetration):
    """A cone test with another treatment of the shoulder."""

    shoulder: str = parameter("mean", "treatment of the node at the shoulder", choices=TREATMENTS)

    def build_in(self, grid: Grid) -> Scene:
        """As in `ConePenetration`, with the other contact."""
        scene = super().build_in(grid)
        parts = [
            treated(part, self.shoulder) if isinstance(part, PenetrometerContact) else part
            for part in scene.parts
        ]
        return replace(scene, parts=tuple(parts))


if __name__ == "__main__":
    treatment, *counts = sys.argv[1:]
    cells = [round(int(rows) / math.sqrt(3.0), 2) for rows in counts]
    clay = ["rigidity_index=[100]", "adhesion_factor=[0]"]
    for case in load_study("mesh_error", [*clay, f"cells_per_radius={cells}"]).cases:
        try:
            result = OtherShoulderCone.of({**case.parameters, "shoulder": treatment}).run()
        except InaccurateRun as told:
            print(case.label, told, flush=True)
        else:
            print(case.label, f"{float(result.cone_factor_simulated):.2f}", flush=True)
