"""Motion without noise to ten digits: an eighth-order step of adapted length, free, along a wall or between two.

Dormand and Prince's 8(5,3) method (Hairer, Norsett and Wanner, Solving Ordinary Differential Equations I, sec. II.5;
coefficients and error estimate as in SciPy) chooses its length itself, so that results do not depend on the time step
of a scene. A high order pays: errors that grow thousandfold near an unstable orbit leave no room for a low one, and
the motion is smooth between contact, lift-off and the change of the nearest colloid, which the caller locates.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from enum import IntEnum
from functools import cache

import numpy as np
import taichi as ti
from scipy.integrate import DOP853

from porous_swim.physics.contact import HardContact
from porous_swim.physics.drift import make_drift
from porous_swim.physics.model import Model
from porous_swim.physics.motility import make_swim
from porous_swim.physics.surface import make_surface


class Mode(IntEnum):
    """What holds a swimmer during a step."""

    FREE = 0
    HELD = 1  # at the wall of its colloid: the centre follows the contact height while the pitch changes
    BETWEEN = 2  # where two colloids are equally near and the flow of each draws the swimmer to the other


N_STAGES = DOP853.n_stages
TOLERANCE = 1e-12  # of position (a) and director, in one step; the rounding of a position of 40 is 7e-15
FINEST = 2.0**-50  # of the offset: far from the centre of a large colloid no step is exact to TOLERANCE


def tableau() -> np.ndarray:
    """(n_stages + 3, n_stages + 1): the stages, the result, and the two error estimates, of order 5 and 3."""
    table = np.zeros((N_STAGES + 3, N_STAGES + 1))
    table[:N_STAGES, :N_STAGES], table[N_STAGES, :N_STAGES] = DOP853.A, DOP853.B
    table[N_STAGES + 1], table[N_STAGES + 2] = DOP853.E5, DOP853.E3
    return table


@cache
def make_motion(model: Model):
    """Return `rate(x, e, around, law, mode) -> velocity, director rate, push, pinch`.

    `around` holds A, partner and partner_A: x is the offset from a sphere of radius A and x + partner that from one
    of partner_A. Whatever holds a swimmer, `push` is the speed at which the wall has to hold it off, and `pinch` the
    lesser of the two speeds at which it is drawn across the middle between the colloids: either holds while it is
    positive.
    """
    real, drift, to = model.real, make_drift(model), make_surface(model)
    swim, height_and_slope = make_swim(model), HardContact.make_height_and_slope(model)

    @ti.func
    def beside(x, e, A, law, held):
        flow, turning = drift(((x, A),), e, law)
        velocity = swim(e, law) + flow
        R = to.distance(x)
        n = to.normal(x, R)
        s, out = n.dot(e), n.dot(velocity)
        _, slope = height_and_slope(s, law.gamma, A)
        # ds/dt = n.de/dt + e.dn/dt, to which the normal velocity does not contribute
        push = slope * (n.dot(turning) + to.bend(e.dot(velocity) - s * out, R)) - out
        return velocity + ti.select(held, push, real(0.0)) * n, turning, push

    @ti.func
    def rate(x, e, around, law, mode):
        velocity, turning, push = beside(x, e, around.A, law, mode == int(Mode.HELD))
        # between two colloids: the mean of the two motions that stays there (Filippov)
        r = x + around.partner
        velocity1, turning1, _ = beside(r, e, around.partner_A, law, False)
        across = to.normal(x, to.distance(x)) - to.normal(r, to.distance(r))
        out, back = across.dot(velocity), -across.dot(velocity1)
        between = mode == int(Mode.BETWEEN)
        weight = ti.select(between, out / (out + back), real(0.0))
        velocity += weight * (velocity1 - velocity)
        turning += weight * (turning1 - turning)
        return velocity, turning, push, ti.min(out, back)

    return rate


@cache
def make_stride(model: Model):
    """Return `stride(table, x, e, other, around, law, mode, tau)`, one step of length tau.

    `table` is the tableau. It gives position, director (to be normalised), grip and distance from -`other` summed
    over the step, the grip at its end, and the error in units of the tolerance. Grip is the push, or the pinch of a
    swimmer between two colloids.
    """
    real, dimensions = model.real, model.dimensions
    rate, to = make_motion(model), make_surface(model)
    n_rows, grip_row, distance_row = 2 * dimensions + 2, 2 * dimensions, 2 * dimensions + 1
    Stages = ti.types.matrix(N_STAGES + 1, n_rows, real)

    @ti.func
    def vector(y, first: ti.template()):
        return ti.Vector([y[first + d] for d in ti.static(range(dimensions))])

    @ti.func
    def weighted(k: ti.template(), table: ti.template(), row):
        total = ti.Vector([real(0.0) for _ in ti.static(range(n_rows))])
        for stage in range(N_STAGES + 1):
            for r in ti.static(range(n_rows)):
                total[r] += table[row, stage] * k[stage, r]
        return total

    @ti.func
    def stride(table: ti.template(), x, e, other, around, law, mode, tau):
        k = Stages(0.0)
        start = ti.Vector([real(0.0) for _ in ti.static(range(n_rows))])
        for d in ti.static(range(dimensions)):
            start[d], start[dimensions + d] = x[d], e[d]
        y = start
        for stage in range(N_STAGES + 1):  # the last one is the rate at the end: row N_STAGES of the table
            y = start + tau * weighted(k, table, stage)
            velocity, turning, push, pinch = rate(vector(y, 0), vector(y, dimensions), around, law, mode)
            grip = ti.select(mode == int(Mode.BETWEEN), pinch, push)
            r = vector(y, 0) + other
            for d in ti.static(range(dimensions)):
                k[stage, d], k[stage, dimensions + d] = velocity[d], turning[d]
            k[stage, grip_row], k[stage, distance_row] = grip, to.distance(r)
        fifth, third = weighted(k, table, N_STAGES + 1), weighted(k, table, N_STAGES + 2)
        squared = fifth.dot(fifth)
        spread = ti.sqrt(squared + real(0.01) * third.dot(third)) + real(1e-300)
        tolerance = ti.max(real(TOLERANCE), real(FINEST) * ti.sqrt(x.dot(x)))
        error = tau * squared / (spread * tolerance)
        return vector(y, 0), vector(y, dimensions), y[grip_row], y[distance_row], k[N_STAGES, grip_row], error

    return stride
