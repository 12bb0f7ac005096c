"""A plan as text: kernels in their order, arrays with what they take."""

from __future__ import annotations

from mpm_warp.plan.plan import Launch, StepPlan

UPDATE_RATE = 20e6
"""Particle updates a second on one thread, as `harness bench` measures them."""


def plan_text(plan: StepPlan, step_count_bound: int | None) -> str:
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
