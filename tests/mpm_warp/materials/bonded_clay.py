"""A law of another package: modified Cam clay whose bonds enlarge its yield surface."""

from dataclasses import dataclass

from mpm_warp import ModifiedCamClay, parameter


@dataclass(frozen=True, kw_only=True)
class BondedClay(ModifiedCamClay):
    """Its bonds are lost as those of grains: by plastic volume strain."""

    bonding: float = parameter(0.0, "growth of the yield surface by bonds, over it", minimum=0)

    @property
    def size_ratio(self) -> float:
        """See `ModifiedCamClay`."""
        return (1.0 + self.bonding) * super().size_ratio
