"""The table of encounters, which may be larger than memory: as a whole, or in parts of whole swimmers.

Most statistics are sums over swimmers, which can be had part by part; others need a column or two of all rows.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pyarrow as pa

from porous_swim.core.errors import ResultsError
from porous_swim.results.tables import (
    ENCOUNTERS_SCHEMA,
    PART,
    TableInfo,
    check_schema,
    damaged,
    open_table,
    read_table,
    writer_of,
)

ENCOUNTERS = "encounters.parquet"
ROWS = "encounters.rows"  # in a run folder: the log of a run that is under way, once it is long
MANY = 1 << 22  # rows of a table that is not read whole unless it is asked for: 1 GB in memory


@dataclass(frozen=True, eq=False)
class Encounters:
    """The encounters of a run: a table in memory, or the file that holds it."""

    source: pa.Table | Path
    schema: pa.Schema
    n: int
    check: Callable[[pa.Table], None] | None = None
    """What looks at each part of a file that is read: a `ResultsError` where no run writes such rows."""

    @classmethod
    def in_memory(cls, table: pa.Table) -> Encounters:
        """Those of `table`."""
        return cls(table, table.schema, len(table))

    @classmethod
    def at(cls, path: Path) -> Encounters:
        """Those of a file: in memory where they are few. `ResultsError` where it is missing or damaged."""
        with open_table(path) as file:
            n, schema = file.metadata.num_rows, file.schema_arrow
        check_schema(schema, ENCOUNTERS_SCHEMA, path)
        return cls.in_memory(read_table(path, ENCOUNTERS_SCHEMA)) if n <= MANY else cls(path, schema, n)

    @classmethod
    def written(cls, parts: Iterable[pa.Table], path: Path | None) -> Encounters:
        """Write tables, each of whole swimmers, in order of these, at least one; without a `path` keep them in memory.

        `path` appears only when it is complete. A single part stays in memory besides.
        """
        if path is None:
            return cls.in_memory(pa.concat_tables(parts))
        temporary, writer, n, table = path.with_name(path.name + PART), None, 0, None
        try:
            for table in parts:
                writer = writer or writer_of(temporary, table.schema)
                writer.write_table(table)
                n += len(table)
            assert writer is not None
            assert table is not None
            writer.close()
            os.replace(temporary, path)
        except BaseException:
            with suppress(OSError):
                if writer is not None:
                    writer.close()
            temporary.unlink(missing_ok=True)
            raise
        return cls.in_memory(table) if n == len(table) else cls(path, table.schema, n)

    def __len__(self) -> int:
        """Number of encounters."""
        return self.n

    def table(self) -> pa.Table:
        """All of them in memory, some 260 bytes each."""
        if isinstance(self.source, pa.Table):
            return self.source
        table = read_table(self.source, ENCOUNTERS_SCHEMA)
        if self.check is not None:
            self.check(table)
        return table

    def parts(self, *columns: str) -> Iterator[pa.Table]:
        """Tables of consecutive swimmers, with all encounters of each: of these columns at least, by default all.

        There is at least one table, which may be empty.

        Raises:
            ResultsError: a file that is damaged, or not in order of swimmers.
        """
        if isinstance(self.source, pa.Table):
            yield self.source
            return
        names = ["swimmer", *(name for name in columns if name != "swimmer")] if columns else None
        held = self.schema.empty_table().select(names or self.schema.names)
        with open_table(self.source) as file:
            for number in range(file.num_row_groups):
                try:
                    group = pa.concat_tables([held, file.read_row_group(number, columns=names)])
                except (OSError, pa.ArrowException) as error:
                    raise damaged(self.source, error) from error
                if self.check is not None:
                    self.check(group)
                swimmer = group.column("swimmer").to_numpy()
                if np.any(swimmer[1:] < swimmer[:-1]):
                    raise ResultsError(f"{self.source}: the rows are not in order of swimmers")
                complete = int(np.searchsorted(swimmer, swimmer[-1:], side="left")[0]) if len(swimmer) else 0
                yield group.slice(0, complete)
                held = group.slice(complete)
        yield held

    def of_one_in(self, many: int) -> pa.Table:
        """The encounters of one swimmer in so many, drawn at random (always the same), as if the run had no others."""
        info = TableInfo.of(self)
        drawn = np.random.default_rng(0).random(info.n_swimmers) < 1.0 / many
        kept = [part.filter(pa.array(drawn[part.column("swimmer").to_numpy()])) for part in self.parts()]
        return replace(info, n_swimmers=int(drawn.sum())).attach(pa.concat_tables(kept))


def parts_of(encounters: pa.Table | Encounters, *columns: str) -> Iterable[pa.Table]:
    """Tables of whole swimmers with at least these columns: the one table, or the parts of a file."""
    return [encounters] if isinstance(encounters, pa.Table) else encounters.parts(*columns)
