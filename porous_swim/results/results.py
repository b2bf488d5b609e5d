"""The results of a run. Reading them needs neither Taichi nor a GPU."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import pyarrow as pa

from porous_swim.results.encounter_table import Encounters
from porous_swim.results.tables import TableInfo


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
        missing = "".join(f", without {each}" for each in self.summary.get("missing", {}))
        return (
            f"<Results of {name}, {status}: {self.info.n_swimmers} swimmers, {self.info.duration:g} a/U, "
            f"{len(self.stored)} encounters{missing}, {where}>"
        )

    @cached_property
    def encounters(self) -> pa.Table:
        """The table of encounters, read into memory when it is first asked for: 260 bytes an encounter."""
        return self.stored.table()
