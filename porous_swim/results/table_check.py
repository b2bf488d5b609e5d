"""What the rows of a run's tables may hold: a range for each column, and an order."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa

from porous_swim.core.errors import ResultsError
from porous_swim.results.encounter_columns import COLUMNS, Kind
from porous_swim.results.tables import TableInfo

_ROUNDING = 1e-6  # of times and of unit vectors, some times that of single precision
LARGEST = 1e30  # of any number: its square is still one
_FARTHEST = 1e15  # a; of positions, further than any swimmer comes
_LARGEST_RADIUS, _MOST_IMAGES = 1e7, 2**30 + 1
_MAY_LACK = {("timeseries", "msd_standard_error")}  # of one swimmer there is none


@dataclass(frozen=True)
class Limits:
    """What the numbers of a run's tables lie between."""

    n_swimmers: int
    n_colloids: int
    first_time: float
    last_time: float
    wall: bool
    box: tuple[float, float, float]

    @classmethod
    def of(cls, info: TableInfo, colloids: pa.Table, path: Path) -> Limits:
        """From the information on the tables, and the colloids of the run."""
        number = colloids.column("colloid").to_numpy()
        if np.any(number != np.arange(len(number))):
            row = int(np.argmax(number != np.arange(len(number))))
            raise _wrong(path, "colloid", row, number[row], f"{row}: colloids are counted from 0")
        radius = colloids.column("radius").to_numpy()
        wall = len(radius) == 1 and bool(np.isinf(radius[0]))
        return cls(info.n_swimmers, len(number), info.first_time, info.last_time, wall, info.box)

    @property
    def slack(self) -> float:
        """What rounding may add to a time."""
        return _ROUNDING * max(abs(self.first_time), abs(self.last_time), 1.0)

    def of_column(self, table: str, column: str) -> tuple[float, float]:
        """The least and the largest that `column` may hold."""
        if table == "encounters":
            return self.of_kind(_ENCOUNTERS[column])
        if column in _KINDS:
            return self.of_kind(_KINDS[column])
        if column == "lag":
            return math.ulp(0.0), self.of_kind(Kind.DURATION)[1]
        if column == "radius":
            return math.ulp(0.0), math.inf if self.wall else _LARGEST_RADIUS
        whole = {"group": (0, self.n_swimmers - 1), "n_swimmers": (0, self.n_swimmers), "state": (0, 2)}
        if column in whole:
            return whole[column]
        if column.startswith("n_"):
            return 0, math.inf
        if column.startswith("fraction_"):
            return 0.0, 1.0
        if column in ("msd", "msd_standard_error", "fourth_moment"):
            return 0.0, LARGEST
        if table == "colloids" and self.box["xyz".index(column)] > 0.0:
            return 0.0, self.box["xyz".index(column)]
        return self.of_kind(Kind.PLACE if column in ("x", "y", "z") else Kind.NUMBER)

    def of_kind(self, kind: Kind) -> tuple[float, float]:
        """The least and the largest that a column of a kind may hold."""
        duration, slack = self.last_time - self.first_time, self.slack
        return {
            Kind.NUMBER: (-LARGEST, LARGEST),
            Kind.PLACE: (-_FARTHEST, _FARTHEST),
            Kind.TIME: (self.first_time - slack, self.last_time + slack),
            Kind.DURATION: (-slack, duration + slack),
            Kind.PITCH: (-0.5 * math.pi - _ROUNDING, 0.5 * math.pi + _ROUNDING),
            Kind.COMPONENT: (-1.0 - _ROUNDING, 1.0 + _ROUNDING),
            Kind.FLAG: (0, 1),
            Kind.SWIMMER: (0, self.n_swimmers - 1),
            Kind.COLLOID: (0 if self.n_colloids else -1, self.n_colloids - 1),
            Kind.IMAGE: (-_MOST_IMAGES, _MOST_IMAGES),
        }[kind]


_ENCOUNTERS = {column.name: column.kind for column in COLUMNS}
_KINDS = {  # of columns of the other tables
    "time": Kind.TIME, "swimmer": Kind.SWIMMER, "colloid": Kind.COLLOID,
    "image_x": Kind.IMAGE, "image_y": Kind.IMAGE, "image_z": Kind.IMAGE,
    "ex": Kind.COMPONENT, "ey": Kind.COMPONENT, "ez": Kind.COMPONENT, "director_correlation": Kind.COMPONENT,
}  # fmt: skip


