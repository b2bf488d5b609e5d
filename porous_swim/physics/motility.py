"""How a swimmer swims and turns by itself: at which velocity, and what becomes of its director at the end of a step."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache
from typing import Literal

from porous_swim.core.parts import Part
from porous_swim.physics.model import Model
from porous_swim.physics.vectors import for_kernels


class Steady(Part):
    """A swimmer that swims along its director, always at the same speed, and never turns by itself."""

    kind: Literal["steady"] = "steady"

    @staticmethod
    @cache
    def make_swim(model: Model):
        """Return `swim(e, law) -> velocity` of a swimmer alone, U."""

        @for_kernels  # nothing is compiled for it
        def swim(e, law):
            return e

        return swim

    @staticmethod
    @cache
    def make_reorient(model: Model):
        """Return `reorient(e, law, at) -> e`, the director at the end of a step.

        `law` is for the step as long as it is; random words are `noise.words_of(at, Stream.REORIENT)`. Where steps end
        at events (`located`) nobody reorients.
        """

        @for_kernels
        def reorient(e, law, at):
            return e

        return reorient


def make_swim(model: Model):
    """Return `swim` of the model's motility."""
    return model.motility.make_swim(model)


def make_reorient(model: Model):
    """Return `reorient` of the model's motility."""
    return model.motility.make_reorient(model)
