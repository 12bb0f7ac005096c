"""Ready scenes, one file each. A new scene is a new file here and nothing else.

The file ``name.py`` defines the class ``Name``: a frozen dataclass whose fields are the scene's
parameters, see :class:`mpm_warp.scenes.base.ReadyScene`. What several have in common is in
`families`.
"""

from __future__ import annotations

import importlib
import pkgutil

from mpm_warp.parameters import nearest_name
from mpm_warp.scenes.base import Progress, ReadyScene, Verification

CatalogueScene = ReadyScene

__all__ = [
    "CatalogueScene",
    "Progress",
    "ReadyScene",
    "UnknownSceneError",
    "Verification",
    "scene_class",
    "scene_names",
]


class UnknownSceneError(LookupError):
    """No scene has that name; the message is one line and names the nearest one."""


def scene_names() -> tuple[str, ...]:
    """Names of all scenes, sorted."""
    modules = pkgutil.iter_modules(__path__)
    return tuple(sorted(it.name for it in modules if it.name != "base" and not it.ispkg))


def scene_class(name: str) -> type[ReadyScene]:
    """The class of the scene called `name`.

    Raises:
        UnknownSceneError: there is none of that name.
    """
    known = scene_names()
    if name not in known:
        raise UnknownSceneError(f"unknown scene {name!r}{nearest_name(name, known)}")
    module = importlib.import_module(f"{__name__}.{name}")
    scene: type[ReadyScene] = getattr(module, "".join(map(str.capitalize, name.split("_"))))
    return scene
