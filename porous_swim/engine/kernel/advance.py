"""The kernel: blocks of lanes that run until something happens, and a scalar pass that deals with it."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.book import make_book
from porous_swim.engine.kernel.encounters import make_encounters, make_orient, make_recall, make_threshold
from porous_swim.engine.kernel.locate import LOCATED_BAND, make_locate
from porous_swim.engine.kernel.log import Log
from porous_swim.engine.kernel.move import make_step
from porous_swim.engine.kernel.pairs import make_swap
from porous_swim.engine.kernel.reflect import make_reflect
from porous_swim.engine.kernel.rows import get_image, make_vectors, make_wide, rows_of
from porous_swim.engine.kernel.settle import make_settle
from porous_swim.engine.kernel.state import (
    N_LANE_INTS,
    PHASE_BIT,
    Event,
    Int,
    LaneInt,
    Law,
    Long,
    Total,
    clock_of_events,
)
from porous_swim.engine.kernel.swimmers import Rules, Swimmers, put_image, set_of
from porous_swim.obstacles.search import Medium
from porous_swim.physics.contact import HardContact
from porous_swim.physics.model import Model
from porous_swim.physics.surface import make_surface


def make_mover(model: Model):
    """Return `step(f, n, swimmer, swimmers, medium, rules, n_steps, n_pairs)` of the model's integrator.

    `swimmer` holds the number of the swimmer in each lane; `n_pairs` is 0 where none of them has a mate.
    """
    return {"euler": make_step, "reflected": make_reflect, "located": make_locate}[model.integrator](model)


@cache
def make_lanes(model: Model):
    """Return `load` and `store`, between memory and lane j of a block."""
    real, located, mates, flights = model.real, model.located, model.mates, model.flights
    rows, middle = rows_of(model), clock_of_events(model.integrator)
    threshold, recall = make_threshold(model), make_recall(model)
    _, sync = make_swap(model)

    @ti.func
    def load(f: ti.template(), n: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(),
             rules: ti.template(), fresh):  # fmt: skip
        """Take swimmer i into the lane; where the launch is `fresh` it is at its first step."""
        for row in ti.static(range(rows.n_shared)):
            f[row][j] = swimmers.real[row, i]
        word = swimmers.int[int(Int.EVENT), i]
        n[Int.EVENT][j], n[LaneInt.PHASE][j] = word & ((1 << PHASE_BIT) - 1), word >> PHASE_BIT
        n[Int.STEP][j] = ti.select(fresh != 0, 0, swimmers.int[int(Int.STEP), i])
        for k in ti.static(range(int(Law.ESCAPE_SINE))):
            f[rows.alpha + k][j] = swimmers.law[set_of(swimmers, i), k]
        b = ti.max(swimmers.int[int(Int.BOUND), i], 0)
        f[rows.escape_sine][j] = threshold(swimmers, medium, i, b, f[rows.alpha][j], f[rows.gamma][j])
        if ti.static(not located):
            f[rows.clock][j] = ti.select(rules.first + n[Int.STEP][j] > 0, real(middle), real(0.0))
        recall(n, j, i, swimmers)
        n[LaneInt.RELEASE][j], n[LaneInt.N_CONTACT][j], n[LaneInt.TOUCH][j] = -1, 0, 0
        n[Int.EVENT][j] |= int(Event.ORIENT)
        n[LaneInt.SWIMMER][j], n[LaneInt.SWAPPED][j] = i, 0
        if ti.static(flights):  # launches begin where flights may
            n[LaneInt.AFTER][j] = n[Int.STEP][j] % rules.flight_ticks

    @ti.func
    def store(f: ti.template(), n: ti.template(), j, swimmers: ti.template(), first):
        """Put the swimmer of the lane back, if there is one, and leave the lane empty."""
        i = n[LaneInt.SWIMMER][j]
        if i >= 0:
            if ti.static(mates):
                sync(n, j, i, swimmers)
            for row in ti.static(range(rows.n_shared)):
                swimmers.real[row, i] = f[row][j]
            swimmers.int[int(Int.STEP), i] = n[Int.STEP][j]
            swimmers.int[int(Int.EVENT), i] = n[Int.EVENT][j] | n[LaneInt.PHASE][j] << PHASE_BIT
            if ti.static(located):
                swimmers.int[int(Int.STRUCK), i] = n[LaneInt.STRUCK][j]
                put_image(swimmers, int(Int.STRUCK_IMAGE), i, get_image(n, LaneInt.STRUCK_IMAGE, j))
            if n[LaneInt.RELEASE][j] >= 0:
                swimmers.long[int(Long.RELEASE), i] = first + n[LaneInt.RELEASE][j]
            swimmers.long[int(Long.N_CONTACT), i] = swimmers.long[int(Long.N_CONTACT), i] + n[LaneInt.N_CONTACT][j]
            if n[Int.EVENT][j] & int(Event.HALT):
                ti.atomic_add(swimmers.total[int(Total.HALTED)], 1)
            elif n[Int.EVENT][j] == 0:
                ti.atomic_add(swimmers.total[int(Total.FINISHED)], 1)
        n[LaneInt.SWIMMER][j], n[Int.EVENT][j] = -1, int(Event.HALT)

    return load, store


@cache
def make_advance(model: Model):
    """Compile `advance(...)`, which moves every swimmer to the end of the launch, or until the log is full."""
    real, lanes, located, mates = model.real, model.lanes, model.located, model.mates
    rows, (whole, _), (get, put) = rows_of(model), make_wide(model), make_vectors(model)
    step, book, settle, orient = make_mover(model), make_book(model), make_settle(model), make_orient(model)
    encounters, contact_height, to = make_encounters(model), HardContact.make_rolled_height(model), make_surface(model)
    (load, store), (swap, sync) = make_lanes(model), make_swap(model)
    Wide, WideInt = ti.types.vector(lanes, real), ti.types.vector(lanes, ti.i32)
    reals, ints, longs = (ti.types.ndarray(t, ndim=2) for t in (real, ti.i32, ti.i64))
    real_row, int_row, long_row = (ti.types.ndarray(t, ndim=1) for t in (real, ti.i32, ti.i64))

    @ti.func
    def attend(f: ti.template(), n: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(),
               log: ti.template(), rules: ti.template()):  # fmt: skip
        """Do what lane j (swimmer i) waits for. What needs the log may have to wait for the next launch."""
        if ti.static(mates):
            sync(n, j, i, swimmers)
        event = n[Int.EVENT][j]
        n[Int.EVENT][j] = event & int(Event.CONTACT | Event.ESCAPE | Event.PITCH)
        if event & int(Event.LOCATE):  # a swimmer just placed stays where it is
            put(f, rows.trial_x, j, get(f, rows.x, j))
            put(f, rows.trial_e, j, get(f, rows.e, j))
        if event & int(Event.LOCATE | Event.FINISH):
            band = rules.tolerance
            if ti.static(located):  # a swimmer released that near touches; later a touch is a touch
                band = ti.select(event & int(Event.LOCATE), band, real(LOCATED_BAND))
            settle(f, n, j, i, swimmers, medium, rules, band)
        orient(f, n, j, i, swimmers, medium)
        if n[Int.EVENT][j] & int(Event.HALT) == 0:
            if event & int(Event.FINISH):
                n[LaneInt.SETTLED][j] = 1
            else:
                if event & int(Event.LOCATE):
                    touch = (n[LaneInt.TOUCH][j] != 0) & (n[LaneInt.WATCH_CONTACT][j] != 0)
                    n[Int.EVENT][j] |= ti.select(touch, int(Event.CONTACT), 0)
                if n[Int.EVENT][j] != 0:
                    encounters(f, n, j, i, swimmers, medium, log, rules)

    @ti.func
    def attend_all(f: ti.template(), n: ti.template(), swimmers: ti.template(), medium: ti.template(),
                   log: ti.template(), rules: ti.template()):  # fmt: skip
        """Do what the lanes wait for: settle and book; what comes of it; orient those whose encounter it changed."""
        for _ in range(3):
            waiting, settled = 0, 0
            for j in range(lanes):
                waiting |= n[Int.EVENT][j]
            if (waiting & ~int(Event.HALT)) != 0:
                for j in range(lanes):
                    if (n[Int.EVENT][j] != 0) & ((n[Int.EVENT][j] & int(Event.HALT)) == 0):
                        attend(f, n, j, n[LaneInt.SWIMMER][j], swimmers, medium, log, rules)
                        settled |= n[LaneInt.SETTLED][j]
            if settled != 0:
                r = whole(f, rows.trial_x) + whole(f, rows.bound_offset)
                s = to.sine(r, whole(f, rows.trial_e), to.distance(r))
                least = contact_height(s, f[rows.gamma], f[rows.bound_A])
                book(f, n, n[LaneInt.SETTLED] != 0, rules, least)
                n[LaneInt.SETTLED] = WideInt(0)

    @ti.kernel
    def advance(
        state: reals, state_int: ints, state_long: longs, law: reals, total: long_row,
        center: longs, radius: real_row, first_cell: int_row, candidate: ints, least: real_row, grid: int_row,
        scale: reals,
        log_real: reals, log_int: ints, log_long: longs,
        dt: real, escape_height: real, contact_band: real, tolerance: real, margin: real,
        first: ti.i64, first_low: ti.u32, first_high: ti.u32, key0: ti.u32, key1: ti.u32,
        flight_ticks: ti.i32, flight_height: real, tableau: reals,
        n_steps: ti.i32, fresh: ti.i32, n_blocks: ti.i32, share: ti.i32, stride: ti.i32, chunk: ti.i32,
    ):  # fmt: skip
        swimmers = ti.static(Swimmers(state, state_int, state_long, law, total))
        medium = ti.static(Medium(center, radius, first_cell, candidate, least, grid, scale))
        log = ti.static(Log(log_real, log_int, log_long))
        rules = ti.static(
            Rules(dt, escape_height, contact_band, tolerance, margin, first, first_low, first_high, key0, key1,
                  flight_ticks, flight_height, tableau)
        )  # fmt: skip
        # Taichi's CPU tasks are at least 512 iterations: a block is `stride` of them
        for t in range(n_blocks * stride):
            if t % stride == 0:
                i, end = t // stride * share, ti.min((t // stride + 1) * share, state_int.shape[1])
                f = [Wide(0.0) for _ in ti.static(range(rows.n_lanes))]
                n = [WideInt(0) for _ in ti.static(range(N_LANE_INTS))]
                n[LaneInt.SWIMMER], n[Int.EVENT] = WideInt(-1), WideInt(int(Event.HALT))
                busy = 1
                while busy != 0:
                    attend_all(f, n, swimmers, medium, log, rules)
                    busy, moving, n_pairs = 0, 0, 0
                    for j in range(lanes):
                        if (n[Int.EVENT][j] == 0) & (n[Int.STEP][j] < n_steps):
                            moving = 1
                            if ti.static(mates):
                                n_pairs += n[LaneInt.PAIRED][j]
                        else:  # the swimmer is at the end of the launch, or cannot go on in it: the next one
                            store(f, n, j, swimmers, first)
                            if i < end:
                                load(f, n, j, i, swimmers, medium, rules, fresh)
                                i += 1
                                busy = 1
                    if moving != 0:
                        busy = 1
                        for _ in range(chunk):
                            step(f, n, ti.cast(n[LaneInt.SWIMMER], ti.u32), swimmers, medium, rules, n_steps, n_pairs)
                            if ti.static(mates):
                                swap(f, n, n_pairs)

    return advance
