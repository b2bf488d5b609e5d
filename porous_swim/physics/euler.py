"""The paper's time stepping: forward Euler, then contact, then noise of the director as an exact rotation."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.physics.drift import make_drift
from porous_swim.physics.model import Model
from porous_swim.physics.noise import make_kick, make_shares, make_turn
from porous_swim.physics.rounding import rounded


@cache
def make_euler(model: Model):
    """Return `move(x, e, A, law, dt, swimmer, step_low, step_high, k0, k1) -> displacement, director`.

    `law` holds alpha, Gamma, sqrt(2 D dt), sqrt(2 D_r dt). Without noise nothing is drawn.
    """
    noisy = model.variates is not None
    drift, kick, turn = make_drift(model), make_kick(model), make_turn(model)
    moves, turns = make_shares(model)

    @ti.func
    def move(x, e, A, law, dt, swimmer, step_low, step_high, k0, k1):
        velocity, rate = drift(x, e, A, law[0], law[1])
        dx = (e + velocity) * dt
        m = e + rate * dt
        n = m / ti.sqrt(m.dot(m))
        if ti.static(not noisy):
            return dx, n
        g = kick(swimmer, step_low, step_high, k0, k1)
        return dx + rounded(moves(g) * law[2]), turn(n, turns(g) * law[3])

    return move
