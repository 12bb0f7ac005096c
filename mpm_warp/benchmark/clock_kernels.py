"""What measures the speed of the kernels: a clock between launches, and three bare loops.

The loops say what the machine gives to any kernel, so that figures of different machines can be
set side by side.
"""

import functools
from typing import Any

import warp as wp

CHAINS = wp.types.vector(64, wp.float64)
"""Numbers worked on at a time: fewer would wait for each other's results."""
DIVISION_CHAINS = wp.types.vector(16, wp.float64)
"""The same of divisions, each of which keeps the processor busy for longer."""


@functools.cache
def make_stamp() -> Any:
    """The kernel, launched once: adds the ticks since its last launch to those of an interval."""

    @wp.func_native("""
    #if defined(__aarch64__)
        wp::int64 now;
        asm volatile("mrs %0, cntvct_el0" : "=r"(now));
    #else
        const wp::int64 now = __builtin_readcyclecounter();
    #endif
        ticks.data[interval] += now - latest.data[0];
        latest.data[0] = now;
    """)
    def add_ticks(
        interval: int, latest: wp.array(dtype=wp.int64), ticks: wp.array(dtype=wp.int64)
    ): ...

    @wp.kernel(module="mpm_warp.stamp", enable_backward=False)
    def stamp(interval: int, latest: wp.array(dtype=wp.int64), ticks: wp.array(dtype=wp.int64)):
        add_ticks(interval, latest, ticks)

    return stamp


@functools.cache
def make_streaming() -> Any:
    """The kernel y <- y + x over double precision numbers: 24 bytes each, hardly any arithmetic."""

    @wp.kernel(module="mpm_warp.streaming", enable_backward=False)
    def streaming(x: wp.array(dtype=wp.float64), y: wp.array(dtype=wp.float64)):
        i = wp.tid()
        y[i] = y[i] + x[i]

    return streaming


@functools.cache
def make_arithmetic() -> Any:
    """The kernel x <- a x + b, so many times over: as many numbers as keep the processor busy."""

    @wp.kernel(module="mpm_warp.arithmetic", enable_backward=False)
    def arithmetic(count: int, a: wp.float64, b: wp.float64, x: wp.array(dtype=CHAINS)):
        i = wp.tid()
        y = x[i]
        shift = CHAINS(b)
        for _ in range(count):
            y = a * y + shift
        x[i] = y

    return arithmetic


@functools.cache
def make_division() -> Any:
    """The kernel x <- a / x, so many times over."""

    @wp.kernel(module="mpm_warp.division", enable_backward=False)
    def division(count: int, a: wp.float64, x: wp.array(dtype=DIVISION_CHAINS)):
        i = wp.tid()
        y = x[i]
        dividend = DIVISION_CHAINS(a)
        for _ in range(count):
            y = wp.cw_div(dividend, y)
        x[i] = y

    return division
