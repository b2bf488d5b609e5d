"""The results of a run, the folder that keeps them, and how they are read back.

Reading needs neither Taichi nor a GPU.
"""

from __future__ import annotations

import itertools
import json
import os
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import pyarrow as pa

from porous_swim.encounters import ENCOUNTERS, ROWS, Encounters
from porous_swim.errors import ResultsError
from porous_swim.results_check import checked
from porous_swim.tables import PART, SCHEMAS, TableInfo, read_table, write_table

SUMMARY = "summary.json"
REPORT = "report"  # folder of the page that `porous-swim report` makes of a run
RUN_FILES = (
    SUMMARY,
    "scene.yaml",
    "recording.rrd",
    "checkpoint.npz",
    ROWS,
    *(f"{name}.parquet" for name in SCHEMAS),
)


@dataclass(frozen=True, repr=False)
class Results:
    """What a run leaves: its tables (pyarrow), its summary, and its folder (None: kept in memory)."""

    stored: Encounters
    """The encounters where they are: statistics take them as they take the table, in less memory."""
    colloids: pa.Table
    timeseries: pa.Table
    lags: pa.Table
    trajectory: pa.Table
    summary: dict[str, Any]
    folder: Path | None
    info: TableInfo
    scene: Mapping[str, Any] | None = None
    """What was run, as `Scene.from_mapping` takes it; None for results with a folder that were read: it is there."""

    def __repr__(self) -> str:
        """What they are of, in a line."""
        name, status = self.info.provenance.get("scene", "a run"), self.summary.get("status", "status not known")
        where = "in memory" if self.folder is None else f"in {self.folder}"
        return (
            f"<Results of {name}, {status}: {self.info.n_swimmers} swimmers, {self.info.duration:g} a/U, "
            f"{len(self.stored)} encounters, {where}>"
        )

    @cached_property
    def encounters(self) -> pa.Table:
        """The table of encounters, read into memory when it is first asked for: 260 bytes an encounter."""
        return self.stored.table()


def load_results(folder: Path | str) -> Results:
    """Read a run folder; `ResultsError` says what is missing or damaged."""
    folder = Path(folder)
    if not folder.is_dir():
        raise ResultsError(f"{folder}: there is no such run folder")
    summary = _read_summary(folder / SUMMARY)
    stored = Encounters.at(folder / ENCOUNTERS)
    others = {name: schema for name, schema in SCHEMAS.items() if name != "encounters"}
    tables = {name: read_table(folder / f"{name}.parquet", schema) for name, schema in others.items()}
    try:
        info = TableInfo.of(stored)
    except ResultsError as error:
        raise ResultsError(f"{folder / ENCOUNTERS}: {error}") from error
    return checked(Results(stored, **tables, summary=summary, folder=folder, info=info), folder)


def _read_summary(path: Path) -> dict[str, Any]:
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise ResultsError(
            f"{path.parent}: no {SUMMARY}, which a run writes last, so this is no run folder or its run died"
        ) from error
    except (OSError, ValueError, RecursionError) as error:
        raise ResultsError(f"{path}: cannot be read as JSON ({error})") from error
    if not isinstance(summary, dict):
        raise ResultsError(f"{path}: found a {type(summary).__name__} where a map belongs")
    return summary


@dataclass(frozen=True)
class RunFolder:
    """A folder that one run fills. `summary.json` comes last: without it the run is not finished."""

    path: Path

    @classmethod
    def next_free(cls, name: str, *, parent: Path | str = "runs") -> RunFolder:
        """Create `parent/name`, or `parent/name-2`, `parent/name-3`, ... where that exists."""
        for number in itertools.count(1):
            path = Path(parent) / (name if number == 1 else f"{name}-{number}")
            try:
                path.mkdir(parents=True)
            except FileExistsError:
                continue
            except OSError as error:
                raise ResultsError(f"{path}: cannot be created as a run folder ({error.strerror})") from error
            return cls(path)
        raise AssertionError("unreachable: numbers do not end")

    @classmethod
    def at(cls, path: Path | str, *, overwrite: bool = False) -> RunFolder:
        """Create `path` or take it where it is empty; `overwrite` removes an earlier run and its report."""
        path = Path(path)
        try:
            path.mkdir(parents=True, exist_ok=True)
            if not overwrite and any(path.iterdir()):
                raise ResultsError(f"{path}: the folder is not empty; overwrite it (--force) or name another")
            for name in RUN_FILES:  # the summary first: half an old run must not look finished
                (path / name).unlink(missing_ok=True)
                (path / (name + PART)).unlink(missing_ok=True)
            shutil.rmtree(path / REPORT, ignore_errors=True)  # it tells of the run that was there
        except OSError as error:
            raise ResultsError(f"{path}: cannot be used as a run folder ({error.strerror})") from error
        return cls(path)

    def write(self, results: Results) -> Results:
        """Write tables and summary, this last; return `results` with this folder in it."""
        stored = Encounters.written(results.stored.parts(), self.path / ENCOUNTERS)
        self.write_tables({name: getattr(results, name) for name in SCHEMAS if name != "encounters"})
        return self.write_summary(replace(results, stored=stored))

    def write_tables(self, tables: Mapping[str, pa.Table]) -> None:
        """Write tables by name."""
        for name, table in tables.items():
            write_table(table, self.path / f"{name}.parquet")

    def write_summary(self, results: Results) -> Results:
        """Write the summary, where all tables are there; return `results` with this folder in it."""
        part = self.path / (SUMMARY + PART)
        part.write_text(json.dumps(results.summary, indent=2, allow_nan=False) + "\n", encoding="utf-8")
        os.replace(part, self.path / SUMMARY)
        return replace(results, folder=self.path)
