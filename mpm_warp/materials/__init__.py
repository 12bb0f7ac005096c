"""Constitutive models, one file each."""

from mpm_warp.materials.tresca import Tresca
from mpm_warp.materials.von_mises import VonMises

CRITERIA = {"tresca": Tresca, "von_mises": VonMises}
"""Perfectly plastic materials by the names of their yield criteria."""
