"""The life of an encounter: capture, first passage of the escape pitch, escape, hop."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.log import make_log
from porous_swim.engine.kernel.record import make_record
from porous_swim.engine.kernel.rows import make_vectors
from porous_swim.engine.kernel.state import Event, Int, LaneInt, Law, Long, Phase, Total, real_rows
from porous_swim.engine.kernel.swimmers import image_of, packed, put_image, same, set_of, touched_image, unpacked
from porous_swim.obstacles.search import make_between
from porous_swim.physics.lift_off import make_lift_off_sine
from porous_swim.physics.surface import Surface, make_surface
from porous_swim.physics.vectors import pick, vec


@ti.func
def base_image(n: ti.template(), j, i, swimmers: ti.template()):
    """The image that `TOUCHED_IMAGE` is told from: that of the encounter, without one that of the nearest colloid."""
    bound = n[LaneInt.PHASE][j] == int(Phase.BOUND)
    return pick(bound, image_of(swimmers, int(Int.BOUND_IMAGE), i), image_of(swimmers, int(Int.IMAGE), i))


@ti.func
def put_touched(n: ti.template(), j, i, swimmers: ti.template(), k, image):
    """Note that swimmer i has touched colloid k; without an encounter, that it is to begin one there."""
    swimmers.int[int(Int.TOUCHED), i] = k
    swimmers.int[int(Int.TOUCHED_IMAGE), i] = packed(image, base_image(n, j, i, swimmers))


@cache
def make_recall(located: bool):
    """Return `recall(n, j, i, swimmers)`, which tells the lane what swimmer i has struck."""
    _, put = make_vectors(3)

    @ti.func
    def recall(n: ti.template(), j, i, swimmers: ti.template()):
        k, image = swimmers.int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i).variable()
        if ti.static(located):
            k, image = swimmers.int[int(Int.STRUCK), i], image_of(swimmers, int(Int.STRUCK_IMAGE), i)
        elif n[Int.EVENT][j] & int(Event.CONTACT):  # which waits for room in the log
            k = swimmers.int[int(Int.TOUCHED), i]
            image = unpacked(swimmers.int[int(Int.TOUCHED_IMAGE), i], base_image(n, j, i, swimmers))
        n[LaneInt.STRUCK][j] = k
        put(n, LaneInt.STRUCK_IMAGE, j, image)

    return recall


@cache
def make_orient(real, dimensions: int, located: bool, mates: bool):
    """Return `orient(f, n, j, i, swimmers, medium)`.

    It makes the lane's relations between its nearest colloid, its mate and the colloid of its encounter.
    """
    rows = real_rows(dimensions, located=located)
    _, put = make_vectors(dimensions)
    get_image, _ = make_vectors(3)
    between = make_between(real, dimensions)

    @ti.func
    def orient(f: ti.template(), n: ti.template(), j, i, swimmers: ti.template(), medium: ti.template()):
        k, image = swimmers.int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i)
        b, image_b = swimmers.int[int(Int.BOUND), i], image_of(swimmers, int(Int.BOUND_IMAGE), i).variable()
        t, image_t = swimmers.int[int(Int.TOUCHED), i], touched_image(swimmers, i)
        none = b < 0
        b, image_b = ti.select(none, k, b), pick(none, image, image_b)
        struck, image_s = n[LaneInt.STRUCK][j], get_image(n, LaneInt.STRUCK_IMAGE, j)
        bound = n[LaneInt.PHASE][j] == int(Phase.BOUND)
        own = bound & same(k, image, b, image_b)
        known = same(struck, image_s, b, image_b) | same(struck, image_s, t, image_t)
        news = (not bound) | (not known)
        awaited = (n[LaneInt.PHASE][j] != int(Phase.FREE)) & (swimmers.long[int(Long.PITCH), i] < 0)
        f[rows.A][j], f[rows.bound_A][j] = medium.radius[k], medium.radius[b]
        put(f, rows.bound_offset, j, between(medium, b, image_b, k, image))
        if ti.static(located or mates):
            m, image_m = swimmers.int[int(Int.MATE), i], image_of(swimmers, int(Int.MATE_IMAGE), i).variable()
            if ti.static(mates):
                own_m, mate_t = same(m, image_m, b, image_b), same(m, image_m, t, image_t)
                n[LaneInt.PAIRED][j] = ti.cast(m >= 0, ti.i32)
                n[LaneInt.MATE_OWN][j] = ti.cast(bound & (m >= 0) & own_m, ti.i32)
                n[LaneInt.MATE_KNOWN][j] = ti.cast(bound & (m >= 0) & (own_m | mate_t), ti.i32)
            else:
                n[LaneInt.BETWEEN][j] = ti.cast(m >= 0, ti.i32)
            m, image_m = ti.select(m < 0, k, m), pick(m < 0, image, image_m)
            f[rows.mate_A][j] = medium.radius[m]
            put(f, rows.mate_offset, j, between(medium, m, image_m, k, image))
        n[LaneInt.OWN][j] = ti.cast(own, ti.i32)
        n[LaneInt.WATCH_CONTACT][j] = ti.cast(news, ti.i32)
        n[LaneInt.WATCH_PITCH][j] = ti.cast(awaited & (f[rows.escape_sine][j] < real(1.0)), ti.i32)

    return orient


@cache
def make_threshold(real, contact_height, sphere: bool, surface: Surface):
    """Return `threshold(swimmers, medium, i, k, alpha, gamma)`: the sine of swimmer i's escape pitch at colloid k."""
    lift_off_sine = make_lift_off_sine(real, contact_height, sphere, surface)

    @ti.func
    def threshold(swimmers: ti.template(), medium: ti.template(), i, k, alpha, gamma):
        sine = swimmers.law[set_of(swimmers, i), int(Law.ESCAPE_SINE)]
        if sine < real(-1.0):
            sine = lift_off_sine(medium.radius[k], alpha, gamma)
        return sine

    return threshold


