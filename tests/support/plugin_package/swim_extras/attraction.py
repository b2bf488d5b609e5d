"""A flow along the normal."""

from functools import cache
from typing import Literal

import taichi as ti

import porous_swim as ps


class Attraction(ps.Flow):
    """A flow straight to a sphere, of the speed alpha A/R^3 at the distance R from its centre; none at a wall."""

    kind: Literal["attraction"]

    @staticmethod
    @cache
    def make_drift(model):
        """Return the drift; see `porous_swim.Flow`."""
        real = model.real

        @ti.func
        def drift(x, e, A, law):
            rho = x.dot(x)
            speed = law.alpha * A / (rho * rho)
            if ti.static(model.surface == "plane"):
                speed = law.alpha * real(0.0)
            return x * speed * real(-1.0), e * real(0.0)

        return drift
