"""The paper's time stepping: forward Euler, then contact, then noise of the director as an exact rotation."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.physics.drift import make_drift
from porous_swim.physics.model import Model
from porous_swim.physics.motility import make_reorient, make_swim
from porous_swim.physics.noise import make_kick, make_shares, make_turn
from porous_swim.physics.rounding import rounded


@cache
def make_euler(model: Model):
    """Return `move(x, e, A, law, dt, at) -> displacement, director`.

    `law` holds the numbers of the swimmer by name, `at` is a `noise.counter`. Without noise nothing is drawn.
    """
    noisy = model.variates is not None
    drift, kick, turn = make_drift(model), make_kick(model), make_turn(model)
    (moves, turns), swim, reorient = make_shares(model), make_swim(model), make_reorient(model)

    @ti.func
    def move(x, e, A, law, dt, at):
        velocity, rate = drift(((x, A),), e, law)
        dx = (swim(e, law) + velocity) * dt
        m = e + rate * dt
        n = m / ti.sqrt(m.dot(m))
        if ti.static(not noisy):
            return dx, reorient(n, law, at)
        g = kick(at)
        e1 = turn(n, turns(g) * law.turn)
        return dx + rounded(moves(g) * law.kick), reorient(e1, law, at)

    return move
