"""Sums and products that every device is to round where the source does."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
import taichi as ti


@ti.func
def rounded(x):
    """Return x, which no compiler then takes apart: Mesa's makes `(a + b) - a` into `b`, others fuse `a * b + c`."""
    return ti.select(x < -1e30, -1e30, x)  # not a maximum, which would lose what is not a number