@cache
def make_capture(real, dimensions: int, contact_height, sphere: bool, surface: Surface, integrator: str):
    """Return `capture(f, n, j, i, swimmers, medium, rules, k, image, struck)`, which opens an encounter with colloid k.

    `struck` says whether it begins at the wall; it does not in a direct hop.
    """
    reflected, located = integrator == "reflected", integrator == "located"
    rows = real_rows(dimensions, located=located)
    get, _ = make_vectors(dimensions)
    _, _, clear = make_record(dimensions, located=located)
    between = make_between(real, dimensions)
    threshold_at = make_threshold(real, contact_height, sphere, surface)
    to = make_surface(real, surface)

    @ti.func
    def count(i, swimmers: ti.template(), k, image):
        """A hop comes from another colloid, a return from the same; a first encounter is neither."""
        b, image_b = swimmers.int[int(Int.BOUND), i], image_of(swimmers, int(Int.BOUND_IMAGE), i)
        again = same(b, image_b, k, image)
        ti.atomic_add(swimmers.total[int(Total.CAPTURES)], 1)
        ti.atomic_add(swimmers.total[int(Total.RETURNS)], ti.select(again, 1, 0))
        ti.atomic_add(swimmers.total[int(Total.HOPS)], ti.select((b >= 0) & (not again), 1, 0))

    @ti.func
    def capture(f: ti.template(), n: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(),
                rules: ti.template(), k, image, struck):  # fmt: skip
        count(i, swimmers, k, image)
        swimmers.int[int(Int.BOUND), i] = k
        put_image(swimmers, int(Int.BOUND_IMAGE), i, image)
        swimmers.int[int(Int.TOUCHED), i] = -1
        n[LaneInt.PHASE][j] = int(Phase.BOUND)
        nearest, nearest_image = swimmers.int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i)
        r = (get(f, rows.x, j) + between(medium, k, image, nearest, nearest_image)).variable()
        e = get(f, rows.e, j)
        R = to.distance(r)
        s, h = to.sine(r, e, R), R - medium.radius[k]
        least = contact_height(s, f[rows.gamma][j], medium.radius[k])
        touch, low = h <= least + rules.tolerance, h
        if ti.static(reflected):  # the wall was touched within the step, and may have been left again
            touch |= struck
            low = ti.select(struck, ti.min(h, least), h)
            r = to.at(r, R, medium.radius[k] + low)
        for d in ti.static(range(dimensions)):
            swimmers.real[rows.entry_x + d, i] = r[d]
            swimmers.real[rows.entry_e + d, i] = e[d]
        push = ti.select(struck, f[rows.push][j], real(0.0))
        clear(f, j)
        f[rows.min_height][j], f[rows.max_height][j] = h, h
        threshold = threshold_at(swimmers, medium, i, k, f[rows.alpha][j], f[rows.gamma][j])
        f[rows.escape_sine][j] = threshold
        f[rows.release_sine][j] = s
        n[LaneInt.RELEASE][j], n[LaneInt.N_CONTACT][j] = -1, 0
        step = rules.first + n[Int.STEP][j]
        swimmers.long[int(Long.START), i] = step
        swimmers.long[int(Long.N_CONTACT), i] = ti.i64(0)
        swimmers.long[int(Long.RELEASE), i] = ti.select(touch, step, ti.i64(-1))
        swimmers.long[int(Long.PITCH), i] = ti.select(s > threshold, step, ti.i64(-1))
        if ti.static(located):
            for row in ti.static((rows.start_clock, rows.pitch_clock, rows.release_clock)):
                f[row][j] = f[rows.clock][j]
        f[rows.contact_clock][j] = real(0.0)
        if ti.static(reflected):  # what is left of the step counts, and the push at first contact
            f[rows.push][j] = push
            f[rows.min_height][j] = low
            f[rows.height][j] = -f[rows.clock][j] * h
        if ti.static(
            not located
        ):  # both ends of each step count: half of the entry here, half less where it is cut off
            band = ti.max(rules.contact_band, rules.tolerance)
            at_entry = ti.select(low - least <= band, real(0.5), real(0.0))
            f[rows.contact_clock][j] = at_entry + ti.select(h - least <= band, -f[rows.clock][j], real(0.0))

    return capture


