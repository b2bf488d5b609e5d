"""Displacements of all swimmers of a run over lags, from the sums that were taken while it went on (`lags.parquet`).

Each row is a mean over a group of swimmers and the windows of one lag, which do not overlap. Groups are independent
samples, as swimmers are; a last group of fewer swimmers is left out. Lengths in a, times in a/U.
"""

from __future__ import annotations

import math

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import column, needs
from porous_swim.analysis.transport.diffusion import (
    FEWEST_LAGS,
    FEWEST_SWIMMERS,
    MOST_LAGS,
    SWIMMERS_PER_LAG,
    DiffusivityFit,
    EffectiveDiffusivity,
    none_for,
)
from porous_swim.analysis.transport.displacements import non_gaussian
from porous_swim.analysis.transport.lagged import TimeAverages
from porous_swim.analysis.transport.transport import Lagged
from porous_swim.results.tables import TableInfo


@needs(lags="lag n_swimmers msd")
def ensemble_msd(lags: pa.Table) -> TimeAverages:
    """Mean squared displacement against lag, a^2; a column of `each` is a group of swimmers."""
    return _averages(lags, "msd")


@needs(lags="lag n_swimmers director_correlation")
def ensemble_director_correlation(lags: pa.Table) -> TimeAverages:
    """Mean of e(t + lag).e(t); a column of `each` is a group of swimmers."""
    return _averages(lags, "director_correlation")


@needs(lags="lag n_swimmers director_correlation")
def director_memory(lags: pa.Table) -> float:
    """The first lag, a/U, from which on directors neither agree nor disagree with themselves by 1/e or more.

    Infinite where they do at the last lag, or where there is none. Of a persistent walk it is the first lag beyond the
    persistence time; among colloids noise need not be what turns directors, and orbits bring them back.
    """
    found = ensemble_director_correlation(lags)
    if len(found.lag) == 0:
        return math.inf
    agreeing = np.flatnonzero(np.abs(found.value) >= math.exp(-1.0))
    after = int(agreeing[-1]) + 1 if len(agreeing) else 0
    return math.inf if after == len(found.lag) else float(found.lag[after])


@needs(lags="lag n_swimmers msd fourth_moment")
def ensemble_non_gaussian_parameter(lags: pa.Table) -> Lagged:
    """As `non_gaussian_parameter`, of all swimmers."""
    return non_gaussian(ensemble_msd(lags), _averages(lags, "fourth_moment"), TableInfo.of(lags).dimensions)


@needs(lags="lag n_swimmers msd director_correlation")
def ensemble_diffusivity(
    lags: pa.Table, *, window: tuple[float, float] | None = None, level: float = 0.95
) -> EffectiveDiffusivity:
    """As `effective_diffusivity`, of all swimmers; the lags are those of the table.

    `n` counts the swimmers of whole groups. NaN where there are fewer than 20 groups, or 4 lags.
    """
    squares = ensemble_msd(lags)
    about = DiffusivityFit(squares.n * _group_size(lags), TableInfo.of(lags), level)
    if squares.n < FEWEST_SWIMMERS or len(squares.lag) == 0:
        return about.nothing(none_for(about.n))
    if window is not None:
        return about.given(_window(squares, *window))
    return about.chosen(lambda start: _window(squares, start, math.inf), squares, ensemble_director_correlation(lags))


def _window(squares: TimeAverages, start: float, end: float) -> TimeAverages | None:
    """Four to eight of the lags from `start` to `end`; None where there are fewer."""
    inside = np.flatnonzero((squares.lag >= start * (1.0 - 1e-9)) & (squares.lag <= end * (1.0 + 1e-9)))
    n_lags = min(MOST_LAGS, squares.n // SWIMMERS_PER_LAG, len(inside))
    if n_lags < FEWEST_LAGS:
        return None
    chosen = inside[np.rint(np.linspace(0, len(inside) - 1, n_lags)).astype(int)]
    return TimeAverages(squares.lag[chosen], squares.each[chosen])


def _group_size(lags: pa.Table) -> int:
    return int(column(lags, "n_swimmers").max(initial=0))


def _averages(lags: pa.Table, name: str) -> TimeAverages:
    whole = column(lags, "n_swimmers") == _group_size(lags)
    lag = np.unique(column(lags, "lag"))
    n_groups = np.count_nonzero(whole) // max(len(lag), 1)
    return TimeAverages(lag, column(lags, name)[whole].reshape(len(lag), n_groups))
