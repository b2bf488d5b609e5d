"""How long swimmers stay: residence times, escape-pitch times, and the time spent bound and in contact.

All are functions of the table of encounters. Times in a/U.
"""

from __future__ import annotations

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import column, needs, time_order
from porous_swim.analysis.estimates import Estimate, Swimmers, joined, mean_over_swimmers, ratio_of_sums
from porous_swim.analysis.lifetimes.lifetimes import Lifetimes
from porous_swim.analysis.lifetimes.survival import SurvivalCurve, WaitingTimes
from porous_swim.results.encounter_table import Encounters, parts_of
from porous_swim.results.tables import TableInfo, steady_from

WHEN = ("swimmer", "start_time", "end_time", "start_censored", "end_censored")
_STAYS = " ".join(WHEN)
_PASSAGES = "swimmer start_time start_censored escape_pitch_time"
_FRACTIONS = "swimmer start_time end_time end_censored contact_time"


def residence_lengths(encounters: pa.Table) -> np.ndarray:
    """Length of each encounter as far as it was seen, (n_encounters,), a/U."""
    return column(encounters, "end_time") - column(encounters, "start_time")


@needs(encounters=_STAYS)
def residence_lifetimes(encounters: pa.Table | Encounters) -> Lifetimes:
    """Lengths of the encounters with what was seen of them, row by row. The table needs its `TableInfo`."""
    last_time = TableInfo.of(encounters).last_time
    return Lifetimes.joined(
        Lifetimes(
            length=residence_lengths(part),
            ended=~column(part, "end_censored"),
            start_seen=~column(part, "start_censored"),
            limit=last_time - column(part, "start_time"),
            swimmer=column(part, "swimmer"),
        )
        for part in parts_of(encounters, *WHEN)
    )


@needs(encounters=_STAYS)
def residence_times(encounters: pa.Table | Encounters, *, horizon: float | None = None) -> WaitingTimes:
    """Residence (trapping) times: the lengths of the encounters, censored ones taken into account.

    Encounters that were under way when the table starts add time to `mean` and stay out of the rest.
    `horizon`, in a/U, bounds `restricted_mean`; it defaults to the longest encounter where at most 2 % last that
    long, else to `Lifetimes.follow_up`.
    """
    return residence_lifetimes(encounters).summary(horizon=horizon)


@needs(encounters=_STAYS)
def residence_survival(encounters: pa.Table | Encounters) -> SurvivalCurve:
    """Probability that an encounter lasts longer than a time; only encounters whose start was seen."""
    return residence_lifetimes(encounters).survival()


@needs(encounters=_PASSAGES)
def escape_pitch_lifetimes(encounters: pa.Table | Encounters) -> Lifetimes:
    """Times from the start of each encounter until the pitch first exceeds `encounter.escape_pitch`, row by row.

    Where it did not come, the sample is censored at the swimmer's next encounter or at the end of the run.
    The table needs its `TableInfo`.
    """
    last_time = TableInfo.of(encounters).last_time
    return Lifetimes.joined(
        _escape_pitch_lifetimes(part, last_time) for part in parts_of(encounters, *WHEN, "escape_pitch_time")
    )


def _escape_pitch_lifetimes(encounters: pa.Table, last_time: float) -> Lifetimes:
    order = time_order(encounters)
    start, swimmer = column(encounters, "start_time"), column(encounters, "swimmer")
    given_up = np.full(len(start), last_time)
    followed = np.flatnonzero(swimmer[order][1:] == swimmer[order][:-1])
    given_up[order[followed]] = start[order[followed + 1]]
    passage = column(encounters, "escape_pitch_time")
    came = ~np.isnan(passage)
    return Lifetimes(
        length=np.where(came, passage, given_up) - start,
        ended=came,
        start_seen=~column(encounters, "start_censored"),
        limit=given_up - start,
        swimmer=swimmer,
    )


@needs(encounters=_PASSAGES)
def escape_pitch_times(encounters: pa.Table | Encounters, *, horizon: float | None = None) -> WaitingTimes:
    """Time from the start of an encounter until the pitch first exceeds `encounter.escape_pitch`.

    See `escape_pitch_lifetimes`; encounters whose start was not seen are left out.
    """
    passages = escape_pitch_lifetimes(encounters)
    return passages.select(passages.start_seen).summary(horizon=horizon)


@needs(encounters=_FRACTIONS)
def bound_fraction(encounters: pa.Table | Encounters) -> Estimate:
    """Fraction of all swimmers' time spent in encounters, after the burn-in of the run. Needs the `TableInfo`."""
    return _time_fraction(_times(encounters)["bound"], TableInfo.of(encounters))


@needs(encounters=_FRACTIONS)
def contact_fraction(encounters: pa.Table | Encounters) -> Estimate:
    """Fraction of all swimmers' time spent in contact, after the burn-in of the run. Needs the `TableInfo`."""
    return _time_fraction(_times(encounters)["contact"], TableInfo.of(encounters))


@needs(encounters=_FRACTIONS)
def contact_fraction_of_encounters(encounters: pa.Table | Encounters) -> Estimate:
    """Fraction of the time in encounters that is spent in contact, after the burn-in of the run."""
    sums = _times(encounters)
    value, error = ratio_of_sums(sums["contact"], sums["bound"])
    return Estimate(value, error, int(sums["n"].sum()), int(sums["n_censored"].sum()), "")


@needs(encounters="start_time end_time end_censored")
def bound_fraction_at(encounters: pa.Table, time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Fraction of swimmers in an encounter at each of the times (n,), and its standard error (n,).

    An encounter covers its start and not its end, except that one under way at the end of the run covers
    that too. Needs the `TableInfo`.
    """
    n = TableInfo.of(encounters).n_swimmers
    ended = ~column(encounters, "end_censored")
    n_started = np.searchsorted(np.sort(column(encounters, "start_time")), time, side="right")
    n_over = np.searchsorted(np.sort(column(encounters, "end_time")[ended]), time, side="right")
    fraction = (n_started - n_over) / n
    # A swimmer is in one encounter at most, so the count is binomial.
    return fraction, np.sqrt(fraction * (1.0 - fraction) / max(n - 1, 1))


def _times(encounters: pa.Table | Encounters) -> dict[str, np.ndarray]:
    """Of each swimmer that occurs, after the burn-in: times bound and in contact, a/U, and numbers of encounters."""
    first = steady_from(encounters)

    def sums(part: pa.Table) -> dict[str, np.ndarray]:
        swimmers, censored = Swimmers.of(column(part, "swimmer")), column(part, "end_censored")
        length, end = residence_lengths(part), column(part, "end_time")
        counts = end >= first
        bound = np.where(counts, end - np.maximum(column(part, "start_time"), first), 0.0)
        # When in an encounter contact was is not in the table: its part after the burn-in has its part of it.
        share = np.divide(bound, length, out=counts.astype(float), where=length > 0.0)
        values = {
            "bound": bound, "contact": share * column(part, "contact_time"),
            "n": counts, "n_censored": censored & counts,
        }  # fmt: skip
        return {name: swimmers.sums(value) for name, value in values.items()}

    return joined(sums(part) for part in parts_of(encounters, *WHEN, "contact_time"))


def _time_fraction(sums: np.ndarray, info: TableInfo) -> Estimate:
    if info.steady_duration <= 0.0:
        return Estimate(np.nan, np.nan, 0, 0, "")
    value, error = mean_over_swimmers(sums / info.steady_duration, n_swimmers=info.n_swimmers)
    return Estimate(value, error, info.n_swimmers, 0, "")
