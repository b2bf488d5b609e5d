"""One colloid and nothing else: the engine's own drift, noise and contact in lanes, without bookkeeping.

What the engine's kernel costs beyond this is the price of records, budgets and compensated sums.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.physics.contact import HardContact
from porous_swim.physics.euler import make_euler
from porous_swim.physics.hydrodynamics import ImageDipole

ROWS = 6  # position and director


@cache
def make_bare(real, lanes: int):
    """Compile `advance(state, first, n_steps, ...)`, which moves spheres in space by uniform noise and hard contact.

    `state` is (6, n_swimmers), offsets from the colloid and directors; n_swimmers is a multiple of `lanes`.
    """
    move = make_euler(ImageDipole.make_drift(real), real, 3, "uniform")
    contact_height = HardContact.make_height(real, "sphere")
    Rows = ti.types.matrix(ROWS, lanes, real)
    Law, Reals = ti.types.vector(4, real), ti.types.ndarray(real, ndim=2)

    @ti.func
    def step(f: ti.template(), j, swimmer, A, law, dt, now, key):
        x, e = ti.Vector([f[d, j] for d in ti.static(range(3))]), ti.Vector([f[3 + d, j] for d in ti.static(range(3))])
        dx, e = move(x, e, A, law, dt, swimmer, now, ti.u32(0), key, ti.u32(0))
        x += dx
        R = ti.sqrt(x.dot(x))
        least = A + contact_height(x.dot(e) / R, real(1.0), A)
        x = ti.max(least / R, real(1.0)) * x
        for d in ti.static(range(3)):
            f[d, j], f[3 + d, j] = x[d], e[d]

    @ti.kernel
    def advance(state: Reals, first: ti.u32, n_steps: ti.i32, A: real, law: Law, dt: real, key: ti.u32, stride: ti.i32):
        for t in range(state.shape[1] // lanes * stride):  # Taichi's tasks are long: a block is `stride` iterations
            if t % stride == 0:
                begin = t // stride * lanes
                f = Rows(0.0)
                for j in range(lanes):
                    for row in ti.static(range(ROWS)):
                        f[row, j] = state[row, begin + j]
                for n in range(n_steps):
                    for j in range(lanes):
                        step(f, j, ti.cast(begin + j, ti.u32), A, law, dt, first + ti.cast(n, ti.u32), key)
                for j in range(lanes):
                    for row in ti.static(range(ROWS)):
                        state[row, begin + j] = f[row, j]

    return advance
