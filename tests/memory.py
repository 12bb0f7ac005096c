"""Memory of random cases of all scenes: that which is predicted beside that which is used.

``python -m tests.memory COUNT SEED`` draws cases of up to 600 MB, builds each in a process of its
own and takes two steps of it; what is sampled on the way is left out. It prints what each took and
was predicted to take, a process's own memory included, and at last the distribution of the ratio.
Run it twice: kernels that are compiled on the way take 50 MB more. Linux alone.
"""

import dataclasses
import itertools
import multiprocessing
import random
import sys
from collections.abc import Callable
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

import harness.run.worker  # noqa: F401  what a worker has loaded
from harness.run.resources import PROCESS_MEMORY
from mpm_warp.scenes import scene_class, scene_names
from mpm_warp.scenes.run_size import RunSize
from mpm_warp.simulation import Simulation
from tests.harness.run.test_random_cases import random_scene

T = TypeVar("T")
SMALLEST_PROCESS = 294e6
"""Peak of a worker that runs the smallest case [byte]."""
LARGEST, ENOUGH, DRAWS = 6e8, 4e7, 40
"""Memory of a case at most, and from where on no larger one is looked for [byte]; draws at most."""
OTHERS = ("step_cost", "sliding_block")
"""Scenes that build several runs, or whose samples take nearly all."""


def in_grid(size: RunSize) -> float:
    """Predicted memory without what is sampled on the way [byte]."""
    return size.byte_count - size.curve_bytes


def drawn(seed: str, name: str) -> tuple[dict[str, Any], RunSize] | None:
    """Parameters of a case that is not too large, of some draws the largest; and its size."""
    source, best = random.Random(seed), None
    for _ in range(DRAWS):
        made = random_scene(source, name)
        size = made.run_size()
        assert size is not None
        is_one_run = getattr(made, "uncertainty", "") != "measured"
        if (
            is_one_run
            and in_grid(size) < LARGEST
            and (best is None or in_grid(size) > in_grid(best[1]))
        ):
            best = (dataclasses.asdict(made), size)
        if best is not None and in_grid(best[1]) > ENOUGH:
            break
    return best


def status(name: str) -> float:
    """A number of the kernel's about this process [byte]."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(1024.0 * int(line.split()[1]) for line in lines if line.startswith(name))


def taken(name: str, parameters: dict[str, Any]) -> float:
    """Build a case, take two steps of it: how much the peak is above the start [byte]."""
    before = status("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")
    Simulation(scene_class(name)(**parameters).build()).advance(2)
    return status("VmHWM") - before


def apart(task: Callable[..., T], *values: object) -> T | None:
    """What a task gives in a fresh copy of this process; None where it fails."""

    def run(connection: Connection) -> None:
        connection.send(task(*values))

    fork = multiprocessing.get_context("fork")
    ours, theirs = fork.Pipe(duplex=False)
    worker = fork.Process(target=run, args=(theirs,))
    worker.start()
    theirs.close()
    try:
        found: T = ours.recv()
    except EOFError:
        return None
    finally:
        worker.join()
    return found


def main() -> None:
    """Draw, build and compare."""
    count, seed = int(sys.argv[1]), sys.argv[2]
    least = apart(taken, "element_test", {})
    assert least is not None
    ratios = []
    names = [name for name in sorted(scene_names()) if name not in OTHERS]
    for number, name in enumerate(itertools.islice(itertools.cycle(names), count)):
        found = apart(drawn, f"{seed} {number}", name)
        own = None if found is None else apart(taken, name, found[0])
        if found is None or own is None:
            continue
        used = SMALLEST_PROCESS + own - least
        predicted = PROCESS_MEMORY + in_grid(found[1])
        ratios.append(predicted / used)
        print(f"{name:20} used {used / 1e6:6.1f} MB, predicted {ratios[-1]:.3f} of it", flush=True)
    low, middle, high = np.quantile(ratios, [0.0, 0.5, 0.95])
    within = np.mean([1.0 <= it <= 1.1 for it in ratios])
    print(f"{len(ratios)} cases: least {low:.3f}, median {middle:.3f}, 95 % below {high:.3f}")
    print(f"from 1.0 to 1.1: {within:.0%}; greatest {max(ratios):.3f}")


if __name__ == "__main__":
    main()
