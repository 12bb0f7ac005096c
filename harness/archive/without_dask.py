"""xarray without those parts of Dask that take long to load.

With its first array xarray loads the arrays of Dask, and with the first file that it writes Dask's
cluster, wherever they are installed: nearly a second in each process, and no array here is Dask's.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from types import ModuleType
from typing import cast

_ABSENT = cast(ModuleType, None)
"""Python's import system takes a module of which this is known for one that is not there."""


@contextmanager
def without_dask() -> Iterator[None]:
    """Inside the ``with``, xarray finds no such parts, unless they have been loaded before.

    Of arrays it keeps the answer. Whoever imports Dask afterwards gets it.
    """
    names = {"dask.array", "distributed"} - sys.modules.keys()
    sys.modules.update(dict.fromkeys(names, _ABSENT))
    try:
        yield
    finally:
        for name in names:
            del sys.modules[name]
