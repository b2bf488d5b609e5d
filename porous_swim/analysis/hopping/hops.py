"""Moves between encounters: hops to another colloid, returns to the same one, and the flights between.

A colloid means the pair of colloid and periodic image. encounters = hops + returns + first ones: a
swimmer's first encounter is neither.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import column, needs, time_order, vectors
from porous_swim.analysis.estimates import Estimate, Swimmers, joined, mean_over_swimmers, ratio_of_sums
from porous_swim.analysis.hopping.nearest import UNKNOWN, Nearest
from porous_swim.analysis.lifetimes.lifetimes import Lifetimes
from porous_swim.analysis.lifetimes.residence import WHEN, residence_lengths
from porous_swim.analysis.lifetimes.survival import WaitingTimes
from porous_swim.analysis.places import centers_of
from porous_swim.results.encounter_table import Encounters, parts_of
from porous_swim.results.tables import TableInfo

_WHERE = ("colloid", *(f"{name}_{axis}" for name in ("image", "entry", "exit") for axis in "xyz"))
MOVES = " ".join(("swimmer", "start_time", "end_time", "start_censored", *_WHERE))  # columns that moves are made of
_FLIGHTS = "swimmer start_time end_time end_censored"


@dataclass(frozen=True)
class Moves:
    """Moves from the end of one encounter to the start of the same swimmer's next one."""

    swimmer: np.ndarray  # (n,)
    from_colloid: np.ndarray  # (n,)
    from_image: np.ndarray  # (n, 3)
    to_colloid: np.ndarray  # (n,)
    to_image: np.ndarray  # (n, 3)
    end_time: np.ndarray  # (n,) a/U, of the encounter that is left
    start_time: np.ndarray  # (n,) a/U, of the encounter that is entered
    displacement: np.ndarray  # (n, 3) a, from exit to entry, unwrapped
    residence: np.ndarray  # (n,) a/U, length of the encounter that is left; NaN where its start was not seen

    def __len__(self) -> int:
        """Number of moves."""
        return len(self.swimmer)

    @property
    def time(self) -> np.ndarray:
        """Time between the encounters, (n,), a/U; 0 for a direct hop."""
        return self.start_time - self.end_time

    def select(self, chosen: np.ndarray) -> Moves:
        """The moves where the mask `chosen` (n,) holds."""
        return Moves(**{name: values[chosen] for name, values in vars(self).items()})


@needs(encounters=MOVES)
def moves(encounters: pa.Table) -> Moves:
    """All moves, hops and returns alike, swimmer by swimmer in order of time."""
    order, swimmer = time_order(encounters), column(encounters, "swimmer")
    last = np.flatnonzero(swimmer[order[1:]] == swimmer[order[:-1]])
    left, entered = order[last], order[last + 1]  # rows of the table
    colloid, image = column(encounters, "colloid"), vectors(encounters, "image_x", "image_y", "image_z")
    entry, exit_ = (
        vectors(encounters, "entry_x", "entry_y", "entry_z"),
        vectors(encounters, "exit_x", "exit_y", "exit_z"),
    )
    return Moves(
        swimmer=swimmer[left],
        from_colloid=colloid[left],
        from_image=image[left],
        to_colloid=colloid[entered],
        to_image=image[entered],
        end_time=column(encounters, "end_time")[left],
        start_time=column(encounters, "start_time")[entered],
        displacement=entry[entered] - exit_[left],
        residence=np.where(column(encounters, "start_censored"), np.nan, residence_lengths(encounters))[left],
    )


@needs(encounters=MOVES)
def hops(encounters: pa.Table) -> Moves:
    """Moves to a different colloid or to another image of the same one."""
    every = moves(encounters)
    return every.select(~same_colloid(every))


@needs(encounters=MOVES)
def returns(encounters: pa.Table) -> Moves:
    """Moves back to the colloid that was left."""
    every = moves(encounters)
    return every.select(same_colloid(every))


def same_colloid(every: Moves) -> np.ndarray:
    """Which moves, (n,), lead back to the image of the colloid that was left."""
    return (every.from_colloid == every.to_colloid) & np.all(every.from_image == every.to_image, axis=1)


@needs(encounters=_FLIGHTS)
def flight_lifetimes(encounters: pa.Table | Encounters) -> Lifetimes:
    """Times from the end of each encounter that ended to the swimmer's next one, swimmer by swimmer.

    A flight under way at the end of the run is censored; the time from the release to the first encounter
    is no flight. The table needs its `TableInfo`.
    """
    last_time = TableInfo.of(encounters).last_time
    return Lifetimes.joined(_flight_lifetimes(part, last_time) for part in parts_of(encounters, *WHEN))


def _flight_lifetimes(encounters: pa.Table, last_time: float) -> Lifetimes:
    order = time_order(encounters)
    swimmer, start, end = (column(encounters, name)[order] for name in ("swimmer", "start_time", "end_time"))
    until = np.full(len(end), last_time)
    followed = np.append(swimmer[1:] == swimmer[:-1], False)[: len(end)]
    until[followed] = start[1:][followed[:-1]]
    every = Lifetimes(until - end, followed, np.ones(len(end), bool), last_time - end, swimmer)
    return every.select(~column(encounters, "end_censored")[order])


