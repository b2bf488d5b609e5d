"""Distributions and binned means with errors over swimmers: one swimmer's samples are not independent.

Errors are an infinitesimal jackknife over swimmers; values that are NaN (null in a table) are left out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from porous_swim.analysis.columns import numbered
from porous_swim.analysis.estimates import Swimmers


@dataclass(frozen=True, eq=False)
class Histogram:
    """A distribution over bins."""

    edges: np.ndarray  # (n_bins + 1,)
    density: np.ndarray  # (n_bins,) share of the samples in a bin over its width
    standard_error: np.ndarray  # (n_bins,) of `density`; NaN for fewer than two swimmers
    count: np.ndarray  # (n_bins,) samples
    n: int  # samples, those outside the edges included
    n_outside: int  # samples outside the edges


@dataclass(frozen=True, eq=False)
class Map:
    """A distribution over the bins of two quantities."""

    x_edges: np.ndarray  # (n_x + 1,)
    y_edges: np.ndarray  # (n_y + 1,)
    density: np.ndarray  # (n_x, n_y) share of the samples in a bin over its area
    standard_error: np.ndarray  # (n_x, n_y) of `density`; NaN for fewer than two swimmers
    count: np.ndarray  # (n_x, n_y) samples
    n: int  # samples, those outside the edges included
    n_outside: int  # samples outside the edges


@dataclass(frozen=True, eq=False)
class Profile:
    """The mean of one quantity in bins of another."""

    edges: np.ndarray  # (n_bins + 1,)
    mean: np.ndarray  # (n_bins,) NaN in an empty bin
    standard_error: np.ndarray  # (n_bins,) NaN where fewer than two swimmers have samples
    count: np.ndarray  # (n_bins,) samples


def histogram(values: np.ndarray, *, edges: np.ndarray, swimmer: np.ndarray) -> Histogram:
    """Distribution of values (n,) that belong to swimmers (n,). The last bin includes its upper edge."""
    known = ~np.isnan(values)
    place = _places(values[known], edges)
    share, error, count = _shares(place, len(edges) - 1, swimmer[known])
    width = np.diff(edges)
    return Histogram(edges, share / width, error / width, count, len(place), int(np.count_nonzero(place < 0)))


def histogram_2d(x: np.ndarray, y: np.ndarray, *, x_edges: np.ndarray, y_edges: np.ndarray, swimmer: np.ndarray) -> Map:
    """Distribution of pairs of values (n,) each, of swimmers (n,). The last bins include their upper edges."""
    known = ~(np.isnan(x) | np.isnan(y))
    column, row = _places(x[known], x_edges), _places(y[known], y_edges)
    shape = (len(x_edges) - 1, len(y_edges) - 1)
    place = np.where((column < 0) | (row < 0), -1, column * shape[1] + row)
    share, error, count = (found.reshape(shape) for found in _shares(place, shape[0] * shape[1], swimmer[known]))
    area = np.outer(np.diff(x_edges), np.diff(y_edges))
    outside = int(np.count_nonzero(place < 0))
    return Map(x_edges, y_edges, share / area, error / area, count, len(place), outside)


def binned_mean(values: np.ndarray, *, against: np.ndarray, edges: np.ndarray, swimmer: np.ndarray) -> Profile:
    """Mean of values (n,) in bins of `against` (n,). The last bin includes its upper edge."""
    n_bins = len(edges) - 1
    place = np.where(np.isnan(values), -1, _places(against, edges))
    inside = place >= 0
    place, values = place[inside], values[inside]
    count = np.bincount(place, minlength=n_bins)
    missing = np.full(n_bins, np.nan)
    mean = np.divide(np.bincount(place, weights=values, minlength=n_bins), count, out=missing.copy(), where=count > 0)
    pair, (residual,) = _sums_of_pairs(place, n_bins, swimmer[inside], values - mean[place])
    squares = np.bincount(pair, weights=residual**2, minlength=n_bins)
    m = np.bincount(pair, minlength=n_bins)  # swimmers with samples in the bin
    factor = np.divide(m, m - 1, out=missing.copy(), where=m > 1)
    return Profile(edges, mean, np.sqrt(factor * squares) / np.maximum(count, 1), count)


def _places(values: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Bin of each value, (n,); -1 outside. NaN is outside."""
    place = np.searchsorted(edges, values, side="right") - 1
    place[values == edges[-1]] = len(edges) - 2
    return np.where(place < len(edges) - 1, place, -1)


def _shares(place: np.ndarray, n_bins: int, swimmer: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Share of all samples in each bin, its standard error, and the count: (n_bins,) each."""
    inside = place >= 0
    count = np.bincount(place[inside], minlength=n_bins)
    swimmers = Swimmers.of(swimmer)
    own = np.bincount(swimmers.group, minlength=swimmers.n)  # samples of each swimmer
    share = count / max(len(place), 1)
    if swimmers.n < 2:
        return share, np.full(n_bins, np.nan), count
    # Sum over swimmers of (count in bin - share x own)^2, multiplied out: most swimmers miss most bins.
    pair, (number, with_own) = _sums_of_pairs(
        place[inside], n_bins, swimmers.group[inside], np.ones(count.sum()), own[swimmers.group[inside]]
    )
    squares = np.bincount(pair, weights=number**2, minlength=n_bins)
    mixed = np.bincount(pair, weights=with_own, minlength=n_bins)
    total = np.maximum(squares - 2.0 * share * mixed + share**2 * float(np.sum(own.astype(float) ** 2)), 0.0)
    return share, np.sqrt(swimmers.n / (swimmers.n - 1) * total) / len(place), count


def _sums_of_pairs(
    place: np.ndarray, n_bins: int, swimmer: np.ndarray, *values: np.ndarray
) -> tuple[np.ndarray, list[np.ndarray]]:
    """For each pair of a swimmer and a bin that occurs: the bin (m,), and the sums of values (n,) over it (m,)."""
    occurring, group = numbered(swimmer.astype(np.int64) * n_bins + place)
    sums = [np.bincount(group, weights=each, minlength=len(occurring)) for each in values]
    return occurring % n_bins, sums
