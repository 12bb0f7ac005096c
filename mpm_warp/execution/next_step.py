"""Which step comes next, and whether there is one: what a recorded loop over steps goes by."""

import functools
from typing import Any

import warp as wp

AUDIT_INTERVAL = 16
"""Steps between two that are audited."""
STEP, END, GOES_ON, AUDITED = range(4)
"""Places in the state of a loop: the step to take, the one at which to stop, and two conditions."""


@functools.cache
def make_next_step() -> Any:
    """The kernel, launched once at the end of each step; `loop` is the state, of four numbers."""

    @wp.kernel(module="mpm_warp.next_step", enable_backward=False)
    def next_step(loop: wp.array(dtype=int)):
        step = loop[wp.static(STEP)] + 1
        loop[wp.static(STEP)] = step
        loop[wp.static(GOES_ON)] = int(step < loop[wp.static(END)])
        loop[wp.static(AUDITED)] = int(step % wp.static(AUDIT_INTERVAL) == 0)

    return next_step
