"""The catalogue of scenes, and the scenes by family."""

from mpm_warp.scenes.catalogue import scene_class, scene_names
from mpm_warp.scenes.catalogue_scene import CatalogueScene, Progress
from mpm_warp.scenes.verification import Verification

__all__ = ["CatalogueScene", "Progress", "Verification", "scene_class", "scene_names"]
