"""Vectors in the rows of a block: those of one lane, and those of all lanes at once."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.physics.vectors import vec


@cache
def make_vectors(dimensions: int):
    """Return `get(f, row, j)` and `put(f, row, j, v)` for the vectors of lane j."""

    @ti.func
    def get(f: ti.template(), row: ti.template(), j):
        return vec(*[f[row + d][j] for d in ti.static(range(dimensions))])

    @ti.func
    def put(f: ti.template(), row: ti.template(), j, v):
        for d in ti.static(range(dimensions)):
            f[row + d][j] = v[d]

    return get, put


@cache
def make_wide(dimensions: int):
    """Return `whole(f, row)` and `put_whole(f, row, v)` for the vectors of all lanes at once."""

    @ti.func
    def whole(f: ti.template(), row: ti.template()):
        return vec(*[f[row + d] for d in ti.static(range(dimensions))])

    @ti.func
    def put_whole(f: ti.template(), row: ti.template(), v):
        for d in ti.static(range(dimensions)):
            f[row + d] = v[d]

    return whole, put_whole
