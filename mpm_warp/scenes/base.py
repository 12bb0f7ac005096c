"""Stand-in for the scenes that are not here: dropped at the merge."""

from abc import abstractmethod
from typing import Any

from mpm_warp.scenes.catalogue import CatalogueScene
from mpm_warp.scenes.catalogue import Progress as Progress
from mpm_warp.scenes.catalogue import Verification as Verification


class ReadyScene(CatalogueScene):
    """Stand-in."""

    def build(self) -> Any:
        """Stand-in."""

    @abstractmethod
    def run(self, progress: Any = None, execution: Any = None) -> Any:
        """Stand-in."""
