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
    """Return `tick(reals, ints, on, rules)`, which sets the clock forward."""
    real, located, reflected, flights, rows = model.real, model.located, model.reflected, model.flights, rows_of(model)

    @ti.func
    def tick(reals: ti.template(), ints: ti.template(), on, rules: ti.template()):
        if ti.static(located):
            ends = reals[rows.trial_clock] >= real(1.0)
            clock = ti.select(ends, real(0.0), reals[rows.trial_clock])
            reals[rows.clock] = ti.select(on, clock, reals[rows.clock])
            ints[Int.STEP] = ints[Int.STEP] + ti.select(on & ends, 1, 0)
        elif ti.static(flights):
            ticks = ti.select(on, ints[LaneInt.TICKS], 0)
            after = ints[LaneInt.AFTER] + ticks
            ints[Int.STEP] = ints[Int.STEP] + ticks
            ints[LaneInt.AFTER] = ti.select(after >= rules.flight_ticks, 0, after)
        else:
            ints[Int.STEP] = ints[Int.STEP] + ti.select(on, 1, 0)
        if ti.static(reflected):
            reals[rows.clock] = ti.select(on, real(MIDDLE), reals[rows.clock])

    return tick


@cache
def make_release(model: Model):
    """Return `stay(reals, ints, on, low)` and `release(reals, ints, touched, values)`: contact and last touch."""
    real, located, rows, (_, hold, _) = model.real, model.located, rows_of(model), make_record(model)

    @ti.func
    def stay(reals: ti.template(), ints: ti.template(), on, low):
        """Add the time in contact, in steps."""
        if ti.static(located):
            part = reals[rows.trial_clock] - reals[rows.clock]
            in_contact = on & (ints[LaneInt.LOW] != 0)
            reals[rows.contact_clock] = reals[rows.contact_clock] + ti.select(in_contact, part, real(0.0))
        else:
            ints[LaneInt.N_CONTACT] = ints[LaneInt.N_CONTACT] + ti.select(on & low, 1, 0)

    @ti.func
    def release(reals: ti.template(), ints: ti.template(), touched, values: ti.template()):
        """Note when the wall was last touched, and what is recorded of that touch."""
        after = ints[Int.STEP] + 1
        if ti.static(located):
            ends = reals[rows.trial_clock] >= real(1.0)
            clock = ti.select(ends, real(0.0), reals[rows.trial_clock])
            after = ti.select(ends, after, after - 1)
            reals[rows.release_clock] = ti.select(touched, clock, reals[rows.release_clock])
        ints[LaneInt.RELEASE] = ti.select(touched, after, ints[LaneInt.RELEASE])
        hold(reals, touched, values)

    return stay, release


@cache
def make_keep(model: Model):
    """Return `keep(reals, ints, on, rules, step, left)`, which adds a step to the record of the encounter under way.

    By the names of its rows. `step` has offsets r0 and r1 from the colloid before and after it, the director e0 before,
    the sines s0 and s, the height h and contact height `least` after it; `left` says whether it ends the encounter.
    """
    real, located, reflected, rows = model.real, model.located, model.reflected, rows_of(model)
    turns, (gather, _, _), (stay, release) = make_winding(model), make_record(model), make_release(model)

    @ti.func
    def over_time(reals: ti.template(), h, left):
        """The height, integrated over the step."""
        if ti.static(located):
            return reals[rows.trial_height]
        if ti.static(reflected):  # the encounter ended in the middle of the step
            return h * ti.select(left, real(1.0 + MIDDLE), real(1.0))
        return h

    @ti.func
    def keep(reals: ti.template(), ints: ti.template(), on, rules: ti.template(), step, left):
        along, angle = turns(step.r0, step.r1, step.e0)
        h = step.h
        gather(
            reals, on,
            {"push": reals[rows.trial_push], "winding": along, "signed": angle, "min_height": h,
             "height": over_time(reals, h, left), "max_height": h},
        )  # fmt: skip
        above = h - step.least
        low = above <= ti.max(rules.contact_band, rules.tolerance)
        stay(reals, ints, on, low)
        rounding = above <= ti.min(rules.tolerance, rules.margin)
        if ti.static(reflected):  # in the middle of the step, as all that happens in it
            touched = on & (rounding | (reals[rows.trial_push] > real(0.0)))
            winding = reals[rows.winding] + real(MIDDLE) * along
            release(reals, ints, touched, {"release_sine": real(0.5) * (step.s0 + step.s), "release_winding": winding})
        else:
            release(reals, ints, on & rounding, {"release_sine": step.s, "release_winding": reals[rows.winding]})

    return keep


