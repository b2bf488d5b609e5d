"""One trial step of one lane: drift, noise, contact with the nearest colloid. Straight-line code that vectorises."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.book import make_book, make_vectors
from porous_swim.engine.state import Event, Int, LaneInt, real_rows
from porous_swim.physics.rounding import rounded
from porous_swim.physics.surface import Surface, make_surface

FAR = 1e3  # a


@cache
def make_step(real, dimensions: int, integrate, contact_height, sphere: bool, surface: Surface):
    """Return `step(f, n, j, swimmer, swimmers, medium, rules, n_steps)`, which moves lane j if it waits for nothing.

    A move beyond the budget (within which the nearest colloid cannot change) stays a trial: the scalar pass ends it.
    """
    rows = real_rows(dimensions)
    get, put = make_vectors(dimensions)
    book = make_book(real, dimensions, surface, "euler")
    to = make_surface(real, surface)

    @ti.func
    def keep_out(x, rest, e, A, gamma):
        """Project a position that is inside the contact height back on it."""
        R = to.distance(x)
        height = contact_height(to.sine(x, e, R), gamma, A)
        least = A + height
        touch = least >= R
        push = ti.max(least - R, real(0.0))
        y = to.along(x, R, push) + rest  # compensated like the step: slow sliding along a large colloid is not lost
        z = rounded(x + y)
        return z, y - (z - x), touch, push, height

    @ti.func
    def step(f: ti.template(), n: ti.template(), j, swimmer, swimmers: ti.template(), medium: ti.template(),
             rules: ti.template(), n_steps):  # fmt: skip
        on = (n[Int.EVENT, j] == 0) & (n[Int.STEP, j] < n_steps)
        x, rest = get(f, rows.x, j), get(f, rows.rest, j)
        law = ti.Vector([f[rows.alpha + k, j] for k in ti.static(range(4))])
        low = rules.first_low + ti.cast(n[Int.STEP, j], ti.u32)
        high = rules.first_high + ti.select(low < rules.first_low, ti.u32(1), ti.u32(0))
        A = f[rows.A, j]
        dx, e = integrate(
            x, get(f, rows.e, j), A, law, rules.dt, ti.cast(swimmer, ti.u32), low, high, rules.key0, rules.key1
        )
        y = dx + rest  # compensated: a swimmer far from its colloid loses no digit of its steps
        x1 = rounded(x + y)
        x1, rest, touch, push, least = keep_out(x1, y - (x1 - x), e, A, f[rows.gamma, j])
        put(f, rows.trial_x, j, x1)
        put(f, rows.trial_rest, j, rest)
        put(f, rows.trial_e, j, e)
        f[rows.trial_push, j] = ti.select(n[LaneInt.OWN, j] != 0, push, real(0.0))
        n[LaneInt.TOUCH, j] = ti.cast(touch, ti.i32)
        moved = x1 - get(f, rows.reference, j)
        within = moved.dot(moved) <= f[rows.budget, j]  # false for a position that is not finite
        n[Int.EVENT, j] |= ti.select(on & (not within), int(Event.FINISH), 0)
        if ti.static(not sphere):  # within its budget a rod is out of contact with every other colloid
            least = ti.select(n[LaneInt.OWN, j] != 0, least, real(-FAR))
        book(f, n, j, on & within, rules, least)

    return step
