"""The scenes of the catalogue, by family, and the catalogue itself."""

from mpm_warp.scenes.catalogue import (
    CatalogueScene,
    Progress,
    Verification,
    scene_class,
    scene_names,
)

__all__ = ["CatalogueScene", "Progress", "Verification", "scene_class", "scene_names"]