@cache
def make_bridge(model: Model):
    """Return `crossings(reals, rules, r0, e0, h, s)` and `press(reals, bound, free, least)`, at walls that reflect."""
    real, rows, to = model.real, rows_of(model), make_surface(model)

    @ti.func
    def crossings(reals: ti.template(), rules: ti.template(), r0, e0, h, s):
        """Whether the path went above the escape height, and past the escape pitch, within the step; its first sine."""
        R = to.distance(r0)
        s0, bend = to.sine(r0, e0, R), to.bend(real(1.0), R)
        kick, turn = reals[rows.law.kick] * reals[rows.law.kick], reals[rows.law.turn] * reals[rows.law.turn]
        left = crosses(rules.escape_height, R - reals[rows.bound_A], h, kick, reals[rows.height_excursion])
        variance = (turn + kick * bend * bend) * (real(1.0) - s0 * s0)
        return left, crosses(reals[rows.law.escape_sine], s0, s, variance, reals[rows.pitch_excursion]), s0

    @ti.func
    def press(reals: ti.template(), bound, free, least):
        """Note the touch of a wall within the step, and of a free swimmer the push: it may begin an encounter."""
        push = reals[rows.trial_push]
        lowest = ti.min(reals[rows.min_height], least)
        reals[rows.min_height] = ti.select(bound & (push > real(0.0)), lowest, reals[rows.min_height])
        reals[rows.push] = ti.select(free, push, reals[rows.push])

    return crossings, press


@cache
def make_commit(model: Model):
    """Return `commit(reals, ints, on, rules, least)`, which commits the trial moves of the lanes `on` of a block.

    A move is a step, or where events are `located` the part of one up to `trial_clock`. `least` is the contact height
    of the trial above the colloid of the encounter. Between walls that reflect, events happen within a step.
    """
    reflected, rows, (whole, put_whole) = model.reflected, rows_of(model), make_wide(model)
    tick, keep, (crossings, press) = make_tick(model), make_keep(model), make_bridge(model)
    to = make_surface(model)

    @ti.func
    def commit(reals: ti.template(), ints: ti.template(), on, rules: ti.template(), least):
        x0, e0, offset = whole(reals, rows.x), whole(reals, rows.e), whole(reals, rows.bound_offset)
        x1, e1 = whole(reals, rows.trial_x), whole(reals, rows.trial_e)
        r0, r1 = x0 + offset, x1 + offset
        R = to.distance(r1)
        s = to.sine(r1, e1, R)
        is_bound = ints[LaneInt.PHASE] == int(Phase.BOUND)
        bound, free = on & is_bound, on & (not is_bound)
        h = R - reals[rows.bound_A]
        left, passed, s0 = h > rules.escape_height, s > reals[rows.law.escape_sine], s
        if ti.static(reflected):
            crossed_height, crossed_pitch, s0 = crossings(reals, rules, r0, e0, h, s)
            left, passed = left | crossed_height, passed | crossed_pitch
        step = record(r0=r0, r1=r1, e0=e0, h=h, s0=s0, s=s, least=least)
        keep(reals, ints, bound, rules, step, left)
        if ti.static(reflected):
            press(reals, bound, free, least)
        touch = on & (ints[LaneInt.TOUCH] != 0) & (ints[LaneInt.WATCH_CONTACT] != 0)
        timed = passed & on & (ints[LaneInt.WATCH_PITCH] != 0)
        events = ti.select(touch, int(Event.CONTACT), 0) | ti.select(timed, int(Event.PITCH), 0)
        ints[Int.EVENT] = ints[Int.EVENT] | events | ti.select(left & bound, int(Event.ESCAPE), 0)
        tick(reals, ints, on, rules)
        put_whole(reals, rows.x, pick(on, x1, x0))
        put_whole(reals, rows.rest, pick(on, whole(reals, rows.trial_rest), whole(reals, rows.rest)))
        put_whole(reals, rows.e, pick(on, e1, e0))

    return commit
