"""The tables of a run, the folder that keeps them, and how they are read back.

Lengths in swimmer half-lengths a, times in a/U; every column carries its unit as field metadata.
Reading needs neither Taichi nor a GPU.
"""

from __future__ import annotations

import itertools
import json
import os
import shutil
from collections.abc import Collection, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from porous_swim.errors import ResultsError


def _columns(names: str, type_: pa.DataType, unit: str = "", *, nullable: bool = False) -> list[pa.Field]:
    metadata = {"unit": unit} if unit else None
    return [pa.field(name, type_, nullable=nullable, metadata=metadata) for name in names.split()]


_INDEX, _COUNT, _FLAG, _REAL = pa.int32(), pa.int64(), pa.bool_(), pa.float64()

# of a plane wall: a point of it, and an infinite radius; its normal is in scene.yaml
COLLOIDS_SCHEMA = pa.schema([*_columns("colloid", _INDEX), *_columns("x y z radius", _REAL, "a")])
ENCOUNTERS_SCHEMA = pa.schema(
    [
        *_columns("swimmer colloid image_x image_y image_z", _INDEX),
        *_columns("start_time end_time", _REAL, "a/U"),
        *_columns("start_censored end_censored", _FLAG),
        *_columns("contact_time", _REAL, "a/U"),
        *_columns("wall_push", _REAL, "a"),
        *_columns("winding", _REAL, "turns"),  # 0 at a plane wall, around which nobody winds
        *_columns("signed_winding", _REAL, "turns", nullable=True),  # null in three dimensions
        *_columns("entry_x entry_y entry_z exit_x exit_y exit_z", _REAL, "a"),  # unwrapped
        *_columns("entry_ex entry_ey entry_ez exit_ex exit_ey exit_ez", _REAL),
        *_columns("entry_pitch exit_pitch", _REAL, "rad"),
        *_columns("release_time", _REAL, "a/U", nullable=True),
        *_columns("release_pitch", _REAL, "rad", nullable=True),
        *_columns("release_winding", _REAL, "turns", nullable=True),
        *_columns("escape_pitch_time", _REAL, "a/U", nullable=True),  # on the clock of start_time
        *_columns("min_height mean_height max_height", _REAL, "a"),
    ]
)
TIMESERIES_SCHEMA = pa.schema(
    [
        *_columns("time", _REAL, "a/U"),
        *_columns("fraction_bound fraction_contact", _REAL),
        *_columns("n_captures n_escapes n_hops n_returns", _COUNT),
        *_columns("msd msd_standard_error", _REAL, "a^2"),  # from the start, over all swimmers
    ]
)
LAGS_SCHEMA = pa.schema(  # a row for each lag and group of swimmers; means over the group and its windows in time
    [
        *_columns("lag", _REAL, "a/U"),
        *_columns("group n_swimmers", _INDEX),
        *_columns("n_windows", _COUNT),
        *_columns("msd", _REAL, "a^2"),
        *_columns("fourth_moment", _REAL, "a^4"),  # mean fourth power of the displacement
        *_columns("director_correlation", _REAL),
    ]
)
TRAJECTORY_SCHEMA = pa.schema(
    [
        *_columns("time", _REAL, "a/U"),
        *_columns("swimmer", _INDEX),
        *_columns("x y z", _REAL, "a"),  # unwrapped
        *_columns("ex ey ez", _REAL),
        *_columns("colloid image_x image_y image_z", _INDEX),  # the nearest; colloid -1 where there is none
        *_columns("state", pa.uint8()),  # 0 free, 1 bound, 2 contact
    ]
)
SCHEMAS = {
    "encounters": ENCOUNTERS_SCHEMA,
    "colloids": COLLOIDS_SCHEMA,
    "timeseries": TIMESERIES_SCHEMA,
    "lags": LAGS_SCHEMA,
    "trajectory": TRAJECTORY_SCHEMA,
}
SUMMARY = "summary.json"
REPORT = "report"  # folder of the page that `porous-swim report` makes of a run
RUN_FILES = (
    SUMMARY,
    "scene.yaml",
    "recording.rrd",
    "checkpoint.npz",
    *(f"{name}.parquet" for name in SCHEMAS),
)
_INFO_KEY = b"porous_swim"
_PART = ".part"  # suffix of a file that is still being written