def check_table(table: pa.Table, limits: Limits, path: Path) -> None:
    """Raise a `ResultsError` for the first number of `table` that is beyond its `limits`, or out of order."""
    name = path.stem
    for column in table.column_names:
        values = table.column(column)
        if values.null_count:
            values = values.drop_null()
        numbers = values.to_numpy()
        if numbers.dtype == bool or len(numbers) == 0:
            continue
        low, high = limits.of_column(name, column)
        with np.errstate(invalid="ignore"):
            good = (numbers.min() >= low) and (numbers.max() <= high)  # a NaN makes both comparisons fail
        if not good:
            bad = ~((numbers >= low) & (numbers <= high))
            if (name, column) in _MAY_LACK:
                bad &= ~np.isnan(numbers)
            if bad.any():
                row = int(np.argmax(bad))
                raise _wrong(path, column, row, numbers[row], f"{low:.6g} to {high:.6g}")
    order = _ORDERS.get(name)
    if order is not None and len(table):
        order(table, limits, path)


def _check_encounters(table: pa.Table, limits: Limits, path: Path) -> None:
    """Swimmer by swimmer, and of each one encounter after the other."""
    if not {"swimmer", "start_time", "end_time"} <= set(table.column_names):
        return
    swimmer, start, end = (table.column(column).to_numpy() for column in ("swimmer", "start_time", "end_time"))
    _check_rising(swimmer, path, "swimmer")
    early = end < start
    if early.any():
        row = int(np.argmax(early))
        raise _wrong(path, "end_time", row, end[row], f"at least the start_time of its row, {start[row]:.6g}")
    early = (swimmer[1:] == swimmer[:-1]) & (start[1:] < end[:-1] - limits.slack)
    if early.any():
        row = int(np.argmax(early)) + 1
        raise _wrong(
            path, "start_time", row, start[row], f"at least the end_time of the row before, {end[row - 1]:.6g}"
        )


def _check_series(table: pa.Table, limits: Limits, path: Path) -> None:
    _check_rising(table.column("time").to_numpy(), path, "time")


def _check_trajectory(table: pa.Table, limits: Limits, path: Path) -> None:
    _check_grid(table, "time", "swimmer", path)


def _check_lags(table: pa.Table, limits: Limits, path: Path) -> None:
    n_groups = _check_grid(table, "lag", "group", path)
    size = table.column("n_swimmers").to_numpy().reshape(-1, n_groups)
    wrong = (size.sum(axis=1) != limits.n_swimmers) | np.any(size != size[0], axis=1)
    if wrong.any():
        row = int(np.argmax(wrong)) * n_groups
        found = int(size[row // n_groups].sum())
        raise _wrong(path, "n_swimmers", row, found, f"{limits.n_swimmers} in all groups, of the same size at each lag")


_ORDERS = {
    "encounters": _check_encounters, "timeseries": _check_series, "trajectory": _check_trajectory, "lags": _check_lags,
}  # fmt: skip


def _check_grid(table: pa.Table, outer: str, inner: str, path: Path) -> int:
    """Rows must be a grid: for each value of `outer`, rising, the same ones of `inner`, rising. Return how many."""
    first, second = (table.column(column).to_numpy() for column in (outer, inner))
    _check_rising(first, path, outer)
    width = int(np.searchsorted(first, first[0], side="right"))
    whole = len(first) // width * width
    lines, members = first[:whole].reshape(-1, width), second[:whole].reshape(-1, width)
    wrong = np.any(members != members[0], axis=1) | (lines[:, 0] != lines[:, -1])
    wrong[1:] |= lines[1:, 0] == lines[:-1, 0]
    if wrong.any() or whole < len(first):
        row = int(np.argmax(wrong)) * width if wrong.any() else whole
        raise _wrong(path, inner, row, second[row], f"the same {width} for each {outer}, once each")
    _check_rising(members[0], path, inner)
    return width


def _check_rising(numbers: np.ndarray, path: Path, column: str) -> None:
    falls = numbers[1:] < numbers[:-1]
    if falls.any():
        row = int(np.argmax(falls)) + 1
        raise _wrong(path, column, row, numbers[row], f"at least {numbers[row - 1]:.6g}, that of the row before")


def _wrong(path: Path, column: str, row: int, found: Any, expected: str) -> ResultsError:
    shown = f"{found:.6g}" if isinstance(found, (float, np.floating)) else f"{found}"
    return ResultsError(
        f"{path}: column {column}, row {row}: found {shown}, expected {expected}; the file is damaged or of another run"
    )
