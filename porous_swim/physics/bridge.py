"""How far a Brownian path goes between two points that are known: the bridge of one step.

An `excursion` is -2 ln U of a uniform variate U; `variance` is that of the path over the step.
Source: Lepingle, Math. Comput. Simul. 38, 119 (1995).
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
import taichi as ti


@ti.func
def reflection(g0, g1, variance, excursion):
    """How far a wall at 0 pushes a path from g0 to g1 (both as if free): minus its lowest point where that is below."""
    rise = g1 - g0
    twice = ti.sqrt(rise * rise + variance * excursion) - (g0 + g1)
    return ti.max(twice, 0.0) * 0.5


@ti.func
def crosses(c, s0, s1, variance, excursion):
    """Whether a path from s0 to s1 passes c on its way: with probability exp(-2 (c - s0) (c - s1)/variance)."""
    return (c - s0) * (c - s1) * 4.0 < variance * excursion
