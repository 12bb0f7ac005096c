"""The catalogue of scenes, and the scenes by family."""

from mpm_warp.scenes.catalogue import (
    CatalogueScene,
    Progress,
    Verification,
    scene_class,
    scene_names,
)

__all__ = ["CatalogueScene", "Progress", "Verification", "scene_class", "scene_names"]
