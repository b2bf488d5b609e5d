"""Rows of the encounter log as they pile up on the host, on disk as soon as there are many; read swimmer by swimmer."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from porous_swim.core.errors import RunError
from porous_swim.core.state import State
from porous_swim.engine.kernel.device_log import N_LOG_INTS, LogInt, LogLong, log_columns

PIECE = 1 << 19  # rows that wait in memory before they go to disk: some 100 MB
SHELVES = 1024  # groups of consecutive swimmers, in the order of which a piece lies on disk
AT_ONCE = 1 << 18  # rows that become a part of the table, where no shelf has more


def row_type(dimensions: int, real: np.dtype | type) -> np.dtype:
    """A row of the log on the host; `censored` where the encounter was still under way."""
    return _row_type(log_columns(dimensions).n_real, real)


def _row_type(n_real: int, real: np.dtype | type) -> np.dtype:
    fields = [
        ("real", real, n_real), ("int", np.int32, N_LOG_INTS), ("long", np.int64, len(LogLong)), ("censored", bool)
    ]  # fmt: skip
    return np.dtype(fields, align=True)


class Spill:
    """Rows in pieces, each sorted by shelves; a piece is an array, or lies in the file at `path` from some byte on.

    Without a `path` everything stays in memory. `RunError` where the file cannot be written or read.
    """

    def __init__(
        self, n_swimmers: int, path: Path | None = None, *, piece: int = PIECE, at_once: int = AT_ONCE
    ) -> None:
        self._path, self._piece, self._at_once = path, piece, at_once
        self._edges = np.linspace(0, n_swimmers, min(SHELVES, n_swimmers) + 1).astype(np.int64)
        self._waiting: list[np.ndarray] = []
        self._n_waiting = 0
        self._pieces: list[np.ndarray | tuple[int, np.dtype]] = []
        self._bounds: list[np.ndarray] = []  # of each piece: where its shelves begin and end

    def add(self, rows: np.ndarray) -> None:
        """Take rows in any order."""
        self._waiting.append(rows)
        self._n_waiting += len(rows)
        if self._n_waiting >= self._piece:
            self._shelve()

    def parts(self, more: np.ndarray) -> Iterator[list[np.ndarray]]:
        """All rows and those of `more`, in parts that hold all rows of consecutive swimmers; not sorted within."""
        if not self._pieces and self._n_waiting + len(more) <= self._at_once:
            yield [*self._waiting, more]
            return
        self._shelve()
        order, bounds = self._sorted(more)
        more = more[order]
        n_rows = np.cumsum(np.sum([np.diff(own) for own in (*self._bounds, bounds)], axis=0))
        begin = 0
        while begin < len(n_rows):
            before = n_rows[begin - 1] if begin else 0
            end = max(begin + 1, int(np.searchsorted(n_rows, before + self._at_once, side="right")))
            own = [self._read(*piece, begin, end) for piece in zip(self._pieces, self._bounds, strict=True)]
            yield [*own, more[bounds[begin] : bounds[end]]]
            begin = end

    def close(self) -> None:
        """Remove the file."""
        if self._path is not None:
            self._path.unlink(missing_ok=True)

    def state(self) -> dict[str, np.ndarray]:
        """The fields of the rows in memory; of the rows on disk their places there: the file goes on where it is."""
        pieces = list(zip(self._pieces, self._bounds, strict=True))
        on_disk = [(piece, bounds) for piece, bounds in pieces if not isinstance(piece, np.ndarray)]
        rows = [piece for piece, _ in pieces if isinstance(piece, np.ndarray)] + self._waiting
        rows += [np.empty(0, dtype) for (_, dtype), _ in on_disk[:1]]
        if not rows:
            return {}
        fields = {name: np.concatenate([part[name] for part in rows]) for name in rows[0].dtype.names or ()}
        return fields | {
            "bytes": np.array([byte for (byte, _), _ in on_disk], dtype=np.int64),
            "bounds": np.array([bounds for _, bounds in on_disk], dtype=np.int64).reshape(-1, len(self._edges)),
        }

    def restore(self, state: State) -> None:
        """Go on from the `state` of another store; RunError where its file, if it had one, is not at the same path."""
        self._waiting, self._n_waiting, self._pieces, self._bounds = [], 0, [], []
        if not state:
            return
        dtype = _row_type(state["real"].shape[1], state["real"].dtype)
        self._bounds = list(state["bounds"].copy())
        self._pieces = [(byte, dtype) for byte in state["bytes"].tolist()]
        if self._pieces:
            self._cut(int(state["bytes"][-1]) + int(self._bounds[-1][-1]) * dtype.itemsize)
        rows = np.empty(len(state["real"]), dtype)
        for name in dtype.names or ():
            rows[name] = state[name]
        self.add(rows)

    def _cut(self, end: int) -> None:
        """Forget what was written to the file behind byte `end`."""
        there = self._path.stat().st_size if self._path is not None and self._path.exists() else 0
        if self._path is None or there < end:
            place = self._path or "encounters"
            raise RunError(f"{place}: expected {end:,} bytes of encounters on disk, found {there:,}")
        os.truncate(self._path, end)

    def _sorted(self, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """An order of rows by shelves, and where in it these begin and end."""
        swimmer = rows["int"][:, LogInt.SWIMMER]
        order = np.argsort(swimmer, kind="stable")
        return order, np.searchsorted(swimmer[order], self._edges)

    def _shelve(self) -> None:
        """Sort the rows that wait into one piece; it goes to disk where it is large, and stays where that fails."""
        if not self._waiting:
            return
        rows = np.concatenate(self._waiting)
        order, bounds = self._sorted(rows)
        rows = rows[order]
        self._pieces.append(rows)
        self._bounds.append(bounds)
        self._waiting, self._n_waiting = [], 0
        if self._path is not None and len(rows) >= self._piece:
            self._pieces[-1] = self._write(rows)

    def _write(self, rows: np.ndarray) -> tuple[int, np.dtype]:
        assert self._path is not None
        try:
            with self._path.open("ab") as file:
                byte = file.tell()
                file.write(rows.data)
        except OSError as error:
            raise self._failure("written", error) from None
        return byte, rows.dtype

    def _read(self, piece: np.ndarray | tuple[int, np.dtype], bounds: np.ndarray, begin: int, end: int) -> np.ndarray:
        """The rows of a piece on the shelves from `begin` up to `end`."""
        first, last = int(bounds[begin]), int(bounds[end])
        if isinstance(piece, np.ndarray):
            return piece[first:last]
        assert self._path is not None
        byte, dtype = piece
        try:
            rows = np.fromfile(self._path, dtype, last - first, offset=byte + first * dtype.itemsize)
        except OSError as error:
            raise self._failure("read", error) from None
        if len(rows) < last - first:
            raise RunError(f"{self._path}: the encounters cannot be read: the file was cut short")
        return rows

    def _failure(self, done: str, error: OSError) -> RunError:
        return RunError(f"{self._path}: the encounters cannot be {done}: {error.strerror or error}")
