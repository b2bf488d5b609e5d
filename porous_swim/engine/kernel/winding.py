"""How a step winds around the colloid of the encounter."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.physics.model import Model
from porous_swim.physics.rounding import rounded

TWO_PI = 6.283185307179586


@cache
def make_turns(model: Model):
    """Return `turns(r0, r1, e)`: the winding of a step along the director, and its angle about +z, in turns."""
    real, dimensions = model.real, model.dimensions

    @ti.func
    def turns(r0, r1, e):
        # (t.dx)/R with t the unit tangential part of the director, R the distance, both at the start of the step
        rho, s, dx = r0.dot(r0), r0.dot(e), r1 - r0
        t = e - r0 * (s / rho)  # from its own components: 1 - s^2/rho would cancel where e points at the centre
        along = t.dot(dx) / ti.sqrt(ti.max(rho * t.dot(t), real(1e-30)))
        if ti.static(dimensions != 2):
            return along * real(1 / TWO_PI), real(0.0)
        # arcsin as a series: below 1e-9 at 0.1 rad
        c = (r0[0] * r1[1] - r0[1] * r1[0]) / ti.sqrt(rho * r1.dot(r1))
        q = c * c
        angle = rounded(c * (real(1.0) + q * (real(1 / 6) + q * (real(3 / 40) + q * real(15 / 336)))))
        return along * real(1 / TWO_PI), angle * real(1 / TWO_PI)

    return turns


@cache
def make_swept(model: Model):
    """Return `swept(r0, r1, e)`: like `turns`, for a smooth path: the winding is the angle swept, exactly."""
    real, turns = model.real, make_turns(model)

    @ti.func
    def swept(r0, r1, e):
        along, angle = turns(r0, r1, e)
        chord = r1 / ti.sqrt(r1.dot(r1)) - r0 / ti.sqrt(r0.dot(r0))
        turn = real(2.0) * ti.asin(ti.min(real(0.5) * ti.sqrt(chord.dot(chord)), real(1.0)))
        return ti.select(along < real(0.0), turn * real(-1.0), turn) * real(1 / TWO_PI), angle

    return swept


@cache
def make_unwound(model: Model):
    """Return `unwound(r0, r1, e)` in place of `turns` at a plane wall, around which nobody winds."""
    real = model.real

    @ti.func
    def unwound(r0, r1, e):
        return real(0.0), real(0.0)

    return unwound


def make_winding(model: Model):
    """Return `turns` as the model needs it."""
    if model.surface == "plane":
        return make_unwound(model)
    return make_swept(model) if model.located else make_turns(model)
