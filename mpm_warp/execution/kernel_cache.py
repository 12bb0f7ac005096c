"""The folder of compiled kernels: what a fault of the disk has damaged in it is compiled again.

Warp loads what it finds in its cache. So a digest of the files of a kernel is written beside them,
and a kernel that differs from its digest is removed before Warp reads it. One without a digest is
removed too, unless it is so new that another process may be about to write the digest.
"""

import hashlib
import json
import os
import re
import shutil
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from typing import Any

import warp as wp

from mpm_warp.errors import KernelCacheError

DIGEST = "mpm_warp.sha256"
"""Name of the file with a digest, in the folder of a kernel."""
NEW = 600.0
"""Age up to which a kernel may lack its digest [s]."""
SOURCES = (".cpp", ".cu")
"""Endings of files that Warp writes but does not read."""


def load_kernels(device: wp.Device, modules: Iterable[Any]) -> None:
    """Compile modules of kernels, or load them from the cache.

    Raises:
        KernelCacheError: a kernel cannot be loaded, not even once it is compiled again.
    """
    new = [module for module in modules if not module.execs]
    for folder in _folders(new):
        if not _is_sound(folder):
            _remove(folder)
    try:
        wp.force_load(device, modules=new)
    except Exception as error:
        if not _is_of_cache(error):
            raise
        for folder in _folders([module for module in new if not module.execs]):
            _remove(folder)
        try:
            wp.force_load(device, modules=new)
        except Exception as again:
            if not _is_of_cache(again):
                raise
            raise KernelCacheError(
                f"compiled kernels in {wp.config.kernel_cache_dir} cannot be loaded: "
                f"{' '.join(str(again).split())}; remove this folder, or set WARP_CACHE_PATH to "
                "another one"
            ) from None
    for folder in _folders(new):
        _write_digest(folder)


def _folders(modules: Iterable[Any]) -> list[Path]:
    """Folders of modules in the cache; a module has one for each version of its code."""
    cache = Path(wp.config.kernel_cache_dir)
    names = "|".join(re.escape(module.name) for module in modules)
    own = re.compile(f"wp_({names})_[0-9a-f]{{7}}")
    if not names or not cache.exists():
        return []
    return [folder for folder in cache.iterdir() if own.fullmatch(folder.name)]


def _is_of_cache(error: Exception) -> bool:
    """Whether an error says that Warp cannot read a file of its cache."""
    of_file = isinstance(error, (json.JSONDecodeError, UnicodeDecodeError, FileNotFoundError))
    return of_file or str(error).startswith("Failed to load")


def _digests(folder: Path) -> dict[str, str]:
    """Digests of the files that Warp reads, by their names."""
    return {
        file.name: hashlib.sha256(file.read_bytes()).hexdigest()
        for file in sorted(folder.iterdir())
        if file.name != DIGEST and file.suffix not in SOURCES
    }


def _is_sound(folder: Path) -> bool:
    """Whether the files of a kernel are as they were written."""
    try:
        if not (folder / DIGEST).exists():
            return time.time() - folder.stat().st_mtime < NEW
        known = json.loads((folder / DIGEST).read_bytes())
        present = _digests(folder)
    except FileNotFoundError:  # another process has removed it
        return True
    except ValueError:
        return False
    return all(present.get(name) == digest for name, digest in known.items())


def _write_digest(folder: Path) -> None:
    with suppress(OSError):  # a folder of others, which can be read only
        text = json.dumps(_digests(folder))
        if (folder / DIGEST).exists() and (folder / DIGEST).read_text() == text:
            return
        part = folder / f"{DIGEST}.{os.getpid()}"
        part.write_text(text)
        part.replace(folder / DIGEST)


def _remove(folder: Path) -> None:
    """Remove a kernel; `KernelCacheError` where that is not allowed."""
    try:
        shutil.rmtree(folder)
    except FileNotFoundError:  # another process was faster
        return
    except OSError as error:
        raise KernelCacheError(
            f"a compiled kernel is damaged and cannot be removed: {error.strerror}: {folder}; "
            "set WARP_CACHE_PATH to another folder"
        ) from None
