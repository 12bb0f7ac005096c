"""Scenes by name, and the observed order of a scene's error."""

import math
from typing import Any

from mpm_warp.errors import InaccurateRun
from mpm_warp.scenes import CatalogueScene, scene_class


def scene(name: str, **given: object) -> Any:
    """A scene by the values of its parameters in flat form."""
    return scene_class(name).of(given)


def order_and_errors(
    scene: type[CatalogueScene], resolution: str, coarse: int, **given: object
) -> tuple[float, float, float]:
    """The order of `error` between a resolution and its double, and the error at each.

    At the coarse one the error may be beyond its limit.
    """
    try:
        at_coarse = float(scene(**given, **{resolution: coarse}).run().error)
    except InaccurateRun as end:
        at_coarse = float(end.curves.error)
    at_fine = float(scene(**given, **{resolution: 2 * coarse}).run().error)
    return math.log2(at_coarse / at_fine), at_coarse, at_fine
