"""The folder that one run fills: locked while the run lives. Nothing in it is deleted but a run's own files."""

from __future__ import annotations

import itertools
import json
import os
import uuid
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import replace
from pathlib import Path

import pyarrow as pa

from porous_swim.core.errors import ResultsError
from porous_swim.core.paths import absolute
from porous_swim.results.encounter_table import ENCOUNTERS, Encounters
from porous_swim.results.manifest import (
    RUN_FILES,
    SCRATCH,
    SUMMARY,
    lock_content,
    own_files,
    records_of,
    report_files,
)
from porous_swim.results.results import Results
from porous_swim.results.run_lock import LOCK, RunLock
from porous_swim.results.tables import PART, SCHEMAS, write_table

SUMMARY_PART = SUMMARY + PART
_RESERVE = 1 << 16  # bytes kept for the summary, so that a full disk has room for it


class RunFolder:
    """A folder that one run fills, and its lock. `summary.json` comes last: without it the run is not finished."""

    def __init__(self, path: Path, lock: RunLock) -> None:
        """Take the folder of a lock; see `next_free` and `at`."""
        self.path, self.run_id = path, uuid.uuid4().hex
        self._lock, self._names = lock, {*RUN_FILES, *SCRATCH}
        self._ended = False

    @classmethod
    def next_free(cls, name: str, *, parent: Path | str = "runs") -> RunFolder:
        """Create `parent/name`, or `parent/name-2`, `parent/name-3`, ... where that exists."""
        for number in itertools.count(1):
            path = absolute(Path(parent) / (name if number == 1 else f"{name}-{number}"))
            try:
                path.mkdir(parents=True)
            except FileExistsError:
                continue
            except OSError as error:
                raise ResultsError(f"{path}: cannot be created as a run folder ({error.strerror})") from error
            return cls.at(path)
        raise AssertionError("unreachable: numbers do not end")

    @classmethod
    def at(
        cls, path: Path | str, *, overwrite: bool = False, inputs: Iterable[Path] = (), hint: str = "overwrite=True",
        say: Callable[[str], None] | None = None,
    ) -> RunFolder:  # fmt: skip
        """Create `path` or take it where it is empty; `overwrite` takes the place of an earlier run and its report.

        Only files that the earlier run lists as its own are deleted; `say` gets their names before. `inputs` are the
        files that the run reads; `hint` is how users ask for `overwrite`.

        Raises:
            ResultsError: a run is under way there, the folder holds something else, or it cannot be written.
        """
        path = absolute(path)
        try:
            path.mkdir(parents=True, exist_ok=True)
            lock = RunLock(path)
        except OSError as error:
            raise ResultsError(f"{path}: cannot be used as a run folder ({error.strerror})") from error
        folder = cls(path, lock)
        try:
            folder._clear(overwrite, inputs, hint, say)
        except OSError as error:
            lock.release(remove=lock.made)
            raise ResultsError(f"{path}: cannot be used as a run folder ({error.strerror})") from error
        except BaseException:
            lock.release(remove=lock.made)
            raise
        return folder

    def __enter__(self) -> RunFolder:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def locks(self) -> bool:
        """Whether the file system keeps other runs out."""
        return self._lock.works

    @property
    def is_own(self) -> bool:
        """Whether the folder is still that of this run: not gone, and not another's who took it all the same.

        A lock that someone has deleted is no reason to lose a run.
        """
        ended = (self.path / SUMMARY).exists()
        return self.path.is_dir() and not ended and self._lock.content().get("run_id", self.run_id) == self.run_id

    def claim(self, names: Iterable[str]) -> None:
        """Name files that this run is about to write besides those that every run writes."""
        self._names |= set(names)
        self._lock.write(**lock_content(self.run_id, self._names))

    def write(self, results: Results) -> Results:
        """Write tables and summary, this last; return `results` with this folder in it."""
        stored = Encounters.written(results.stored.parts(), self.path / ENCOUNTERS)
        for name in SCHEMAS:
            if name != "encounters":
                self.write_table(name, getattr(results, name))
        return self.write_summary(replace(results, stored=stored))

    def write_table(self, name: str, table: pa.Table) -> None:
        """Write one table."""
        write_table(table, self.path / f"{name}.parquet")

    def write_summary(self, results: Results) -> Results:
        """Write the summary, with the list of the files that are there; the run then has ended, and the lock goes.

        Return `results` with that summary and this folder in it.
        """
        summary = {**results.summary, "files": records_of(self.path, self._names - {SUMMARY, *SCRATCH})}
        text = json.dumps(summary, indent=2, allow_nan=False) + "\n"
        self._write_whole(text.encode())
        self._ended = True
        self.close()
        return replace(results, summary=summary, folder=self.path)

    def close(self) -> None:
        """Let go of the folder. The list of a run that wrote no summary stays."""
        self._lock.release(remove=self._ended)

    def _write_whole(self, content: bytes) -> None:
        """Write the summary in the place that was kept for it, and give it its name when it is on disk."""
        part = self.path / SUMMARY_PART
        with part.open("r+b" if part.exists() else "wb") as file:
            file.write(content)
            file.truncate()
            file.flush()
            os.fsync(file.fileno())
        os.replace(part, self.path / SUMMARY)

    def _clear(self, overwrite: bool, inputs: Iterable[Path], hint: str, say: Callable[[str], None] | None) -> None:
        """Delete an earlier run, where that is asked for and allowed, and list what this one may write."""
        there = {entry.name for entry in self.path.iterdir()} - ({LOCK} if self._lock.made else set())
        nothing_yet = there <= {LOCK, SUMMARY_PART}  # of a run that died before it wrote anything
        own = own_files(self.path, self._lock.before)
        if there and not (nothing_yet and own is not None):
            if not overwrite:
                raise ResultsError(
                    f"{self.path}: the folder is not empty; name another, or replace a run in it with {hint}"
                )
            if own is None:
                raise ResultsError(
                    f"{self.path}: nothing in this folder says that it holds a run of this program, so nothing in it "
                    "is deleted; name another folder"
                )
        self._refuse_inputs(inputs)
        self._refuse_strangers(there - (own or set()))
        doomed = [*report_files(self.path), *(self.path / name for name in sorted((own or set()) - {LOCK}))]
        if doomed and not nothing_yet and say is not None:
            names = ", ".join(str(path.relative_to(self.path)) for path in doomed)
            say(f"{self.path}: replacing the run in this folder: deleting {names}")
        self._names |= own or set()
        self.claim(())  # before anything is deleted: whatever happens, the folder says whose it is
        (self.path / SUMMARY).unlink(missing_ok=True)  # first: half an old run must not look finished
        for path in doomed:
            path.unlink(missing_ok=True)
        parents = {path.parent for path in doomed} - {self.path}
        for inner_first in sorted(parents, key=lambda path: len(path.parts), reverse=True):
            with suppress(OSError):  # the user's own files are in it
                inner_first.rmdir()
        self._names = {*RUN_FILES, *SCRATCH}
        self.claim(())
        self._keep_room()

    def _keep_room(self) -> None:
        try:
            (self.path / SUMMARY_PART).write_bytes(b" " * _RESERVE)
        except OSError:
            (self.path / SUMMARY_PART).unlink(missing_ok=True)
            raise

    def _refuse_inputs(self, inputs: Iterable[Path]) -> None:
        """No input lies in the folder."""
        for path in inputs:
            places = absolute(path), path.resolve()  # a link may lie here, and what it names
            if any(place.is_relative_to(folder) for place in places for folder in (self.path, self.path.resolve())):
                raise ResultsError(f"{self.path}: {path}, which this run reads, lies in this folder; name another")

    def _refuse_strangers(self, names: set[str]) -> None:
        """No file that is not of an earlier run has a name that a run writes."""
        taken = sorted(names & {*RUN_FILES, *SCRATCH} - {LOCK})
        if taken:
            raise ResultsError(
                f"{self.path}: {taken[0]} is not of the run in this folder and would be overwritten; move it, or name "
                "another folder"
            )
