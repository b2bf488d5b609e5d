"""How a swimmer swims and turns by itself: at which velocity, and what becomes of its director at the end of a step."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache
from typing import TYPE_CHECKING, Literal

from porous_swim.core.registry import OpenPart, add
from porous_swim.physics.model import Model
from porous_swim.physics.vectors import for_kernels


class Motility(OpenPart):
    """How swimmers swim and turn by themselves: a frozen model, chosen by `kind` in `swimmers.motility`.

    A motility overrides `make_swim`, `make_reorient` or both; what it leaves alone is that of a steady swimmer. Numbers
    that its functions need are declared in `NUMBERS`, are handed over by `numbers(self, given)`, in a, U and a/U, and
    come as `law.name`; what is true of a whole step, such as the probability to turn in it, follows from
    `given.time_step`.

    The functions get wide values, one for each lane, or plain ones: no branches, constants as `model.real(0.5)`,
    vectors before numbers in products, no assignment in place, `physics.vectors.pick` to choose. Decorate the methods
    with `@staticmethod` and `@functools.cache`. Nothing is remembered from step to step but the director.
    """

    if TYPE_CHECKING:
        kind: str

    @classmethod
    def reorients(cls) -> bool:
        """Whether directors turn by themselves, for which steps that end at events (`located`) are not made."""
        return cls.make_reorient is not Motility.make_reorient

    @staticmethod
    @cache
    def make_swim(model: Model):
        """Return the Taichi function `swim(e, law) -> velocity` of a swimmer alone, U; `e` is its unit director."""

        @for_kernels  # nothing is compiled for it
        def swim(e, law):
            return e

        return swim

    @staticmethod
    @cache
    def make_reorient(model: Model):
        """Return the Taichi function `reorient(e, law, at) -> e`: the unit director at the end of a time step.

        Random words are `noise.words_of(at, Stream.REORIENT)`: they are pure in seed, swimmer and step. In two
        dimensions (`model.dimensions`) a director has two components.
        """

        @for_kernels
        def reorient(e, law, at):
            return e

        return reorient


class Steady(Motility):
    """A swimmer that swims along its director, always at the same speed, and never turns by itself."""

    kind: Literal["steady"] = "steady"


def make_swim(model: Model):
    """Return `swim` of the model's motility."""
    return model.motility.make_swim(model)


def make_reorient(model: Model):
    """Return `reorient` of the model's motility."""
    return model.motility.make_reorient(model)


add(Steady)
