"""Commands on scenes, and on what there is.

What computes is imported by the command that needs it: help is at once.
"""

from __future__ import annotations

import argparse

from harness.cli.exit_codes import DONE, INCOMPLETE
from harness.errors import HarnessError
from harness.study.definition import study_names
from harness.study.study import load_study
from mpm_warp.parameters import parameters_of
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
    import json

    from harness.study.schema import study_schema

    print(json.dumps(study_schema(), indent=2))
    return DONE


def show_plan(options: argparse.Namespace) -> int:
    """Print the kernels and arrays of a scene."""
    from harness.cli.plan_text import plan_text
    from harness.run.worker import start_warp_in_silence

    start_warp_in_silence()
    scene = scene_class(options.scene)()
    plan = scene.plan()
    if plan is None:
        raise HarnessError(f"{options.scene}: the scene runs no grid, it has no plan")
    print(plan_text(plan, scene.step_count_bound(plan)))
    return DONE


def verify_scenes(options: argparse.Namespace) -> int:
    """Hold scenes against their exact solutions."""
    from harness.archive.atomic_files import prepare, write_whole
    from harness.archive.case_files import write_netcdf
    from harness.archive.provenance import provenance
    from harness.run.verify import as_dataset, checks_of, heading, table_rows, verify
    from harness.run.worker import start_warp_in_silence

    checks = checks_of(options.scene, extreme=options.extreme)
    start_warp_in_silence()
    if options.out is not None:
        prepare(options.out)
    lines, results = [heading()], []
    print(lines[0])
    for check in checks:
        results.append(verify(check))
        lines.append(table_rows(results[-1]))
        print(lines[-1], flush=True)
        if options.out is not None:
            dataset = as_dataset(results).assign_attrs(provenance())
            write_netcdf(dataset, options.out / "verify.nc")
            write_whole("\n".join([*lines, ""]).encode(), options.out / "verify.txt")
    if options.out is not None:
        from harness.pictures.work_precision import draw_work_precision

        draw_work_precision(as_dataset(results), options.out / "verify.png")
    return INCOMPLETE if any(result.shortfalls for result in results) else DONE
