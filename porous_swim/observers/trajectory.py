"""Where the recorded swimmers were, as a table. Lengths in a, times in a/U; positions unwrapped."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

import numpy as np
import pyarrow as pa

from porous_swim.core.errors import RunError
from porous_swim.observers.base import Every, Frame
from porous_swim.results.tables import PART, TRAJECTORY_SCHEMA, TableInfo, writer_of

_NAMES = ["time", "swimmer", "colloid", "image_x", "image_y", "image_z", "state"]  # columns of few values
_GROUP_ROWS = 1 << 17  # in a row group: 11 MB, large enough to compress, small enough to hold


class Trajectory:
    """A row per frame and swimmer of `swimmers` (ids), in that order; columns of `TRAJECTORY_SCHEMA`.

    With a `path` rows go to disk as they come, under the name with `.rows.part` appended until `table`;
    without one they stay in memory. `RunError` where the file cannot be written.
    """

    def __init__(self, schedule: Every, *, swimmers: np.ndarray, path: Path | str | None = None) -> None:
        self.schedule = schedule
        self._swimmers = np.asarray(swimmers, dtype=np.int32)
        self._path = None if path is None else Path(path)
        self._waiting: dict[str, list[np.ndarray]] = {}  # by column, an array for each frame
        self._n_waiting = 0
        self._batches: list[pa.RecordBatch] = []  # without a path
        self._writer: pa.ipc.RecordBatchStreamWriter | None = None
        self._failed = False
        if self._path is not None:
            self._rows_path = self._path.with_name(self._path.name + ".rows" + PART)
            try:
                self._writer = pa.ipc.new_stream(self._rows_path, TRAJECTORY_SCHEMA)  # cheap: it is read once
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
        if not self._failed and self._writer is not None:
            self._write()

    def drop(self) -> None:
        """Give the table up, and the room on the disk that it takes."""
        self._failed = True
        self._waiting, self._n_waiting = {}, 0
        if self._path is None or self._writer is None:
            return
        with suppress(OSError, pa.ArrowException):
            self._writer.close()
        for suffix in (".rows" + PART, PART):
            with suppress(OSError):
                self._path.with_name(self._path.name + suffix).unlink(missing_ok=True)

    def finish(self, *, interrupted: bool) -> None:
        """Write the rows that wait; an interrupted run keeps all rows up to its end."""
        if not self._failed:
            self._write()

    def table(self, info: TableInfo) -> pa.Table:
        """All rows, with `info` attached; with a path, close the file and give it its name. Call it once."""
        if self._path is None:
            self._write()
            return info.attach(pa.Table.from_batches(self._batches, schema=TRAJECTORY_SCHEMA))
        assert self._writer is not None
        part = self._path.with_name(self._path.name + PART)
        try:
            self._writer.close()
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
        if self._writer is None:
            self._batches.append(whole)
            return
        try:
            for first in range(0, len(whole), _GROUP_ROWS):
                self._writer.write_batch(whole.slice(first, _GROUP_ROWS))
        except OSError as error:
            raise self._failure(error) from None

    def _failure(self, error: Exception) -> RunError:
        self._failed = True
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        return RunError(f"{self._path}: the trajectory cannot be written: {reason}")


def _rows(frame: Frame, swimmers: np.ndarray) -> dict[str, np.ndarray]:
    columns: dict[str, np.ndarray] = {"time": np.full(len(swimmers), frame.time), "swimmer": swimmers}
    vectors = {"x y z": frame.position, "ex ey ez": frame.director, "image_x image_y image_z": frame.image}
    for names, array in vectors.items():
        columns.update(zip(names.split(), array[swimmers].T, strict=True))
    columns.update(colloid=frame.colloid[swimmers], state=frame.state[swimmers])
    return columns
