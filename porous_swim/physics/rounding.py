"""Sums and products that every device is to round where the source does."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
import taichi as ti

from porous_swim.physics.vectors import Vec, for_kernels


@ti.func
def _kept(x):
    return ti.select(x < -1e30, -1e30, x)  # not a maximum, which would lose what is not a number


@for_kernels
def rounded(x):
    """Return x, which no compiler then takes apart: Mesa's makes `(a + b) - a` into `b`, others fuse `a * b + c`."""
    return Vec([_kept(component) for component in x.components]) if isinstance(x, Vec) else _kept(x)
