"""Commands on scenes: which there are, their parameters, the schema of studies, their plans."""

from __future__ import annotations

import argparse
import json

from harness.cli.exit_codes import DONE
from harness.run.limits import UPDATE_RATE
from harness.study.files import study_names
from harness.study.schema import study_schema
from harness.study.study import load_study
from mpm_warp.parameters import parameters_of
from mpm_warp.plan.launch import Launch
from mpm_warp.plan.plan import Plan
from mpm_warp.scenes import scene_class, scene_names


def list_names(options: argparse.Namespace) -> int:
    """Print the studies and scenes that there are."""
    print("studies:")
    for name in study_names():
        print(f"  {name:24} {load_study(name).title}")
    print("scenes:")
    for name in scene_names():
        print(f"  {name:24} {scene_class(name).summary}")
    return DONE


def describe(options: argparse.Namespace) -> int:
    """Print a scene's parameters."""
    scene = scene_class(options.scene)
    print(f"{options.scene}: {scene.summary}\n")
    for name, parameter in parameters_of(scene).items():
        unit = "" if parameter.unit == "1" else f" {parameter.unit}"
        default = "derived" if parameter.default is None else f"{parameter.default}{unit}"
        print(f"{name:26} {default:16} {parameter.meaning}; {parameter.allowed}")
    return DONE


def schema(options: argparse.Namespace) -> int:
    """Print the JSON schema of studies."""
    print(json.dumps(study_schema(), indent=2))
    return DONE


def show_plan(options: argparse.Namespace) -> int:
    """Print the kernels and arrays of a scene."""
    scene = scene_class(options.scene)()
    plan = scene.plan()
    print(_plan_text(plan, scene.step_count_bound(plan)))
    return DONE


def _plan_text(plan: Plan, step_count_bound: int | None) -> str:
    """Launches of a step, arrays and their bytes, particle count, time step, steps and seconds."""
    lines = [f"kernels of a step: {len(plan.step)}"]
    lines += [_launch_line(launch) for launch in plan.step]
    now_and_then = plan.launches[len(plan.step) :]
    if now_and_then:
        lines += ["kernels now and then:", *map(_launch_line, now_and_then)]
    byte_count = sum(array.byte_count for array in plan.arrays.values())
    lines += [f"arrays: {len(plan.arrays)}, {byte_count:,} bytes"]
    lines += [
        f"  {name:24} {array.dtype.__name__:12} {array.shape!s:14} {array.byte_count:>12,} bytes"
        for name, array in plan.arrays.items()
    ]
    lines += [f"particles: {plan.particle_count:,}", f"time step: {plan.time_step:.4g} s"]
    if step_count_bound is not None:
        seconds = step_count_bound * plan.particle_count / UPDATE_RATE
        lines.append(
            f"steps: {step_count_bound:,} at most, {seconds:.2g} s at "
            f"{UPDATE_RATE / 1e6:.0f} million particle updates a second"
        )
    return "\n".join(lines)


def _launch_line(launch: Launch) -> str:
    # Warp names a kernel by the functions that it was defined in, too.
    return f"  {launch.kernel.key.split('__')[-1]:24} {launch.dim}"
