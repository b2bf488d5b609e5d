"""The columns of the encounter table: the one list from which everything else about them follows.

The rows that the kernel keeps of an encounter (`engine/kernel/state.py`), what a capture clears, the device's log, the
table on the host (`engine/encounter_log.py`), its schema (`results/tables.py`), what a file may hold
(`results/table_check.py`) and the table in `docs/statistics.md` (`results/encounter_page.py`) are made from it. What a
step adds to a row is all that stands elsewhere, under the row's name: in `engine/kernel/commit.py`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from math import inf
from typing import ClassVar


class Kind(Enum):
    """What the numbers of a column are: their type, and the range that they are checked against when read."""

    NUMBER = "number"
    PLACE = "place"  # a coordinate or a height
    TIME = "time"  # on the clock of the run
    DURATION = "duration"
    PITCH = "pitch"
    COMPONENT = "component"  # of a unit vector
    FLAG = "flag"
    SWIMMER = "swimmer"
    COLLOID = "colloid"
    IMAGE = "image"


@dataclass(frozen=True)
class Record:
    """A row of reals that the kernel keeps of the encounter under way."""

    row: str
    dimensions: tuple[int, ...] = (2, 3)
    """In how many dimensions there is such a row."""
    start: ClassVar[float] = 0.0
    """What it holds when an encounter begins."""

    @property
    def rows(self) -> tuple[str, ...]:
        """Names of all rows that it takes."""
        return (self.row,)


class Sum(Record):
    """The sum over the steps of the encounter; a second row keeps what its rounding left (Kahan)."""

    @property
    def rows(self) -> tuple[str, ...]:
        """Names of the sum and of its rest."""
        return self.row, f"{self.row}_rest"


class Least(Record):
    """The least at the ends of the steps; no value before the first one, unless `capture` gives one."""

    start = inf


class Greatest(Record):
    """The greatest at the ends of the steps; no value before the first one, unless `capture` gives one."""

    start = -inf


class AtRelease(Record):
    """The value at the last touch of the wall; none where it was never touched."""


@dataclass(frozen=True)
class Host:
    """A value that `engine/encounter_log.py` makes under the column's name, from `record` where there is one."""

    record: Record | None = None


@dataclass(frozen=True)
class Column:
    """A column of the encounter table."""

    name: str
    unit: str
    source: Record | Host
    meaning: str
    kind: Kind = Kind.NUMBER
    null: str = ""
    """Where it has no value, as "where ..."; empty for a column that always has one."""

    @property
    def record(self) -> Record | None:
        """What the kernel keeps for it, if anything."""
        return self.source.record if isinstance(self.source, Host) else self.source


def _made(names: str, unit: str, kind: Kind, meaning: str, null: str = "") -> list[Column]:
    """Columns that the host makes; `{}` in `meaning` stands for what follows the last `_` of a name."""
    return [Column(name, unit, Host(), meaning.format(name.rpartition("_")[2]), kind, null) for name in names.split()]


_UNTOUCHED = "where the colloid was never touched, as after a direct hop"

COLUMNS = (
    *_made("swimmer", "", Kind.SWIMMER, "Number of the swimmer, from 0."),
    *_made("colloid", "", Kind.COLLOID, "Number of the colloid, as in `colloids.parquet`."),
    *_made("image_x image_y image_z", "", Kind.IMAGE, "Which periodic image of the colloid, in boxes along {}."),
    *_made("start_time", "a/U", Kind.TIME, "When the encounter began: at first contact, or at a direct hop."),
    *_made("end_time", "a/U", Kind.TIME, "When the height exceeded the escape height, or the end of the run."),
    *_made("start_censored", "", Kind.FLAG, "Whether it began before the time that the table covers; never in a run."),
    *_made("end_censored", "", Kind.FLAG, "Whether it was still under way at the end of the run."),
    *_made("contact_time", "a/U", Kind.DURATION,
           "Time in the contact band, by both ends of each step: of second order in the step."),
    Column("wall_push", "a", Sum("push"),
           "Sum of the distances by which contact pushed the swimmer out of the encounter's own colloid. The push of "
           "another colloid that is touched meanwhile goes to no encounter."),
    Column("winding", "turns", Sum("winding"),
           "Turns around the colloid, positive where the swimmer moves the way it points; 0 at a plane wall."),
    Column("signed_winding", "turns", Sum("signed", dimensions=(2,)),
           "Turns around the colloid, positive counterclockwise; 0 at a plane wall.", null="in three dimensions"),
    *_made("entry_x entry_y entry_z", "a", Kind.PLACE, "Position {} at the start, unwrapped."),
    *_made("exit_x exit_y exit_z", "a", Kind.PLACE, "Position {} at the end, unwrapped."),
    *_made("entry_ex entry_ey entry_ez", "", Kind.COMPONENT, "Component {} of the director at the start."),
    *_made("exit_ex exit_ey exit_ez", "", Kind.COMPONENT, "Component {} of the director at the end."),
    *_made("entry_pitch", "rad", Kind.PITCH, "Angle of the director to the surface at the start, positive away."),
    *_made("exit_pitch", "rad", Kind.PITCH, "The same at the end."),
    *_made("release_time", "a/U", Kind.TIME,
           "When the colloid was last touched. With `integrator: reflected`, this and the next two are those of the "
           "middle of that step, and of second order in it.", null=_UNTOUCHED),
    Column("release_pitch", "rad", Host(AtRelease("release_sine")), "Pitch at that touch.", Kind.PITCH, _UNTOUCHED),
    Column("release_winding", "turns", AtRelease("release_winding"), "`winding` until that touch.", null=_UNTOUCHED),
    *_made("escape_pitch_time", "a/U", Kind.TIME,
           "When the pitch first exceeded the escape pitch, perhaps after the end; on the clock of `start_time`.",
           null="where it did not before the next encounter or the end of the run"),
    Column("min_height", "a", Least("min_height"), "Least height of the centre above the surface.", Kind.PLACE),
    Column("mean_height", "a", Host(Sum("height")), "Mean height over time, by both ends of each step.", Kind.PLACE),
    Column("max_height", "a", Greatest("max_height"), "Greatest height.", Kind.PLACE),
)  # fmt: skip


def records(dimensions: int) -> tuple[Record, ...]:
    """What the kernel keeps of an encounter in `dimensions`."""
    return tuple(record for record in all_records() if dimensions in record.dimensions)


def all_records() -> tuple[Record, ...]:
    """What it keeps in two or in three dimensions."""
    return tuple(column.record for column in COLUMNS if column.record is not None)


def check_columns(columns: Sequence[Column]) -> None:
    """Raise a `ValueError` where two columns, or two rows of the kernel, have one name."""
    rows = [row for column in columns if column.record is not None for row in column.record.rows]
    for what, names in (("columns", [column.name for column in columns]), ("rows of the kernel", rows)):
        twice = sorted(name for name, count in Counter(names).items() if count > 1)
        if twice:
            raise ValueError(f"two {what} of the encounter table have the name {twice[0]!r}")


check_columns(COLUMNS)
