"""Contact with every colloid, and which one is nearest: what the lanes, which know one colloid, cannot do."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.rows import make_vectors
from porous_swim.engine.state import Event, Int, LaneInt, Phase, real_rows
from porous_swim.engine.swimmers import image_of, put_image, same
from porous_swim.obstacles.search import make_between, make_search
from porous_swim.physics.surface import Surface, make_surface
from porous_swim.physics.vectors import pick, vec

MAX_PROJECTIONS = 8
MAX_IMAGE = 2**30
BETWEEN = 1e-10  # a difference of distances, in a, below which two colloids are equally near, where events are located


@cache
def make_project(real, surface: Surface):
    """Return `on_sphere` and `on_circle`, which put a point on one contact sphere (or plane) or on two at once."""
    to = make_surface(real, surface)

    @ti.func
    def on_sphere(y, c, radius):
        v = y - c
        return c + to.at(v, to.distance(v), radius)

    @ti.func
    def on_circle(y, c, radius, c1, radius1):
        """The point nearest to y on both spheres; on the first one where they do not meet."""
        d = c1 - c
        rho = d.dot(d)
        a = real(0.5) * (rho + radius * radius - radius1 * radius1) / rho
        v = y - c
        across = v - d * (v.dot(d) / rho)
        square = radius * radius - a * a * rho
        out = across.dot(across)
        meet = (square > real(0.0)) & (out > real(0.0))
        both = c + d * a + across * ti.sqrt(ti.max(square, real(0.0)) / out)
        return pick(meet, both, on_sphere(y, c, radius))

    return on_sphere, on_circle


@cache
def make_resolve(real, dimensions: int, contact_height, sphere: bool, surface: Surface):
    """Return `resolve(medium, k, image, y, y_old, e, e_old, gamma, tolerance)`.

    `y` is an offset from image `image` of colloid k. While the swimmer reaches into a colloid by more than the
    tolerance it is put on that colloid's contact sphere, or, when it goes back and forth between two, on the circle
    where both contact spheres meet (in the plane, the point). After 8 tries it stays where and as it was.

    It returns y, e, the result of the search there, and the last two colloids that it was put on (-1: none).
    """
    between = make_between(real, dimensions)
    search = make_search(real, dimensions, contact_height, sphere, surface)
    on_sphere, on_circle = make_project(real, surface)
    to = make_surface(real, surface)

    @ti.func
    def resolve(medium: ti.template(), k, image, y_trial, y_old, e_trial, e_old, gamma, tolerance):
        y, e = y_trial.variable(), e_trial.variable()
        last, last_image, before, before_image = -1, vec(0, 0, 0).variable(), -1, vec(0, 0, 0).variable()
        c_last, radius_last = (y * real(0.0)).variable(), real(0.0)
        found = search.empty()
        tries, inside = 0, True
        while inside:
            found = search.run(medium, k, image, y, e, gamma)
            inside = (found.depth > tolerance) & (tries <= MAX_PROJECTIONS)
            if inside:
                j, image_j = found.deep, found.deep_image
                c = between(medium, k, image, j, image_j)
                v = y - c
                A = medium.radius[j]
                radius = A + contact_height(to.sine(v, e, to.distance(v)), gamma, A)
                back = same(j, image_j, before, before_image)
                y = pick(back, on_circle(y, c, radius, c_last, radius_last), on_sphere(y, c, radius))
                y, e = pick(tries == MAX_PROJECTIONS, y_old, y), pick(tries == MAX_PROJECTIONS, e_old, e)
                before, before_image = last, last_image
                last, last_image, c_last, radius_last = j, image_j, c, radius
            tries += 1
        return y, e, found, last, last_image, before, before_image

    return resolve


@cache
def make_settle(real, dimensions: int, contact_height, sphere: bool, surface: Surface, integrator: str):
    """Return `settle(f, n, j, i, swimmers, medium, rules, band)`, which ends the trial move of lane j (swimmer i).

    The trial obeys contact with every colloid, offsets are measured from the colloid nearest to it, and the budget
    is set anew: half of the lead of the nearest surface, so that no other can be nearer within it. A swimmer no
    higher than `band` above contact touches, and so does one that a reflecting wall has pushed on its way.
    """
    reflected, located = integrator == "reflected", integrator == "located"
    rows = real_rows(dimensions, located=located)
    get, put = make_vectors(dimensions)
    get_image, put_lane_image = make_vectors(3)
    between = make_between(real, dimensions)
    resolve = make_resolve(real, dimensions, contact_height, sphere, surface)
    to = make_surface(real, surface)

    @ti.func
    def push_off(f: ti.template(), j, y, z):
        """Book the part of a projection that leads away from the colloid of the encounter."""
        moved, r = z - y, z + get(f, rows.bound_offset, j)
        if moved.dot(moved) > real(0.0):
            put(f, rows.trial_rest, j, y * real(0.0))
            f[rows.trial_push][j] += ti.max(real(0.0), to.sine(r, moved, to.distance(r)))

    @ti.func
    def set_budget(f: ti.template(), n: ti.template(), j, y, found, rules: ti.template()):
        budget = real(0.5) * (found.second - found.first)
        if ti.static(
            not sphere
        ):  # the second nearest may stop a rod that the nearest lets pass, or have it in its band
            budget = ti.min(budget, found.second - real(1.0) - ti.max(rules.contact_band, rules.tolerance))
        budget = ti.max(real(0.0), budget - rules.margin)
        if ti.static(not located):  # a later touch is that of the nearest
            struck, image = n[LaneInt.STRUCK][j], get_image(n, LaneInt.STRUCK_IMAGE, j)
            budget = ti.select(same(struck, image, found.near, found.image), budget, real(0.0))
        f[rows.budget][j] = budget * budget
        put(f, rows.reference, j, y)

    @ti.func
    def strike(
        n: ti.template(), j, i, swimmers: ti.template(), found, tolerance,
        last, last_image, before, before_image, push_k, push_image,
    ):  # fmt: skip
        """Name the colloid that a contact is with; in a wedge the one that is not that of the encounter.

        `push_k` is the colloid whose reflecting wall has pushed the swimmer on its way; -1 if none.
        """
        deep = found.depth >= -tolerance
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
            z, d, found, last, last_image, before, before_image = resolve(
                medium, k, image, y, x, e, get(f, rows.e, j), f[rows.gamma][j], rules.tolerance
            )
            push_off(f, j, y, z)
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
                n, j, i, swimmers, found, rules.tolerance, last, last_image, before, before_image,
                ti.select(pushed, k, -1), image,
            )  # fmt: skip
            set_budget(f, n, j, z, found, rules)
            put(f, rows.trial_x, j, z)
            put(f, rows.trial_e, j, d)
            n[LaneInt.TOUCH][j] = ti.cast((found.depth >= -band) | pushed, ti.i32)
            for axis in ti.static(range(3)):
                if ti.abs(found.image[axis]) > MAX_IMAGE:
                    stop(n, j)

    return settle
