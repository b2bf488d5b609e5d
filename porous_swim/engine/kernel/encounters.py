"""The life of an encounter: capture, first passage of the escape pitch, escape, hop."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.capture import make_capture
from porous_swim.engine.kernel.device_log import make_log
from porous_swim.engine.kernel.rows import get_image, make_vectors, put_lane_image, rows_of
from porous_swim.engine.kernel.state import Event, Int, LaneInt, Long, Phase, Total
from porous_swim.engine.kernel.swimmers import image_of, packed, same, touched_image, unpacked
from porous_swim.obstacles.search import make_between
from porous_swim.physics.model import Model
from porous_swim.physics.surface import make_surface
from porous_swim.physics.vectors import pick, record, vec


@ti.func
def base_image(ints: ti.template(), j, i, swimmers: ti.template()):
    """The image that `TOUCHED_IMAGE` is told from: that of the encounter, without one that of the nearest colloid."""
    bound = ints[LaneInt.PHASE][j] == int(Phase.BOUND)
    return pick(bound, image_of(swimmers, int(Int.BOUND_IMAGE), i), image_of(swimmers, int(Int.IMAGE), i))


@ti.func
def put_touched(ints: ti.template(), j, i, swimmers: ti.template(), k, image):
    """Note that swimmer i has touched colloid k; without an encounter, that it is to begin one there."""
    swimmers.int[int(Int.TOUCHED), i] = k
    swimmers.int[int(Int.TOUCHED_IMAGE), i] = packed(image, base_image(ints, j, i, swimmers))


@cache
def make_recall(model: Model):
    """Return `recall(ints, j, i, swimmers)`, which tells the lane what swimmer i has touched."""
    located = model.located

    @ti.func
    def recall(ints: ti.template(), j, i, swimmers: ti.template()):
        k, image = swimmers.int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i).variable()
        if ti.static(located):
            k, image = swimmers.int[int(Int.TOUCHED_BODY), i], image_of(swimmers, int(Int.TOUCHED_BODY_IMAGE), i)
        elif ints[Int.EVENT][j] & int(Event.CONTACT):  # which waits for room in the log
            k = swimmers.int[int(Int.TOUCHED), i]
            image = unpacked(swimmers.int[int(Int.TOUCHED_IMAGE), i], base_image(ints, j, i, swimmers))
        ints[LaneInt.TOUCHED_BODY][j] = k
        put_lane_image(ints, LaneInt.TOUCHED_BODY_IMAGE, j, image)

    return recall


@cache
def make_refresh_neighbours(model: Model):
    """Return `refresh_neighbours(reals, ints, j, i, swimmers, medium)`.

    It makes the lane's relations between its nearest colloid, its partner and the colloid of its encounter.
    """
    real, located, partners, rows = model.real, model.located, model.partners, rows_of(model)
    _, put = make_vectors(model)
    between = make_between(model)

    @ti.func
    def refresh_neighbours(
        reals: ti.template(), ints: ti.template(), j, i, swimmers: ti.template(), medium: ti.template()
    ):
        k, image = swimmers.int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i)
        b, image_b = swimmers.int[int(Int.BOUND), i], image_of(swimmers, int(Int.BOUND_IMAGE), i).variable()
        t, image_t = swimmers.int[int(Int.TOUCHED), i], touched_image(swimmers, i)
        none = b < 0
        b, image_b = ti.select(none, k, b), pick(none, image, image_b)
        touched_body, image_s = ints[LaneInt.TOUCHED_BODY][j], get_image(ints, LaneInt.TOUCHED_BODY_IMAGE, j)
        bound = ints[LaneInt.PHASE][j] == int(Phase.BOUND)
        own = bound & same(k, image, b, image_b)
        known = same(touched_body, image_s, b, image_b) | same(touched_body, image_s, t, image_t)
        news = (not bound) | (not known)
        awaited = (ints[LaneInt.PHASE][j] != int(Phase.FREE)) & (swimmers.long[int(Long.PITCH), i] < 0)
        reals[rows.A][j], reals[rows.bound_A][j] = medium.radius[k], medium.radius[b]
        put(reals, rows.bound_offset, j, between(medium, b, image_b, k, image))
        if ti.static(located or partners):
            m, image_m = swimmers.int[int(Int.PARTNER), i], image_of(swimmers, int(Int.PARTNER_IMAGE), i).variable()
            if ti.static(partners):
                own_m, partner_t = same(m, image_m, b, image_b), same(m, image_m, t, image_t)
                ints[LaneInt.PAIRED][j] = ti.cast(m >= 0, ti.i32)
                ints[LaneInt.PARTNER_OWN][j] = ti.cast(bound & (m >= 0) & own_m, ti.i32)
                ints[LaneInt.PARTNER_KNOWN][j] = ti.cast(bound & (m >= 0) & (own_m | partner_t), ti.i32)
            else:
                ints[LaneInt.BETWEEN][j] = ti.cast(m >= 0, ti.i32)
            m, image_m = ti.select(m < 0, k, m), pick(m < 0, image, image_m)
            reals[rows.partner_A][j] = medium.radius[m]
            put(reals, rows.partner_offset, j, between(medium, m, image_m, k, image))
        ints[LaneInt.OWN][j] = ti.cast(own, ti.i32)
        ints[LaneInt.WATCH_CONTACT][j] = ti.cast(news, ti.i32)
        ints[LaneInt.WATCH_PITCH][j] = ti.cast(awaited & (reals[rows.law.escape_sine][j] < real(1.0)), ti.i32)

    return refresh_neighbours


@cache
def make_encounters(model: Model):
    """Return `encounters(reals, ints, j, i, swimmers, medium, log, rules)`, for the events of a step of lane j.

    What needs a row of the log stays pending while the log is full.
    """
    real, located, partners = model.real, model.located, model.partners
    rows, (get, _) = rows_of(model), make_vectors(model)
    between, to = make_between(model), make_surface(model)
    capture, log_row = make_capture(model), make_log(model)

    @ti.func
    def within_reach(reals: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(), reach):
        """Whether the colloid touched last in the encounter is no farther than `reach`."""
        near = False
        t, image_t = swimmers.int[int(Int.TOUCHED), i], touched_image(swimmers, i)
        if t >= 0:
            k, image = swimmers.int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i)
            r = get(reals, rows.x, j) + between(medium, t, image_t, k, image)
            near = to.distance(r) - medium.radius[t] <= reach
        return near

    @ti.func
    def encounters(reals: ti.template(), ints: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(),
                   log: ti.template(), rules: ti.template()):  # fmt: skip
        event, phase = ints[Int.EVENT][j], ints[LaneInt.PHASE][j]
        if ti.static(partners):  # what is no news may become news
            reals[rows.budget][j] = real(0.0)
        step = rules.first + ints[Int.STEP][j]
        escaped = (event & int(Event.ESCAPE)) != 0
        passed, touched_body = (event & int(Event.PITCH)) != 0, (event & int(Event.CONTACT)) != 0
        bound = phase == int(Phase.BOUND)
        if passed & bound:
            swimmers.long[int(Long.PITCH), i] = step
            if ti.static(located):
                reals[rows.pitch_clock][j] = reals[rows.clock][j]
        late = passed & (phase == int(Phase.LEFT))
        written = True
        if escaped:  # a reflected path may have come back from there
            reals[rows.max_height][j] = ti.max(reals[rows.max_height][j], rules.escape_height)
        if escaped | late:
            written = log_row(reals, ints, j, i, swimmers, log, step, late)
        k, image = ints[LaneInt.TOUCHED_BODY][j], get_image(ints, LaneInt.TOUCHED_BODY_IMAGE, j)
        # before an escape in the same step, as the next encounter begins at the last touched; or until the log has room
        if touched_body & (bound | (not written)):
            put_touched(ints, j, i, swimmers, k, image)
        if written:
            ints[Int.EVENT][j] = int(Event.REFRESH)
            target, target_image = -1, vec(0, 0, 0).variable()
            if late:
                swimmers.long[int(Long.PITCH), i] = step
                phase = int(Phase.FREE)
            if escaped:
                ti.atomic_add(swimmers.total[int(Total.ESCAPES)], 1)
                reals[rows.push][j] = real(0.0)
                awaited = (ints[LaneInt.WATCH_PITCH][j] != 0) & (not passed)
                phase = ti.select(awaited, int(Phase.LEFT), int(Phase.FREE))
                if within_reach(reals, j, i, swimmers, medium, rules.escape_height):  # a direct hop
                    target = swimmers.int[int(Int.TOUCHED), i]
                    target_image = touched_image(swimmers, i)
                swimmers.int[int(Int.TOUCHED), i] = -1
            ints[LaneInt.PHASE][j] = phase
            if touched_body & (not bound):
                target, target_image = k, image
            if target >= 0:
                begun = record(k=target, image=target_image, touched_body=touched_body)
                capture(reals, ints, j, i, swimmers, medium, rules, begun)

    return encounters
