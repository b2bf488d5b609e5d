"""Time stepping with noise whose bias is of first order in the step or less, at walls too.

The drift is the mean of that at the start and at a predicted end (Heun), the director turns by one exact rotation, and
the wall holds the swimmer as it holds a continuous path: by the lowest point of the Brownian bridge of the gap above
contact (Lepingle, Math. Comput. Simul. 38, 119, 1995). A sphere's gap has the variance 2 D dt of a step; that of a
spheroid gains from the turn of the director relative to the wall, by the slope of the contact height at the start.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.physics.bridge import reflection
from porous_swim.physics.contact import HardContact
from porous_swim.physics.drift import make_drift
from porous_swim.physics.model import Model
from porous_swim.physics.motility import make_reorient, make_swim
from porous_swim.physics.noise import make_draw, make_shares, make_turn
from porous_swim.physics.rounding import rounded
from porous_swim.physics.surface import make_surface
from porous_swim.physics.vectors import record, vec


@cache
def make_twist(model: Model):
    """Return `twist(e, rate)`, the rate of a director in the form that `noise.make_turn` takes."""
    if model.dimensions == 2:

        @ti.func
        def twist(e, rate):
            return vec(rounded(e[0] * rate[1]) - rounded(e[1] * rate[0]))

    else:

        @ti.func
        def twist(e, rate):
            return rate

    return twist


@cache
def make_reflected(model: Model):
    """Return `move(x, e, A, law, dt, at)`.

    `law` holds the numbers of the swimmer by name, `at` is a `noise.counter`. It gives the displacement, as if there
    were no wall, and the director; the gap at the start, its variance over the step and its excursion; and the
    excursion of the pitch.
    """
    real, n_turns = model.real, 2 * model.dimensions - 3
    drift, draw, turn, twist = make_drift(model), make_draw(model), make_turn(model), make_twist(model)
    (moves, turns), swim, reorient = make_shares(model), make_swim(model), make_reorient(model)
    height_and_slope, to = HardContact.make_height_and_slope(model), make_surface(model)

    @ti.func
    def turned(e, w):
        """The director turned; by at most one radian in each direction, as far as the series of `turn` goes."""
        return turn(e, vec(*[ti.max(real(-1.0), ti.min(w[d], real(1.0))) for d in ti.static(range(n_turns))]))

    @ti.func
    def predict(x, e, dx, de, law, wall):
        """Where a swimmer is at the end by the first drift; contact heights along their tangent, never below gamma."""
        e1, x1 = turned(e, de), x + dx
        R = to.distance(x1)
        least = ti.max(wall.least + wall.slope * (to.sine(x1, e1, R) - wall.sine), law.gamma)
        push = reflection(wall.gap, rounded(R - wall.A - least), wall.variance, wall.deep)
        return x1 + to.along(x1, R, push), e1

    @ti.func
    def move(x, e, A, law, dt, at):
        g, deep, aside = draw(at)
        kick, wobble = rounded(moves(g) * law.kick), rounded(turns(g) * law.turn)
        R = to.distance(x)
        s, bend = to.sine(x, e, R), to.bend(real(1.0), R)
        least, slope = height_and_slope(s, law.gamma, A)
        gap = rounded(R - A - least)
        tilt = slope * slope * (real(1.0) - s * s)
        variance = law.kick * law.kick + tilt * (law.turn * law.turn + law.kick * law.kick * bend * bend)
        velocity, rate = drift(((x, A),), e, law)
        v, spin = swim(e, law), twist(e, rate)
        wall = record(A=A, least=least, slope=slope, sine=s, gap=gap, variance=variance, deep=deep)
        x1, e1 = predict(x, e, (v + velocity) * dt + kick, spin * dt + wobble, law, wall)
        velocity1, rate1 = drift(((x1, A),), e1, law)
        half = real(0.5) * dt
        dx = (v + velocity + (swim(e1, law) + velocity1)) * half + kick
        e2 = turned(e, (spin + twist(e1, rate1)) * half + wobble)
        return dx, reorient(e2, law, at), gap, variance, deep, aside

    return move
