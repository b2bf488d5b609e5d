"""The files of a run folder: which are a run's own, and whether they are those that it wrote.

A run that is under way, or died, lists the names that it may write in its lock. One that ended lists in `summary.json`
what it wrote, `files`: each with its size in bytes and its CRC-32, tables with their number of rows. Only files in such
lists are ever deleted.
"""

from __future__ import annotations

import json
import zlib
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from porous_swim.core.errors import ResultsError
from porous_swim.results.encounter_table import ROWS
from porous_swim.results.run_lock import LOCK
from porous_swim.results.tables import PART, SCHEMAS, TableInfo

SUMMARY = "summary.json"
RECORDING = "recording.rrd"
SCENE = "scene.yaml"
TABLES = tuple(f"{name}.parquet" for name in SCHEMAS)
TRAJECTORY_ROWS = "trajectory.parquet.rows" + PART
RUN_FILES = (SUMMARY, SCENE, RECORDING, *TABLES)
SCRATCH = (LOCK, ROWS, TRAJECTORY_ROWS, *(name + PART for name in RUN_FILES))
RUN_NAMES = frozenset(name.casefold() for name in (*RUN_FILES, *SCRATCH))  # no input is copied to these

REPORTS = ("report", "comparison")  # folders of the pages that `porous-swim report` makes of a run
FIGURES = "figures"
REPORT_LIST = "files.json"
_MARK = "porous_swim"
_BLOCK = 1 << 22


@dataclass(frozen=True)
class Record:
    """What a summary says of a file."""

    bytes: int
    crc32: str
    rows: int | None = None

    @classmethod
    def of(cls, path: Path) -> Record:
        """That of a file as it is."""
        rows = pq.read_metadata(path).num_rows if path.name in TABLES else None
        return cls(path.stat().st_size, _crc32(path), rows)

    def as_dict(self) -> dict[str, Any]:
        """As it stands in a summary."""
        return {name: value for name, value in vars(self).items() if value is not None}


def records_of(folder: Path, names: Iterable[str]) -> dict[str, Any]:
    """`files` of a summary: those of `names` that are there."""
    return {name: Record.of(folder / name).as_dict() for name in sorted(names) if (folder / name).is_file()}


@dataclass(frozen=True)
class Manifest:
    """What the summary of a run says of its files."""

    folder: Path
    run_id: Any
    files: Mapping[str, Record]
    missing: Mapping[str, str]
    """Names of files that could not be written, and why."""

    @classmethod
    def of(cls, summary: Mapping[str, Any], folder: Path) -> Manifest:
        """That of the summary in `folder`; ResultsError where it is damaged."""
        provenance, missing = summary.get("provenance"), summary.get("missing", {})
        run_id = provenance.get("run_id") if isinstance(provenance, dict) else None
        try:
            files = {name: Record(**record) for name, record in summary.get("files", {}).items()}
            sound = all(_sound(record) for record in files.values())
            sound = sound and all(isinstance(reason, str) for reason in missing.values())
        except (AttributeError, TypeError):
            sound = False
        if not sound:
            raise ResultsError(f"{folder / SUMMARY}: its list of files is damaged")
        return cls(folder, run_id, files, missing)

    def check(self, name: str, *, whole: bool) -> None:
        """Compare a file with what is said of it: its size, and with `whole` its checksum. ResultsError."""
        path, record = self.folder / name, self.files.get(name)
        what = "table" if name in TABLES else "file"
        if record is None:
            return
        try:
            same = path.stat().st_size == record.bytes and (not whole or _crc32(path) == record.crc32)
        except FileNotFoundError:
            raise ResultsError(f"{path}: the {what} is missing") from None
        except OSError as error:
            raise ResultsError(f"{path}: the {what} cannot be read ({error.strerror})") from error
        if not same:
            info = _info(path)
            if info is not None:
                self.check_run(name, info)
            raise ResultsError(f"{path}: the {what} is damaged: its contents are not those that its run wrote")

    def check_run(self, name: str, info: TableInfo) -> None:
        """Raise a ResultsError where a table is of another run."""
        found = info.provenance.get("run_id") if isinstance(info.provenance, dict) else None
        if found != self.run_id:
            raise ResultsError(f"{self.folder / name}: the table is of another run than {SUMMARY} beside it")

    def check_rows(self, name: str, n: int) -> None:
        """Raise a ResultsError where a table has not as many rows as its run wrote."""
        record = self.files.get(name)
        if record is not None and record.rows is not None and record.rows != n:
            raise ResultsError(f"{self.folder / name}: the table has {n:,} rows, and its run wrote {record.rows:,}")


def _info(path: Path) -> TableInfo | None:
    """What a table says of itself, if it does: it may be damaged."""
    try:
        return TableInfo.of(pq.read_schema(path).empty_table())
    except (OSError, ValueError, pa.ArrowException):
        return None


def own_files(folder: Path, lock: Mapping[str, Any] | None) -> set[str] | None:
    """Names of the files in a folder that its own lists say are a run's; None where nothing says that it is a run's.

    `lock` is what the lock of an earlier run says.
    """
    lists = [lock.get("files")] if lock is not None and lock.get("program") == _MARK else []
    with suppress(OSError, ValueError, RecursionError, TypeError, KeyError):
        summary = json.loads((folder / SUMMARY).read_bytes())
        if "run_id" in summary["provenance"]:
            lists.append([SUMMARY, *summary["files"]])
    with suppress(TypeError, KeyError):
        names = {name for each in lists for name in each or ()}
        return {name for name in names if _is_plain(name) and _is_there(folder / name)} if lists else None
    return None


def lock_content(run_id: str, names: Iterable[str]) -> dict[str, Any]:
    """What the lock of a run says besides who holds it."""
    return {"program": _MARK, "run_id": run_id, "files": sorted(names)}


def list_report(folder: Path, names: Iterable[str]) -> None:
    """Write the list of the files of a report, by their paths in its `folder`."""
    (folder / REPORT_LIST).write_text(json.dumps({"program": _MARK, "files": sorted(names)}) + "\n", encoding="utf-8")


def report_files(folder: Path) -> list[Path]:
    """The files of the reports in a run folder, as their own lists name them, the list last."""
    found: list[Path] = []
    for report in (folder / name for name in REPORTS):
        with suppress(OSError, ValueError, RecursionError, AttributeError, TypeError):
            listed = json.loads((report / REPORT_LIST).read_bytes())
            if listed.get("program") == _MARK and not report.is_symlink():
                names = [name for name in listed["files"] if _is_plain(name.removeprefix(f"{FIGURES}/"))]
                found += [report / name for name in (*names, REPORT_LIST) if _is_there(report / name)]
    return found


def _is_plain(name: Any) -> bool:
    """Whether it names a file in the folder itself: lists may have been changed."""
    return isinstance(name, str) and name not in ("", ".", "..") and not {"/", "\\", "\0"} & set(name)


def _is_there(path: Path) -> bool:
    return path.is_symlink() or path.is_file()


def _sound(record: Record) -> bool:
    return isinstance(record.bytes, int) and isinstance(record.crc32, str) and isinstance(record.rows, int | None)


def _crc32(path: Path) -> str:
    """Checksum of a file: some GB a second, so that it costs less than reading a table."""
    value = 0
    with path.open("rb") as file:
        while block := file.read(_BLOCK):
            value = zlib.crc32(block, value)
    return f"{value:08x}"
