"""Columns of a run's tables as numpy arrays, and what is said of tables that lack some."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec, TypeVar

import numpy as np
import pyarrow as pa

from porous_swim.core.errors import ResultsError

# what statistics of displacements and of directors need of a trajectory
PLACES = "time swimmer x y z"
DIRECTORS = "ex ey ez"

_Given = ParamSpec("_Given")
_Found = TypeVar("_Found")


def needs(**columns: str) -> Callable[[Callable[_Given, _Found]], Callable[_Given, _Found]]:
    """Have a function refuse tables that lack columns: by its parameters, the names of those that it reads.

    Tables are pyarrow tables, or what has their `schema` (`Encounters`). The function says what it needs, and of which
    table; `needs` of the function has the names.
    """
    wanted = {parameter: tuple(names.split()) for parameter, names in columns.items()}

    def checked(function: Callable[_Given, _Found]) -> Callable[_Given, _Found]:
        signature = inspect.signature(function)

        @wraps(function)
        def call(*args: _Given.args, **kwargs: _Given.kwargs) -> _Found:
            given = signature.bind(*args, **kwargs).arguments
            for parameter, names in wanted.items():
                optional = signature.parameters[parameter].default is None
                if parameter in given and not (optional and given[parameter] is None):
                    check_columns(given[parameter], names, of=f"{function.__name__}: {parameter}")
            return function(*args, **kwargs)

        call.needs = wanted  # type: ignore[attr-defined]
        return call

    return checked


def check_columns(table: Any, names: tuple[str, ...], *, of: str) -> None:
    """`ResultsError` about the argument `of` unless it is a table with numbers in these columns."""
    needed = f"needed are the columns {', '.join(names)}" if len(names) > 1 else f"needed is the column {names[0]}"
    schema = getattr(table, "schema", None)
    if not isinstance(schema, pa.Schema):
        raise ResultsError(f"{of}: found {type(table).__name__}, which is no pyarrow table; {needed}")
    lacking = [name for name in names if name not in schema.names]
    if lacking:
        raise ResultsError(f"{of}: the table lacks {', '.join(lacking)}; {needed}")
    for name in names:
        kind = schema.field(name).type
        if not (pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_boolean(kind)):
            raise ResultsError(f"{of}: found {kind} in the column {name}; {needed}, of numbers")


def column(table: pa.Table, name: str) -> np.ndarray:
    """One column, (n_rows,); null in a real column is NaN. `ResultsError` where there is none of that name."""
    if name not in table.schema.names:
        raise ResultsError(f"the table lacks the column {name}; it has {', '.join(table.schema.names)}")
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
