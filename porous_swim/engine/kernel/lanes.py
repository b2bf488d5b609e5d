"""Swimmers on their way between memory and the lanes of a block."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import taichi as ti

from porous_swim.engine.kernel.capture import make_threshold
from porous_swim.engine.kernel.encounters import make_recall
from porous_swim.engine.kernel.pairs import make_swap
from porous_swim.engine.kernel.rows import get_image, rows_of
from porous_swim.engine.kernel.state import PHASE_BIT, Event, Int, LaneInt, Long, Total, clock_of_events
from porous_swim.engine.kernel.swimmers import put_image, set_of
from porous_swim.physics.model import Model


@cache
def make_lanes(model: Model):
    """Return `load` and `store`, between memory and lane j of a block."""
    real, located, partners, flights = model.real, model.located, model.partners, model.flights
    rows, middle = rows_of(model), clock_of_events(model.integrator)
    numbers = tuple((getattr(rows.law, name), column) for column, name in enumerate(model.numbers))
    threshold, recall = make_threshold(model), make_recall(model)
    _, sync = make_swap(model)

    @ti.func
    def load(reals: ti.template(), ints: ti.template(), j, i, swimmers: ti.template(), medium: ti.template(),
             rules: ti.template(), fresh):  # fmt: skip
        """Take swimmer i into the lane; where the launch is `fresh` it is at its first step."""
        for row in ti.static(range(rows.n_shared)):
            reals[row][j] = swimmers.real[row, i]
        word = swimmers.int[int(Int.EVENT), i]
        ints[Int.EVENT][j], ints[LaneInt.PHASE][j] = word & ((1 << PHASE_BIT) - 1), word >> PHASE_BIT
        ints[Int.STEP][j] = ti.select(fresh != 0, 0, swimmers.int[int(Int.STEP), i])
        for row, column in ti.static(numbers):
            reals[row][j] = swimmers.law[set_of(swimmers, i), column]
        b = ti.max(swimmers.int[int(Int.BOUND), i], 0)
        reals[rows.law.escape_sine][j] = threshold(
            swimmers, medium, i, b, reals[rows.law.alpha][j], reals[rows.law.gamma][j]
        )
        if ti.static(not located):
            reals[rows.clock][j] = ti.select(rules.first + ints[Int.STEP][j] > 0, real(middle), real(0.0))
        recall(ints, j, i, swimmers)
        ints[LaneInt.RELEASE][j], ints[LaneInt.N_CONTACT][j], ints[LaneInt.TOUCH][j] = -1, 0, 0
        ints[Int.EVENT][j] |= int(Event.REFRESH)
        ints[LaneInt.SWIMMER][j], ints[LaneInt.SWAPPED][j] = i, 0
        if ti.static(flights):  # launches begin where flights may
            ints[LaneInt.AFTER][j] = ints[Int.STEP][j] % rules.flight_ticks

    @ti.func
    def store(reals: ti.template(), ints: ti.template(), j, swimmers: ti.template(), first):
        """Put the swimmer of the lane back, if there is one, and leave the lane empty."""
        i = ints[LaneInt.SWIMMER][j]
        if i >= 0:
            if ti.static(partners):
                sync(ints, j, i, swimmers)
            for row in ti.static(range(rows.n_shared)):
                swimmers.real[row, i] = reals[row][j]
            swimmers.int[int(Int.STEP), i] = ints[Int.STEP][j]
            swimmers.int[int(Int.EVENT), i] = ints[Int.EVENT][j] | ints[LaneInt.PHASE][j] << PHASE_BIT
            if ti.static(located):
                swimmers.int[int(Int.TOUCHED_BODY), i] = ints[LaneInt.TOUCHED_BODY][j]
                put_image(swimmers, int(Int.TOUCHED_BODY_IMAGE), i, get_image(ints, LaneInt.TOUCHED_BODY_IMAGE, j))
            if ints[LaneInt.RELEASE][j] >= 0:
                swimmers.long[int(Long.RELEASE), i] = first + ints[LaneInt.RELEASE][j]
            swimmers.long[int(Long.N_CONTACT), i] = swimmers.long[int(Long.N_CONTACT), i] + ints[LaneInt.N_CONTACT][j]
            if ints[Int.EVENT][j] & int(Event.HALT):
                ti.atomic_add(swimmers.total[int(Total.HALTED)], 1)
            elif ints[Int.EVENT][j] == 0:
                ti.atomic_add(swimmers.total[int(Total.FINISHED)], 1)
        ints[LaneInt.SWIMMER][j], ints[Int.EVENT][j] = -1, int(Event.HALT)

    return load, store
