"""Vectors in the rows of a block: those of one lane, and those of all lanes at once."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache
from types import SimpleNamespace

import taichi as ti

from porous_swim.engine.kernel.state import real_rows
from porous_swim.physics.law import make_named
from porous_swim.physics.model import Model
from porous_swim.physics.vectors import for_kernels, lane_of, vec


def rows_of(model: Model) -> SimpleNamespace:
    """Row numbers of the real arrays: see `state.real_rows`."""
    return real_rows(model.dimensions, located=model.located, numbers=model.numbers)


@ti.func
def get_image(ints: ti.template(), row: ti.template(), j):
    """The periodic image in three rows of lane j."""
    return vec(*[ints[row + d][j] for d in ti.static(range(3))])


@ti.func
def put_lane_image(ints: ti.template(), row: ti.template(), j, image):
    """Store a periodic image in three rows of lane j."""
    for d in ti.static(range(3)):
        ints[row + d][j] = image[d]


@cache
def make_vectors(model: Model):
    """Return `get(reals, row, j)` and `put(reals, row, j, v)` for the vectors of lane j."""
    dimensions = model.dimensions

    @ti.func
    def get(reals: ti.template(), row: ti.template(), j):
        return vec(*[reals[row + d][j] for d in ti.static(range(dimensions))])

    @ti.func
    def put(reals: ti.template(), row: ti.template(), j, v):
        for d in ti.static(range(dimensions)):
            reals[row + d][j] = v[d]

    return get, put


@cache
def make_wide(model: Model):
    """Return `whole(reals, row)` and `put_whole(reals, row, v)` for the vectors of all lanes at once."""
    dimensions = model.dimensions

    @ti.func
    def whole(reals: ti.template(), row: ti.template()):
        return vec(*[reals[row + d] for d in ti.static(range(dimensions))])

    @ti.func
    def put_whole(reals: ti.template(), row: ti.template(), v):
        for d in ti.static(range(dimensions)):
            reals[row + d] = v[d]

    return whole, put_whole


@cache
def make_law(model: Model):
    """Return `law(reals)` and `law_of_lane(reals, j)`: the numbers of the swimmers in all lanes by name, or in one."""
    named, rows = make_named(model), vars(rows_of(model).law).values()

    @for_kernels
    def law(f):
        return named(*[f[row] for row in rows])

    @for_kernels
    def law_of_lane(f, j):
        return named(*[lane_of(f[row], j) for row in rows])

    return law, law_of_lane