@needs(encounters=_FLIGHTS)
def flights(encounters: pa.Table | Encounters, *, horizon: float | None = None) -> WaitingTimes:
    """Mean times between encounters: see `flight_lifetimes`."""
    return flight_lifetimes(encounters).summary(horizon=horizon)


@dataclass(frozen=True)
class HopStatistics:
    """How often and how far swimmers hop; the swimmers are the independent samples."""

    hop_rate: Estimate
    """Hops per swimmer and time, U/a."""
    return_rate: Estimate
    """Returns per swimmer and time, U/a."""
    time: Estimate
    """Mean time of a hop, a/U. Hops that the run cut off are missing: `flights` takes them into account."""
    length: Estimate
    """Mean distance between the centres of the two colloids, a."""
    displacement: Estimate
    """Mean distance from exit to entry, a."""
    nearest_share: Estimate
    """Share of the hops that lead to a nearest neighbour of the colloid that was left: to its first shell where the
    distances between colloids form shells, as in a lattice; else to a colloid whose cell touches."""


@needs(encounters=MOVES, colloids="colloid x y z radius")
def hop_statistics(encounters: pa.Table | Encounters, colloids: pa.Table) -> HopStatistics:
    """Rates, times and lengths of hops. The table of encounters needs its `TableInfo`.

    Rates are those after the burn-in of the run (`record.burn_in`); all else is of all hops.
    Without a second colloid, or an image of the one, there is nowhere to hop, and without any nowhere to return: no
    rates, not rates of 0.
    """
    info = TableInfo.of(encounters)
    nearest = Nearest(colloids, box=info.box)
    sums: list[tuple[dict[str, np.ndarray], ...]] = []
    for part in parts_of(encounters, *WHEN, *_WHERE):
        every = moves(part)
        same = same_colloid(every)
        late = every.start_time >= info.steady_from
        counts = _counts(every.select(~same & late)), _counts(every.select(same & late))
        sums.append((_hop_sums(every.select(~same), colloids, nearest, info), *counts))
    hopped, hopped_late, returned_late = (joined(each) for each in zip(*sums, strict=True))
    n = int(hopped["n"].sum())

    def mean(values: str, unit: str) -> Estimate:
        return Estimate(*ratio_of_sums(hopped[values], hopped["n"]), n, 0, unit)

    nearest_share = mean("nearest", "")
    if n and nearest.unknown:
        nearest_share = replace(Estimate.none(""), n=n, warning=UNKNOWN)
    elsewhere = len(colloids) > 1 or (len(colloids) == 1 and any(info.box))
    return HopStatistics(
        hop_rate=_rate(hopped_late["n"], info) if elsewhere else Estimate.none("U/a"),
        return_rate=_rate(returned_late["n"], info) if len(colloids) else Estimate.none("U/a"),
        time=mean("time", "a/U"),
        length=mean("length", "a"),
        displacement=mean("displacement", "a"),
        nearest_share=nearest_share,
    )


def _counts(counted: Moves) -> dict[str, np.ndarray]:
    return {"n": Swimmers.of(counted.swimmer).sums(np.ones(len(counted)))}


def _hop_sums(hopped: Moves, colloids: pa.Table, nearest: Nearest, info: TableInfo) -> dict[str, np.ndarray]:
    """Of each swimmer that hopped, over its hops."""
    length, image = hop_lengths(hopped, colloids, box=info.box), hopped.to_image - hopped.from_image
    values = {
        "time": hopped.time, "length": length, "displacement": np.linalg.norm(hopped.displacement, axis=1),
        "nearest": nearest.among(hopped.from_colloid, hopped.to_colloid, image, length),
    }  # fmt: skip
    swimmers = Swimmers.of(hopped.swimmer)
    return {name: swimmers.sums(value) for name, value in values.items()} | _counts(hopped)


@needs(colloids="colloid x y z")
def hop_lengths(hopped: Moves, colloids: pa.Table, *, box: tuple[float, float, float]) -> np.ndarray:
    """Distance between the centres of the two colloids of each move, (n,), a."""
    return np.linalg.norm(hop_vectors(hopped, colloids, box=box), axis=1)


def hop_vectors(hopped: Moves, colloids: pa.Table, *, box: tuple[float, float, float]) -> np.ndarray:
    """From the centre of the colloid that is left to that of the one entered, (n, 3), a, over periodic images."""
    centers = centers_of(colloids)
    unwrapped = (hopped.to_image - hopped.from_image) * np.asarray(box)
    return np.asarray(centers[hopped.to_colloid] - centers[hopped.from_colloid] + unwrapped)


def _rate(counts: np.ndarray, info: TableInfo) -> Estimate:
    if info.steady_duration <= 0.0:
        return Estimate.none("U/a")
    value, error = mean_over_swimmers(counts / info.steady_duration, n_swimmers=info.n_swimmers)
    return Estimate(value, error, int(counts.sum()), 0, "U/a")
