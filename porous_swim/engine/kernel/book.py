"""Booking a step: the record of the encounter, and the events that the step brings.

The rows of a block's state are wide values: a function of whole rows books all lanes at once, those that moved within
their budget after every step, and those that needed a search together when all of these have been settled.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.record import make_record
from porous_swim.engine.kernel.rows import make_wide
from porous_swim.engine.kernel.state import MIDDLE, Event, Int, LaneInt, Phase, real_rows
from porous_swim.physics.bridge import crosses
from porous_swim.physics.rounding import rounded
from porous_swim.physics.surface import Surface, make_surface
from porous_swim.physics.vectors import pick

TWO_PI = 6.283185307179586


@cache
def make_turns(real, dimensions: int):
    """Return `turns(r0, r1, e)`: the winding of a step along the director, and its angle about +z, in turns."""

    @ti.func
    def turns(r0, r1, e):
        # (t.dx)/R with t the unit tangential part of the director, R the distance, both at the start of the step
        rho, s, dx = r0.dot(r0), r0.dot(e), r1 - r0
        t = e - r0 * (s / rho)  # from its own components: 1 - s^2/rho would cancel where e points at the centre
        along = t.dot(dx) / ti.sqrt(ti.max(rho * t.dot(t), real(1e-30)))
        if ti.static(dimensions != 2):
            return along * real(1 / TWO_PI), real(0.0)
        # arcsin as a series: below 1e-9 at 0.1 rad
        c = (r0[0] * r1[1] - r0[1] * r1[0]) / ti.sqrt(rho * r1.dot(r1))
        q = c * c
        angle = rounded(c * (real(1.0) + q * (real(1 / 6) + q * (real(3 / 40) + q * real(15 / 336)))))
        return along * real(1 / TWO_PI), angle * real(1 / TWO_PI)

    return turns


@cache
def make_swept(real, dimensions: int):
    """Return `swept(r0, r1, e)`: like `turns`, for a smooth path: the winding is the angle swept, exactly."""
    turns = make_turns(real, dimensions)

    @ti.func
    def swept(r0, r1, e):
        along, angle = turns(r0, r1, e)
        chord = r1 / ti.sqrt(r1.dot(r1)) - r0 / ti.sqrt(r0.dot(r0))
        turn = real(2.0) * ti.asin(ti.min(real(0.5) * ti.sqrt(chord.dot(chord)), real(1.0)))
        return ti.select(along < real(0.0), turn * real(-1.0), turn) * real(1 / TWO_PI), angle

    return swept


@cache
def make_unwound(real):
    """Return `unwound(r0, r1, e)` in place of `turns` at a plane wall, around which nobody winds."""

    @ti.func
    def unwound(r0, r1, e):
        return real(0.0), real(0.0)

    return unwound


@cache
def make_book(real, dimensions: int, surface: Surface, integrator: str, flights: bool = False):
    """Return `book(f, n, on, rules, least)`, which commits the trial moves of the lanes `on` of a block.

    A move is a step, or where events are `located` the part of one up to `trial_clock`. `least` is the contact height
    of the trial above the colloid of the encounter. Between walls that reflect, events happen within a step.
    """
    located, reflected = integrator == "located", integrator == "reflected"
    rows = real_rows(dimensions, located=located)
    gather, hold, _ = make_record(dimensions, located=located)
    whole, put_whole = make_wide(dimensions)
    turns = make_swept(real, dimensions) if located else make_turns(real, dimensions)
    if surface == "plane":
        turns = make_unwound(real)
    to = make_surface(real, surface)

    @ti.func
    def tick(f: ti.template(), n: ti.template(), on, rules: ti.template()):
        """Set the clock forward."""
        if ti.static(located):
            ends = f[rows.trial_clock] >= real(1.0)
            clock = ti.select(ends, real(0.0), f[rows.trial_clock])
            f[rows.clock] = ti.select(on, clock, f[rows.clock])
            n[Int.STEP] = n[Int.STEP] + ti.select(on & ends, 1, 0)
        elif ti.static(flights):
            ticks = ti.select(on, n[LaneInt.TICKS], 0)
            after = n[LaneInt.AFTER] + ticks
            n[Int.STEP] = n[Int.STEP] + ticks
            n[LaneInt.AFTER] = ti.select(after >= rules.flight_ticks, 0, after)
        else:
            n[Int.STEP] = n[Int.STEP] + ti.select(on, 1, 0)
        if ti.static(reflected):
            f[rows.clock] = ti.select(on, real(MIDDLE), f[rows.clock])

    @ti.func
    def over_time(f: ti.template(), h, left):
        """The height, integrated over the step."""
        if ti.static(located):
            return f[rows.trial_height]
        if ti.static(reflected):  # the encounter ended in the middle of the step
            return h * ti.select(left, real(1.0 + MIDDLE), real(1.0))
        return h

    @ti.func
    def stay(f: ti.template(), n: ti.template(), on, low):
        """Add the time in contact, in steps."""
        if ti.static(located):
            part = f[rows.trial_clock] - f[rows.clock]
            in_contact = on & (n[LaneInt.LOW] != 0)
            f[rows.contact_clock] = f[rows.contact_clock] + ti.select(in_contact, part, real(0.0))
        else:
            n[LaneInt.N_CONTACT] = n[LaneInt.N_CONTACT] + ti.select(on & low, 1, 0)

    @ti.func
    def release(f: ti.template(), n: ti.template(), touched, values: ti.template()):
        """Note when the wall was last touched, and what is recorded of that touch."""
        after = n[Int.STEP] + 1
        if ti.static(located):
            ends = f[rows.trial_clock] >= real(1.0)
            clock = ti.select(ends, real(0.0), f[rows.trial_clock])
            after = ti.select(ends, after, after - 1)
            f[rows.release_clock] = ti.select(touched, clock, f[rows.release_clock])
        n[LaneInt.RELEASE] = ti.select(touched, after, n[LaneInt.RELEASE])
        hold(f, touched, values)

    @ti.func
    def crossings(f: ti.template(), rules: ti.template(), r0, e0, h, s):
        """Whether the path went above the escape height, and past the escape pitch, within the step; its first sine."""
        R = to.distance(r0)
        s0, bend = to.sine(r0, e0, R), to.bend(real(1.0), R)
        kick, turn = f[rows.kick] * f[rows.kick], f[rows.turn] * f[rows.turn]
        left = crosses(rules.escape_height, R - f[rows.bound_A], h, kick, f[rows.height_excursion])
        variance = (turn + kick * bend * bend) * (real(1.0) - s0 * s0)
        return left, crosses(f[rows.escape_sine], s0, s, variance, f[rows.pitch_excursion]), s0

    @ti.func
    def press(f: ti.template(), bound, free, least):
        """Note the touch of a wall within the step, and of a free swimmer the push: it may begin an encounter."""
        push = f[rows.trial_push]
        lowest = ti.min(f[rows.min_height], least)
        f[rows.min_height] = ti.select(bound & (push > real(0.0)), lowest, f[rows.min_height])
        f[rows.push] = ti.select(free, push, f[rows.push])

    @ti.func
    def record(f: ti.template(), n: ti.template(), on, rules: ti.template(), least, r0, r1, e0, h, s0, s, left):
        """Add the step to the record of the encounter under way, by the names of its rows; its sines are s0 and s."""
        along, angle = turns(r0, r1, e0)
        gather(
            f, on,
            {"push": f[rows.trial_push], "winding": along, "signed": angle, "min_height": h,
             "height": over_time(f, h, left), "max_height": h},
        )  # fmt: skip
        above = h - least
        low = above <= ti.max(rules.contact_band, rules.tolerance)
        stay(f, n, on, low)
        rounding = above <= ti.min(rules.tolerance, rules.margin)
        if ti.static(reflected):  # in the middle of the step, as all that happens in it
            touched = on & (rounding | (f[rows.trial_push] > real(0.0)))
            winding = f[rows.winding] + real(MIDDLE) * along
            release(f, n, touched, {"release_sine": real(0.5) * (s0 + s), "release_winding": winding})
        else:
            release(f, n, on & rounding, {"release_sine": s, "release_winding": f[rows.winding]})

    @ti.func
    def book(f: ti.template(), n: ti.template(), on, rules: ti.template(), least):
        x0, e0, offset = whole(f, rows.x), whole(f, rows.e), whole(f, rows.bound_offset)
        x1, e1 = whole(f, rows.trial_x), whole(f, rows.trial_e)
        r0, r1 = x0 + offset, x1 + offset
        R = to.distance(r1)
        s = to.sine(r1, e1, R)
        is_bound = n[LaneInt.PHASE] == int(Phase.BOUND)
        bound, free = on & is_bound, on & (not is_bound)
        h = R - f[rows.bound_A]
        left, passed, s0 = h > rules.escape_height, s > f[rows.escape_sine], s
        if ti.static(reflected):
            crossed_height, crossed_pitch, s0 = crossings(f, rules, r0, e0, h, s)
            left, passed = left | crossed_height, passed | crossed_pitch
        record(f, n, bound, rules, least, r0, r1, e0, h, s0, s, left)
        if ti.static(reflected):
            press(f, bound, free, least)
        touch = on & (n[LaneInt.TOUCH] != 0) & (n[LaneInt.WATCH_CONTACT] != 0)
        timed = passed & on & (n[LaneInt.WATCH_PITCH] != 0)
        events = ti.select(touch, int(Event.CONTACT), 0) | ti.select(timed, int(Event.PITCH), 0)
        n[Int.EVENT] = n[Int.EVENT] | events | ti.select(left & bound, int(Event.ESCAPE), 0)
        tick(f, n, on, rules)
        put_whole(f, rows.x, pick(on, x1, x0))
        put_whole(f, rows.rest, pick(on, whole(f, rows.trial_rest), whole(f, rows.rest)))
        put_whole(f, rows.e, pick(on, e1, e0))

    return book