@dataclass(frozen=True)
class TableInfo:
    """What holds for all rows of a run's tables."""

    n_swimmers: int
    dimensions: int
    box: tuple[float, float, float]  # a; 0 along an axis that does not repeat
    first_time: float  # a/U
    last_time: float  # a/U
    time_step: float  # a/U
    units: dict[str, Any] | None  # what a and U are, where the scene says so
    provenance: dict[str, Any]

    @property
    def duration(self) -> float:
        """Time that the tables cover, in a/U."""
        return self.last_time - self.first_time

    @classmethod
    def of(cls, table: pa.Table) -> TableInfo:
        """The information attached to `table`; `ResultsError` where there is none."""
        try:
            stored = json.loads((table.schema.metadata or {})[_INFO_KEY])
            return cls(**{**stored, "box": tuple(stored["box"])})
        except (KeyError, TypeError, ValueError) as error:
            raise ResultsError(
                "a table without the metadata of a porous_swim run: use the tables of a Results, "
                "or TableInfo.attach on your own"
            ) from error

    def attach(self, table: pa.Table) -> pa.Table:
        """`table` with this information in its schema's metadata."""
        stored = json.dumps(asdict(self), allow_nan=False).encode()
        return table.replace_schema_metadata({**(table.schema.metadata or {}), _INFO_KEY: stored})


def make_table(schema: pa.Schema, columns: Mapping[str, np.ndarray], *, info: TableInfo) -> pa.Table:
    """A table of a schema from arrays of one length; NaN in a nullable column becomes null."""
    arrays = [
        pa.array(np.asarray(columns[field.name]), type=field.type, from_pandas=field.nullable) for field in schema
    ]
    return info.attach(pa.Table.from_arrays(arrays, schema=schema))


def write_table(table: pa.Table, path: Path | str) -> None:
    """Write `table` as Parquet; `path` appears only when it is complete."""
    path = Path(path)
    part = path.with_name(path.name + _PART)
    # numbers that are hardly ever equal make a dictionary as large as themselves
    repeated = [field.name for field in table.schema if not pa.types.is_floating(field.type)]
    pq.write_table(table, part, compression="zstd", use_dictionary=repeated)
    os.replace(part, path)


@dataclass(frozen=True)
class Results:
    """What a run leaves: its tables (pyarrow), its summary, and its folder (None: kept in memory)."""

    encounters: pa.Table
    colloids: pa.Table
    timeseries: pa.Table
    lags: pa.Table
    trajectory: pa.Table
    summary: dict[str, Any]
    folder: Path | None
    info: TableInfo


def load_results(folder: Path | str) -> Results:
    """Read a run folder; `ResultsError` says what is missing or damaged."""
    folder = Path(folder)
    if not folder.is_dir():
        raise ResultsError(f"{folder}: there is no such run folder")
    summary = _read_summary(folder / SUMMARY)
    tables = {name: _read_table(folder / f"{name}.parquet", schema) for name, schema in SCHEMAS.items()}
    try:
        info = TableInfo.of(tables["encounters"])
    except ResultsError as error:
        raise ResultsError(f"{folder / 'encounters.parquet'}: {error}") from error
    return Results(**tables, summary=summary, folder=folder, info=info)


def _read_summary(path: Path) -> dict[str, Any]:
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise ResultsError(
            f"{path.parent}: no {SUMMARY}, which a run writes last, so this is no run folder or its run died"
        ) from error
    except (OSError, ValueError) as error:
        raise ResultsError(f"{path}: cannot be read as JSON ({error})") from error
    if not isinstance(summary, dict):
        raise ResultsError(f"{path}: found a {type(summary).__name__} where a map belongs")
    return summary


def _read_table(path: Path, schema: pa.Schema) -> pa.Table:
    try:
        table = pq.read_table(path, partitioning=None)
    except FileNotFoundError as error:
        raise ResultsError(f"{path}: the table is missing") from error
    except (OSError, pa.ArrowException) as error:
        raise ResultsError(f"{path}: the table is damaged ({str(error).splitlines()[0]})") from error
    if not table.schema.equals(schema):
        lacking = sorted(set(schema.names) - set(table.schema.names))
        found = f"lacks {', '.join(lacking)}" if lacking else "has other column types"
        raise ResultsError(f"{path}: the table {found} and is not one that this version wrote")
    return table


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
                (path / (name + _PART)).unlink(missing_ok=True)
            shutil.rmtree(path / REPORT, ignore_errors=True)  # it tells of the run that was there
        except OSError as error:
            raise ResultsError(f"{path}: cannot be used as a run folder ({error.strerror})") from error
        return cls(path)

    def write(self, results: Results, *, there: Collection[str] = ()) -> Results:
        """Write tables, but those that are `there`, and summary, this last; return `results` with this folder in it."""
        for name in (name for name in SCHEMAS if name not in there):
            write_table(getattr(results, name), self.path / f"{name}.parquet")
        part = self.path / (SUMMARY + _PART)
        part.write_text(json.dumps(results.summary, indent=2, allow_nan=False) + "\n", encoding="utf-8")
        os.replace(part, self.path / SUMMARY)
        return replace(results, folder=self.path)
