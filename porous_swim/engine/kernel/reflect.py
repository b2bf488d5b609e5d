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
    """Return `step(f, n, swimmer, swimmers, medium, rules, n_steps, n_pairs)`, which moves those that do not wait."""
    real, partners, flights, rows = model.real, model.partners, model.flights, rows_of(model)
    (whole, put_whole), (law_of, _) = make_wide(model), make_law(model)
    integrate, pair, end = make_reflected(model), make_pair(model), make_end(model)
    contact_height, to = HardContact.make_height(model), make_surface(model)

    @ti.func
    def scaled(f: ti.template(), n: ti.template(), x, A, rules: ti.template()):
        """The length of each lane's step, and the law over it: a free swimmer far from all takes several at once."""
        law = law_of(f)
        if ti.static(not flights):
            return rules.dt, law
        flies = (n[LaneInt.PHASE] == int(Phase.FREE)) & (n[LaneInt.AFTER] == 0)
        far = flies & (to.distance(x) - A >= rules.flight_height)
        ticks = ti.cast(rules.flight_ticks, real)
        n[LaneInt.TICKS] = ti.select(far, rules.flight_ticks, 1)
        root = ti.select(far, ti.sqrt(ticks), real(1.0))
        return ti.select(far, rules.dt * ticks, rules.dt), law.but(kick=law.kick * root, turn=law.turn * root)

    @ti.func
    def step(f: ti.template(), n: ti.template(), swimmer, swimmers: ti.template(), medium: ti.template(),
             rules: ti.template(), n_steps, n_pairs):  # fmt: skip
        on = (n[Int.EVENT] == 0) & (n[Int.STEP] < n_steps)
        x, A = whole(f, rows.x), f[rows.A]
        dt, law = scaled(f, n, x, A, rules)
        at = now(n, swimmer, rules)
        dx, e, gap0, variance, deep, aside = integrate(x, whole(f, rows.e), A, law, dt, at)
        y = dx + whole(f, rows.rest)  # compensated: a swimmer far from its colloid loses no digit of its steps
        free = rounded(x + y)
        R = to.distance(free)
        least = contact_height(to.sine(free, e, R), law.gamma, A)
        push = reflection(gap0, rounded(R - A - least), variance, deep)
        z = to.along(free, R, push) + (y - (free - x))
        x1 = rounded(free + z)
        put_whole(f, rows.trial_x, x1)
        put_whole(f, rows.trial_rest, z - (x1 - free))
        put_whole(f, rows.trial_e, e)
        f[rows.height_excursion], f[rows.pitch_excursion] = deep, aside
        counts = (n[LaneInt.OWN] != 0) | (n[LaneInt.PHASE] != int(Phase.BOUND))
        f[rows.trial_push] = ti.select(counts, push, real(0.0))
        n[LaneInt.TOUCH] = ti.cast(push > real(0.0), ti.i32)
        if ti.static(partners):
            least_own, needs = pair(f, n, n_pairs, least)
            end(f, n, on, rules, least_own, needs)
        else:
            end(f, n, on, rules, least, 0)

    return step
