"""The beginning of an encounter, and the pitch whose first passage is timed in it."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.record import make_record
from porous_swim.engine.kernel.rows import make_vectors, rows_of
from porous_swim.engine.kernel.state import Int, LaneInt, Long, Phase, Total
from porous_swim.engine.kernel.swimmers import image_of, put_image, same, set_of
from porous_swim.obstacles.search import make_between
from porous_swim.physics.contact import HardContact
from porous_swim.physics.lift_off import make_lift_off_sine
from porous_swim.physics.model import Model
from porous_swim.physics.surface import make_surface


@cache
def make_threshold(model: Model):
    """Return `threshold(swimmers, medium, i, k, alpha, gamma)`: the sine of swimmer i's escape pitch at colloid k."""
    real, lift_off_sine = model.real, make_lift_off_sine(model)
    column = model.numbers.index("escape_sine")

    @ti.func
    def threshold(swimmers: ti.template(), medium: ti.template(), i, k, alpha, gamma):
        sine = swimmers.law[set_of(swimmers, i), column]
        if sine < real(-1.0):
            sine = lift_off_sine(medium.radius[k], alpha, gamma)
        return sine

    return threshold


@cache
def make_capture(model: Model):
    """Return `capture(reals, ints, j, i, swimmers, medium, rules, target)`, which opens an encounter.

    `target` is the colloid, `k` and `image`; `touched_body` says whether it begins at the wall: not in a
    direct hop.
    """
    real, dimensions, reflected, located = model.real, model.dimensions, model.reflected, model.located
    rows, (get, _) = rows_of(model), make_vectors(model)
    contact_height, threshold_at = HardContact.make_rolled_height(model), make_threshold(model)
    between, to, (_, _, clear) = make_between(model), make_surface(model), make_record(model)

    @ti.func
    def count(i, swimmers: ti.template(), k, image):
        """A hop comes from another colloid, a return from the same; a first encounter is neither."""
        b, image_b = swimmers.int[int(Int.BOUND), i], image_of(swimmers, int(Int.BOUND_IMAGE), i)
        again = same(b, image_b, k, image)
        ti.atomic_add(swimmers.total[int(Total.CAPTURES)], 1)
        ti.atomic_add(swimmers.total[int(Total.RETURNS)], ti.select(again, 1, 0))
        ti.atomic_add(swimmers.total[int(Total.HOPS)], ti.select((b >= 0) & (not again), 1, 0))

    @ti.func
    def capture(reals: ti.template(), ints: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(),
                rules: ti.template(), target):  # fmt: skip
        k, image, touched_body = target.k, target.image, target.touched_body
        count(i, swimmers, k, image)
        swimmers.int[int(Int.BOUND), i] = k
        put_image(swimmers, int(Int.BOUND_IMAGE), i, image)
        swimmers.int[int(Int.TOUCHED), i] = -1
        ints[LaneInt.PHASE][j] = int(Phase.BOUND)
        nearest, nearest_image = swimmers.int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i)
        r = (get(reals, rows.x, j) + between(medium, k, image, nearest, nearest_image)).variable()
        e = get(reals, rows.e, j)
        R = to.distance(r)
        s, h = to.sine(r, e, R), R - medium.radius[k]
        least = contact_height(s, reals[rows.law.gamma][j], medium.radius[k])
        touch, low = h <= least + rules.tolerance, h
        if ti.static(reflected):  # the wall was touched within the step, and may have been left again
            touch |= touched_body
            low = ti.select(touched_body, ti.min(h, least), h)
            r = to.at(r, R, medium.radius[k] + low)
        for d in ti.static(range(dimensions)):
            swimmers.real[rows.entry_x + d, i] = r[d]
            swimmers.real[rows.entry_e + d, i] = e[d]
        push = ti.select(touched_body, reals[rows.push][j], real(0.0))
        clear(reals, j)
        reals[rows.min_height][j], reals[rows.max_height][j] = h, h
        threshold = threshold_at(swimmers, medium, i, k, reals[rows.law.alpha][j], reals[rows.law.gamma][j])
        reals[rows.law.escape_sine][j] = threshold
        reals[rows.release_sine][j] = s
        ints[LaneInt.RELEASE][j], ints[LaneInt.N_CONTACT][j] = -1, 0
        step = rules.first + ints[Int.STEP][j]
        swimmers.long[int(Long.START), i] = step
        swimmers.long[int(Long.N_CONTACT), i] = ti.i64(0)
        swimmers.long[int(Long.RELEASE), i] = ti.select(touch, step, ti.i64(-1))
        swimmers.long[int(Long.PITCH), i] = ti.select(s > threshold, step, ti.i64(-1))
        if ti.static(located):
            for row in ti.static((rows.start_clock, rows.pitch_clock, rows.release_clock)):
                reals[row][j] = reals[rows.clock][j]
        reals[rows.contact_clock][j] = real(0.0)
        if ti.static(reflected):  # what is left of the step counts, and the push at first contact
            reals[rows.push][j] = push
            reals[rows.min_height][j] = low
            reals[rows.height][j] = -reals[rows.clock][j] * h
        if ti.static(
            not located
        ):  # both ends of each step count: half of the entry here, half less where it is cut off
            band = ti.max(rules.contact_band, rules.tolerance)
            at_entry = ti.select(low - least <= band, real(0.5), real(0.0))
            reals[rows.contact_clock][j] = at_entry + ti.select(h - least <= band, -reals[rows.clock][j], real(0.0))

    return capture
