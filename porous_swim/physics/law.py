"""The numbers of a swimmer in a kernel: they come by name, `law.alpha`."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

from porous_swim.physics.model import Model
from porous_swim.physics.vectors import for_kernels, record


@cache
def make_named(model: Model):
    """Return `named(*values)`: a value for each of the numbers of the model, in their order, by name."""

    @for_kernels
    def named(*values):
        return record(**dict(zip(model.numbers, values, strict=True)))

    return named
