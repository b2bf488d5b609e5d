"""The kernel: blocks of lanes that run until something happens, and a scalar pass that deals with it."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.device_log import Log
from porous_swim.engine.kernel.handle_events import make_handle_events
from porous_swim.engine.kernel.lanes import make_lanes
from porous_swim.engine.kernel.locate import make_locate
from porous_swim.engine.kernel.move import make_step
from porous_swim.engine.kernel.pairs import make_swap
from porous_swim.engine.kernel.reflect import make_reflect
from porous_swim.engine.kernel.rows import rows_of
from porous_swim.engine.kernel.state import N_LANE_INTS, Event, Int, LaneInt
from porous_swim.engine.kernel.swimmers import Rules, Swimmers
from porous_swim.obstacles.search import Medium
from porous_swim.physics.model import Model


def make_mover(model: Model):
    """Return `step(reals, ints, swimmer, swimmers, medium, rules, n_steps, n_pairs)` of the model's integrator.

    `swimmer` holds the number of the swimmer in each lane; `n_pairs` is 0 where none of them has a partner.
    """
    return {"euler": make_step, "reflected": make_reflect, "located": make_locate}[model.integrator](model)


@cache
def make_advance(model: Model):
    """Compile `advance(...)`, which moves every swimmer to the end of the launch, or until the log is full."""
    real, lanes, partners, rows = model.real, model.lanes, model.partners, rows_of(model)
    step, handle_all_events = make_mover(model), make_handle_events(model)
    (load, store), (swap, _) = make_lanes(model), make_swap(model)
    Wide, WideInt = ti.types.vector(lanes, real), ti.types.vector(lanes, ti.i32)
    reals, ints, longs = (ti.types.ndarray(t, ndim=2) for t in (real, ti.i32, ti.i64))
    real_row, int_row, long_row = (ti.types.ndarray(t, ndim=1) for t in (real, ti.i32, ti.i64))

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
                reals = [Wide(0.0) for _ in ti.static(range(rows.n_lanes))]
                ints = [WideInt(0) for _ in ti.static(range(N_LANE_INTS))]
                ints[LaneInt.SWIMMER], ints[Int.EVENT] = WideInt(-1), WideInt(int(Event.HALT))
                busy = 1
                while busy != 0:
                    handle_all_events(reals, ints, swimmers, medium, log, rules)
                    busy, moving, n_pairs = 0, 0, 0
                    for j in range(lanes):
                        if (ints[Int.EVENT][j] == 0) & (ints[Int.STEP][j] < n_steps):
                            moving = 1
                            if ti.static(partners):
                                n_pairs += ints[LaneInt.PAIRED][j]
                        else:  # the swimmer is at the end of the launch, or cannot go on in it: the next one
                            store(reals, ints, j, swimmers, first)
                            if i < end:
                                load(reals, ints, j, i, swimmers, medium, rules, fresh)
                                i += 1
                                busy = 1
                    if moving != 0:
                        busy = 1
                        for _ in range(chunk):
                            swimmer = ti.cast(ints[LaneInt.SWIMMER], ti.u32)
                            step(reals, ints, swimmer, swimmers, medium, rules, n_steps, n_pairs)
                            if ti.static(partners):
                                swap(reals, ints, n_pairs)

    return advance
