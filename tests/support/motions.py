"""A flow and motilities with numbers of their own, as a user would write them."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
import math
from functools import cache
from typing import Annotated, ClassVar, Literal

import taichi as ti
from pydantic import Field

from porous_swim.core.numbers import Given
from porous_swim.physics.flow import Flow
from porous_swim.physics.model import Model
from porous_swim.physics.motility import Steady
from porous_swim.physics.noise import Stream, words_of
from porous_swim.physics.variates import BITS, circle, split
from porous_swim.physics.vectors import by_lane, pick, vec


class Swirl(Flow):
    """A swirl about each sphere, as of one that spins: u = strength (A/R)^power along the circle about its z axis."""

    kind: Literal["swirl"] = "swirl"
    strength: Annotated[float, Field(ge=-10.0, le=10.0)]
    """Speed at the surface, at the equator."""
    power: Annotated[float, Field(ge=1.0, le=10.0)]
    """How fast it decays with the distance from the axis."""
    NUMBERS: ClassVar[tuple[str, ...]] = ("strength", "power")

    def numbers(self, given: Given) -> dict[str, float]:
        return {"strength": self.strength, "power": self.power}

    @staticmethod
    @cache
    def make_drift(model: Model):
        real = model.real

        @ti.func
        def drift(x, e, A, law):
            R = ti.sqrt(x[0] * x[0] + x[1] * x[1])
            u = law.strength * real(0.0)  # at a wall
            if ti.static(model.surface == "sphere"):
                u = law.strength * by_lane(ti.pow, A / R, law.power) / R
            velocity = x * real(0.0)
            velocity[0] = x[1] * u * real(-1.0)
            velocity[1] = x[0] * u
            return velocity, e * real(0.0)

        return drift


class Paced(Steady):
    """Swims at a speed of its own."""

    NUMBERS: ClassVar[tuple[str, ...]] = ("speed",)

    @staticmethod
    @cache
    def make_swim(model: Model):
        @ti.func
        def swim(e, law):
            return e * law.speed

        return swim


class Tumbling(Steady):
    """Runs and tumbles in the plane: after a step any direction with the probability `tumble`."""

    NUMBERS: ClassVar[tuple[str, ...]] = ("tumble",)

    @staticmethod
    @cache
    def make_reorient(model: Model):
        real = model.real

        @ti.func
        def reorient(e, law, at):
            words = words_of(at, Stream.REORIENT)
            i = split(words[0], words[1], words[2], words[3])
            x, y = circle(i[1], BITS)
            tumbles = i[0] * real(1.0) < law.tumble * real(2.0**BITS)
            return pick(tumbles, vec(x * real(1.0), y * real(1.0)), e)

        return reorient


def tumble_of(rate: float, time_step: float) -> float:
    """The probability of a tumble in a step."""
    return -math.expm1(-rate * time_step)