@cache
def make_encounters(
    real, dimensions: int, contact_height, sphere: bool, surface: Surface, integrator: str, mates: bool
):  # fmt: skip
    """Return `encounters(f, n, j, i, swimmers, medium, log, rules)`, for the events of a step of lane j (swimmer i).

    What needs a row of the log stays pending while the log is full.
    """
    located = integrator == "located"
    rows = real_rows(dimensions, located=located)
    get, _ = make_vectors(dimensions)
    get_image, _ = make_vectors(3)
    between = make_between(real, dimensions)
    capture = make_capture(real, dimensions, contact_height, sphere, surface, integrator)
    to = make_surface(real, surface)
    log_row = make_log(real, dimensions, integrator)

    @ti.func
    def within_reach(f: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(), reach):
        """Whether the colloid touched last in the encounter is no farther than `reach`."""
        near = False
        t, image_t = swimmers.int[int(Int.TOUCHED), i], touched_image(swimmers, i)
        if t >= 0:
            k, image = swimmers.int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i)
            r = get(f, rows.x, j) + between(medium, t, image_t, k, image)
            near = to.distance(r) - medium.radius[t] <= reach
        return near

    @ti.func
    def encounters(f: ti.template(), n: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(),
                   log: ti.template(), rules: ti.template()):  # fmt: skip
        event, phase = n[Int.EVENT][j], n[LaneInt.PHASE][j]
        if ti.static(mates):  # what is no news may become news
            f[rows.budget][j] = real(0.0)
        step = rules.first + n[Int.STEP][j]
        escaped = (event & int(Event.ESCAPE)) != 0
        passed, struck = (event & int(Event.PITCH)) != 0, (event & int(Event.CONTACT)) != 0
        bound = phase == int(Phase.BOUND)
        if passed & bound:
            swimmers.long[int(Long.PITCH), i] = step
            if ti.static(located):
                f[rows.pitch_clock][j] = f[rows.clock][j]
        late = passed & (phase == int(Phase.LEFT))
        written = True
        if escaped:  # a reflected path may have come back from there
            f[rows.max_height][j] = ti.max(f[rows.max_height][j], rules.escape_height)
        if escaped | late:
            written = log_row(f, n, j, i, swimmers, log, step, late)
        k, image = n[LaneInt.STRUCK][j], get_image(n, LaneInt.STRUCK_IMAGE, j)
        # before an escape in the same step, as the next encounter begins at the last touched; or until the log has room
        if struck & (bound | (not written)):
            put_touched(n, j, i, swimmers, k, image)
        if written:
            n[Int.EVENT][j] = int(Event.ORIENT)
            target, target_image = -1, vec(0, 0, 0).variable()
            if late:
                swimmers.long[int(Long.PITCH), i] = step
                phase = int(Phase.FREE)
            if escaped:
                ti.atomic_add(swimmers.total[int(Total.ESCAPES)], 1)
                f[rows.push][j] = real(0.0)
                awaited = (n[LaneInt.WATCH_PITCH][j] != 0) & (not passed)
                phase = ti.select(awaited, int(Phase.LEFT), int(Phase.FREE))
                if within_reach(f, j, i, swimmers, medium, rules.escape_height):  # a direct hop
                    target = swimmers.int[int(Int.TOUCHED), i]
                    target_image = touched_image(swimmers, i)
                swimmers.int[int(Int.TOUCHED), i] = -1
            n[LaneInt.PHASE][j] = phase
            if struck & (not bound):
                target, target_image = k, image
            if target >= 0:
                capture(f, n, j, i, swimmers, medium, rules, target, target_image, struck)

    return encounters
