"""The drift of a swimmer: the sum of the flows of a model, over all that is near."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

from porous_swim.physics.model import Model
from porous_swim.physics.vectors import for_kernels


@cache
def make_drift(model: Model):
    """Return `drift(near, e, law) -> velocity, director rate`.

    `near` is a tuple of pairs (x, A) for what is near: the offset from a sphere of radius A, or from a plane wall. Each
    flow has `make_drift(model)`, which returns `drift(x, e, A, law)` for one of them. `law` holds the numbers of the
    model by name. The swimmer's own velocity is not in the drift.
    """
    flows = [flow.make_drift(model) for flow in model.flows]

    @for_kernels
    def drift(near, e, law):
        terms = [flow(x, e, A, law) for x, A in near for flow in flows]
        velocity, rate = terms[0]
        for more, turning in terms[1:]:
            velocity, rate = velocity + more, rate + turning
        return velocity, rate

    return drift
