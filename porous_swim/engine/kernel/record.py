"""The record of the encounter under way: the rows of `results.encounter_columns`, and how a step goes into them.

Values arrive by the names of their rows. A row for which no value comes, and a value for which there is no row, end
the compilation.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from collections.abc import Mapping
from functools import cache
from typing import Any

import taichi as ti

from porous_swim.engine.kernel.rows import rows_of
from porous_swim.physics.model import Model
from porous_swim.physics.rounding import rounded
from porous_swim.results.encounter_columns import AtRelease, Greatest, Least, Record, Sum, all_records, records


@ti.func
def add(reals: ti.template(), row: ti.template(), on, value):
    """Add `value` to a sum in the lanes `on`; the next row keeps what the rounding left (Kahan)."""
    total, rest = reals[row], reals[row + 1]
    y = value + rest
    t = rounded(total + y)
    reals[row] = ti.select(on, t, total)
    reals[row + 1] = ti.select(on, y - (t - total), rest)


def checked(values: Mapping[str, Any], *kinds: type[Record]) -> Mapping[str, Any]:
    """Return `values`; `ValueError` unless there is one for each row of these kinds, in 2-D or 3-D, and no other."""
    rows = {record.row for record in all_records() if isinstance(record, kinds)}
    names = " and ".join(kind.__name__ for kind in kinds)
    for row in sorted(rows - set(values)):
        raise ValueError(f"no value is recorded for the row {row!r} of the encounter columns: give it one in commit.py")
    for row in sorted(set(values) - rows):
        raise ValueError(f"a value is recorded for {row!r}, which is no row of kind {names} of the encounter columns")
    return values


@cache
def make_record(model: Model):
    """Return `gather(reals, on, values)`, `hold(reals, touched, values)` and `clear(reals, j)`.

    `gather` books a step of the lanes `on`, `hold` the last touch of the wall so far, and `clear` begins the record of
    lane j. `values` are wide values by the names of their rows.
    """
    rows, kept = rows_of(model), records(model.dimensions)
    starts = tuple((getattr(rows, row), record.start) for record in kept for row in record.rows)

    def pairs(values: Mapping[str, Any], kind: type[Record]) -> tuple[tuple[int, Any], ...]:
        return tuple((getattr(rows, record.row), values[record.row]) for record in kept if isinstance(record, kind))

    @ti.func
    def gather(reals: ti.template(), on, values: ti.template()):
        for row, value in ti.static(pairs(checked(values, Sum, Least, Greatest), Sum)):
            add(reals, row, on, value)
        for row, value in ti.static(pairs(values, Least)):
            reals[row] = ti.select(on, ti.min(value, reals[row]), reals[row])
        for row, value in ti.static(pairs(values, Greatest)):
            reals[row] = ti.select(on, ti.max(value, reals[row]), reals[row])

    @ti.func
    def hold(reals: ti.template(), touched, values: ti.template()):
        for row, value in ti.static(pairs(checked(values, AtRelease), AtRelease)):
            reals[row] = ti.select(touched, value, reals[row])

    @ti.func
    def clear(reals: ti.template(), j):
        for row, start in ti.static(starts):
            reals[row][j] = start

    return gather, hold, clear
