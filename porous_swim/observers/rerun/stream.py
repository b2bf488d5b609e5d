"""A Rerun file that is complete or says why not.

The SDK hides three failures (0.41): bad arguments are warnings unless strict, a full disk shows only at a
flush, and a missing footer only at reading. Here each is an error, and the file has its name only when it is
whole.
"""

from __future__ import annotations

import ctypes
import os
import warnings
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb
from rerun.chunk import RrdReader

from porous_swim.core.errors import RunError
from porous_swim.observers.base import Frame
from porous_swim.observers.rerun.timeline import TimeLine

APPLICATION = "porous_swim"
# a flush of a few MB on a slow disk; without a limit it may wait for ever for a writer that met a full disk
_FLUSH_SECONDS = 30.0
BATCH_ROWS = 256  # of a series: a row on its own costs a kilobyte


class Moments:
    """When the rows of a batch were seen."""

    def __init__(self) -> None:
        self.steps: list[int] = []
        self.times: list[float] = []

    def __len__(self) -> int:
        """Number of rows."""
        return len(self.steps)

    def add(self, frame: Frame) -> None:
        """One more row, at `frame`."""
        self.steps.append(frame.step)
        self.times.append(frame.time)


class RecordingFile:
    """One .rrd file in the making, under the name with `.part` appended until it is closed."""

    def __init__(self, path: Path | str, *, recording_id: str, timeline: TimeLine) -> None:
        self.path, self._timeline = Path(path), timeline
        self._part = self.path.with_name(self.path.name + ".part")
        rr.set_strict_mode(True)
        # without properties and log time there is no wall clock in the file: equal runs give equal contents
        # and without flushes by the clock, equal chunks
        self.stream = rr.RecordingStream(
            APPLICATION,
            recording_id=recording_id,
            send_properties=False,
            batcher_config=rr.ChunkBatcherConfig.NEVER(),
        )
        try:
            self.stream.save(self._part)
        except RuntimeError as error:
            raise RunError(f"{self._part}: the recording cannot be written here: {_reason(error)}") from None
        self.stream.set_log_time_enabled(False)

    def lay_out(self, blueprint: rrb.Blueprint) -> None:
        """Set the layout in which the file opens, in place of an earlier one, and make it the one on show.

        A layout that is only the default is passed over by the viewer in a browser, which makes one of its own.

        Not as an argument of `save`, which waits without a limit until it is written: for ever where the disk is full.
        """
        self.stream.send_blueprint(blueprint, make_active=True)

    def describe(self, name: str, provenance: Mapping[str, object]) -> None:
        """Store the recording's name and its provenance, a flat map of texts and numbers."""
        self.stream.send_recording_name(name)
        plain = int | float | str
        texts = {key: value if isinstance(value, plain) else str(value) for key, value in provenance.items()}
        self.stream.send_property("provenance", rr.AnyValues(drop_untyped_nones=True, **texts))

    def log(self, entity: str, *archetypes: rr.AsComponents) -> None:
        """Log what holds at all times."""
        self.stream.log(entity, *archetypes, static=True)

    def log_at(self, entity: str, *archetypes: rr.AsComponents, step: int, time: float) -> None:
        """Log one thing at one moment. Costs about 1 kB of file: for rare things."""
        self._timeline.set(self.stream, step=step, time=time)
        self.stream.log(entity, *archetypes)
        self.stream.reset_time()

    def send(self, entity: str, columns: rr.ComponentColumnList, moments: Moments) -> None:
        """Send one row per moment. The SDK keeps references: hand over arrays that nothing will change."""
        self.stream.send_columns(entity, self._timeline.columns(moments.steps, moments.times), columns)

    def flush(self) -> None:
        """Wait until all that was sent is on disk; `RunError` where it cannot be."""
        try:
            self.stream.flush(timeout_sec=_FLUSH_SECONDS)
        except (RuntimeError, TimeoutError) as error:
            self._abandon()
            raise RunError(f"{self._part}: the recording stopped, is the disk full? ({_reason(error)})") from None

    def _abandon(self) -> None:
        # At exit, and when the stream is freed, the SDK flushes once more without a limit and may never
        # return (seen for one full disk in ten): keep it from both.
        rr.unregister_shutdown()
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(self.stream))

    def drop(self) -> None:
        """Give the file up, and its room first: the SDK may hold it open until the process ends."""
        self._abandon()
        with suppress(OSError):
            os.truncate(self._part, 0)
            self._part.unlink()

    def close(self) -> None:
        """Write the footer, check that it can be read, and give the file its name."""
        self.flush()
        self.stream.disconnect()
        try:
            with warnings.catch_warnings(action="ignore", category=rr.error_utils.RerunWarning):  # it ends in an error
                RrdReader(self._part).store()
        except (RuntimeError, ValueError, OSError) as error:
            raise RunError(f"{self._part}: the recording is cut short, is the disk full? ({_reason(error)})") from None
        os.replace(self._part, self.path)


def _reason(error: Exception) -> str:
    return str(error).splitlines()[0] if str(error) else type(error).__name__
