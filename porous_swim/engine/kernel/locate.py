"""One trial move of one lane without noise: it ends with the time step, or just behind the first event in it."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.commit import make_commit
from porous_swim.engine.kernel.move import FAR
from porous_swim.engine.kernel.resolve_contacts import BETWEEN
from porous_swim.engine.kernel.rows import make_law, make_vectors, rows_of
from porous_swim.engine.kernel.state import Event, Int, LaneInt, Phase
from porous_swim.engine.kernel.swimmers import image_of, same
from porous_swim.obstacles.search import make_search
from porous_swim.physics.contact import HardContact
from porous_swim.physics.located import Mode, make_motion, make_stride
from porous_swim.physics.model import Model
from porous_swim.physics.surface import make_surface
from porous_swim.physics.vectors import record, vec

HALVINGS = 50  # of a time step: to its last bit
SHORTEST = 1e-9  # of a time step: where errors or turning points ask for less, go on
SWITCH = 1e-3  # of a time step: shortest stay with one of two colloids that hold the swimmer in a wedge
LOCATED_BAND = 1e-10  # a swimmer no higher above another colloid than this touches it
AT_WALL = 1e-12  # distance from contact, in distances from the centre, that is rounding


@cache
def make_get(model: Model):
    """Return `get(reals, row, j)`, a vector of Taichi, of the plain numbers of one lane."""
    dimensions = model.dimensions

    @ti.func
    def get(reals: ti.template(), row: ti.template(), j):
        return ti.Vector([reals[row + d][j] for d in ti.static(range(dimensions))])

    return get


@cache
def make_passed(model: Model):
    """Return `switched` and `passed`, which say whether a move has gone beyond an event, and `is_low`."""
    real, dimensions, rows, get = model.real, model.dimensions, rows_of(model), make_get(model)
    search, to = make_search(model), make_surface(model)
    height_and_slope = HardContact.make_height_and_slope(model)

    @ti.func
    def switched(reals: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(), x, e, mode):
        """Whether another colloid is nearer at x; nobody looks within the budget."""
        other = False
        moved = x - get(reals, rows.reference, j)
        if moved.dot(moved) > reals[rows.budget][j]:
            k, image = swimmers.int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i)
            place = vec(*[x[d] for d in ti.static(range(dimensions))])
            heading = vec(*[e[d] for d in ti.static(range(dimensions))])
            found = search.run(medium, k, image, place, heading, reals[rows.law.gamma][j])
            m, image_m = swimmers.int[int(Int.PARTNER), i], image_of(swimmers, int(Int.PARTNER_IMAGE), i)
            partner = (mode == int(Mode.BETWEEN)) & same(m, image_m, found.near, found.image)
            other = not (same(k, image, found.near, found.image) | partner)
        return other

    @ti.func
    def is_low(reals: ti.template(), j, rules: ti.template(), x, e):
        """Whether the swimmer is in the contact band of the colloid of its encounter."""
        r = x + get(reals, rows.bound_offset, j)
        R = to.distance(r)
        least, _ = height_and_slope(to.sine(r, e, R), reals[rows.law.gamma][j], reals[rows.bound_A][j])
        return R - reals[rows.bound_A][j] - least <= ti.max(rules.contact_band, rules.tolerance)

    @ti.func
    def passed(reals: ti.template(), ints: ti.template(), j, rules: ti.template(), x, e, mode, low):
        """Whether the swimmer touches, crosses the edge of the contact band, escapes, or passes a pitch."""
        R = to.distance(x)
        least, _ = height_and_slope(to.sine(x, e, R), reals[rows.law.gamma][j], reals[rows.A][j])
        sunk = R - reals[rows.A][j] - least < -real(AT_WALL) * R
        r = x + get(reals, rows.bound_offset, j)
        distance = to.distance(r)
        bound = ints[LaneInt.PHASE][j] == int(Phase.BOUND)
        left = bound & (distance - reals[rows.bound_A][j] > rules.escape_height)
        pitched = (ints[LaneInt.WATCH_PITCH][j] != 0) & (to.sine(r, e, distance) > reals[rows.law.escape_sine][j])
        crossed = bound & (is_low(reals, j, rules, x, e) != low)
        return ((mode != int(Mode.HELD)) & sunk) | crossed | left | pitched

    return switched, passed, is_low


@cache
def make_modes(model: Model):
    """Return `mode_of(reals, ints, j, x, e, around, law)` and `level(x, around)`.

    The first says what holds the swimmer, and how fast it approaches the wall; the second puts a swimmer between two
    colloids back to where both are equally near. For `around` see `located.make_motion`.
    """
    real, rate, to = model.real, make_motion(model), make_surface(model)
    height_and_slope = HardContact.make_height_and_slope(model)

    @ti.func
    def mode_of(reals: ti.template(), ints: ti.template(), j, x, e, around, law):
        R = to.distance(x)
        least, _ = height_and_slope(to.sine(x, e, R), law.gamma, around.A)
        _, _, push, pinch = rate(x, e, around, law, int(Mode.FREE))
        held = (R - around.A - least <= real(AT_WALL) * R) & (push >= real(0.0))
        mode = ti.select(held, int(Mode.HELD), int(Mode.FREE))
        r = x + around.partner
        level = ti.abs(R - around.A - to.distance(r) + around.partner_A) <= real(BETWEEN)
        between = (ints[LaneInt.BETWEEN][j] != 0) & (not held) & level & (pinch > real(0.0))
        return ti.select(between, int(Mode.BETWEEN), mode), push

    @ti.func
    def level(x, around):
        r = x + around.partner
        R, R1 = to.distance(x), to.distance(r)
        across = to.normal(x, R) - to.normal(r, R1)
        return x - ((R - around.A - R1 + around.partner_A) / across.dot(across)) * across

    return mode_of, level


@cache
def make_travel(model: Model):
    """Return `travel(reals, ints, j, i, swimmers, medium, rules, whole) -> position, director, held, length`.

    It is the longest move up to `whole` that is accurate, and ends just behind the first event in it.
    """
    real, rows, get, (_, law_of) = model.real, rows_of(model), make_get(model), make_law(model)
    stride, (mode_of, level), (switched, passed, is_low) = make_stride(model), make_modes(model), make_passed(model)
    height_and_slope, to = HardContact.make_height_and_slope(model), make_surface(model)

    @ti.func
    def turns_back(x, e, A, law, tau, push0, push1):
        """Whether a free swimmer may have dipped into the wall: it came nearer first, and goes away at the end."""
        R = to.distance(x)
        least, _ = height_and_slope(to.sine(x, e, R), law.gamma, A)
        return (push0 > real(0.0)) & (push1 < real(0.0)) & (R - A - least < tau * (push0 - push1))

    @ti.func
    def shortened(tau, error):
        """The length to try where `tau` was not accurate, or may have passed a turning point."""
        shorter = real(0.9) * ti.pow(error, real(-0.125))
        return tau * ti.select(error > real(1.0), ti.max(real(0.2), ti.min(shorter, real(0.9))), real(0.5))

    @ti.func
    def travel(reals: ti.template(), ints: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(),
               rules: ti.template(), whole):  # fmt: skip
        x0, e0, law = get(reals, rows.x, j), get(reals, rows.e, j), law_of(reals, j)
        around = record(
            A=reals[rows.A][j], partner=get(reals, rows.partner_offset, j), partner_A=reals[rows.partner_A][j]
        )
        mode, push0 = mode_of(reals, ints, j, x0, e0, around, law)
        started_low = is_low(reals, j, rules, x0, e0)
        x, e, pushed, distance, other = x0, e0, real(0.0), real(0.0), get(reals, rows.bound_offset, j)
        low, high, tau = real(0.0), whole, whole
        halvings, going = -1, True  # -1: no event known
        while going:
            x, e, pushed, distance, grip, error = stride(rules.tableau, x0, e0, other, around, law, mode, tau)
            e /= ti.sqrt(e.dot(e))
            long = tau > real(SHORTEST) * rules.dt
            if (halvings < 0) & long & ((not (error <= real(1.0))) | (
                (mode == int(Mode.FREE)) & turns_back(x, e, around.A, law, tau, push0, grip)
            )):  # fmt: skip
                tau = shortened(tau, error)
                high = tau
            elif halvings == HALVINGS:
                going = False
            else:
                loose = (mode != int(Mode.FREE)) & (grip < real(0.0))
                beyond = loose | passed(reals, ints, j, rules, x, e, mode, started_low)
                far = False
                if (not beyond) & ((mode != int(Mode.HELD)) | (tau > real(SWITCH) * rules.dt)):
                    far = switched(reals, j, i, swimmers, medium, x, e, mode)
                if beyond | far:
                    high = tau
                else:
                    low = tau
                if (halvings < 0) & (not (beyond | far)):
                    going = False
                else:
                    halvings += 1
                    tau = ti.select(halvings == HALVINGS, high, real(0.5) * (low + high))
        reals[rows.trial_push][j] = ti.select((mode == int(Mode.HELD)) & (ints[LaneInt.OWN][j] != 0), pushed, real(0.0))
        reals[rows.trial_height][j] = (distance - tau * reals[rows.bound_A][j]) / rules.dt
        ints[LaneInt.LOW][j] = ti.cast(started_low, ti.i32)
        x = ti.select(mode == int(Mode.BETWEEN), level(x, around), x)
        return x, e, mode == int(Mode.HELD), tau

    return travel


@cache
def make_locate(model: Model):
    """Return `step(reals, ints, swimmer, swimmers, medium, rules, n_steps, n_pairs)`, which moves a lane."""
    real, rows, (get, (_, put)) = model.real, rows_of(model), (make_get(model), make_vectors(model))
    travel, commit, to = make_travel(model), make_commit(model), make_surface(model)
    height_and_slope = HardContact.make_height_and_slope(model)

    @ti.func
    def step(reals: ti.template(), ints: ti.template(), swimmer, swimmers: ti.template(), medium: ti.template(),
             rules: ti.template(), n_steps, n_pairs):  # fmt: skip
        j, i = 0, ti.cast(swimmer[0], ti.i32)
        if (ints[Int.EVENT][j] == 0) & (ints[Int.STEP][j] < n_steps):
            clock = reals[rows.clock][j]
            whole = rules.dt * (real(1.0) - clock)
            x, e, held, tau = travel(reals, ints, j, i, swimmers, medium, rules, whole)
            A = reals[rows.A][j]
            R = to.distance(x)
            least, _ = height_and_slope(to.sine(x, e, R), reals[rows.law.gamma][j], A)
            touch = held | (R - A - least <= real(AT_WALL) * R)
            x = ti.select(touch, to.at(x, R, A + least), x)
            put(reals, rows.trial_x, j, x)
            put(reals, rows.trial_e, j, e)
            reals[rows.trial_clock][j] = ti.select(tau < whole, clock + tau / rules.dt, real(1.0))
            ints[LaneInt.TOUCH][j] = ti.cast(touch, ti.i32)
            moved = x - get(reals, rows.reference, j)
            within = moved.dot(moved) <= reals[rows.budget][j]  # false for a position that is not finite
            ints[Int.EVENT][j] |= ti.select(within, 0, int(Event.FINISH))
            if ti.static(not model.sphere):  # within its budget a rod is out of contact with every other colloid
                least = ti.select(ints[LaneInt.OWN][j] != 0, least, real(-FAR))
            commit(reals, ints, within, rules, least)

    return step
