"""Which colloid a swimmer touches where several push it, and how hard that of its encounter pushes."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.rows import get_image, put_lane_image, rows_of
from porous_swim.engine.kernel.state import Int, LaneInt, Phase
from porous_swim.engine.kernel.swimmers import image_of, same
from porous_swim.physics.model import Model
from porous_swim.physics.vectors import pick


@cache
def make_touch(model: Model):
    """Return `strike(ints, j, i, swimmers, found, tolerance, held, pushed)` and `push_off(reals, ints, ...)`.

    They name the colloid that is touched, and add up the push. `found` and `held` are those of `outside`.
    """
    real, reflected, rows = model.real, model.reflected, rows_of(model)

    @ti.func
    def strike(ints: ti.template(), j, i, swimmers: ti.template(), found, tolerance, held, pushed):
        """Name the colloid that a contact is with; in a wedge the one that is not that of the encounter.

        `pushed` is the colloid whose reflecting wall has pushed the swimmer on its way; its `k` is -1 if none.
        """
        deep = found.depth >= -tolerance
        last, last_image, before, before_image = held.last, held.last_image, held.before, held.before_image
        k, image = found.near, found.image.variable()
        if ti.static(reflected):
            first = (before < 0) & (pushed.k >= 0)
            before, before_image = ti.select(first, pushed.k, before), pick(first, pushed.image, before_image)
            k, image = ti.select(pushed.k >= 0, pushed.k, k), pick(pushed.k >= 0, pushed.image, image)
        k, image = ti.select(deep, found.deep, k), pick(deep, found.deep_image, image)
        b, image_b = swimmers.int[int(Int.BOUND), i], image_of(swimmers, int(Int.BOUND_IMAGE), i)
        bound = ints[LaneInt.PHASE][j] == int(Phase.BOUND)
        other = bound & (before >= 0) & (not same(before, before_image, b, image_b))
        k, image = ti.select(other, before, k), pick(other, before_image, image)
        other = bound & (last >= 0) & (not same(last, last_image, b, image_b))
        ints[LaneInt.TOUCHED_BODY][j] = ti.select(other, last, k)
        put_lane_image(ints, LaneInt.TOUCHED_BODY_IMAGE, j, pick(other, last_image, image))

    @ti.func
    def push_off(reals: ti.template(), ints: ti.template(), j, k, image, held):
        """Add the push of the colloid of the encounter; a free swimmer's is that of the one it strikes.

        `k` is the nearest colloid at the start of the step, which has pushed on its way.
        """
        push = reals[rows.trial_push][j]
        if ints[LaneInt.PHASE][j] == int(Phase.BOUND):
            push += held.own
        else:
            s, image_s = ints[LaneInt.TOUCHED_BODY][j], get_image(ints, LaneInt.TOUCHED_BODY_IMAGE, j)
            push = ti.select(same(s, image_s, k, image), push, real(0.0))
            push += ti.select(same(s, image_s, held.last, held.last_image), held.push, real(0.0))
            push += ti.select(same(s, image_s, held.before, held.before_image), held.push_before, real(0.0))
        reals[rows.trial_push][j] = ti.max(push, real(0.0))

    return strike, push_off
