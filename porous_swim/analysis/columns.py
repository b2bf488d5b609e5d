"""Columns of a run's tables as numpy arrays."""

from __future__ import annotations

import numpy as np
import pyarrow as pa


def column(table: pa.Table, name: str) -> np.ndarray:
    """One column, (n_rows,); null in a real column is NaN."""
    return np.asarray(table.column(name).to_numpy())


def vectors(table: pa.Table, *names: str) -> np.ndarray:
    """Columns side by side, (n_rows, n_names)."""
    return np.stack([column(table, name) for name in names], axis=1)


def numbered(keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values that occur among integers (n,), increasing, and the number of each row's value among them, (n,).

    As np.unique with its inverse, but without sorting where the values are not much larger than their number.
    """
    if len(keys) == 0 or keys.min() < 0 or keys.max() >= 4 * len(keys):
        occurring, number = np.unique(keys, return_inverse=True)
        return occurring, number.reshape(-1)
    there = np.zeros(int(keys.max()) + 1, bool)
    there[keys] = True
    return np.flatnonzero(there), (np.cumsum(there) - 1)[keys]


def time_order(encounters: pa.Table) -> np.ndarray:
    """Rows, (n_rows,), swimmer by swimmer, each in order of time (the order of equal times is kept)."""
    start, swimmer = column(encounters, "start_time"), column(encounters, "swimmer")
    later = (swimmer[1:] > swimmer[:-1]) | ((swimmer[1:] == swimmer[:-1]) & (start[1:] >= start[:-1]))
    return np.arange(len(start)) if later.all() else np.lexsort((start, swimmer))  # as the tables of a run are
