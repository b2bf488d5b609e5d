"""A position that obeys contact with every colloid, at the director that the swimmer has turned to."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.swimmers import same
from porous_swim.obstacles.search import make_between, make_search
from porous_swim.physics.contact import HardContact
from porous_swim.physics.model import Model
from porous_swim.physics.surface import make_surface
from porous_swim.physics.vectors import record, vec
from porous_swim.physics.wedge import make_wedge

MAX_PROJECTIONS = 8  # as exact ones; two bodies need four
MAX_DOUBLINGS = 14  # of the distance, beginning with the tolerance, that further ones keep from contact


@cache
def make_project(model: Model):
    """Return `on_sphere` and `on_circle`, which put a point on one contact surface or on two at once."""
    real, to, wedge = model.real, make_surface(model), make_wedge(model)

    @ti.func
    def on_sphere(y, c, radius):
        v = y - c
        return c + to.at(v, to.distance(v), radius)

    @ti.func
    def on_circle(y, e, one, other, gamma):
        """The point of both near y; on the first one where they do not meet.

        Each has its `center`, its radius `A`, and the radius `reach` of contact at y.
        """
        c, radius, radius1 = one.center, one.reach, other.reach
        d = other.center - c
        z = on_sphere(y, c, radius).variable()
        if ti.static(model.sphere):
            rho = d.dot(d)
            a = real(0.5) * (rho + radius * radius - radius1 * radius1) / rho
            v = y - c
            across = v - d * (v.dot(d) / rho)
            square = radius * radius - a * a * rho
            out = across.dot(across)
            if (square > real(0.0)) & (out > real(0.0)):
                z = c + d * a + across * ti.sqrt(ti.max(square, real(0.0)) / out)
        elif ti.static(model.surface == "sphere"):
            v, meets = wedge.corner(y - c, e, d, one.A, other.A, gamma)
            if meets:
                z = c + v
        return z

    return on_sphere, on_circle


@cache
def make_outside(model: Model):
    """Return `outside(medium, near, bound, y, y_old, e, gamma, tolerance) -> position, found, held`.

    `near` and `bound` are colloids (`k` and `image`); `y` is an offset from the first. While the swimmer reaches into a
    colloid by more than the tolerance it is put on that colloid's contact surface, or, when it goes back and forth
    between two, where both surfaces meet. What this does not settle (pockets of three and more) is put a little further
    out, and further each time. Where that fails, too, no place is found and the swimmer stays at `y_old`. The director
    is never touched.

    `found` is the result of the search there. `held` names the last two colloids that pushed (-1: none) and tells how
    far each did along its normal, and colloid `bound`, too; and whether the swimmer is `jammed`: no place was found.
    """
    real, between, search = model.real, make_between(model), make_search(model)
    on_sphere, on_circle = make_project(model)
    contact_height, to, wedge = HardContact.make_rolled_height(model), make_surface(model), make_wedge(model)

    @ti.func
    def none():
        image = vec(0, 0, 0)
        return record(
            last=-1, last_image=image, push=real(0.0), before=-1, before_image=image, push_before=real(0.0),
            own=real(0.0), jammed=0,
        )  # fmt: skip

    @ti.func
    def commit(held, j, image_j, back, push, push_other, bound):
        """Note how far j pushed, and the colloid before it, too, where both did."""
        again = same(j, image_j, held.last, held.last_image)
        own = ti.select(same(j, image_j, bound.k, bound.image), push, real(0.0))
        own += ti.select(same(held.last, held.last_image, bound.k, bound.image), push_other, real(0.0))
        held.own += own
        mine = ti.select(again, held.push, ti.select(back, held.push_before, real(0.0))) + push
        if not again:
            held.before, held.before_image, held.push_before = held.last, held.last_image, held.push + push_other
        held.last, held.last_image, held.push = j, image_j, mine

    @ti.func
    def outside(medium: ti.template(), near, bound, y_trial, y_old, e, gamma, tolerance):
        y, held, found = y_trial.variable(), none(), search.empty()
        before = record(center=y * real(0.0), A=real(0.0), reach=real(0.0))  # the colloid that pushed last
        tries, inside, extra = 0, True, real(0.0)
        while inside:
            found = search.run(medium, near.k, near.image, y, e, gamma)
            inside = (found.depth > tolerance) & (held.jammed == 0)
            if inside & (tries < MAX_PROJECTIONS + MAX_DOUBLINGS):
                j, image_j = found.deep, found.deep_image
                c = between(medium, near.k, near.image, j, image_j)
                v, A = y - c, medium.radius[j]
                radius = A + contact_height(to.sine(v, e, to.distance(v)), gamma, A)
                now = record(center=c, A=A, reach=radius)
                back = same(j, image_j, held.before, held.before_image)
                push_other, z = real(0.0), y.variable()
                if back & (tries < MAX_PROJECTIONS):
                    z = on_circle(y, e, now, before, gamma)
                else:
                    extra = ti.select(tries < MAX_PROJECTIONS, extra, ti.max(tolerance, extra * real(2.0)))
                    z = on_sphere(y, c, radius + extra)
                moved, r = z - y, z - c
                push = to.sine(r, moved, to.distance(r))
                if ti.static(model.surface == "sphere"):  # noqa: SIM102 (known while compiling)
                    if back & (tries < MAX_PROJECTIONS):
                        push, push_other = wedge.pushes(moved, r, z - before.center)
                commit(held, j, image_j, back, push, push_other, bound)
                y, before = z, now
                tries += 1
            elif inside:
                y, held = y_old, none()
                held.jammed = 1  # what is found there comes next, and ends this
        return y, found, held

    return outside
