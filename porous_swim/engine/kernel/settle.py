"""Contact with every colloid, and which one is nearest: what the lanes, which know one colloid, cannot do."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.resolve import make_resolve
from porous_swim.engine.kernel.rows import get_image, make_vectors, put_lane_image, rows_of
from porous_swim.engine.kernel.state import Event, Int, LaneInt, Phase, Total
from porous_swim.engine.kernel.swimmers import image_of, put_image, same, touched_image
from porous_swim.obstacles.search import make_between
from porous_swim.physics.model import Model
from porous_swim.physics.vectors import pick

MAX_IMAGE = 2**30
PAIRED_WITHIN = 0.2  # a, beyond reach: nearer a rod has the second nearest colloid for its mate
BETWEEN = 1e-10  # a difference of distances, in a, below which two colloids are equally near, where events are located


@cache
def make_settle(model: Model):
    """Return `settle(f, n, j, i, swimmers, medium, rules, band)`, which ends the trial move of lane j (swimmer i).

    The trial obeys contact with every colloid, offsets are measured from the colloid nearest to it, and the budget
    is set anew: half of the lead of the nearest surface, so that no other can be nearer within it. A swimmer no
    higher than `band` above contact touches, and so does one that a reflecting wall has pushed on its way.
    """
    real, reflected, located, mates = model.real, model.reflected, model.located, model.mates
    sphere, rows, (get, put) = model.sphere, rows_of(model), make_vectors(model)
    between, resolve = make_between(model), make_resolve(model)

    @ti.func
    def push_off(f: ti.template(), n: ti.template(), j, k, image, held):
        """Add the push of the colloid of the encounter; a free swimmer's is that of the one it strikes.

        `k` is the nearest colloid at the start of the step, which has pushed on its way.
        """
        push = f[rows.trial_push][j]
        if n[LaneInt.PHASE][j] == int(Phase.BOUND):
            push += held.own
        else:
            s, image_s = n[LaneInt.STRUCK][j], get_image(n, LaneInt.STRUCK_IMAGE, j)
            push = ti.select(same(s, image_s, k, image), push, real(0.0))
            push += ti.select(same(s, image_s, held.last, held.last_image), held.push, real(0.0))
            push += ti.select(same(s, image_s, held.before, held.before_image), held.push_before, real(0.0))
        f[rows.trial_push][j] = ti.max(push, real(0.0))

    @ti.func
    def choose_mate(i, swimmers: ti.template(), found, rules: ti.template()):
        """The mate of a rod, if any; and how far it may go until a colloid that its lane does not know may matter.

        Contact heights are at most 1.
        """
        band = real(1.0) + ti.max(rules.contact_band, rules.tolerance)
        reach, paired = found.second - band, False
        if ti.static(mates):
            # cells list all that is within the escape height
            together = ti.min(found.third, rules.escape_height) - band
            paired = (reach < real(PAIRED_WITHIN)) & (reach < together) & (found.mate >= 0)
            swimmers.int[int(Int.MATE), i] = ti.select(paired, found.mate, -1)
            put_image(swimmers, int(Int.MATE_IMAGE), i, found.mate_image)
            reach = ti.select(paired, together, reach)
        return reach, paired

    @ti.func
    def no_news(n: ti.template(), j, i, swimmers: ti.template(), k, image):
        """Whether contact with colloid k is known in the encounter under way."""
        own = same(k, image, swimmers.int[int(Int.BOUND), i], image_of(swimmers, int(Int.BOUND_IMAGE), i))
        touched = same(k, image, swimmers.int[int(Int.TOUCHED), i], touched_image(swimmers, i))
        return (n[LaneInt.PHASE][j] == int(Phase.BOUND)) & (own | touched)

    @ti.func
    def set_budget(
        f: ti.template(), n: ti.template(), j, i, swimmers: ti.template(), y, found, rules: ti.template()
    ):  # fmt: skip
        budget = real(0.5) * (found.second - found.first)
        if ti.static(not sphere):
            reach, mate = choose_mate(i, swimmers, found, rules)
            if ti.static(mates):
                swaps = (
                    mate
                    & no_news(n, j, i, swimmers, found.near, found.image)
                    & no_news(n, j, i, swimmers, found.mate, found.mate_image)
                )
                # both may be the nearest: it is the third, beyond the list of the cell if need be, that must not be
                lead = real(0.5) * (ti.min(found.third, rules.escape_height) - found.first)
                budget = ti.select(swaps, lead, budget)
            budget = ti.min(budget, reach)
        budget = ti.max(real(0.0), budget - rules.margin)
        if ti.static(not located):  # a later touch is that of the nearest
            struck, image = n[LaneInt.STRUCK][j], get_image(n, LaneInt.STRUCK_IMAGE, j).variable()
            if ti.static(mates):
                known = no_news(n, j, i, swimmers, struck, image)
                if known & no_news(n, j, i, swimmers, found.near, found.image):
                    n[LaneInt.STRUCK][j], struck = found.near, found.near
                    put_lane_image(n, LaneInt.STRUCK_IMAGE, j, found.image)
                    image = found.image
            budget = ti.select(same(struck, image, found.near, found.image), budget, real(0.0))
        f[rows.budget][j] = budget * budget
        put(f, rows.reference, j, y)

    @ti.func
    def strike(
        n: ti.template(), j, i, swimmers: ti.template(), found, tolerance, held, push_k, push_image,
    ):  # fmt: skip
        """Name the colloid that a contact is with; in a wedge the one that is not that of the encounter.

        `push_k` is the colloid whose reflecting wall has pushed the swimmer on its way; -1 if none.
        """
        deep = found.depth >= -tolerance
        last, last_image, before, before_image = held.last, held.last_image, held.before, held.before_image
        k, image = found.near, found.image.variable()
        if ti.static(reflected):
            pushed = (before < 0) & (push_k >= 0)
            before, before_image = ti.select(pushed, push_k, before), pick(pushed, push_image, before_image)
            k, image = ti.select(push_k >= 0, push_k, k), pick(push_k >= 0, push_image, image)
        k, image = ti.select(deep, found.deep, k), pick(deep, found.deep_image, image)
        b, image_b = swimmers.int[int(Int.BOUND), i], image_of(swimmers, int(Int.BOUND_IMAGE), i)
        bound = n[LaneInt.PHASE][j] == int(Phase.BOUND)
        other = bound & (before >= 0) & (not same(before, before_image, b, image_b))
        k, image = ti.select(other, before, k), pick(other, before_image, image)
        other = bound & (last >= 0) & (not same(last, last_image, b, image_b))
        n[LaneInt.STRUCK][j] = ti.select(other, last, k)
        put_lane_image(n, LaneInt.STRUCK_IMAGE, j, pick(other, last_image, image))

    @ti.func
    def pair(i, swimmers: ti.template(), found, k, image):
        """Remember the colloid that a swimmer left, as long as it is as near as the new one."""
        stays = same(k, image, found.near, found.image)
        mate = ti.select(found.second - found.first > real(BETWEEN), -1, swimmers.int[int(Int.MATE), i])
        image_m = image_of(swimmers, int(Int.MATE_IMAGE), i)
        swimmers.int[int(Int.MATE), i] = ti.select(stays, mate, k)
        put_image(swimmers, int(Int.MATE_IMAGE), i, pick(stays, image_m, image))

    @ti.func
    def stop(n: ti.template(), j):
        n[Int.EVENT][j] = int(Event.HALT)

    @ti.func
    def settle(
        f: ti.template(), n: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(),
        rules: ti.template(), band,
    ):  # fmt: skip
        x, y, e = get(f, rows.x, j), get(f, rows.trial_x, j), get(f, rows.trial_e, j)
        finite = (y.dot(y) < real(1e30)) & (e.dot(e) < real(1e30))
        if not finite:
            stop(n, j)
        else:
            k, image = swimmers.int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i)
            b, image_b = swimmers.int[int(Int.BOUND), i], image_of(swimmers, int(Int.BOUND_IMAGE), i)
            y1, found, held = resolve(
                medium, k, image, y, x, e, f[rows.gamma][j], rules.tolerance, b, image_b
            )  # fmt: skip
            z = y1.variable()
            if held.jammed != 0:
                ti.atomic_add(swimmers.total[int(Total.JAMMED)], 1)
            if (held.last >= 0) | (held.jammed != 0):
                put(f, rows.trial_rest, j, y * real(0.0))
            if ti.static(located):
                pair(i, swimmers, found, k, image)
            if not same(k, image, found.near, found.image):
                shift = between(medium, found.near, found.image, k, image)
                z += shift
                put(f, rows.x, j, x + shift)
                swimmers.int[int(Int.COLLOID), i] = found.near
                put_image(swimmers, int(Int.IMAGE), i, found.image)
            pushed = False
            if ti.static(reflected):
                pushed = n[LaneInt.TOUCH][j] != 0
            strike(
                n, j, i, swimmers, found, rules.tolerance, held, ti.select(pushed, k, -1), image,
            )  # fmt: skip
            push_off(f, n, j, k, image, held)
            set_budget(f, n, j, i, swimmers, z, found, rules)
            put(f, rows.trial_x, j, z)
            n[LaneInt.TOUCH][j] = ti.cast((found.depth >= -band) | pushed, ti.i32)
            for axis in ti.static(range(3)):
                if ti.abs(found.image[axis]) > MAX_IMAGE:
                    stop(n, j)

    return settle
