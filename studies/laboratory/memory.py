"""Memory of random cases of all scenes: that which is predicted beside that which is used.

``memory COUNT SEED`` draws cases of up to 600 MB and runs each as a worker does, in
a process of its own: to its end where that takes some seconds, what is sampled on the way included;
else two steps of it, without samples. It prints the peak of each process and what was predicted,
and at last the distribution of the ratio. Run it twice: kernels that are compiled on the way take
50 MB more. Linux alone.
"""

import importlib
import itertools
import multiprocessing
import random
import sys
from collections.abc import Iterable
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from harness.archive.conventions import COMPLETED
from harness.machine import peak_memory
from harness.run.resources import UPDATE_RATE, predicted_memory
from harness.run.worker import load_libraries, run_case
from harness.study.cases import Case
from mpm_warp import CatalogueScene, Simulation, scene_class, scene_names
from mpm_warp.fields.flat import values_of
from studies.laboratory.random_cases import random_scene

LARGEST, ENOUGH, DRAWS = 6e8, 4e7, 40
"""Memory of a case at most, and from where on no larger one is looked for [byte]; draws at most."""
SECONDS, STEPS = 1.0, 20_000
"""Predicted time and steps of a case that is run to its end, at most."""


def drawn(seed: str, name: str) -> dict[str, Any]:
    """Parameters of a case that is not too large, of some draws the largest."""
    source, best, most = random.Random(seed), dict[str, Any](), -1.0
    for _ in range(DRAWS):
        made = random_scene(source, name)
        size = made.run_size()
        assert size is not None
        is_one_run = getattr(made, "uncertainty", "") != "measured"
        if is_one_run and most < size.byte_count < LARGEST:
            best, most = values_of(made), size.byte_count
        if most > ENOUGH:
            break
    return best


def is_short(scene: CatalogueScene) -> bool:
    """Whether a case is run to its end; not where its steps are not known beforehand."""
    size = scene.run_size()
    assert size is not None
    return size.particle_updates < SECONDS * UPDATE_RATE and 0 < size.step_count < STEPS


def run(connection: Connection, name: str, parameters: dict[str, Any], whole: bool) -> None:
    """Run a case in this process; send the peak of its memory [byte], None where it has no end."""
    load_libraries()
    status = COMPLETED
    if whole:
        version = scene_class(name).version
        case = Case(scene=name, scene_version=version, parameters=parameters, label=name)
        with TemporaryDirectory() as folder:
            status = run_case(case, Path(folder)).status
    else:
        scene = scene_class(name)(**parameters)
        simulation = Simulation(scene.build())
        simulation.advance(2)
        simulation.check()
        if scene.loads_solvers:
            importlib.import_module("scipy.integrate")  # as its result would
    connection.send(float(peak_memory()) if status == COMPLETED else None)


def peak_of(name: str, parameters: dict[str, Any], *, whole: bool) -> float | None:
    """The peak of a fresh process that runs a case."""
    spawn = multiprocessing.get_context("spawn")
    ours, theirs = spawn.Pipe(duplex=False)
    worker = spawn.Process(target=run, args=(theirs, name, parameters, whole))
    worker.start()
    theirs.close()
    try:
        found: float | None = ours.recv()
    except EOFError:
        return None
    finally:
        worker.join()
    return found


def ratios(names: Iterable[str], seed: str) -> Iterable[float]:
    """Of a case of each scene, that which is predicted over that which is used."""
    for number, name in enumerate(names):
        parameters = drawn(f"{seed} {number}", name)
        scene = scene_class(name)(**parameters)
        size, whole = scene.run_size(), is_short(scene)
        assert size is not None
        peak = peak_of(name, parameters, whole=whole)
        if peak is None:  # it ends before its samples are all there
            whole, peak = False, peak_of(name, parameters, whole=False)
        if peak is None:
            print(f"{name}: cannot be run: {parameters}", flush=True)
            continue
        if not whole:
            size = replace(size, curve_bytes=0.0)
        ratio = predicted_memory(scene, size) / peak
        how = "to its end" if whole else "two steps"
        print(f"{name:20} {how} {peak / 1e6:6.1f} MB, predicted {ratio:.3f} of it", flush=True)
        yield ratio


def main() -> None:
    """Draw, run and compare."""
    count, seed = int(sys.argv[1]), sys.argv[2]
    several_runs = {"step_cost"}
    names = itertools.islice(itertools.cycle(sorted({*scene_names()} - several_runs)), count)
    found = np.array(list(ratios(names, seed)))
    low, middle, high, most = np.quantile(found, [0.0, 0.5, 0.95, 1.0])
    print(f"{len(found)} cases: least {low:.3f}, median {middle:.3f}, 95 % below {high:.3f}")
    print(f"from 1.0 to 1.1: {np.mean((found >= 1.0) & (found <= 1.1)):.0%}; greatest {most:.3f}")


if __name__ == "__main__":
    main()
