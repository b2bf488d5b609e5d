"""Where the recorded swimmers were, as a table. Lengths in a, times in a/U; positions unwrapped."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

import numpy as np
import pyarrow as pa

from porous_swim.core.errors import RunError
from porous_swim.core.state import State
from porous_swim.observers.base import Frame, Observer, Schedule
from porous_swim.results.tables import PART, TRAJECTORY_SCHEMA, TableInfo, writer_of

_NAMES = ["time", "swimmer", "colloid", "image_x", "image_y", "image_z", "state"]  # columns of few values
_GROUP_ROWS = 1 << 17  # in a row group: 11 MB, large enough to compress, small enough to hold


class Trajectory(Observer):
    """A row per frame and swimmer of `swimmers` (ids), in that order; columns of `TRAJECTORY_SCHEMA`.

    With a `path` rows go to disk as they come, under the name with `.rows.part` appended until `table`;
    without one they stay in memory. `RunError` where the file cannot be written. Rows that are there already are
    overwritten, but by `restore`.
    """

    def __init__(self, schedule: Schedule, *, swimmers: np.ndarray, path: Path | str | None = None) -> None:
        self.schedule = schedule
        self._swimmers = np.asarray(swimmers, dtype=np.int32)
        self._path = None if path is None else Path(path)
        self._waiting: dict[str, list[np.ndarray]] = {}  # by column, an array for each frame
        self._n_waiting = 0
        self._batches: list[pa.RecordBatch] = []  # without a path
        self._writer: pa.ipc.RecordBatchStreamWriter | None = None
        self._n_written = 0  # rows in the file
        self._failed = False
        if self._path is not None:
            self._rows_path = self._path.with_name(self._path.name + ".rows" + PART)
            try:
                self._file = pa.OSFile(str(self._rows_path), "ab")
            except OSError as error:
                raise self._failure(error) from None

    def observe(self, frame: Frame) -> None:
        """Take in one frame; write a row group when it is full."""
        for name, values in _rows(frame, self._swimmers).items():
            self._waiting.setdefault(name, []).append(values)
        self._n_waiting += len(self._swimmers)
        if self._n_waiting >= _GROUP_ROWS:
            self._write()

    def keep(self) -> None:
        """Write the rows that wait: what is on disk outlives a run that is killed."""
        if not self._failed and self._path is not None:
            self._write()

    def drop(self) -> None:
        """Give the table up, and the room on the disk that it takes."""
        self._failed = True
        self._waiting, self._n_waiting = {}, 0
        if self._path is None:
            return
        with suppress(OSError, pa.ArrowException):
            self._close()
        for suffix in (".rows" + PART, PART):
            with suppress(OSError):
                self._path.with_name(self._path.name + suffix).unlink(missing_ok=True)

    def finish(self, *, interrupted: bool) -> None:
        """Write the rows that wait; an interrupted run keeps all rows up to its end."""
        if not self._failed:
            self._write()

    def state(self) -> dict[str, np.ndarray]:
        """The columns; with a path how many rows of the file count, which goes on where it is."""
        self._write()
        if self._path is not None:
            return {"n_written": np.array(self._n_written)}
        rows = pa.Table.from_batches(self._batches, schema=TRAJECTORY_SCHEMA)
        return {name: rows[name].to_numpy() for name in rows.column_names}

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such run, with a path in its file; RunError where that lacks rows."""
        if self._path is None:
            arrays = [pa.array(state[field.name], type=field.type) for field in TRAJECTORY_SCHEMA]
            self._batches = [pa.RecordBatch.from_arrays(arrays, schema=TRAJECTORY_SCHEMA)]
            return
        n_rows = int(state["n_written"])
        batches = _stored(self._rows_path, n_rows)
        n_found = sum(len(batch) for batch in batches)
        if n_found != n_rows:
            raise RunError(f"{self._rows_path}: expected {n_rows:,} rows of the trajectory, found {n_found:,}")
        self._append(batches)

    def table(self, info: TableInfo) -> pa.Table:
        """All rows, with `info` attached; with a path, close the file and give it its name. Call it once."""
        if self._path is None:
            self._write()
            return info.attach(pa.Table.from_batches(self._batches, schema=TRAJECTORY_SCHEMA))
        part = self._path.with_name(self._path.name + PART)
        try:
            self._append([])
            self._close()
            # the schema stands at the front of a file, and the time of the last row is known only now: copy
            with pa.OSFile(str(self._rows_path)) as file, pa.ipc.open_stream(file) as rows:
                table = info.attach(rows.read_all())
            with writer_of(part, table.schema, repeated=_NAMES) as complete:
                complete.write_table(table, row_group_size=_GROUP_ROWS)
            os.replace(part, self._path)
            self._rows_path.unlink()
            return table
        except (OSError, pa.ArrowException) as error:
            raise self._failure(error) from None

    def _write(self) -> None:
        if not self._waiting:
            return
        # pyarrow keeps references to arrays: concatenating made each its own
        arrays = [pa.array(np.concatenate(self._waiting[field.name]), type=field.type) for field in TRAJECTORY_SCHEMA]
        whole = pa.RecordBatch.from_arrays(arrays, schema=TRAJECTORY_SCHEMA)
        self._waiting, self._n_waiting = {}, 0
        if self._path is None:
            self._batches.append(whole)
        else:
            self._append([whole.slice(first, _GROUP_ROWS) for first in range(0, len(whole), _GROUP_ROWS)])

    def _append(self, batches: list[pa.RecordBatch]) -> None:
        """Write to the file; the first time from its beginning."""
        try:
            if self._writer is None:
                os.truncate(self._rows_path, 0)
                self._writer = pa.ipc.new_stream(self._file, TRAJECTORY_SCHEMA)  # cheap: it is read once
            for batch in batches:
                self._writer.write_batch(batch)
                self._n_written += len(batch)
        except OSError as error:
            raise self._failure(error) from None

    def _close(self) -> None:
        if self._writer is not None:
            self._writer.close()
        self._file.close()

    def _failure(self, error: Exception) -> RunError:
        self._failed = True
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        return RunError(f"{self._path}: the trajectory cannot be written: {reason}")


def _stored(path: Path, n_rows: int) -> list[pa.RecordBatch]:
    """The batches of a file of rows that hold its first `n_rows`, or all there are; its writer may have been killed."""
    batches: list[pa.RecordBatch] = []
    if n_rows:
        with suppress(StopIteration, pa.ArrowException), pa.ipc.open_stream(path.read_bytes()) as stored:
            while sum(len(batch) for batch in batches) < n_rows:
                batches.append(stored.read_next_batch())
    return batches


def _rows(frame: Frame, swimmers: np.ndarray) -> dict[str, np.ndarray]:
    columns: dict[str, np.ndarray] = {"time": np.full(len(swimmers), frame.time), "swimmer": swimmers}
    vectors = {"x y z": frame.position, "ex ey ez": frame.director, "image_x image_y image_z": frame.image}
    for names, array in vectors.items():
        columns.update(zip(names.split(), array[swimmers].T, strict=True))
    columns.update(colloid=frame.colloid[swimmers], state=frame.state[swimmers])
    return columns
