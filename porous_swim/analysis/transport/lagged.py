"""Averages over all pairs of frames a lag apart, swimmer by swimmer. Lengths in a, times in a/U.

They use every frame as a start, and so are the more precise, where the ensemble does not change in time; `msd` and
`director_correlation` start from the release alone. The swimmers are the independent samples.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import DIRECTORS, PLACES, needs
from porous_swim.analysis.transport.transport import Tracks, mean_of_known, tracks
from porous_swim.analysis.transport.transport import error_of_mean as error_of_mean
from porous_swim.core.errors import ResultsError
from porous_swim.results.tables import steady_frames

N_LAGS = 30  # by default, in geometric order
LONGEST = 0.5  # of the run: beyond, starts share so much of their way that they add nothing


@dataclass(frozen=True, eq=False)
class TimeAverages:
    """A time-averaged quantity against lag."""

    lag: np.ndarray  # (n_lags,) a/U
    each: np.ndarray  # (n_lags, n_swimmers), averages over one swimmer's starts; NaN where it has none

    @property
    def n(self) -> int:
        """Swimmers."""
        return self.each.shape[1]

    @property
    def value(self) -> np.ndarray:
        """Mean over swimmers, (n_lags,)."""
        return mean_of_known(self.each, axis=1)

    @property
    def standard_error(self) -> np.ndarray:
        """Of `value`, (n_lags,): the jackknife over swimmers, which for a mean is the usual one."""
        return error_of_mean(self.each)

    def complete(self) -> TimeAverages:
        """Of the swimmers that have an average at every lag."""
        there = ~np.isnan(self.each).any(axis=0)
        return self if there.all() else TimeAverages(self.lag, self.each[:, there])


@needs(trajectory=PLACES)
def time_averaged_msd(trajectory: pa.Table, *, lags: np.ndarray | None = None) -> TimeAverages:
    """Mean squared displacement against lag, a^2. See `lag_averages` for `lags`."""
    return lag_averages(even_frames(trajectory), squared_step, lags=lags)


@needs(trajectory=f"{PLACES} {DIRECTORS}")
def time_averaged_director_correlation(trajectory: pa.Table, *, lags: np.ndarray | None = None) -> TimeAverages:
    """Mean of e(t + lag).e(t). See `lag_averages` for `lags`."""
    return lag_averages(even_frames(trajectory), director_overlap, lags=lags)


@needs(trajectory=PLACES)
def straightness(trajectory: pa.Table, *, lags: np.ndarray | None = None) -> TimeAverages:
    """Mean |displacement|/lag, in U: 1 for a swimmer that goes straight. See `lag_averages` for `lags`."""
    found = lag_averages(even_frames(trajectory), lambda *pair: np.sqrt(squared_step(*pair)), lags=lags)
    return TimeAverages(found.lag, found.each / found.lag[:, None])


def scalar_products(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Over the last axis of vectors (n_starts, n_swimmers, 3): (n_starts, n_swimmers)."""
    return np.asarray(np.einsum("fsi,fsi->fs", first, second))


def squared_step(step: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Squared displacements, (n_starts, n_swimmers), as `lag_averages` takes them."""
    return scalar_products(step, step)


def director_overlap(step: np.ndarray, before: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Scalar products of directors before and after, (n_starts, n_swimmers), as `lag_averages` takes them."""
    return scalar_products(before, after)


def even_frames(trajectory: pa.Table) -> Tracks:
    """The recorded swimmers at equal intervals, after the burn-in of the run.

    A last frame that comes early (the end of a run) is left out.

    Frames that nobody is in may be missing: they stay so, NaN for all.

    Raises:
        ResultsError: other frames are not at equal intervals, or half of them are missing.
    """
    recorded = tracks(steady_frames(trajectory))
    interval = np.diff(recorded.time)
    if len(interval) > 1 and interval[-1] < interval[0] * (1.0 - 1e-6):
        recorded = Tracks(recorded.time[:-1], recorded.swimmer, recorded.position[:-1], recorded.director[:-1])
        interval = interval[:-1]
    if len(interval) == 0 or np.ptp(interval) <= 1e-6 * interval[0]:
        return recorded
    step = np.rint(interval / np.min(interval)).astype(int)
    if np.any(np.abs(interval - step * np.min(interval)) > 1e-6 * interval) or 2 * len(step) < step.sum():
        raise ResultsError(
            f"trajectory: found frames {np.min(interval):g} to {np.max(interval):g} a/U apart; "
            "lags need equal intervals, of which half and more may not be missing"
        )
    return _with_missing(recorded, np.append(0, np.cumsum(step)))


def _with_missing(recorded: Tracks, frame: np.ndarray) -> Tracks:
    """The tracks at numbers (n_frames,) among equal intervals, with frames of nobody between."""
    n_frames = int(frame[-1]) + 1
    time = np.linspace(recorded.time[0], recorded.time[-1], n_frames)
    time[frame] = recorded.time
    shape = n_frames, *recorded.position.shape[1:]
    position, director = np.full(shape, math.nan), np.full(shape, math.nan)
    position[frame], director[frame] = recorded.position, recorded.director
    return Tracks(time, recorded.swimmer, position, director)


def lag_averages(
    recorded: Tracks,
    quantity: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray],
    *,
    lags: np.ndarray | None = None,
) -> TimeAverages:
    """Average over starts a quantity of displacements, directors before and after, (n_starts, n_swimmers, 3) each.

    `lags` (n_lags,), in a/U, are whole numbers of frames above 0; by default 30 in geometric order up to half of
    the run.
    """
    frames = _whole_frames(recorded, lags)
    each = np.empty((len(frames), len(recorded.swimmer)))
    for i, n in enumerate(frames):
        step = recorded.position[n:] - recorded.position[:-n]
        each[i] = mean_of_known(quantity(step, recorded.director[:-n], recorded.director[n:]), axis=0)
    interval = recorded.time[1] - recorded.time[0] if len(recorded.time) > 1 else 0.0
    return TimeAverages(frames * interval, each)


def geometric_frames(first: int, last: int, n: int) -> np.ndarray:
    """Up to `n` whole numbers from `first` to `last`, evenly spaced in their logarithm."""
    if last < first or first < 1:
        return np.zeros(0, int)
    return np.unique(np.rint(np.geomspace(first, last, n)).astype(int))


def _whole_frames(recorded: Tracks, lags: np.ndarray | None) -> np.ndarray:
    n_frames = len(recorded.time)
    if lags is None:
        return geometric_frames(1, int(LONGEST * (n_frames - 1)), N_LAGS)
    if n_frames < 2:
        raise ResultsError(f"trajectory: found {n_frames} frames; a lag needs two")
    interval = recorded.time[1] - recorded.time[0]
    frames = np.rint(np.asarray(lags) / interval).astype(int)
    wrong = (np.abs(frames * interval - lags) > 1e-6 * interval) | (frames < 1) | (frames >= n_frames)
    if np.any(wrong):
        raise ResultsError(
            f"lags: found {np.asarray(lags)[wrong][0]:g} a/U, allowed are multiples of {interval:g} "
            f"up to {interval * (n_frames - 1):g}"
        )
    return frames
