"""Tables from the device to the host. Taichi's own way takes the whole array, on a CPU some 15 ns for every number."""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
from functools import cache

import numpy as np
import taichi as ti
from taichi.lang.util import to_numpy_type

from porous_swim.engine import backend


@cache
def _make_copy(number):
    Table = ti.types.ndarray(number, ndim=2)

    @ti.kernel
    def copy(source: Table, target: Table):
        for i in range(target.shape[0]):
            for j in range(target.shape[1]):
                target[i, j] = source[i, j]

    return copy


def on_host(table, n_rows: int | None = None) -> np.ndarray:
    """A copy of the first `n_rows` rows, by default of all, of a table on the device."""
    if not backend.ensure_any().is_cpu:
        return np.asarray(table.to_numpy()[:n_rows])
    rows = np.empty((table.shape[0] if n_rows is None else n_rows, table.shape[1]), to_numpy_type(table.dtype))
    if rows.size > 0:
        _make_copy(table.dtype)(table, rows)
    return rows
