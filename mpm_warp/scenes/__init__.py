"""Ready scenes, one file each. A new scene is a new file here and nothing else.

The file ``name.py`` defines the class ``Name``: a frozen dataclass whose fields are the scene's
parameters, see :class:`mpm_warp.scenes.base.ReadyScene`. What several have in common is in
`families`.
"""

from __future__ import annotations

import importlib
import pkgutil

from mpm_warp.parameters import nearest_name
from mpm_warp.scenes.base import Progress, ReadyScene

__all__ = ["Progress", "ReadyScene", "UnknownSceneError", "scene_class", "scene_names"]


IN_FAMILIES = {
    "flying_block": "blocks",
    "sliding_block": "blocks",
    "stretched_bar": "bars",
    "struck_bar": "impact",
    "struck_column": "impact",
}
"""Stand-in until the merge: scenes that have moved into the folder of their family."""


class UnknownSceneError(LookupError):
    """No scene has that name; the message is one line and names the nearest one."""


def scene_names() -> tuple[str, ...]:
    """Names of all scenes, sorted."""
    modules = pkgutil.iter_modules(__path__)
    flat = (it.name for it in modules if it.name not in {"base", "catalogue"} and not it.ispkg)
    return tuple(sorted([*flat, *IN_FAMILIES]))


def scene_class(name: str) -> type[ReadyScene]:
    """The class of the scene called `name`.

    Raises:
        UnknownSceneError: there is none of that name.
    """
    known = scene_names()
    if name not in known:
        raise UnknownSceneError(f"unknown scene {name!r}{nearest_name(name, known)}")
    family = f"{IN_FAMILIES[name]}." if name in IN_FAMILIES else ""
    module = importlib.import_module(f"{__name__}.{family}{name}")
    scene: type[ReadyScene] = getattr(module, "".join(map(str.capitalize, name.split("_"))))
    return scene
