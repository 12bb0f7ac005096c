"""Compiled kernels that a fault of the disk has damaged are compiled again, or named."""

import os
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import warp as wp

from mpm_warp import GravityColumn, Simulation
from mpm_warp.errors import KernelCacheError
from mpm_warp.execution.kernel_cache import DIGEST, load_kernels
from mpm_warp.kernel_types import kernel

pytestmark = pytest.mark.slow


@kernel
def count_up(numbers: wp.array[wp.int32]):
    numbers[wp.tid()] = wp.tid() + 1


DAMAGES: dict[str, Callable[[bytes], bytes]] = {
    "no bytes": lambda code: b"",
    "cut": lambda code: code[: len(code) // 2],
    "zeros": lambda code: bytes(len(code)),
    "first byte flipped": lambda code: bytes([code[0] ^ 255]) + code[1:],
    "one bit flipped": lambda code: code[:-200] + bytes([code[-200] ^ 4]) + code[-199:],
}
SEEN_BY_WARP = ("no bytes", "cut", "first byte flipped")
"""Warp loads the others without a word."""


@pytest.fixture(scope="module")
def compiled(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A cache with the kernel alone."""
    folder = tmp_path_factory.mktemp("compiled")
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(wp.config, "kernel_cache_dir", str(folder))
        load_and_launch()
    return folder


@pytest.fixture
def cache(compiled: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of it, for this test alone."""
    folder = tmp_path / "cache"
    shutil.copytree(compiled, folder)
    monkeypatch.setattr(wp.config, "kernel_cache_dir", str(folder))
    return folder


def load_and_launch() -> None:
    """Load the kernel as a new process would."""
    count_up.module.unload()
    load_kernels(wp.get_device("cpu"), [count_up.module])
    numbers = wp.zeros(3, dtype=wp.int32, device="cpu")
    wp.launch(count_up, 3, [numbers], device="cpu")
    np.testing.assert_array_equal(numbers.numpy(), [1, 2, 3])


def files(cache: Path, ending: str) -> list[Path]:
    return sorted(cache.glob(f"wp_*/*{ending}"))


@pytest.mark.parametrize(
    ("ending", "damage", "digest"),
    [
        *((".o", damage, "kept") for damage in DAMAGES),
        *((".o", damage, "never written") for damage in DAMAGES),
        *((".o", damage, "not yet written") for damage in SEEN_BY_WARP),
        (".meta", "no bytes", "kept"),
        (".meta", "no bytes", "not yet written"),
        (".sha256", "no bytes", "kept"),
        (".sha256", "zeros", "kept"),
    ],
)
def test_a_damaged_kernel_is_compiled_again(
    cache: Path, ending: str, damage: str, digest: str
) -> None:
    (file,) = files(cache, ending)
    sound = file.read_bytes()
    file.write_bytes(DAMAGES[damage](sound))
    if digest != "kept":
        (file.parent / DIGEST).unlink()
    if digest == "never written":
        os.utime(file.parent, (0.0, 0.0))
    load_and_launch()
    assert file.read_bytes() == sound
    assert files(cache, DIGEST)


def test_a_sound_kernel_is_not_compiled_again(cache: Path) -> None:
    written = [file.stat().st_mtime_ns for file in files(cache, "")]
    load_and_launch()
    assert [file.stat().st_mtime_ns for file in files(cache, "")] == written


def test_a_kernel_that_never_loads_is_an_error_that_names_the_folder(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(*given: object, **others: object) -> None:
        raise Exception("Failed to load CPU module 'it'")

    monkeypatch.setattr(wp, "force_load", fail)
    for do in (load_and_launch, lambda: Simulation(GravityColumn(cell_count=2).build())):
        with pytest.raises(KernelCacheError, match=f"in {cache} cannot be loaded: .* remove this"):
            do()


def test_a_damaged_kernel_that_may_not_be_removed_is_an_error_that_names_it(
    cache: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(folder: Path) -> None:
        raise PermissionError(13, "Permission denied", str(folder))

    (file,) = files(cache, ".o")
    file.write_bytes(b"")
    monkeypatch.setattr(shutil, "rmtree", refuse)
    with pytest.raises(KernelCacheError, match=f"Permission denied: {file.parent}; set WARP_"):
        load_and_launch()
