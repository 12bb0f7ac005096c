"""Axisymmetric and plane-strain material point method on NVIDIA Warp kernels.

Every name that a script needs can be imported from here: the scenes of the catalogue, and the
classes for a scene of one's own.

    from mpm_warp import ConePenetration

    result = ConePenetration(rigidity_index=150).run(progress=True)

Examples below run after `import numpy as np`, `from dataclasses import dataclass` and `from
mpm_warp import *`. `harness describe NAME` lists the parameters of a scene.

`import mpm_warp` by itself takes no time. The simulator is imported with the first of its names.
"""

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mpm_warp.public_names import *
else:

    def __getattr__(name: str) -> object:
        if name == "__all__":
            # of `from mpm_warp import *`, and of pdoc, which asks for no name that is not here
            globals().update((it, getattr(import_module(__name__), it)) for it in __dir__())
            return __dir__()
        missing = f"module {__name__!r} has no attribute {name!r}"
        # Python asks for names of its own, and for names of modules before it imports them.
        if name.startswith("_") or find_spec(f"{__name__}.{name}") is not None:
            raise AttributeError(missing)
        names = _public_names()
        if name not in names:
            nearest = import_module("mpm_warp.fields.names").did_you_mean(name, names)
            raise AttributeError(f"{missing}{nearest}")
        # `offered` adds the parameters of laws of other packages to a scene.
        return getattr(names[name], "offered", lambda: names[name])()


def __dir__() -> list[str]:
    """The public names."""
    return sorted(_public_names())


def _public_names() -> dict[str, object]:
    """The names of `public_names`, and all scenes of the catalogue."""
    listed = vars(import_module("mpm_warp.public_names"))
    scenes = import_module("mpm_warp.scenes.catalogue").own_scenes()
    public = {name: value for name, value in listed.items() if not name.startswith("_")}
    return public | {scene.__name__: scene for scene in scenes.values()}
