"""Contact with every colloid, and which one is nearest: what the lanes, which know one colloid, cannot do."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.budget import make_budget
from porous_swim.engine.kernel.resolve import make_outside
from porous_swim.engine.kernel.rows import make_vectors, rows_of
from porous_swim.engine.kernel.state import Event, Int, LaneInt, Total
from porous_swim.engine.kernel.swimmers import image_of, put_image, same
from porous_swim.engine.kernel.touch import make_touch
from porous_swim.obstacles.search import make_between
from porous_swim.physics.model import Model
from porous_swim.physics.vectors import pick, record

MAX_IMAGE = 2**30
BETWEEN = 1e-10  # a difference of distances, in a, below which two colloids are equally near, where events are located


@cache
def make_resolve_contacts(model: Model):
    """Return `resolve_contacts(reals, ints, j, i, swimmers, medium, rules, band)`, which ends the trial move of a lane.

    It is that of lane j, of swimmer i.

    The trial obeys contact with every colloid, offsets are measured from the colloid nearest to it, and the budget
    is set anew. A swimmer no higher than `band` above contact touches, and so does one that a reflecting wall has
    pushed on its way.
    """
    real, reflected, located = model.real, model.reflected, model.located
    rows, (get, put) = rows_of(model), make_vectors(model)
    between, outside = make_between(model), make_outside(model)
    (strike, push_off), set_budget = make_touch(model), make_budget(model)

    @ti.func
    def pair(i, swimmers: ti.template(), found, k, image):
        """Remember the colloid that a swimmer left, as long as it is as near as the new one."""
        stays = same(k, image, found.near, found.image)
        partner = ti.select(found.second - found.first > real(BETWEEN), -1, swimmers.int[int(Int.PARTNER), i])
        image_m = image_of(swimmers, int(Int.PARTNER_IMAGE), i)
        swimmers.int[int(Int.PARTNER), i] = ti.select(stays, partner, k)
        put_image(swimmers, int(Int.PARTNER_IMAGE), i, pick(stays, image_m, image))

    @ti.func
    def resolve_contacts(
        reals: ti.template(), ints: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(),
        rules: ti.template(), band,
    ):  # fmt: skip
        x, y, e = get(reals, rows.x, j), get(reals, rows.trial_x, j), get(reals, rows.trial_e, j)
        finite = (y.dot(y) < real(1e30)) & (e.dot(e) < real(1e30))
        if not finite:
            ints[Int.EVENT][j] = int(Event.HALT)
        else:
            k, image = swimmers.int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i)
            b, image_b = swimmers.int[int(Int.BOUND), i], image_of(swimmers, int(Int.BOUND_IMAGE), i)
            near, bound = record(k=k, image=image), record(k=b, image=image_b)
            y1, found, held = outside(medium, near, bound, y, x, e, reals[rows.law.gamma][j], rules.tolerance)
            z = y1.variable()
            if held.jammed != 0:
                ti.atomic_add(swimmers.total[int(Total.JAMMED)], 1)
            if (held.last >= 0) | (held.jammed != 0):
                put(reals, rows.trial_rest, j, y * real(0.0))
            if ti.static(located):
                pair(i, swimmers, found, k, image)
            if not same(k, image, found.near, found.image):
                shift = between(medium, found.near, found.image, k, image)
                z += shift
                put(reals, rows.x, j, x + shift)
                swimmers.int[int(Int.COLLOID), i] = found.near
                put_image(swimmers, int(Int.IMAGE), i, found.image)
            pushed = False
            if ti.static(reflected):
                pushed = ints[LaneInt.TOUCH][j] != 0
            wall = record(k=ti.select(pushed, k, -1), image=image)
            strike(ints, j, i, swimmers, found, rules.tolerance, held, wall)
            push_off(reals, ints, j, k, image, held)
            set_budget(reals, ints, j, i, swimmers, z, found, rules)
            put(reals, rows.trial_x, j, z)
            ints[LaneInt.TOUCH][j] = ti.cast((found.depth >= -band) | pushed, ti.i32)
            for axis in ti.static(range(3)):
                if ti.abs(found.image[axis]) > MAX_IMAGE:
                    ints[Int.EVENT][j] = int(Event.HALT)

    return resolve_contacts
