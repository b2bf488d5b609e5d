"""How far a swimmer may go from where it was looked for, until another colloid than those its lane knows may matter."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.rows import get_image, make_vectors, put_lane_image, rows_of
from porous_swim.engine.kernel.state import Int, LaneInt, Phase
from porous_swim.engine.kernel.swimmers import image_of, put_image, same, touched_image
from porous_swim.physics.model import Model

PARTNER_WITHIN = 0.2  # a, beyond reach: nearer a rod has the second nearest colloid for its partner


@ti.func
def no_news(ints: ti.template(), j, i, swimmers: ti.template(), k, image):
    """Whether contact with colloid k is known in the encounter under way."""
    own = same(k, image, swimmers.int[int(Int.BOUND), i], image_of(swimmers, int(Int.BOUND_IMAGE), i))
    touched = same(k, image, swimmers.int[int(Int.TOUCHED), i], touched_image(swimmers, i))
    return (ints[LaneInt.PHASE][j] == int(Phase.BOUND)) & (own | touched)


@cache
def make_choose_partner(model: Model):
    """Return `choose_partner(i, swimmers, found, rules) -> reach, whether there is a partner`, for rods.

    The reach is how far a rod may go until a colloid that its lane does not know may matter.
    """
    real, partners = model.real, model.partners

    @ti.func
    def choose_partner(i, swimmers: ti.template(), found, rules: ti.template()):
        # contact heights are at most 1
        band = real(1.0) + ti.max(rules.contact_band, rules.tolerance)
        reach, paired = found.second - band, False
        if ti.static(partners):
            # cells list all that is within the escape height
            together = ti.min(found.third, rules.escape_height) - band
            paired = (reach < real(PARTNER_WITHIN)) & (reach < together) & (found.partner >= 0)
            swimmers.int[int(Int.PARTNER), i] = ti.select(paired, found.partner, -1)
            put_image(swimmers, int(Int.PARTNER_IMAGE), i, found.partner_image)
            reach = ti.select(paired, together, reach)
        return reach, paired

    return choose_partner


@cache
def make_budget(model: Model):
    """Return `set_budget(reals, ints, j, i, swimmers, y, found, rules)`, at offset y, where the search gave `found`.

    The budget is half of the lead of the nearest surface, so that no other can be nearer within it.
    """
    real, partners, located, sphere = model.real, model.partners, model.located, model.sphere
    rows, (_, put), choose_partner = rows_of(model), make_vectors(model), make_choose_partner(model)

    @ti.func
    def set_budget(
        reals: ti.template(), ints: ti.template(), j, i, swimmers: ti.template(), y, found, rules: ti.template()
    ):  # fmt: skip
        budget = real(0.5) * (found.second - found.first)
        if ti.static(not sphere):
            reach, partner = choose_partner(i, swimmers, found, rules)
            if ti.static(partners):
                swaps = (
                    partner
                    & no_news(ints, j, i, swimmers, found.near, found.image)
                    & no_news(ints, j, i, swimmers, found.partner, found.partner_image)
                )
                # both may be the nearest: it is the third, beyond the list of the cell if need be, that must not be
                lead = real(0.5) * (ti.min(found.third, rules.escape_height) - found.first)
                budget = ti.select(swaps, lead, budget)
            budget = ti.min(budget, reach)
        budget = ti.max(real(0.0), budget - rules.margin)
        if ti.static(not located):  # a later touch is that of the nearest
            touched_body, image = (
                ints[LaneInt.TOUCHED_BODY][j],
                get_image(ints, LaneInt.TOUCHED_BODY_IMAGE, j).variable(),
            )
            if ti.static(partners):
                known = no_news(ints, j, i, swimmers, touched_body, image)
                if known & no_news(ints, j, i, swimmers, found.near, found.image):
                    ints[LaneInt.TOUCHED_BODY][j], touched_body = found.near, found.near
                    put_lane_image(ints, LaneInt.TOUCHED_BODY_IMAGE, j, found.image)
                    image = found.image
            budget = ti.select(same(touched_body, image, found.near, found.image), budget, real(0.0))
        reals[rows.budget][j] = budget * budget
        put(reals, rows.reference, j, y)

    return set_budget
