"""The drift of a swimmer: the sum of the flows of a model."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

from porous_swim.physics.model import Model


@cache
def make_drift(model: Model):
    """Return `drift(x, e, A, alpha, Gamma) -> velocity, director rate` at offset x from a sphere of radius A."""
    (flow,) = model.flows
    return flow.make_drift(model)
