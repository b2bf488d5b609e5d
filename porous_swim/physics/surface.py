"""How a swimmer stands to a surface: its distance along the normal, its pitch, and moves along the normal.

The offset of a swimmer from a sphere is seen from the centre, in the axes of space; the one from a plane wall is seen
from a point of the wall, in axes whose last one is the normal. The height above a wall is thus a coordinate, which
keeps its digits however far the swimmer slides. Height is distance minus A, with A = 0 for a wall.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache
from types import SimpleNamespace

import taichi as ti

from porous_swim.physics.model import Model

NEAREST = 1e-6  # a, the least distance from the centre of a sphere: a free swimmer may stand where it is measured from


@cache
def make_surface(model: Model) -> SimpleNamespace:
    """Return the functions of the obstacles' surface, of an offset x whose distance is R.

    `distance(x)` is R, `normal(x, R)` points into the fluid, `sine(x, v, R)` is the part of v along it, `along(x, R,
    length)` a vector of that length along it, `at(x, R, distance)` the point at a distance on the normal through x,
    `bend(v, R)` the rate at which the normal turns under a motion with speed v along the surface.
    """
    return make_sphere(model) if model.surface == "sphere" else make_plane(model)


@cache
def make_sphere(model: Model) -> SimpleNamespace:
    """Return these functions for a sphere."""
    real = model.real

    @ti.func
    def distance(x):
        return ti.sqrt(ti.max(x.dot(x), real(NEAREST**2)))  # all others divide by it

    @ti.func
    def normal(x, R):
        return x / R

    @ti.func
    def sine(x, v, R):
        return x.dot(v) / R

    @ti.func
    def along(x, R, length):
        return x * (length / R)

    @ti.func
    def bend(v, R):
        return v / R

    return SimpleNamespace(distance=distance, normal=normal, sine=sine, along=along, at=along, bend=bend)


@cache
def make_plane(model: Model) -> SimpleNamespace:
    """Return these functions for a plane wall."""
    real = model.real

    @ti.func
    def distance(x):
        return x[x.n - 1]

    @ti.func
    def sine(x, v, R):
        return v[v.n - 1]

    @ti.func
    def along(x, R, length):
        v = x * real(0.0)
        v[x.n - 1] = length
        return v

    @ti.func
    def normal(x, R):
        return along(x, R, real(1.0))

    @ti.func
    def at(x, R, distance):
        y = x * real(1.0)
        y[x.n - 1] = distance
        return y

    @ti.func
    def bend(v, R):
        return real(0.0)

    return SimpleNamespace(distance=distance, normal=normal, sine=sine, along=along, at=at, bend=bend)
