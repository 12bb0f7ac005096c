"""Constitutive models, one file each."""

from collections.abc import Mapping

from mpm_warp.materials.perfectly_plastic import PerfectlyPlastic
from mpm_warp.materials.tresca import Tresca
from mpm_warp.materials.von_mises import VonMises

CRITERIA: Mapping[str, type[PerfectlyPlastic]] = {"tresca": Tresca, "von_mises": VonMises}
"""Perfectly plastic materials by the names of their yield criteria."""
