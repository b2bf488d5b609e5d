"""Hard contact: how near a swimmer's centre may come to a colloid's surface.

Lengths in half-lengths a. A sphere keeps h >= 1. A prolate spheroid (semi-axes 1, gamma, gamma) touches a sphere of
radius A with the point whose normal n is turned by p from its axis: its support there is the vector
(cos p, gamma^2 sin p)/S with S = sqrt(cos^2 p + gamma^2 sin^2 p), so that the centres are x = A n + support apart.
A plane it touches where n is the normal: h = sqrt(s^2 + gamma^2 (1 - s^2)) at sine s of the pitch.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache
from math import inf
from typing import ClassVar, Literal

import taichi as ti

from porous_swim.core.numbers import Given
from porous_swim.core.parts import Part
from porous_swim.physics.model import Model, Shape

# Shapes below this aspect ratio, or at colloids below this radius, are needles: more work for the same digits.
ROD_RATIO, ROD_RADIUS = 0.1, 1.0
THINNEST = 0.01  # aspect ratio down to which a needle's contact height was checked, at radii from 0.05 on


def shape_of(aspect_ratio: float, radius: float) -> Shape:
    """The class of contact that the least aspect ratio gamma and the least radius of colloids (a) need.

    `flat` is a spheroid's with a plane, the only colloid of infinite radius.
    """
    if aspect_ratio == 1.0:
        return "sphere"
    if radius == inf:
        return "flat"
    return "rod" if aspect_ratio >= ROD_RATIO and radius >= ROD_RADIUS else "needle"


class HardContact(Part):
    """A wall that stops the swimmer without torque or friction."""

    kind: Literal["hard"] = "hard"
    NUMBERS: ClassVar[tuple[str, ...]] = ("gamma",)  # the aspect ratio

    def numbers(self, given: Given) -> dict[str, float]:
        """See `Part`."""
        return {"gamma": given.aspect_ratio}

    @staticmethod
    @cache
    def make_height(model: Model):
        """Return `contact_height(s, gamma, A)`: the least height at sine s of the pitch above a sphere of radius A."""
        return _first(HardContact.make_height_and_slope(model))

    @staticmethod
    @cache
    def make_rolled_height(model: Model):
        """Return the same for what is called seldom: a fifth slower, and compiled in half the time."""
        return _first(HardContact.make_rolled_height_and_slope(model))

    @staticmethod
    @cache
    def make_height_and_slope(model: Model):
        """Return `height_and_slope(s, gamma, A)`: the least height, and its derivative with respect to s."""
        return make_flat(model) if model.shape == "flat" else _curved(model, make_normal(model))

    @staticmethod
    @cache
    def make_rolled_height_and_slope(model: Model):
        """Return the same for what is called seldom: see `make_rolled_height`."""
        return make_flat(model) if model.shape == "flat" else _curved(model, make_rolled_normal(model))


def _first(height_and_slope):
    """The first of two results."""

    @ti.func
    def contact_height(s, gamma, A):
        h, _ = height_and_slope(s, gamma, A)
        return h

    return contact_height


def _curved(model: Model, normal):
    """Height and slope above a sphere, by the direction of contact."""
    real = model.real

    @ti.func
    def height_and_slope(s, gamma, A):
        if ti.static(model.sphere):
            return real(1.0), real(0.0)
        up = ti.min(ti.max(s, s * real(-1.0)), real(1.0))
        along = ti.sqrt(real(1.0) - up * up)
        c, w = normal(up, along, gamma, A)
        g = gamma * gamma
        S = ti.sqrt(c * c + g * w * w)
        turn = (g - real(1.0)) * c * w / S  # S'(p)
        R = ti.sqrt((S + A) * (S + A) + turn * turn)
        h = (S * S + turn * turn + real(2.0) * A * S) / (R + A)  # R - A without cancellation
        # dh/dtheta = -R S'/(A + S), over cos(theta); at the tip w/cos(theta) from the condition of contact
        tip = c * (A * S + real(1.0)) / ti.max((A * S + g) * up, real(1e-30))
        ratio = ti.select(up > along, tip, w / ti.max(along, real(1e-30)))
        sign = ti.select(s < real(0.0), real(-1.0), real(1.0))
        return h, sign * (R * (real(1.0) - g) * c * ratio / (S * (A + S)))

    return height_and_slope


@cache
def make_flat(model: Model):
    """Return `height_and_slope(s, gamma, A)` at a plane: the support of the spheroid along the normal."""
    real = model.real

    @ti.func
    def height_and_slope(s, gamma, A):
        up = ti.max(ti.min(s, real(1.0)), real(-1.0))
        g = gamma * gamma
        h = ti.sqrt(g + (real(1.0) - g) * up * up)
        return h, (real(1.0) - g) * up / h

    return height_and_slope


@cache
def make_approach(model: Model):
    """Return `near` and `halley(c, w, up, along, g, A) -> c, w`, steps of two iterations for the direction of contact.

    The condition of contact, x(p) parallel to the line of centres, reads tan p = along (A S + 1)/(up (A S + gamma^2)):
    taken as an iteration (`near`) it comes near from any start, and Halley's method ends it. Directions turn as
    vectors: no angle is needed.
    """
    real = model.real

    @ti.func
    def unit(c, w):
        r = real(1.0) / ti.sqrt(c * c + w * w)
        return c * r, w * r

    @ti.func
    def halley(c, w, up, along, g, A):
        """Turn (c, w) by one step towards a root of f, the cross product of x(p) and the line of centres."""
        k = real(1.0) - g
        inverse = real(1.0) / ti.sqrt(c * c + g * w * w)  # 1/S
        a, b = A + inverse, A + g * inverse
        cube = k * inverse * inverse * inverse
        da = cube * c * w  # d(1/S)/dp
        m = c * along - g * w * up
        f = c * a * along - w * b * up
        df = da * m - (w * a * along + c * b * up)
        dda = cube * (c * c - w * w) + real(3.0) * k * da * c * w * inverse * inverse
        ddf = dda * m - real(2.0) * da * (w * along + g * c * up) - f
        turn = f * df / (real(0.5) * f * ddf - df * df)
        return unit(c - w * turn, w + c * turn)

    @ti.func
    def near(c, w, up, along, g, A):
        S = ti.sqrt(c * c + g * w * w)
        return unit(up * (A * S + g), along * (A * S + real(1.0)))

    return near, halley


def n_approaches(model: Model) -> tuple[int, int]:
    """Steps of `near` and of `halley` that the shape takes.

    Errors of the height for a rod: 4e-9 after two Halley steps, rounding after three; for a needle rounding (largest of
    8000 random cases each).
    """
    return (2, 2 if model.real == ti.f32 else 3) if model.shape == "rod" else (12, 10)


@cache
def make_normal(model: Model):
    """Return `normal(up, along, gamma, A) -> cos p, sin p`, the direction of contact seen from the swimmer's axis.

    `up` and `along` are sine and cosine of the pitch's size.
    """
    (near, halley), (n_starts, n_steps) = make_approach(model), n_approaches(model)

    @ti.func
    def normal(up, along, gamma, A):
        g = gamma * gamma
        c, w = up, along
        for _ in ti.static(range(n_starts)):
            c, w = near(c, w, up, along, g, A)
        for _ in ti.static(range(n_steps)):
            c, w = halley(c, w, up, along, g, A)
        return c, w

    return normal


@cache
def make_rolled_normal(model: Model):
    """Return the same in loops, which compile fast."""
    (near, halley), (n_starts, n_steps) = make_approach(model), n_approaches(model)

    @ti.func
    def normal(up, along, gamma, A):
        g = gamma * gamma
        c, w = up, along
        for _ in range(n_starts):
            c, w = near(c, w, up, along, g, A)
        for _ in range(n_steps):
            c, w = halley(c, w, up, along, g, A)
        return c, w

    return normal
