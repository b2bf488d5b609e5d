"""Booking a step: the record of the encounter, and the events that the step brings.

Runs in the lanes for most steps and in the scalar pass for those that needed a search: the same function.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.state import Event, Int, LaneInt, Phase, real_rows
from porous_swim.physics.bridge import NEAREST, crosses
from porous_swim.physics.rounding import rounded
from porous_swim.physics.surface import Surface, make_surface

TWO_PI = 6.283185307179586
MIDDLE = -0.5  # clock of the middle of the step that is behind: when a path crosses a threshold, for all that is known


@cache
def make_vectors(dimensions: int):
    """Return `get(f, row, j)` and `put(f, row, j, v)` for the vectors of a lane."""

    @ti.func
    def get(f: ti.template(), row: ti.template(), j):
        return ti.Vector([f[row + d, j] for d in ti.static(range(dimensions))])

    @ti.func
    def put(f: ti.template(), row: ti.template(), j, v):
        for d in ti.static(range(dimensions)):
            f[row + d, j] = v[d]

    return get, put


@ti.func
def add(f: ti.template(), row: ti.template(), j, on, value):
    """Add `value` to a sum where `on`; the next row keeps what the rounding left (Kahan)."""
    total, rest = f[row, j], f[row + 1, j]
    y = value + rest
    t = rounded(total + y)
    f[row, j] = ti.select(on, t, total)
    f[row + 1, j] = ti.select(on, y - (t - total), rest)


@cache
def make_turns(real, dimensions: int):
    """Return `turns(r0, r1, e)`: the winding of a step along the director, and its angle about +z, in turns."""

    @ti.func
    def turns(r0, r1, e):
        # (t.dx)/R with t the unit tangential part of the director, R the distance, both at the start of the step
        rho, s, dx = r0.dot(r0), r0.dot(e), r1 - r0
        t = e - s / rho * r0  # from its own components: 1 - s^2/rho would cancel where e points at the centre
        along = t.dot(dx) / ti.sqrt(ti.max(rho * t.dot(t), real(1e-30)))
        angle = real(0.0)
        if ti.static(dimensions == 2):  # arcsin as a series: below 1e-9 at 0.1 rad
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
        return ti.select(along < real(0.0), -turn, turn) * real(1 / TWO_PI), angle

    return swept


@cache
def make_unwound(real):
    """Return `unwound(r0, r1, e)` in place of `turns` at a plane wall, around which nobody winds."""

    @ti.func
    def unwound(r0, r1, e):
        return real(0.0), real(0.0)

    return unwound


@cache
def make_book(real, dimensions: int, surface: Surface, integrator: str):
    """Return `book(f, n, j, on, rules, least)`, which commits the trial move of lane j where `on`.

    A move is a step, or where events are `located` the part of one up to `trial_clock`. `least` is the contact height
    of the trial above the colloid of the encounter. Between walls that reflect, events happen within a step.
    """
    located, reflected = integrator == "located", integrator == "reflected"
    rows = real_rows(dimensions)
    get, put = make_vectors(dimensions)
    turns = make_swept(real, dimensions) if located else make_turns(real, dimensions)
    if surface == "plane":
        turns = make_unwound(real)
    to = make_surface(real, surface)

    @ti.func
    def tick(f: ti.template(), n: ti.template(), j, on):
        """Set the clock forward."""
        if ti.static(located):
            ends = f[rows.trial_clock, j] >= real(1.0)
            clock = ti.select(ends, real(0.0), f[rows.trial_clock, j])
            f[rows.clock, j] = ti.select(on, clock, f[rows.clock, j])
            n[Int.STEP, j] += ti.select(on & ends, 1, 0)
        else:
            n[Int.STEP, j] += ti.select(on, 1, 0)
        if ti.static(reflected):
            f[rows.clock, j] = ti.select(on, real(MIDDLE), f[rows.clock, j])

    @ti.func
    def weigh(f: ti.template(), n: ti.template(), j, on, h, low, left):
        """Add the height and the time in contact, in steps."""
        if ti.static(located):
            part = f[rows.trial_clock, j] - f[rows.clock, j]
            add(f, rows.height, j, on, f[rows.trial_height, j])
            f[rows.contact_clock, j] += ti.select(on & (n[LaneInt.LOW, j] != 0), part, real(0.0))
        else:
            if ti.static(reflected):  # the encounter ended in the middle of the step
                h *= ti.select(left, real(1.0 + MIDDLE), real(1.0))
            add(f, rows.height, j, on, h)
            n[LaneInt.N_CONTACT, j] += ti.select(on & low, 1, 0)

    @ti.func
    def hold(f: ti.template(), n: ti.template(), j, at_wall, s):
        """Note when and where the wall was last touched."""
        after, clock = n[Int.STEP, j] + 1, real(0.0)
        if ti.static(located):
            ends = f[rows.trial_clock, j] >= real(1.0)
            after, clock = ti.select(ends, after, after - 1), ti.select(ends, real(0.0), f[rows.trial_clock, j])
            f[rows.release_clock, j] = ti.select(at_wall, clock, f[rows.release_clock, j])
        if ti.static(reflected):
            f[rows.release_clock, j] = ti.select(at_wall, real(MIDDLE), f[rows.release_clock, j])
        n[LaneInt.RELEASE, j] = ti.select(at_wall, after, n[LaneInt.RELEASE, j])
        f[rows.release_sine, j] = ti.select(at_wall, s, f[rows.release_sine, j])
        f[rows.release_winding, j] = ti.select(at_wall, f[rows.winding, j], f[rows.release_winding, j])

    @ti.func
    def crossings(f: ti.template(), j, rules: ti.template(), r0, e0, h, s):
        """Whether the path went above the escape height, and past the escape pitch, within the step."""
        R = to.distance(r0)
        out = ti.max(R, real(NEAREST))
        s0, bend = to.sine(r0, e0, out), to.bend(real(1.0), out)
        kick, turn = f[rows.kick, j] * f[rows.kick, j], f[rows.turn, j] * f[rows.turn, j]
        left = crosses(rules.escape_height, R - f[rows.bound_A, j], h, kick, f[rows.height_excursion, j])
        variance = (turn + kick * bend * bend) * (real(1.0) - s0 * s0)
        return left, crosses(f[rows.escape_sine, j], s0, s, variance, f[rows.pitch_excursion, j])

    @ti.func
    def press(f: ti.template(), j, bound, free, least):
        """Note the touch of a wall within the step, and of a free swimmer the push: it may begin an encounter."""
        push = f[rows.trial_push, j]
        lowest = ti.min(f[rows.min_height, j], least)
        f[rows.min_height, j] = ti.select(bound & (push > real(0.0)), lowest, f[rows.min_height, j])
        f[rows.push, j] = ti.select(free, push, f[rows.push, j])

    @ti.func
    def record(f: ti.template(), n: ti.template(), j, on, rules: ti.template(), least, r0, r1, e0, h, s, left):
        """Add the step to the record of the encounter under way."""
        along, angle = turns(r0, r1, e0)
        add(f, rows.winding, j, on, along)
        if ti.static(dimensions == 2):
            add(f, rows.signed, j, on, angle)
        add(f, rows.push, j, on, f[rows.trial_push, j])
        f[rows.min_height, j] = ti.select(on, ti.min(h, f[rows.min_height, j]), f[rows.min_height, j])
        f[rows.max_height, j] = ti.select(on, ti.max(h, f[rows.max_height, j]), f[rows.max_height, j])
        above = h - least
        low = above <= ti.max(rules.contact_band, rules.tolerance)
        weigh(f, n, j, on, h, low, left)
        at_wall = above <= ti.min(rules.tolerance, rules.margin)  # but for rounding
        if ti.static(reflected):
            at_wall |= f[rows.trial_push, j] > real(0.0)
        hold(f, n, j, on & at_wall, s)

    @ti.func
    def book(f: ti.template(), n: ti.template(), j, on, rules: ti.template(), least):
        x0, e0, offset = get(f, rows.x, j), get(f, rows.e, j), get(f, rows.bound_offset, j)
        x1, e1 = get(f, rows.trial_x, j), get(f, rows.trial_e, j)
        r0, r1 = x0 + offset, x1 + offset
        R = to.distance(r1)
        s = to.sine(r1, e1, R)
        bound = on & (n[Int.PHASE, j] == int(Phase.BOUND))
        h = R - f[rows.bound_A, j]
        left, passed = h > rules.escape_height, s > f[rows.escape_sine, j]
        if ti.static(reflected):
            crossed_height, crossed_pitch = crossings(f, j, rules, r0, e0, h, s)
            left, passed = left | crossed_height, passed | crossed_pitch
        record(f, n, j, bound, rules, least, r0, r1, e0, h, s, left)
        if ti.static(reflected):
            press(f, j, bound, on & (n[Int.PHASE, j] != int(Phase.BOUND)), least)
        touch = on & (n[LaneInt.TOUCH, j] != 0) & (n[LaneInt.WATCH_CONTACT, j] != 0)
        passed &= on & (n[LaneInt.WATCH_PITCH, j] != 0)
        left &= bound
        events = ti.select(touch, int(Event.CONTACT), 0) | ti.select(passed, int(Event.PITCH), 0)
        n[Int.EVENT, j] |= events | ti.select(left, int(Event.ESCAPE), 0)
        tick(f, n, j, on)
        put(f, rows.x, j, ti.select(on, x1, x0))
        put(f, rows.rest, j, ti.select(on, get(f, rows.trial_rest, j), get(f, rows.rest, j)))
        put(f, rows.e, j, ti.select(on, e1, e0))

    return book
