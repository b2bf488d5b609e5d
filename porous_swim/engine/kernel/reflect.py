"""One trial step of a block between reflecting walls. Straight-line code on wide values, as in `move`."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.move import make_end, now
from porous_swim.engine.kernel.pairs import make_pair
from porous_swim.engine.kernel.rows import make_law, make_wide, rows_of
from porous_swim.engine.kernel.state import Int, LaneInt, Phase
from porous_swim.physics.bridge import reflection
from porous_swim.physics.contact import HardContact
from porous_swim.physics.model import Model
from porous_swim.physics.reflected import make_reflected
from porous_swim.physics.rounding import rounded
from porous_swim.physics.surface import make_surface


@cache
def make_reflect(model: Model):
    """Return `step(reals, ints, swimmer, swimmers, medium, rules, n_steps, n_pairs)`, which moves the lanes."""
    real, partners, flights, rows = model.real, model.partners, model.flights, rows_of(model)
    (whole, put_whole), (law_of, _) = make_wide(model), make_law(model)
    integrate, pair, end = make_reflected(model), make_pair(model), make_end(model)
    contact_height, to = HardContact.make_height(model), make_surface(model)

    @ti.func
    def scaled(reals: ti.template(), ints: ti.template(), x, A, rules: ti.template()):
        """The length of each lane's step, and the law over it: a free swimmer far from all takes several at once."""
        law = law_of(reals)
        if ti.static(not flights):
            return rules.dt, law
        flies = (ints[LaneInt.PHASE] == int(Phase.FREE)) & (ints[LaneInt.AFTER] == 0)
        far = flies & (to.distance(x) - A >= rules.flight_height)
        ticks = ti.cast(rules.flight_ticks, real)
        ints[LaneInt.TICKS] = ti.select(far, rules.flight_ticks, 1)
        root = ti.select(far, ti.sqrt(ticks), real(1.0))
        return ti.select(far, rules.dt * ticks, rules.dt), law.but(kick=law.kick * root, turn=law.turn * root)

    @ti.func
    def step(reals: ti.template(), ints: ti.template(), swimmer, swimmers: ti.template(), medium: ti.template(),
             rules: ti.template(), n_steps, n_pairs):  # fmt: skip
        on = (ints[Int.EVENT] == 0) & (ints[Int.STEP] < n_steps)
        x, A = whole(reals, rows.x), reals[rows.A]
        dt, law = scaled(reals, ints, x, A, rules)
        at = now(ints, swimmer, rules)
        dx, e, gap0, variance, deep, aside = integrate(x, whole(reals, rows.e), A, law, dt, at)
        y = dx + whole(reals, rows.rest)  # compensated: a swimmer far from its colloid loses no digit of its steps
        free = rounded(x + y)
        R = to.distance(free)
        least = contact_height(to.sine(free, e, R), law.gamma, A)
        push = reflection(gap0, rounded(R - A - least), variance, deep)
        z = to.along(free, R, push) + (y - (free - x))
        x1 = rounded(free + z)
        put_whole(reals, rows.trial_x, x1)
        put_whole(reals, rows.trial_rest, z - (x1 - free))
        put_whole(reals, rows.trial_e, e)
        reals[rows.height_excursion], reals[rows.pitch_excursion] = deep, aside
        counts = (ints[LaneInt.OWN] != 0) | (ints[LaneInt.PHASE] != int(Phase.BOUND))
        reals[rows.trial_push] = ti.select(counts, push, real(0.0))
        ints[LaneInt.TOUCH] = ti.cast(push > real(0.0), ti.i32)
        if ti.static(partners):
            least_own, needs = pair(reals, ints, n_pairs, least)
            end(reals, ints, on, rules, least_own, needs)
        else:
            end(reals, ints, on, rules, least, 0)

    return step
