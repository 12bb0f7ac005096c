"""Memory of random cases of all scenes: that which is predicted beside that which is used.

``python -m tests.memory COUNT SEED`` draws cases of up to 600 MB, builds each in a process of its
own and takes two steps of it; what is sampled on the way is left out. It prints what each took and
was predicted to take, a process's own memory included, and at last the distribution of the ratio.
Run it twice: kernels that are compiled on the way take 50 MB more. Linux alone.
"""

import itertools
import multiprocessing
import random
import sys
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np

import harness.run.worker  # noqa: F401  what a worker has loaded
from harness.run.resources import PROCESS_MEMORY
from mpm_warp.scenes import CatalogueScene, scene_names
from mpm_warp.scenes.run_size import RunSize
from mpm_warp.simulation import Simulation
from tests.harness.run.test_random_cases import random_scene

SMALLEST_PROCESS = 294e6
"""Peak of a worker that runs the smallest case [byte]."""
LARGEST, ENOUGH, DRAWS = 6e8, 4e7, 40
"""Memory of a case at most, and from where on no larger one is looked for [byte]; draws at most."""
OTHERS = ("step_cost", "sliding_block")
"""Scenes that build several runs, or whose samples take nearly all."""


def in_grid(size: RunSize) -> float:
    """Predicted memory without what is sampled on the way [byte]."""
    return size.byte_count - size.curve_bytes


def drawn(source: random.Random, name: str) -> tuple[CatalogueScene, RunSize] | None:
    """A case of a scene that is not too large, of some draws the largest."""
    best = None
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
            best = (made, size)
        if best is not None and in_grid(best[1]) > ENOUGH:
            break
    return best


def status(name: str) -> float:
    """A number of the kernel's about this process [byte]."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(1024.0 * int(line.split()[1]) for line in lines if line.startswith(name))


def build(made: CatalogueScene | None, connection: Connection) -> None:
    """Build a case, or a run of none, and send how much the peak is above the start."""
    before = status("VmRSS")
    Path("/proc/self/clear_refs").write_text("5")
    Simulation((made or random_scene(random.Random(0), "element_test")).build()).advance(2)
    connection.send(status("VmHWM") - before)


def peak(made: CatalogueScene | None) -> float | None:
    """Memory of a case above that of its process at the start [byte]; None where it fails."""
    fork = multiprocessing.get_context("fork")
    ours, theirs = fork.Pipe(duplex=False)
    worker = fork.Process(target=build, args=(made, theirs))
    worker.start()
    theirs.close()
    try:
        found: float = ours.recv()
    except EOFError:
        return None
    finally:
        worker.join()
    return found


def main() -> None:
    """Draw, build and compare."""
    count, source = int(sys.argv[1]), random.Random(int(sys.argv[2]))
    least = peak(None)
    assert least is not None
    ratios = []
    names = [name for name in sorted(scene_names()) if name not in OTHERS]
    for name in itertools.islice(itertools.cycle(names), count):
        found = drawn(source, name)
        taken = None if found is None else peak(found[0])
        if found is None or taken is None:
            continue
        used = SMALLEST_PROCESS + taken - least
        predicted = PROCESS_MEMORY + in_grid(found[1])
        ratios.append(predicted / used)
        print(f"{name:20} used {used / 1e6:6.1f} MB, predicted {ratios[-1]:.3f} of it", flush=True)
    low, middle, high = np.quantile(ratios, [0.0, 0.5, 0.95])
    within = np.mean([1.0 <= it <= 1.1 for it in ratios])
    print(f"{len(ratios)} cases: least {low:.3f}, median {middle:.3f}, 95 % below {high:.3f}")
    print(f"from 1.0 to 1.1: {within:.0%}; greatest {max(ratios):.3f}")


if __name__ == "__main__":
    main()
