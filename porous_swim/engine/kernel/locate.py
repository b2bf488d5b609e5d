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
    """Return `get(f, row, j)`, a vector of Taichi: steps of a length of their own are one lane's, and plain numbers."""
    dimensions = model.dimensions

    @ti.func
    def get(f: ti.template(), row: ti.template(), j):
        return ti.Vector([f[row + d][j] for d in ti.static(range(dimensions))])

    return get


@cache
def make_passed(model: Model):
    """Return `switched` and `passed`, which say whether a move has gone beyond an event, and `is_low`."""
    real, dimensions, rows, get = model.real, model.dimensions, rows_of(model), make_get(model)
    search, to = make_search(model), make_surface(model)
    height_and_slope = HardContact.make_height_and_slope(model)

    @ti.func
    def switched(f: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(), x, e, mode):
        """Whether another colloid is nearer at x; nobody looks within the budget."""
        other = False
        moved = x - get(f, rows.reference, j)
        if moved.dot(moved) > f[rows.budget][j]:
            k, image = swimmers.int[int(Int.COLLOID), i], image_of(swimmers, int(Int.IMAGE), i)
            place = vec(*[x[d] for d in ti.static(range(dimensions))])
            heading = vec(*[e[d] for d in ti.static(range(dimensions))])
            found = search.run(medium, k, image, place, heading, f[rows.law.gamma][j])
            m, image_m = swimmers.int[int(Int.PARTNER), i], image_of(swimmers, int(Int.PARTNER_IMAGE), i)
            partner = (mode == int(Mode.BETWEEN)) & same(m, image_m, found.near, found.image)
            other = not (same(k, image, found.near, found.image) | partner)
        return other

    @ti.func
    def is_low(f: ti.template(), j, rules: ti.template(), x, e):
        """Whether the swimmer is in the contact band of the colloid of its encounter."""
        r = x + get(f, rows.bound_offset, j)
        R = to.distance(r)
        least, _ = height_and_slope(to.sine(r, e, R), f[rows.law.gamma][j], f[rows.bound_A][j])
        return R - f[rows.bound_A][j] - least <= ti.max(rules.contact_band, rules.tolerance)

    @ti.func
    def passed(f: ti.template(), n: ti.template(), j, rules: ti.template(), x, e, mode, low):
        """Whether the swimmer touches, crosses the edge of the contact band, escapes, or passes a pitch."""
        R = to.distance(x)
        least, _ = height_and_slope(to.sine(x, e, R), f[rows.law.gamma][j], f[rows.A][j])
        sunk = R - f[rows.A][j] - least < -real(AT_WALL) * R
        r = x + get(f, rows.bound_offset, j)
        distance = to.distance(r)
        bound = n[LaneInt.PHASE][j] == int(Phase.BOUND)
        left = bound & (distance - f[rows.bound_A][j] > rules.escape_height)
        pitched = (n[LaneInt.WATCH_PITCH][j] != 0) & (to.sine(r, e, distance) > f[rows.law.escape_sine][j])
        crossed = bound & (is_low(f, j, rules, x, e) != low)
        return ((mode != int(Mode.HELD)) & sunk) | crossed | left | pitched

    return switched, passed, is_low


