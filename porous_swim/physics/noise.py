"""Brownian noise of position and director, pure in (seed, swimmer, step).

D in a U, D_r in U/a. Each Cartesian component of the position gains sqrt(2 D dt) N; the director turns by
sqrt(2 D_r dt) N in each tangential direction (one in the plane, two in space).
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from enum import IntEnum
from functools import cache
from math import sqrt
from typing import Annotated, ClassVar, Literal

import taichi as ti
from pydantic import Field

from porous_swim.core.numbers import Given
from porous_swim.core.parts import Diffusivity, Part, RotationalDiffusivity
from porous_swim.physics.model import Model, Variates
from porous_swim.physics.perrin import spheroid_diffusion
from porous_swim.physics.philox import philox
from porous_swim.physics.variates import BITS, cut, gaussian_pair, minus_two_log, split, uniform
from porous_swim.physics.vectors import for_kernels, record, vec


class Stream(IntEnum):
    """Uses of the generator on the device; the last word of the counter. One place for all."""

    KICK = 0
    REORIENT = 1  # of motilities


class NoNoise(Part):
    """A swimmer that follows the flow exactly."""

    kind: Literal["none"] = "none"


class Brownian(Part):
    """Thermal (or active) noise of a swimmer in a quiet fluid."""

    kind: Literal["brownian"] = "brownian"
    translational_diffusion: Diffusivity = Field(ge=0.0, le=1e6)
    """D, the same in all directions: of a spheroid the mean over its orientations, in 2-D over those in the plane.
    With `units`, `thermal` means kT/(6 pi viscosity a), for a spheroid times the mean of Perrin's factors."""
    rotational_diffusion: (
        Annotated[RotationalDiffusivity, Field(ge=0.0, le=1e6)] | Literal["from_sphere", "from_spheroid"]
    ) = "from_sphere"
    """D_r. `from_sphere` means 3 D/4, that of a sphere of radius a; `from_spheroid` that of a spheroid of the
    swimmers' aspect ratio whose mean D this is (Perrin 1934)."""
    variates: Variates = "gaussian"
    """Distribution of a single step's increments: `uniform` is faster and has the same mean and variance."""

    NUMBERS: ClassVar[tuple[str, ...]] = ("kick", "turn")  # sqrt(2 D dt), sqrt(2 D_r dt)

    def numbers(self, given: Given) -> dict[str, float]:
        """See `Part`."""
        D, D_r = self.translational_diffusion, self.turning(given.aspect_ratio, given.dimensions)
        return {"kick": sqrt(2.0 * D * given.time_step), "turn": sqrt(2.0 * D_r * given.time_step)}

    def turning(self, aspect_ratio: float, dimensions: int) -> float:
        """D_r, U/a, of a swimmer of `aspect_ratio`; `from_spheroid`: D_r/D of one passive body (see `perrin`)."""
        D, D_r = self.translational_diffusion, self.rotational_diffusion
        if D_r == "from_spheroid":
            factors = spheroid_diffusion(aspect_ratio)
            return 0.75 * D * factors.turning / factors.mean(dimensions)
        return 0.75 * D if D_r == "from_sphere" else D_r


Noise = NoNoise | Brownian


@for_kernels
def counter(swimmer, low, high, k0, k1):
    """What the random numbers of a step follow from: the swimmer, the step in two words and the key, all u32.

    `swimmer`, `low` and `high` are of one kind: numbers, or wide values.
    """
    return record(swimmer=swimmer, low=low, high=high, k0=k0, k1=k1)


@ti.func
def words_of(at, stream: ti.template()):
    """Four random words of a `counter`, for one use of the generator."""
    return philox(at.low, at.high, at.swimmer, at.swimmer * ti.u32(0) + ti.u32(int(stream)), at.k0, at.k1)


@cache
def make_kick(model: Model):
    """Return `kick(at)`, a list of independent variates of variance 1 at a `counter`.

    The first `dimensions` of the 2 `dimensions` are for the position, those from the fourth on for the director.
    """
    real, dimensions, variates = model.real, model.dimensions, model.variates

    @ti.func
    def kick(at):
        words = words_of(at, Stream.KICK)
        i = split(words[0], words[1], words[2], words[3])
        if ti.static(variates == "uniform"):
            return [uniform(i[k], BITS) * real(1.0) for k in ti.static(range(2 * dimensions))]
        pairs = [gaussian_pair(i[2 * k], BITS, i[2 * k + 1], BITS) for k in ti.static(range(dimensions))]
        return [pairs[k // 2][k % 2] * real(1.0) for k in ti.static(range(2 * dimensions))]

    return kick


@cache
def make_draw(model: Model):
    """Return `draw(at) -> variates, excursion, excursion`.

    Like `kick`, and twice -2 ln U for the farthest points of the paths within a step: up to 23.6, from 16 bits.
    """
    real, dimensions, variates = model.real, model.dimensions, model.variates

    @ti.func
    def draw(at):
        words = words_of(at, Stream.KICK)
        high, low = cut(words[3], 16)
        deep, aside = minus_two_log(high, 16) * real(1.0), minus_two_log(low, 16) * real(1.0)
        if ti.static(variates == "uniform"):
            halves = [cut(words[k], 16) for k in ti.static(range(dimensions))]
            n = [uniform(halves[k // 2][k % 2], 16) * real(1.0) for k in ti.static(range(2 * dimensions))]
            return n, deep, aside
        parts = [cut(words[k], 12) for k in ti.static(range(dimensions))]
        pairs = [gaussian_pair(parts[k][0], 20, parts[k][1], 12) for k in ti.static(range(dimensions))]
        n = [pairs[k // 2][k % 2] * real(1.0) for k in ti.static(range(2 * dimensions))]
        return n, deep, aside

    return draw


@cache
def make_shares(model: Model):
    """Return `moves(g)` and `turns(g)`: the variates of `kick` or `draw` that are for the position and the director."""
    dimensions = model.dimensions

    @ti.func
    def moves(g: ti.template()):
        return vec(*[g[d] for d in ti.static(range(dimensions))])

    @ti.func
    def turns(g: ti.template()):
        return vec(*[g[3 + d] for d in ti.static(range(2 * dimensions - 3))])

    return moves, turns


@cache
def make_turn(model: Model):
    """Return `turn(e, w) -> e`, the unit director rotated by the angle w (plane) or the tangential part of w (space).

    The rotation is exact to 3e-7 at one radian and to 2e-12 at 0.3, and the result has unit length.
    """
    real = model.real
    if model.dimensions == 2:

        @ti.func
        def tangential(e, w):
            return vec(e[1] * real(-1.0), e[0]) * w[0]

    else:

        @ti.func
        def tangential(e, w):
            return w - e * w.dot(e)

    @ti.func
    def turn(e, w):
        d = tangential(e, w)
        q = d.dot(d)
        sine = real(1.0) - q * (real(1 / 6) - q * (real(1 / 120) - q * (real(1 / 5040) - q * real(1 / 362880))))
        cosine = real(1.0) - q * (real(0.5) - q * (real(1 / 24) - q * (real(1 / 720) - q * real(1 / 40320))))
        n = e * cosine + d * sine
        return n / ti.sqrt(n.dot(n))

    return turn
