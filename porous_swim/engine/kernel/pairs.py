"""Contact of rods with a second colloid, in lanes: straight-line code on wide values, as in `move`.

A rod held between two spheres touches both at nearly every step. Its lane then knows the second one, too, its
partner, and looks for nobody else while no third can be touched. What it finds is what `outside`
finds; the rare cases in which it finds nothing, and a touch that is news, are left to that.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.rows import make_wide, put_lane_image, rows_of
from porous_swim.engine.kernel.state import Int, LaneInt
from porous_swim.engine.kernel.swimmers import image_of, put_image
from porous_swim.physics.contact import HardContact
from porous_swim.physics.model import Model
from porous_swim.physics.rounding import rounded
from porous_swim.physics.surface import make_surface
from porous_swim.physics.vectors import pick
from porous_swim.physics.wedge import make_wedge

STEPS = 3  # of Newton's method, from a point on the surface of one that is inside of the other by part of a time step
NEAR = 1e-4  # a, the last of them: what is left is its square over the distance from the line of centres


@cache
def make_pair(model: Model):
    """Return `pair(reals, ints, n_pairs, least)`, which puts trial moves outside of partners, too, if any lane has one.

    The trial obeys contact with the nearest colloid, `least` is its contact height there. It returns the contact height
    above the colloid of the encounter, where that is one of the two, else `least`; and 1 in the lanes whose trial has
    to be settled. The push of a partner whose encounter it is is added to that of the trial.
    """
    real, rows, (whole, put_whole) = model.real, rows_of(model), make_wide(model)
    height_and_slope, wedge = HardContact.make_rolled_height_and_slope(model), make_wedge(model)
    to = make_surface(model)

    @ti.func
    def corner(v, e, d, A, A1, gamma):
        """Where both contact surfaces meet near v, which is on one of them, and whether it has been found."""
        rho = ti.sqrt(d.dot(d))
        axis = d / rho
        a = v.dot(axis)
        across = v - axis * a
        s = ti.max(ti.sqrt(across.dot(across)), real(1e-6))
        w = across / s
        along, aside, change = e.dot(axis), e.dot(w), rho
        for _ in range(STEPS):  # no unrolled copies: they take long to compile
            da, ds = wedge.newton(a, s, rho, along, aside, A, A1, gamma)
            a, s, change = a + da, s + ds, da * da + ds * ds
        return axis * a + w * s, (change <= real(NEAR * NEAR)) & (s > real(0.0))

    @ti.func
    def part(reals: ti.template(), ints: ti.template(), least):
        x, e = whole(reals, rows.trial_x), whole(reals, rows.trial_e)
        A, A1, gamma, d = reals[rows.A], reals[rows.partner_A], reals[rows.law.gamma], whole(reals, rows.partner_offset)
        v1 = x + d
        R1 = to.distance(v1)
        least1, _ = height_and_slope(to.sine(v1, e, R1), gamma, A1)
        depth = A1 + least1 - R1
        touched_body = (ints[LaneInt.PAIRED] != 0) & (depth > real(0.0))
        known = ints[LaneInt.PARTNER_KNOWN] != 0
        z = x + to.along(v1, R1, depth)
        R = to.distance(z)
        above, _ = height_and_slope(to.sine(z, e, R), gamma, A)
        pinched = above > R - A
        v, found = corner(z, e, d * real(-1.0), A, A1, gamma)
        push, push1 = wedge.pushes(v - x, v, v + d)
        push, push1 = ti.select(pinched, push, real(0.0)), ti.select(pinched, push1, depth)
        touch_is_news = ints[LaneInt.WATCH_CONTACT] != 0  # where the partner pushes the rod onto the nearest
        good = touched_body & known & ((found & (not touch_is_news)) | (not pinched))
        y = pick(pinched, v, z)
        own, partner_own = ints[LaneInt.OWN] != 0, ints[LaneInt.PARTNER_OWN] != 0
        more = ti.select(own, push, ti.select(partner_own, push1, real(0.0)))
        total = ti.max(reals[rows.trial_push] + more, real(0.0))
        reals[rows.trial_push] = ti.select(good, total, reals[rows.trial_push])
        on_both = good & pinched
        here = ti.select(on_both, to.distance(y) - A, ti.select(good, above, least))
        there = ti.select(on_both, to.distance(y + d) - A1, least1)
        least_own = ti.select(partner_own, there, here)
        put_whole(reals, rows.trial_x, pick(good, y, x))
        rest = whole(reals, rows.trial_rest)
        put_whole(reals, rows.trial_rest, pick(good, rest * real(0.0), rest))
        return least_own, ti.select(touched_body & (not good), 1, 0)

    @ti.func
    def pair(reals: ti.template(), ints: ti.template(), n_pairs, least):
        own, needs = least, ints[LaneInt.PAIRED] * 0
        if n_pairs != 0:
            own, needs = part(reals, ints, least)
        return own, needs

    return pair


@cache
def make_swap(model: Model):
    """Return `swap(reals, ints, n_pairs)` and `sync(ints, j, i, swimmers)`.

    The first makes the partner of each lane its nearest colloid where it is nearer; the second tells memory.
    """
    rows, (whole, put_whole) = rows_of(model), make_wide(model)

    @ti.func
    def exchange(reals: ti.template(), ints: ti.template()):
        x, d, bound = whole(reals, rows.x), whole(reals, rows.partner_offset), whole(reals, rows.bound_offset)
        rest, reference = whole(reals, rows.rest), whole(reals, rows.reference)
        A, A1, own, partner_own = reals[rows.A], reals[rows.partner_A], ints[LaneInt.OWN], ints[LaneInt.PARTNER_OWN]
        y = rounded(x + d)
        known = (ints[LaneInt.PAIRED] != 0) & (ints[LaneInt.PARTNER_KNOWN] != 0) & (ints[LaneInt.WATCH_CONTACT] == 0)
        nearer = ti.sqrt(y.dot(y)) - A1 < ti.sqrt(x.dot(x)) - A
        other = known & nearer & (ints[Int.EVENT] == 0)
        put_whole(reals, rows.x, pick(other, y, x))
        put_whole(reals, rows.rest, pick(other, rest + (d - (y - x)), rest))
        put_whole(reals, rows.reference, pick(other, reference + d, reference))
        put_whole(reals, rows.bound_offset, pick(other, bound - d, bound))
        put_whole(reals, rows.partner_offset, pick(other, d * -1.0, d))
        reals[rows.A], reals[rows.partner_A] = ti.select(other, A1, A), ti.select(other, A, A1)
        ints[LaneInt.OWN], ints[LaneInt.PARTNER_OWN] = (
            ti.select(other, partner_own, own),
            ti.select(other, own, partner_own),
        )
        ints[LaneInt.SWAPPED] = ti.select(other, 1 - ints[LaneInt.SWAPPED], ints[LaneInt.SWAPPED])

    @ti.func
    def swap(reals: ti.template(), ints: ti.template(), n_pairs):
        if n_pairs != 0:
            exchange(reals, ints)

    @ti.func
    def sync(ints: ti.template(), j, i, swimmers: ti.template()):
        if ints[LaneInt.SWAPPED][j] != 0:
            k, image = swimmers.int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i)
            m, image_m = swimmers.int[int(Int.PARTNER), i], image_of(swimmers, int(Int.PARTNER_IMAGE), i)
            swimmers.int[int(Int.COLLOID), i], swimmers.int[int(Int.PARTNER), i] = m, k
            put_image(swimmers, int(Int.IMAGE), i, image_m)
            put_image(swimmers, int(Int.PARTNER_IMAGE), i, image)
            ints[LaneInt.TOUCHED_BODY][j], ints[LaneInt.SWAPPED][j] = m, 0
            put_lane_image(ints, LaneInt.TOUCHED_BODY_IMAGE, j, image_m)

    return swap, sync