@cache
def make_modes(model: Model):
    """Return `mode_of(f, n, j, x, e, around, law)` and `level(x, around)`.

    The first says what holds the swimmer, and how fast it approaches the wall; the second puts a swimmer between two
    colloids back to where both are equally near. For `around` see `located.make_motion`.
    """
    real, rate, to = model.real, make_motion(model), make_surface(model)
    height_and_slope = HardContact.make_height_and_slope(model)

    @ti.func
    def mode_of(f: ti.template(), n: ti.template(), j, x, e, around, law):
        R = to.distance(x)
        least, _ = height_and_slope(to.sine(x, e, R), law.gamma, around.A)
        _, _, push, pinch = rate(x, e, around, law, int(Mode.FREE))
        held = (R - around.A - least <= real(AT_WALL) * R) & (push >= real(0.0))
        mode = ti.select(held, int(Mode.HELD), int(Mode.FREE))
        r = x + around.partner
        level = ti.abs(R - around.A - to.distance(r) + around.partner_A) <= real(BETWEEN)
        between = (n[LaneInt.BETWEEN][j] != 0) & (not held) & level & (pinch > real(0.0))
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
    """Return `travel(f, n, j, i, swimmers, medium, rules, whole) -> position, director, held, length`.

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
    def travel(f: ti.template(), n: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(),
               rules: ti.template(), whole):  # fmt: skip
        x0, e0, law = get(f, rows.x, j), get(f, rows.e, j), law_of(f, j)
        around = record(A=f[rows.A][j], partner=get(f, rows.partner_offset, j), partner_A=f[rows.partner_A][j])
        mode, push0 = mode_of(f, n, j, x0, e0, around, law)
        started_low = is_low(f, j, rules, x0, e0)
        x, e, pushed, distance, other = x0, e0, real(0.0), real(0.0), get(f, rows.bound_offset, j)
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
                beyond = loose | passed(f, n, j, rules, x, e, mode, started_low)
                far = False
                if (not beyond) & ((mode != int(Mode.HELD)) | (tau > real(SWITCH) * rules.dt)):
                    far = switched(f, j, i, swimmers, medium, x, e, mode)
                if beyond | far:
                    high = tau
                else:
                    low = tau
                if (halvings < 0) & (not (beyond | far)):
                    going = False
                else:
                    halvings += 1
                    tau = ti.select(halvings == HALVINGS, high, real(0.5) * (low + high))
        f[rows.trial_push][j] = ti.select((mode == int(Mode.HELD)) & (n[LaneInt.OWN][j] != 0), pushed, real(0.0))
        f[rows.trial_height][j] = (distance - tau * f[rows.bound_A][j]) / rules.dt
        n[LaneInt.LOW][j] = ti.cast(started_low, ti.i32)
        x = ti.select(mode == int(Mode.BETWEEN), level(x, around), x)
        return x, e, mode == int(Mode.HELD), tau

    return travel


@cache
def make_locate(model: Model):
    """Return `step(f, n, swimmer, swimmers, medium, rules, n_steps, n_pairs)`, which moves a lane that may go on."""
    real, rows, (get, (_, put)) = model.real, rows_of(model), (make_get(model), make_vectors(model))
    travel, commit, to = make_travel(model), make_commit(model), make_surface(model)
    height_and_slope = HardContact.make_height_and_slope(model)

    @ti.func
    def step(f: ti.template(), n: ti.template(), swimmer, swimmers: ti.template(), medium: ti.template(),
             rules: ti.template(), n_steps, n_pairs):  # fmt: skip
        j, i = 0, ti.cast(swimmer[0], ti.i32)
        if (n[Int.EVENT][j] == 0) & (n[Int.STEP][j] < n_steps):
            clock = f[rows.clock][j]
            whole = rules.dt * (real(1.0) - clock)
            x, e, held, tau = travel(f, n, j, i, swimmers, medium, rules, whole)
            A = f[rows.A][j]
            R = to.distance(x)
            least, _ = height_and_slope(to.sine(x, e, R), f[rows.law.gamma][j], A)
            touch = held | (R - A - least <= real(AT_WALL) * R)
            x = ti.select(touch, to.at(x, R, A + least), x)
            put(f, rows.trial_x, j, x)
            put(f, rows.trial_e, j, e)
            f[rows.trial_clock][j] = ti.select(tau < whole, clock + tau / rules.dt, real(1.0))
            n[LaneInt.TOUCH][j] = ti.cast(touch, ti.i32)
            moved = x - get(f, rows.reference, j)
            within = moved.dot(moved) <= f[rows.budget][j]  # false for a position that is not finite
            n[Int.EVENT][j] |= ti.select(within, 0, int(Event.FINISH))
            if ti.static(not model.sphere):  # within its budget a rod is out of contact with every other colloid
                least = ti.select(n[LaneInt.OWN][j] != 0, least, real(-FAR))
            commit(f, n, within, rules, least)

    return step
