"""The paper's time stepping: forward Euler, then contact, then noise of the director as an exact rotation."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.physics.noise import make_kick, make_turn
from porous_swim.physics.rounding import rounded


@cache
def make_euler(drift, real, dimensions: int, variates: str | None):
    """Return `move(x, e, A, law, dt, swimmer, step_low, step_high, k0, k1) -> displacement, director`.

    `law` holds alpha, Gamma, sqrt(2 D dt), sqrt(2 D_r dt). Without noise `variates` is None and nothing is drawn.
    """
    noisy = variates is not None
    kick = make_kick(real, dimensions, variates)
    turn = make_turn(real, dimensions)

    @ti.func
    def move(x, e, A, law, dt, swimmer, step_low, step_high, k0, k1):
        velocity, rate = drift(x, e, A, law[0], law[1])
        dx = dt * (e + velocity)
        n = e + dt * rate
        n = n / ti.sqrt(n.dot(n))
        if ti.static(noisy):
            g = kick(swimmer, step_low, step_high, k0, k1)
            dx += rounded(law[2] * ti.Vector([g[d] for d in ti.static(range(dimensions))]))
            n = turn(n, law[3] * ti.Vector([g[3 + d] for d in ti.static(range(2 * dimensions - 3))]))
        return dx, n

    return move
