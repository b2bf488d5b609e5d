"""Booking a step: the record of the encounter, and the events that the step brings.

The rows of a block's state are wide values: a function of whole rows books all lanes at once, those that moved within
their budget after every step, and those that needed a search together when all of these have been settled.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.record import make_record
from porous_swim.engine.kernel.rows import make_wide, rows_of
from porous_swim.engine.kernel.state import MIDDLE, Event, Int, LaneInt, Phase
from porous_swim.engine.kernel.winding import make_winding
from porous_swim.physics.bridge import crosses
from porous_swim.physics.model import Model
from porous_swim.physics.surface import make_surface
from porous_swim.physics.vectors import pick, record


@cache
def make_tick(model: Model):
    """Return `tick(f, n, on, rules)`, which sets the clock forward."""
    real, located, reflected, flights, rows = model.real, model.located, model.reflected, model.flights, rows_of(model)

    @ti.func
    def tick(f: ti.template(), n: ti.template(), on, rules: ti.template()):
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

    return tick


@cache
def make_release(model: Model):
    """Return `stay(f, n, on, low)` and `release(f, n, touched, values)`: times in contact, and of the last touch."""
    real, located, rows, (_, hold, _) = model.real, model.located, rows_of(model), make_record(model)

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

    return stay, release


@cache
def make_keep(model: Model):
    """Return `keep(f, n, on, rules, step, left)`, which adds a step to the record of the encounter under way.

    By the names of its rows. `step` has offsets r0 and r1 from the colloid before and after it, the director e0 before,
    the sines s0 and s, the height h and contact height `least` after it; `left` says whether it ends the encounter.
    """
    real, located, reflected, rows = model.real, model.located, model.reflected, rows_of(model)
    turns, (gather, _, _), (stay, release) = make_winding(model), make_record(model), make_release(model)

    @ti.func
    def over_time(f: ti.template(), h, left):
        """The height, integrated over the step."""
        if ti.static(located):
            return f[rows.trial_height]
        if ti.static(reflected):  # the encounter ended in the middle of the step
            return h * ti.select(left, real(1.0 + MIDDLE), real(1.0))
        return h

    @ti.func
    def keep(f: ti.template(), n: ti.template(), on, rules: ti.template(), step, left):
        along, angle = turns(step.r0, step.r1, step.e0)
        h = step.h
        gather(
            f, on,
            {"push": f[rows.trial_push], "winding": along, "signed": angle, "min_height": h,
             "height": over_time(f, h, left), "max_height": h},
        )  # fmt: skip
        above = h - step.least
        low = above <= ti.max(rules.contact_band, rules.tolerance)
        stay(f, n, on, low)
        rounding = above <= ti.min(rules.tolerance, rules.margin)
        if ti.static(reflected):  # in the middle of the step, as all that happens in it
            touched = on & (rounding | (f[rows.trial_push] > real(0.0)))
            winding = f[rows.winding] + real(MIDDLE) * along
            release(f, n, touched, {"release_sine": real(0.5) * (step.s0 + step.s), "release_winding": winding})
        else:
            release(f, n, on & rounding, {"release_sine": step.s, "release_winding": f[rows.winding]})

    return keep


@cache
def make_bridge(model: Model):
    """Return `crossings(f, rules, r0, e0, h, s)` and `press(f, bound, free, least)`, between walls that reflect."""
    real, rows, to = model.real, rows_of(model), make_surface(model)

    @ti.func
    def crossings(f: ti.template(), rules: ti.template(), r0, e0, h, s):
        """Whether the path went above the escape height, and past the escape pitch, within the step; its first sine."""
        R = to.distance(r0)
        s0, bend = to.sine(r0, e0, R), to.bend(real(1.0), R)
        kick, turn = f[rows.law.kick] * f[rows.law.kick], f[rows.law.turn] * f[rows.law.turn]
        left = crosses(rules.escape_height, R - f[rows.bound_A], h, kick, f[rows.height_excursion])
        variance = (turn + kick * bend * bend) * (real(1.0) - s0 * s0)
        return left, crosses(f[rows.law.escape_sine], s0, s, variance, f[rows.pitch_excursion]), s0

    @ti.func
    def press(f: ti.template(), bound, free, least):
        """Note the touch of a wall within the step, and of a free swimmer the push: it may begin an encounter."""
        push = f[rows.trial_push]
        lowest = ti.min(f[rows.min_height], least)
        f[rows.min_height] = ti.select(bound & (push > real(0.0)), lowest, f[rows.min_height])
        f[rows.push] = ti.select(free, push, f[rows.push])

    return crossings, press


@cache
def make_commit(model: Model):
    """Return `commit(f, n, on, rules, least)`, which commits the trial moves of the lanes `on` of a block.

    A move is a step, or where events are `located` the part of one up to `trial_clock`. `least` is the contact height
    of the trial above the colloid of the encounter. Between walls that reflect, events happen within a step.
    """
    reflected, rows, (whole, put_whole) = model.reflected, rows_of(model), make_wide(model)
    tick, keep, (crossings, press) = make_tick(model), make_keep(model), make_bridge(model)
    to = make_surface(model)

    @ti.func
    def commit(f: ti.template(), n: ti.template(), on, rules: ti.template(), least):
        x0, e0, offset = whole(f, rows.x), whole(f, rows.e), whole(f, rows.bound_offset)
        x1, e1 = whole(f, rows.trial_x), whole(f, rows.trial_e)
        r0, r1 = x0 + offset, x1 + offset
        R = to.distance(r1)
        s = to.sine(r1, e1, R)
        is_bound = n[LaneInt.PHASE] == int(Phase.BOUND)
        bound, free = on & is_bound, on & (not is_bound)
        h = R - f[rows.bound_A]
        left, passed, s0 = h > rules.escape_height, s > f[rows.law.escape_sine], s
        if ti.static(reflected):
            crossed_height, crossed_pitch, s0 = crossings(f, rules, r0, e0, h, s)
            left, passed = left | crossed_height, passed | crossed_pitch
        step = record(r0=r0, r1=r1, e0=e0, h=h, s0=s0, s=s, least=least)
        keep(f, n, bound, rules, step, left)
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

    return commit
