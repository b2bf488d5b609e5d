"""Runs and tumbles."""

import math
from functools import cache
from typing import Annotated, ClassVar, Literal

import taichi as ti
from pydantic import Field

import porous_swim as ps
from porous_swim.core.parts import Time
from porous_swim.physics.noise import Stream, words_of
from porous_swim.physics.variates import BITS, circle, split
from porous_swim.physics.vectors import pick, vec


class Tumbling(ps.Motility):
    """A swimmer that tumbles at random times, at once, and then has any direction."""

    kind: Literal["tumbling"]
    run_time: Annotated[Time, Field(ge=1e-3, le=1e9)]
    """Mean time between two tumbles."""

    NUMBERS: ClassVar[tuple[str, ...]] = ("tumble",)

    def numbers(self, given):
        """Return the probability of a tumble in a step."""
        return {"tumble": -math.expm1(-given.time_step / self.run_time)}

    @staticmethod
    @cache
    def make_reorient(model):
        """Return what becomes of the director; see `porous_swim.Motility`."""
        real, dimensions = model.real, model.dimensions

        @ti.func
        def reorient(e, law, at):
            words = words_of(at, Stream.REORIENT)
            i = split(words[0], words[1], words[2], words[3])
            x, y = circle(i[1], BITS)
            tumbles = i[0] * real(1.0) < law.tumble * real(2.0**BITS)
            if ti.static(dimensions == 2):
                return pick(tumbles, vec(x * real(1.0), y * real(1.0)), e)
            z = (i[2] * real(1.0) + real(0.5)) * real(2.0 / 2**BITS) - real(1.0)
            across = ti.sqrt(real(1.0) - z * z)
            return pick(tumbles, vec(x * across, y * across, z), e)

        return reorient
