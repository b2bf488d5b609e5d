"""One trial step of one lane between reflecting walls. Straight-line code that vectorises, as in `move`."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.book import make_book, make_vectors
from porous_swim.engine.move import FAR
from porous_swim.engine.state import Event, Int, LaneInt, Phase, real_rows
from porous_swim.physics.bridge import reflection
from porous_swim.physics.rounding import rounded
from porous_swim.physics.surface import Surface, make_surface


@cache
def make_reflect(real, dimensions: int, integrate, contact_height, sphere: bool, surface: Surface):
    """Return `step(f, n, j, swimmer, swimmers, medium, rules, n_steps)`, which moves lane j if it waits for nothing.

    A move beyond the budget (within which the nearest colloid cannot change) stays a trial: the scalar pass ends it.
    """
    rows = real_rows(dimensions)
    get, put = make_vectors(dimensions)
    book = make_book(real, dimensions, surface, "reflected")
    to = make_surface(real, surface)

    @ti.func
    def step(f: ti.template(), n: ti.template(), j, swimmer, swimmers: ti.template(), medium: ti.template(),
             rules: ti.template(), n_steps):  # fmt: skip
        on = (n[Int.EVENT, j] == 0) & (n[Int.STEP, j] < n_steps)
        x, A, gamma = get(f, rows.x, j), f[rows.A, j], f[rows.gamma, j]
        law = ti.Vector([f[rows.alpha + k, j] for k in ti.static(range(4))])
        low = rules.first_low + ti.cast(n[Int.STEP, j], ti.u32)
        high = rules.first_high + ti.select(low < rules.first_low, ti.u32(1), ti.u32(0))
        dx, e, gap0, variance, deep, aside = integrate(
            x, get(f, rows.e, j), A, law, gamma, rules.dt, ti.cast(swimmer, ti.u32), low, high, rules.key0, rules.key1
        )  # fmt: skip
        y = dx + get(f, rows.rest, j)  # compensated: a swimmer far from its colloid loses no digit of its steps
        x1 = rounded(x + y)
        rest = y - (x1 - x)
        R = to.distance(x1)
        least = contact_height(to.sine(x1, e, R), gamma, A)
        push = reflection(gap0, rounded(R - A - least), variance, deep)
        y = to.along(x1, R, push) + rest
        x = x1
        x1 = rounded(x + y)
        put(f, rows.trial_x, j, x1)
        put(f, rows.trial_rest, j, y - (x1 - x))
        put(f, rows.trial_e, j, e)
        f[rows.height_excursion, j], f[rows.pitch_excursion, j] = deep, aside
        counts = (n[LaneInt.OWN, j] != 0) | (n[Int.PHASE, j] != int(Phase.BOUND))
        f[rows.trial_push, j] = ti.select(counts, push, real(0.0))
        n[LaneInt.TOUCH, j] = ti.cast(push > real(0.0), ti.i32)
        moved = x1 - get(f, rows.reference, j)
        within = moved.dot(moved) <= f[rows.budget, j]  # false for a position that is not finite
        n[Int.EVENT, j] |= ti.select(on & (not within), int(Event.FINISH), 0)
        if ti.static(not sphere):  # within its budget a rod is out of contact with every other colloid
            least = ti.select(n[LaneInt.OWN, j] != 0, least, real(-FAR))
        book(f, n, j, on & within, rules, least)

    return step
