"""How far a swimmer may go from where it was looked for, until another colloid than those its lane knows may matter."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.rows import get_image, make_vectors, put_lane_image, rows_of
from porous_swim.engine.kernel.state import Int, LaneInt, Phase
from porous_swim.engine.kernel.swimmers import image_of, put_image, same, touched_image
from porous_swim.physics.model import Model

PAIRED_WITHIN = 0.2  # a, beyond reach: nearer a rod has the second nearest colloid for its mate


@ti.func
def no_news(n: ti.template(), j, i, swimmers: ti.template(), k, image):
    """Whether contact with colloid k is known in the encounter under way."""
    own = same(k, image, swimmers.int[int(Int.BOUND), i], image_of(swimmers, int(Int.BOUND_IMAGE), i))
    touched = same(k, image, swimmers.int[int(Int.TOUCHED), i], touched_image(swimmers, i))
    return (n[LaneInt.PHASE][j] == int(Phase.BOUND)) & (own | touched)


@cache
def make_choose_mate(model: Model):
    """Return `choose_mate(i, swimmers, found, rules) -> reach, whether there is a mate`, for rods.

    The reach is how far a rod may go until a colloid that its lane does not know may matter.
    """
    real, mates = model.real, model.mates

    @ti.func
    def choose_mate(i, swimmers: ti.template(), found, rules: ti.template()):
        # contact heights are at most 1
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

    return choose_mate


@cache
def make_budget(model: Model):
    """Return `set_budget(f, n, j, i, swimmers, y, found, rules)`, at offset y where the search `found` what it did.

    The budget is half of the lead of the nearest surface, so that no other can be nearer within it.
    """
    real, mates, located, sphere = model.real, model.mates, model.located, model.sphere
    rows, (_, put), choose_mate = rows_of(model), make_vectors(model), make_choose_mate(model)

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

    return set_budget
