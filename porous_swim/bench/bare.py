"""One colloid and nothing else: the engine's own drift, noise and contact in lanes, without bookkeeping.

What the engine's kernel costs beyond this is the price of records, budgets and compensated sums.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.rows import make_wide
from porous_swim.physics.contact import HardContact
from porous_swim.physics.euler import make_euler
from porous_swim.physics.law import make_named
from porous_swim.physics.model import Model
from porous_swim.physics.noise import counter

ROWS = 6  # position and director


@cache
def make_bare(model: Model):
    """Compile `advance(state, first, n_steps, ...)`, which moves spheres by forward Euler steps among spheres.

    `state` is (6, n_swimmers), offsets from the colloid and directors; n_swimmers is a multiple of the lanes.
    """
    real, lanes, move = model.real, model.lanes, make_euler(model)
    contact_height, (whole, put_whole) = HardContact.make_height(model), make_wide(model)
    Wide, WideWord = ti.types.vector(lanes, real), ti.types.vector(lanes, ti.u32)
    n_numbers, named = len(model.numbers), make_named(model)
    Numbers, Reals = ti.types.vector(n_numbers, real), ti.types.ndarray(real, ndim=2)

    @ti.func
    def step(f: ti.template(), swimmer, A, law, dt, now, key):
        zero = swimmer * ti.u32(0)
        dx, e = move(whole(f, 0), whole(f, 3), A, law, dt, counter(swimmer, zero + now, zero, key, ti.u32(0)))
        x = whole(f, 0) + dx
        R = ti.sqrt(x.dot(x))
        least = A + contact_height(x.dot(e) / R, law.gamma, A)
        put_whole(f, 0, x * ti.max(least / R, real(1.0)))
        put_whole(f, 3, e)

    @ti.kernel
    def advance(
        state: Reals, first: ti.u32, n_steps: ti.i32, A: real, numbers: Numbers, dt: real, key: ti.u32, stride: ti.i32
    ):
        law = named(*[numbers[k] for k in ti.static(range(n_numbers))])
        for t in range(state.shape[1] // lanes * stride):  # Taichi's tasks are long: a block is `stride` iterations
            if t % stride == 0:
                begin = t // stride * lanes
                f, swimmer = [Wide(0.0) for _ in ti.static(range(ROWS))], WideWord(ti.u32(0))
                for j in range(lanes):
                    swimmer[j] = ti.cast(begin + j, ti.u32)
                    for row in ti.static(range(ROWS)):
                        f[row][j] = state[row, begin + j]
                for n in range(n_steps):
                    step(f, swimmer, A, law, dt, first + ti.cast(n, ti.u32), key)
                for j in range(lanes):
                    for row in ti.static(range(ROWS)):
                        state[row, begin + j] = f[row][j]

    return advance
