"""The files of a run, written one by one: what cannot be written is left out and named, and the rest is kept."""

from __future__ import annotations

import errno
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol, TypeVar

import pyarrow as pa

from porous_swim.core.console import tell
from porous_swim.core.errors import RunError
from porous_swim.results.encounter_table import ENCOUNTERS, ROWS
from porous_swim.results.manifest import RECORDING, TRAJECTORY_ROWS
from porous_swim.results.run_folder import RunFolder
from porous_swim.results.tables import PART

TRAJECTORY = "trajectory.parquet"
STATISTICS = "statistics"  # of the summary: no file, but they may fail as one
_FULL = {errno.ENOSPC, errno.EDQUOT}
_TABLE_SHARE = 0.4  # of the room that the log of encounters takes, their table takes at least so much
T = TypeVar("T")


class Droppable(Protocol):
    """What writes a file that a run can do without."""

    def drop(self) -> None:
        """Give the file up, and the room on the disk that it takes."""


class Outputs:
    """What a run writes into its folder, if it has one; `missing` says of what failed why."""

    def __init__(self, folder: RunFolder | None, *, say: bool) -> None:
        self._folder = folder
        self.say = say  # of each file that is lost while the run goes on
        self.missing: dict[str, str] = {}
        self.spare: Mapping[str, Droppable | None] = {}  # by file; the last goes first where the disk is full
        self._first: Exception | None = None

    def check_own(self) -> None:
        """Raise a RunError where another run has taken the folder, or someone took it away: nothing is written then."""
        if self._folder is not None and not self._folder.is_own:
            raise RunError(f"{self._folder.path}: this is no longer the folder of the run; nothing is written into it")

    @contextmanager
    def optional(self, name: str) -> Iterator[None]:
        """A block that writes a file the run can do without, of a `name`; where it fails, the file is lost."""
        try:
            yield
        except Exception as error:
            if self._folder is None or not name:
                raise
            self._lose(name, error)

    def put_table(self, name: str, table: pa.Table, *, required: bool = False) -> None:
        """Write a table."""
        folder = self._folder
        if folder is None:
            return

        def write() -> None:
            with writing(folder.path / f"{name}.parquet"):
                folder.write_table(name, table)

        if required:
            self.require(f"{name}.parquet", write, None)
        else:
            with self.optional(f"{name}.parquet"):
                write()

    def require(self, name: str, write: Callable[[], T], otherwise: T) -> T:
        """What `write` returns, which writes the file `name`; on a full disk recording and trajectory make room for it.

        Where all that does not help, the file is lost, and the result is `otherwise`.
        """
        while True:
            try:
                return write()
            except Exception as error:
                if self._folder is None:
                    raise
                spared = [
                    each for each, writer in self.spare.items() if writer is not None and each not in self.missing
                ]
                if not spared or not _is_full(error) or not self._may_fit():
                    self._lose(name, error)
                    return otherwise
                self._lose(spared[-1], RunError(f"{self._path(spared[-1])}: given up for {name}: the disk is full"))

    def tell_missing(self, summary: dict[str, Any]) -> dict[str, Any]:
        """A summary that says what is missing, if anything is: the run then has failed."""
        if not self.missing:
            return summary
        lost = [f"{name} could not be written and is missing. ({why})" for name, why in self.missing.items()]
        if ENCOUNTERS in self.missing:
            lost.append("Without encounters, the statistics of encounters, winding and hops mean nothing.")
        return summary | {"status": "failed", "missing": self.missing, "warnings": [*lost, *summary["warnings"]]}

    def complain(self) -> None:
        """Raise the first error, if there was one; as it is, where it is no fault of the disk."""
        if self._first is None:
            return
        if not isinstance(self._first, RunError | OSError | pa.ArrowException):
            raise self._first
        missing = ", ".join(self.missing)
        raise RunError(f"{self._first}; the rest of the run is kept, without {missing}") from self._first

    def _lose(self, name: str, error: Exception) -> None:
        self._first = self._first or error
        self.missing.setdefault(name, str(error) or type(error).__name__)
        writer = self.spare.get(name)
        if writer is not None:
            writer.drop()
        if self.say:
            tell(f"{error}; the run goes on without {name}", sys.stderr)

    def _may_fit(self) -> bool:
        """Whether the table of encounters may fit once recording and trajectory have made room for it."""
        try:
            need = _TABLE_SHARE * _size(self._path(ROWS))
            spare = [_size(self._path(name)) for name in (RECORDING + PART, TRAJECTORY_ROWS)]
            return shutil.disk_usage(self._path("")).free + sum(spare) >= need
        except OSError:
            return False

    def _path(self, name: str) -> Path:
        assert self._folder is not None
        return self._folder.path / name


@contextmanager
def writing(path: Path | None) -> Iterator[None]:
    """Say which file the disk has no room for."""
    try:
        yield
    except OSError as error:
        raise RunError(f"{path}: the tables cannot be written: {error.strerror or error}") from None


def _size(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0


def _is_full(error: BaseException | None) -> bool:
    """Whether an error began with a full disk."""
    while error is not None:
        if isinstance(error, OSError) and error.errno in _FULL:
            return True
        error = error.__cause__ or error.__context__
    return False
