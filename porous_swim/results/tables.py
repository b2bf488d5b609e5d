"""The tables of a run: their columns, what holds for all their rows, how they are written and read.

Lengths in swimmer half-lengths a, times in a/U; every column carries its unit as field metadata.
Reading needs neither Taichi nor a GPU.
"""

from __future__ import annotations

import json
import math
import os
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from porous_swim.core.errors import ResultsError
from porous_swim.results.encounter_columns import COLUMNS, Kind


def _columns(names: str, type_: pa.DataType, unit: str = "", *, nullable: bool = False) -> list[pa.Field]:
    metadata = {"unit": unit} if unit else None
    return [pa.field(name, type_, nullable=nullable, metadata=metadata) for name in names.split()]


_INDEX, _COUNT, _FLAG, _REAL = pa.int32(), pa.int64(), pa.bool_(), pa.float64()

# of a plane wall: a point of it, and an infinite radius; its normal is in scene.yaml
COLLOIDS_SCHEMA = pa.schema([*_columns("colloid", _INDEX), *_columns("x y z radius", _REAL, "a")])
_TYPES = {Kind.FLAG: _FLAG, Kind.SWIMMER: _INDEX, Kind.COLLOID: _INDEX, Kind.IMAGE: _INDEX}  # the others are reals
ENCOUNTERS_SCHEMA = pa.schema(
    field
    for column in COLUMNS
    for field in _columns(column.name, _TYPES.get(column.kind, _REAL), column.unit, nullable=bool(column.null))
)
TIMESERIES_SCHEMA = pa.schema(
    [
        *_columns("time", _REAL, "a/U"),
        *_columns("fraction_bound fraction_contact", _REAL),
        *_columns("n_captures n_escapes n_hops n_returns", _COUNT),
        *_columns("msd", _REAL, "a^2"),  # from the start, over all swimmers
        *_columns("msd_standard_error", _REAL, "a^2", nullable=True),  # null for a single swimmer
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
_INFO_KEY = b"porous_swim"
PART = ".part"  # suffix of a file that is still being written


class HasSchema(Protocol):
    """A table, or what stands for one."""

    @property
    def schema(self) -> pa.Schema:
        """Its columns, with the information on the table for metadata."""


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
    burn_in: float = 0.0  # a/U, from the first time on, that statistics of a steady state leave out
    spacing: float | None = None  # a, mean distance of colloids; None without any, or where the field is open

    @property
    def steady_from(self) -> float:
        """Time from which on statistics of a steady state are taken, in a/U."""
        return self.first_time + self.burn_in

    @property
    def steady_duration(self) -> float:
        """Time that they cover, in a/U."""
        return max(self.last_time - self.steady_from, 0.0)

    @property
    def duration(self) -> float:
        """Time that the tables cover, in a/U."""
        return self.last_time - self.first_time

    @classmethod
    def of(cls, table: HasSchema) -> TableInfo:
        """The information attached to `table`; `ResultsError` where there is none."""
        try:
            stored = json.loads((table.schema.metadata or {})[_INFO_KEY])
            return cls(**{**stored, "box": tuple(stored["box"])})
        except (KeyError, TypeError, ValueError, RecursionError) as error:
            raise ResultsError(
                "a table without the metadata of a porous_swim run: use the tables of a Results, "
                "or TableInfo.attach on your own"
            ) from error

    def attach(self, table: pa.Table) -> pa.Table:
        """`table` with this information in its schema's metadata."""
        stored = json.dumps(asdict(self), allow_nan=False).encode()
        return table.replace_schema_metadata({**(table.schema.metadata or {}), _INFO_KEY: stored})


def steady_from(table: HasSchema) -> float:
    """Time, a/U, from which on statistics of a steady state are taken: -inf for a table that is not of a run."""
    return TableInfo.of(table).steady_from if _INFO_KEY in (table.schema.metadata or {}) else -math.inf


def steady_frames(trajectory: pa.Table) -> pa.Table:
    """The rows that statistics of a steady state take in."""
    first = steady_from(trajectory)
    if first <= 0.0:
        return trajectory
    return trajectory.filter(pc.greater(trajectory["time"], first - 0.5 * TableInfo.of(trajectory).time_step))


def make_table(schema: pa.Schema, columns: Mapping[str, np.ndarray], *, info: TableInfo) -> pa.Table:
    """A table of a schema from arrays of one length; NaN in a nullable column becomes null."""
    arrays = [
        pa.array(np.asarray(columns[field.name]), type=field.type, from_pandas=field.nullable) for field in schema
    ]
    return info.attach(pa.Table.from_arrays(arrays, schema=schema))


def writer_of(path: Path, schema: pa.Schema, *, repeated: Sequence[str] | None = None) -> pq.ParquetWriter:
    """A writer of a Parquet file, compressed, with a checksum of each page.

    `repeated` are columns of few values, by default those that are no real numbers.
    """
    if repeated is None:  # numbers that are hardly ever equal make a dictionary as large as themselves
        repeated = [field.name for field in schema if not pa.types.is_floating(field.type)]
    return pq.ParquetWriter(
        path, schema, compression="zstd", use_dictionary=list(repeated), write_page_checksum=True
    )  # fmt: skip


def write_table(table: pa.Table, path: Path | str) -> None:
    """Write `table` as Parquet; `path` appears only when it is complete."""
    path = Path(path)
    part = path.with_name(path.name + PART)
    try:
        with writer_of(part, table.schema) as writer:
            writer.write_table(table)
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def open_table(path: Path) -> pq.ParquetFile:
    """A Parquet file; `ResultsError` where it is missing or damaged."""
    try:
        return pq.ParquetFile(path, page_checksum_verification=True)
    except FileNotFoundError as error:
        raise ResultsError(f"{path}: the table is missing") from error
    except (OSError, pa.ArrowException) as error:
        raise damaged(path, error) from error


def read_table(path: Path, schema: pa.Schema) -> pa.Table:
    """A table of a schema; `ResultsError` where it is missing, damaged, or of another schema."""
    with open_table(path) as file:
        check_schema(file.schema_arrow, schema, path)
        try:
            return file.read()
        except (OSError, pa.ArrowException) as error:
            raise damaged(path, error) from error


def check_schema(found: pa.Schema, wanted: pa.Schema, path: Path) -> None:
    """Raise a `ResultsError` where the columns of a file are not those wanted."""
    if not found.equals(wanted):
        lacking = sorted(set(wanted.names) - set(found.names))
        how = f"lacks {', '.join(lacking)}" if lacking else "has other column types"
        raise ResultsError(f"{path}: the table {how} and is not one that this version wrote")


def damaged(path: Path, error: Exception) -> ResultsError:
    """The error about a file that cannot be read."""
    return ResultsError(f"{path}: the table is damaged ({str(error).splitlines()[0]})")
