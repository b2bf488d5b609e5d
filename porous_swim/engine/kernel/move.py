"""One trial step of a block: drift, noise, contact with the nearest colloid. Straight-line code on wide values."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.commit import make_commit
from porous_swim.engine.kernel.pairs import make_pair
from porous_swim.engine.kernel.rows import make_law, make_wide, rows_of
from porous_swim.engine.kernel.state import Event, Int, LaneInt
from porous_swim.physics.contact import HardContact
from porous_swim.physics.euler import make_euler
from porous_swim.physics.model import Model
from porous_swim.physics.noise import counter
from porous_swim.physics.rounding import rounded
from porous_swim.physics.surface import make_surface

FAR = 1e3  # a


@ti.func
def now(ints: ti.template(), swimmer, rules: ti.template()):
    """The counter of each lane's random numbers: its swimmer, and the step since the start of the run."""
    low = ti.cast(ints[Int.STEP], ti.u32) + rules.first_low
    high = ti.select(low < rules.first_low, ti.u32(1), ti.u32(0)) + rules.first_high
    return counter(swimmer, low, high, rules.key0, rules.key1)


@cache
def make_end(model: Model):
    """Return `end(reals, ints, on, rules, least, needs)`, which books the trial moves of the lanes `on` within budget.

    A move beyond the budget (within which the nearest colloid cannot change) stays a trial: the scalar pass settles it,
    and those of lanes that have a 1 in `needs`. `least` is the contact height of the trial above the nearest colloid,
    or above a partner whose encounter it is.
    """
    real, sphere, partners = model.real, model.sphere, model.partners
    rows, (whole, _), commit = rows_of(model), make_wide(model), make_commit(model)

    @ti.func
    def end(reals: ti.template(), ints: ti.template(), on, rules: ti.template(), least, needs):
        moved = whole(reals, rows.trial_x) - whole(reals, rows.reference)
        within = moved.dot(moved) <= reals[rows.budget]  # false for a position that is not finite
        if ti.static(partners):
            within = within & (needs == 0)
        ints[Int.EVENT] = ints[Int.EVENT] | ti.select(on & (not within), int(Event.FINISH), 0)
        if ti.static(sphere):
            commit(reals, ints, on & within, rules, least)
        else:  # within its budget a rod is out of contact with every other colloid
            own = ints[LaneInt.OWN] != 0
            if ti.static(partners):
                own = own | (ints[LaneInt.PARTNER_OWN] != 0)
            commit(reals, ints, on & within, rules, ti.select(own, least, real(-FAR)))

    return end


@cache
def make_step(model: Model):
    """Return `step(reals, ints, swimmer, swimmers, medium, rules, n_steps, n_pairs)`, which moves the lanes."""
    real, partners, rows = model.real, model.partners, rows_of(model)
    (whole, put_whole), (law, _) = make_wide(model), make_law(model)
    integrate, pair, end = make_euler(model), make_pair(model), make_end(model)
    contact_height, to = HardContact.make_height(model), make_surface(model)

    @ti.func
    def keep_out(x, rest, e, A, gamma):
        """Project a position that is inside the contact height back on it."""
        R = to.distance(x)
        height = contact_height(to.sine(x, e, R), gamma, A)
        least = A + height
        push = ti.max(least - R, real(0.0))
        y = to.along(x, R, push) + rest  # compensated like the step: slow sliding along a large colloid is not lost
        z = rounded(x + y)
        return z, y - (z - x), least >= R, push, height

    @ti.func
    def step(reals: ti.template(), ints: ti.template(), swimmer, swimmers: ti.template(), medium: ti.template(),
             rules: ti.template(), n_steps, n_pairs):  # fmt: skip
        on = (ints[Int.EVENT] == 0) & (ints[Int.STEP] < n_steps)
        x, A = whole(reals, rows.x), reals[rows.A]
        dx, e = integrate(x, whole(reals, rows.e), A, law(reals), rules.dt, now(ints, swimmer, rules))
        y = dx + whole(reals, rows.rest)  # compensated: a swimmer far from its colloid loses no digit of its steps
        free = rounded(x + y)
        x1, rest, touch, push, least = keep_out(free, y - (free - x), e, A, reals[rows.law.gamma])
        reals[rows.trial_push] = ti.select(ints[LaneInt.OWN] != 0, push, real(0.0))
        put_whole(reals, rows.trial_x, x1)
        put_whole(reals, rows.trial_rest, rest)
        put_whole(reals, rows.trial_e, e)
        ints[LaneInt.TOUCH] = ti.cast(touch, ti.i32)
        if ti.static(partners):
            least_own, needs = pair(reals, ints, n_pairs, least)
            end(reals, ints, on, rules, least_own, needs)
        else:
            end(reals, ints, on, rules, least, 0)

    return step
