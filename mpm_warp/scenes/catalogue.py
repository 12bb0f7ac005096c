"""The catalogue of scenes of this and of other packages.

A scene is a subclass of `CatalogueScene` with a summary and without abstract methods, in any module
below `mpm_warp.scenes`. Its name is that of the class in lower case with underscores:
`ConePenetration` is "cone_penetration". A new scene is one new file and nothing else.

Other packages offer scenes by the entry point group `mpm_warp.scenes` in their pyproject.toml:

    [project.entry-points."mpm_warp.scenes"]
    pile_driving = "their_package.pile_driving:PileDriving"
"""

import functools
import importlib
import inspect
import pkgutil
from collections.abc import Iterable, Mapping
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from mpm_warp.errors import UnknownSceneError
from mpm_warp.fields.declaration import own_parameters_of
from mpm_warp.fields.names import nearest_name
from mpm_warp.scenes.catalogue_scene import CatalogueScene

GROUP = "mpm_warp.scenes"
"""Group of the entry points by which other packages offer scenes."""

Offered = type[CatalogueScene] | EntryPoint
"""A scene of this package, or the entry point of one of another.

Where importlib_metadata is loaded, as by Dask, entry points are of its class instead.
"""


def scene_names() -> tuple[str, ...]:
    """Names of all scenes, sorted.

    Raises:
        UnknownSceneError: two scenes have the same name.

    Example:
        >>> len(scene_names()), scene_names()[0]
        (25, 'ball_penetration')
    """
    return tuple(sorted(_all_scenes()))


def scene_class(name: str) -> type[CatalogueScene]:
    """The class of the scene of that name.

    Raises:
        UnknownSceneError: there is no such scene (the message names the nearest), two scenes have
            the same name, or the entry point of the scene does not give a scene.

    Example:
        >>> scene_class("cone_penetration").summary
        'cone penetration test in undrained clay, to steady state'
    """
    scenes = _all_scenes()
    if name not in scenes:
        raise UnknownSceneError(f"unknown scene {name!r}{nearest_name(name, scenes)}")
    scene = scenes[name]
    return scene if isinstance(scene, type) else _loaded(scene)


@functools.cache
def _all_scenes() -> Mapping[str, Offered]:
    """All scenes by name, cached because the search opens a file of each installed package."""
    others = [(offered.name, offered) for offered in entry_points(group=GROUP)]
    return _by_name([*own_scenes().items(), *others])


@functools.cache
def own_scenes() -> Mapping[str, Offered]:
    """The scenes of this package by name."""
    names = pkgutil.walk_packages([str(Path(__file__).parent)], f"{__package__}.")
    modules = [importlib.import_module(module.name) for module in names]
    return _by_name(
        (found.catalogue_name(), found)
        for module in modules
        for found in vars(module).values()
        if _is_scene(found) and found.__module__ == module.__name__
    )


def _by_name(offered: Iterable[tuple[str, Offered]]) -> Mapping[str, Offered]:
    scenes: dict[str, Offered] = {}
    for name, scene in offered:
        if name in scenes:
            raise UnknownSceneError(
                f"two scenes are called {name!r}: {_origin(scenes[name])} and {_origin(scene)}; "
                "rename one of them"
            )
        scenes[name] = scene
    return scenes


def _is_scene(found: object) -> bool:
    """Whether a class is a scene, not one that scenes are made of, which has no summary."""
    is_class = isinstance(found, type) and issubclass(found, CatalogueScene)
    return is_class and not inspect.isabstract(found) and hasattr(found, "summary")


def _origin(scene: Offered) -> str:
    if isinstance(scene, type):
        return f"{scene.__module__}.{scene.__qualname__}"
    package = "an unknown package" if scene.dist is None else scene.dist.name
    return f"the entry point {scene.value!r} of {package}"


def _loaded(entry_point: EntryPoint) -> type[CatalogueScene]:
    """The class of an entry point; `UnknownSceneError` if it cannot be loaded or is no scene."""
    where = f"scene {entry_point.name!r}: {_origin(entry_point)}"
    try:
        scene: type[CatalogueScene] = entry_point.load()
    except (Exception, SystemExit) as error:
        reason = " ".join(f"{type(error).__name__}: {error}".split())
        raise UnknownSceneError(f"{where} cannot be loaded: {reason}") from error
    if not _is_scene(scene):
        raise UnknownSceneError(f"{where} is not a CatalogueScene without abstract methods")
    try:
        own_parameters_of(scene)
    except TypeError as error:
        raise UnknownSceneError(f"{where}: {error}") from None
    return scene
