"""The encounter log on the device: one row for each encounter that ended, and one for each late escape pitch."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from enum import IntEnum
from functools import cache
from types import SimpleNamespace
from typing import Any, NamedTuple

import taichi as ti

from porous_swim.engine.kernel.rows import make_vectors, rows_of
from porous_swim.engine.kernel.state import Int, LaneInt, Long, Total, clock_of_events
from porous_swim.physics.model import Model
from porous_swim.results.encounter_columns import records


class Log(NamedTuple):
    """The log as kernel arguments."""

    real: Any  # (capacity, log_columns(dimensions).n_real)
    int: Any  # (capacity, len(LogInt)) i32
    long: Any  # (capacity, len(LogLong)) i64


class LogInt(IntEnum):
    """Integer columns of a row."""

    SWIMMER = 0
    COLLOID = 1
    IMAGE = 2  # three columns


N_LOG_INTS = 5


class LogLong(IntEnum):
    """Step columns of a row. A row whose END is -1 only brings the PITCH of an encounter logged before."""

    START = 0
    END = 1
    RELEASE = 2
    PITCH = 3
    N_CONTACT = 4


CLOCKS = {"start_clock": LogLong.START, "pitch_clock": LogLong.PITCH, "release_clock": LogLong.RELEASE}


def kept(dimensions: int, *, located: bool) -> tuple[str, ...]:
    """Scalar columns that are rows of the state; the clocks of other steps follow from it."""
    return (*(record.row for record in records(dimensions)), "contact_clock", *(CLOCKS if located else ()))


@cache
def log_columns(dimensions: int) -> SimpleNamespace:
    """Real columns of a row: four vectors, then scalars; offsets are from the encounter's colloid."""
    d = dimensions
    names = *kept(dimensions, located=True), "end_clock"
    scalars = {name: column for column, name in enumerate(names, start=4 * d)}
    return SimpleNamespace(entry_x=0, entry_e=d, exit_x=2 * d, exit_e=3 * d, **scalars, n_real=4 * d + len(names))


@cache
def make_log(model: Model):
    """Return `log_row(reals, ints, j, i, swimmers, log, step, late) -> whether there was room`.

    `late` writes only the passage of the escape pitch, for an encounter that was logged before.
    """
    real, dimensions, located = model.real, model.dimensions, model.located
    middle = clock_of_events(model.integrator)
    rows, columns = rows_of(model), log_columns(dimensions)
    pairs = tuple((getattr(columns, name), getattr(rows, name)) for name in kept(dimensions, located=located))
    clocks = () if located else tuple((getattr(columns, name), int(CLOCKS[name])) for name in CLOCKS)
    get, _ = make_vectors(model)

    @ti.func
    def write(reals: ti.template(), ints: ti.template(), j, i, swimmers: ti.template(), log: ti.template(), slot, step):
        release = ti.cast(ints[LaneInt.RELEASE][j], ti.i64)
        if ints[LaneInt.RELEASE][j] >= 0:
            release += step - ints[Int.STEP][j]
        else:  # the wall was last touched in an earlier launch, or never
            release = swimmers.long[int(Long.RELEASE), i]
        log.long[slot, int(LogLong.RELEASE)] = release
        log.long[slot, int(LogLong.PITCH)] = swimmers.long[int(Long.PITCH), i]
        log.long[slot, int(LogLong.N_CONTACT)] = swimmers.long[int(Long.N_CONTACT), i] + ints[LaneInt.N_CONTACT][j]
        x, e = get(reals, rows.x, j) + get(reals, rows.bound_offset, j), get(reals, rows.e, j)
        for d in ti.static(range(dimensions)):
            log.real[slot, columns.entry_x + d] = swimmers.real[rows.entry_x + d, i]
            log.real[slot, columns.entry_e + d] = swimmers.real[rows.entry_e + d, i]
            log.real[slot, columns.exit_x + d] = x[d]
            log.real[slot, columns.exit_e + d] = e[d]
        for column, row in ti.static(pairs):
            log.real[slot, column] = reals[row][j]
        for column, happened in ti.static(clocks):
            log.real[slot, column] = ti.select(log.long[slot, happened] > 0, real(middle), real(0.0))

    @ti.func
    def log_row(
        reals: ti.template(), ints: ti.template(), j, i, swimmers: ti.template(), log: ti.template(), step, late
    ):
        slot = ti.cast(ti.atomic_add(swimmers.total[int(Total.LOGGED)], 1), ti.i32)
        room = slot < log.int.shape[0]
        if room:
            log.int[slot, int(LogInt.SWIMMER)] = i
            log.int[slot, int(LogInt.COLLOID)] = swimmers.int[int(Int.BOUND), i]
            for d in ti.static(range(3)):
                log.int[slot, int(LogInt.IMAGE) + d] = swimmers.int[int(Int.BOUND_IMAGE) + d, i]
            log.long[slot, int(LogLong.START)] = swimmers.long[int(Long.START), i]
            log.real[slot, columns.end_clock] = reals[rows.clock][j]
            if late:
                log.real[slot, columns.pitch_clock] = reals[rows.clock][j]
                log.long[slot, int(LogLong.END)] = ti.i64(-1)
                log.long[slot, int(LogLong.PITCH)] = step
            else:
                log.long[slot, int(LogLong.END)] = step
                write(reals, ints, j, i, swimmers, log, slot, step)
        return room

    return log_row
