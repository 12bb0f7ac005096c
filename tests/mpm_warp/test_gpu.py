"""Every kernel compiles for a GPU; on one, where there is one, runs give a processor's results."""

import itertools
import re
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import warp as wp

import mpm_warp
from harness.run.verify import Check, checks_of, quick
from mpm_warp import Execution, History, ParameterError, Scene, SceneError, Simulation
from mpm_warp.fields.declaration import Value, own_parameters_of
from mpm_warp.planning import make_plan
from mpm_warp.scenes import scene_class, scene_names
from mpm_warp.scenes.cone.cone_penetration import ConePenetration

pytestmark = pytest.mark.slow

GPU = "cuda:0"
on_a_gpu = pytest.mark.skipif(not wp.is_cuda_available(), reason="no GPU here")
HOPPER = 90
"""A generation of GPUs, by its compute capability."""
KERNEL = r"@(?:wp\.)?kernel\b.*\n *def (\w+)"
OF_PROCESSORS = {"barrier", "next_step"}
"""Kernels of threads, which no GPU ever runs."""
RING: dict[str, Value] = {"interface_radius": 2.0, "friction": 0.0}
MEASURABLE: dict[str, Value] = {"cells_per_radius": 3.0}
FURTHER: dict[str, list[dict[str, Value]]] = {
    "cavity_sphere": [{}, {"remoulded_strength_ratio": 0.2, "ductility": 10.0}],
    "cone_penetration": [
        MEASURABLE,
        {"approach": 0, **MEASURABLE},
        {"friction_coefficient": 0.03, **MEASURABLE},
    ],
    "sounding": [{"layer_top": 1.1, "layer_strength_ratio": 2.0, "adhesion_factor": 0.5}],
    "sliding_block": [{}, {"damping_ratio": 0}, RING, {"damping_ratio": 0, **RING}],
}
"""Parameters without choices that decide on kernels all the same, by scene.

The error of a cone test is measured with such cells at any accuracy, and refused with wider ones.
"""


def variants(name: str) -> Iterator[Any]:
    """What a scene builds under all its choices, and with what else decides on its kernels."""
    scene = scene_class(name)
    choices = {
        key: [*definition.choices, *([None] if definition.default is None else [])]
        for key, definition in own_parameters_of(scene).items()
        if definition.choices and definition.kind is str
    }
    for values in itertools.product(*choices.values()):
        for further in FURTHER.get(name, ({},)):
            with suppress(ParameterError, SceneError):  # choices that do not go together
                yield scene(**dict(zip(choices, values, strict=True)), **further).build()


@pytest.fixture(scope="module")
def kernels() -> set[wp.Kernel]:
    """Of all scenes, their launches in one share, as where a simulation is on a GPU."""
    scenes = [scene for name in scene_names() for scene in variants(name)]
    # With snapshots a run also records what its soil has gone through.
    scenes += [it.with_parts(History()) for it in scenes if isinstance(it, Scene)]
    plans = [make_plan(scene, share_count=1) for scene in scenes]
    return {launch.kernel for plan in plans for launch in plan.launches}


def test_of_every_kernel_some_variant_is_compiled(kernels: set[wp.Kernel]) -> None:
    """By their names in the source: a new one cannot be left out by oversight."""
    sources = [path.read_text() for path in Path(mpm_warp.__path__[0]).rglob("*.py")]
    named = {name for text in sources for name in re.findall(KERNEL, text)}
    compiled = {kernel.key.split("__")[-1] for kernel in kernels}
    assert named - compiled == OF_PROCESSORS


@pytest.mark.skipif(sys.platform == "darwin", reason="Warp compiles for no GPU there")
def test_every_kernel_compiles_for_a_gpu(kernels: set[wp.Kernel]) -> None:
    """What is compiled is kept from run to run, as kernels of a processor are."""
    wp.init()  # it chooses the folder
    for module in {kernel.module for kernel in kernels}:
        folder = Path(wp.config.kernel_cache_dir, f"gpu_{module.get_module_identifier()}")
        if not any(".entry" in it.read_text() for it in folder.glob("*.ptx")):
            (compiled,) = wp.compile_aot_module(
                module, arch=HOPPER, module_dir=folder, use_ptx=True
            )
            assert ".entry" in compiled.read_text()


@on_a_gpu
def test_a_gpu_gives_the_cone_factors_of_the_processor() -> None:
    """The same sums are added in another order, as a rounding of each step."""
    for factor in (0.0, 0.5, 1.0):
        cone = ConePenetration(cells_per_radius=2, penetration=16, adhesion_factor=factor)
        expected = float(cone.run().cone_factor)
        result = float(cone.run(execution=Execution(GPU)).cone_factor)
        np.testing.assert_allclose(result, expected, rtol=1e-9)


@on_a_gpu
def test_what_is_read_from_a_gpu_is_what_it_has() -> None:
    """After steps, values given and a launch; what was read before is not read again."""
    cone = ConePenetration(cells_per_radius=2).build()
    simulation = Simulation(cone, Execution(GPU))
    names = list(simulation.arrays)

    def assert_read() -> None:
        for name in names:
            np.testing.assert_array_equal(simulation.array(name), simulation.arrays[name].numpy())

    for change in (
        lambda: simulation.advance(20),
        lambda: simulation.assign("particle.velocity", 0.0),
        lambda: simulation.launch(simulation.plan.step[0]),
    ):
        assert_read()
        change()
        assert_read()


@on_a_gpu
@pytest.mark.parametrize("check", quick(checks_of()), ids=lambda it: it.scene)
def test_scenes_on_a_gpu_are_within_their_bounds(check: Check) -> None:
    result = check.runs[-1].run(execution=Execution(GPU))
    for name, bound in check.verification.bounds.items():
        assert float(result[name]) <= bound
