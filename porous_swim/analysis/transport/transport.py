"""How far swimmers get: mean squared displacement, effective diffusivity, director correlation.

Displacements and lags run from the start of the run, so that the swimmers are independent samples at
every lag. Lengths in a, times in a/U.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import DIRECTORS, PLACES, column, needs, numbered, vectors
from porous_swim.analysis.estimates import Estimate
from porous_swim.core.errors import ResultsError
from porous_swim.results.tables import TableInfo

_SPARSEST, _SMALL = 20, 1 << 20  # places of a grid of frames and swimmers for each row; a grid that is never too large
PERSISTENCE_TIMES_WANTED = 10.0  # the ballistic start then changes a late slope by less than 1 %


@dataclass(frozen=True)
class Tracks:
    """The recorded swimmers as arrays, frame by frame; NaN where a swimmer is missing from a frame."""

    time: np.ndarray  # (n_frames,) a/U
    swimmer: np.ndarray  # (n_swimmers,)
    position: np.ndarray  # (n_frames, n_swimmers, 3) a, unwrapped
    director: np.ndarray  # (n_frames, n_swimmers, 3); NaN in a table without directors

    @property
    def gaps(self) -> bool:
        """Whether a swimmer is missing from a frame."""
        return bool(np.isnan(self.position).any())


@dataclass(frozen=True)
class Lagged:
    """A quantity averaged over swimmers against lag: the time since the start, or between any two frames."""

    lag: np.ndarray  # (n_lags,) a/U
    value: np.ndarray  # (n_lags,)
    standard_error: np.ndarray  # (n_lags,), over swimmers; NaN for a single one
    n: int  # swimmers; at each lag those count that are there


@dataclass(frozen=True)
class Diffusivity:
    """Effective diffusivity: late slope of the squared displacement over twice the dimensions, in a U."""

    value: float
    standard_error: float  # over swimmers
    n: int  # swimmers
    window: tuple[float, float]  # a/U, the lags of the fit
    reliable: bool  # False where the run is shorter than 10 persistence times
    reason: str | None = None
    """Why `value` is not to be trusted: a sentence for reports and summaries; None where it is."""

    def estimate(self) -> Estimate:
        """The diffusivity with its error and count."""
        return Estimate(self.value, self.standard_error, self.n, 0, "a U")


@needs(trajectory=PLACES)
def tracks(trajectory: pa.Table) -> Tracks:
    """Arrays from a table of trajectories. Frames from which a swimmer is missing are missing, not interpolated.

    A frame is a time at which a swimmer is there. Tables need no directors where only displacements are asked for.

    Raises:
        ResultsError: a swimmer twice at one time, or swimmers that have hardly a time in common.
    """
    time, swimmer = column(trajectory, "time"), column(trajectory, "swimmer")
    if np.any(np.diff(time) < 0.0) or np.any((np.diff(time) == 0.0) & (np.diff(swimmer) < 0)):
        order = np.lexsort((swimmer, time))
        trajectory = trajectory.take(pa.array(order))
        time, swimmer = time[order], swimmer[order]
    new = np.append(True, np.diff(time) > 0.0)[: len(time)]
    times, (swimmers, number) = time[new], numbered(swimmer)
    shape = (len(times), len(swimmers))
    place = (np.cumsum(new) - 1) * shape[1] + number  # in the grid; rows are in its order
    again = np.flatnonzero(np.diff(place) == 0)
    if len(again):
        raise ResultsError(
            f"trajectory: found swimmer {swimmer[again[0]]} twice at time {time[again[0]]:g}; "
            "each swimmer must be there once at most at each time"
        )
    if shape[0] * shape[1] > max(_SPARSEST * len(time), _SMALL):
        raise ResultsError(
            f"trajectory: found {len(time)} rows for {shape[0]} times and {shape[1]} swimmers; "
            f"each swimmer must be there at one of {_SPARSEST} times at least on average"
        )
    names = [("x", "y", "z"), ("ex", "ey", "ez")]
    position, director = (_grid(trajectory, each, place, shape) for each in names)
    return Tracks(times, swimmers, position, director)


def _grid(trajectory: pa.Table, names: tuple[str, ...], place: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Vectors (n_frames, n_swimmers, 3) from rows at places of the grid; NaN elsewhere and without such columns."""
    if set(names) <= set(trajectory.schema.names) and len(place) == shape[0] * shape[1]:
        return vectors(trajectory, *names).reshape(*shape, 3)
    found = np.full((shape[0] * shape[1], 3), math.nan)
    if set(names) <= set(trajectory.schema.names):
        found[place] = vectors(trajectory, *names)
    return found.reshape(*shape, 3)


@needs(trajectory=PLACES)
def msd(trajectory: pa.Table) -> Lagged:
    """Mean squared displacement from the start over the recorded swimmers that are there in the first frame, a^2."""
    recorded = tracks(trajectory)
    return _over_swimmers(recorded, _squared_displacement(recorded))


@needs(trajectory=f"{PLACES} {DIRECTORS}")
def director_correlation(trajectory: pa.Table) -> Lagged:
    """Mean of e(t).e(0) over the recorded swimmers that are there in the first frame."""
    recorded = tracks(trajectory)
    return _over_swimmers(recorded, np.sum(recorded.director * recorded.director[:1], axis=2))


@needs(trajectory=PLACES)
def diffusivity(trajectory: pa.Table, *, persistence_time: float) -> Diffusivity:
    """Effective diffusivity from the second half of the run. The table needs its `TableInfo`.

    Each recorded swimmer gives one independent estimate, the least-squares slope of its squared
    displacement over 2 x dimensions; their mean is the slope of the MSD. Swimmers that are missing from the first
    frame, or from one of the second half, do not count. `persistence_time` is 1/((dimensions - 1) D_r), in a/U.
    """
    recorded = tracks(trajectory)
    lag = _lag(recorded)
    duration = float(lag[-1]) if len(lag) else 0.0
    late = lag >= 0.5 * duration
    window = (float(lag[late][0]), duration) if len(lag) else (0.0, 0.0)
    reliable = duration >= PERSISTENCE_TIMES_WANTED * persistence_time
    squares = _squared_displacement(recorded)[late]
    squares = squares[:, ~np.isnan(squares).any(axis=0)] if recorded.gaps else squares
    n = squares.shape[1]
    if n == 0 or np.count_nonzero(late) < 2:
        reason = "There is no diffusivity: it needs swimmers and two frames in the second half of the run."
        return Diffusivity(math.nan, math.nan, 0, window, False, reason)
    centred = lag[late] - lag[late].mean()
    slope = centred @ squares / np.sum(centred**2)  # (n_swimmers,)
    each = slope / (2.0 * TableInfo.of(trajectory).dimensions)
    error = float(np.std(each, ddof=1)) / math.sqrt(n) if n > 1 else math.nan
    if reliable:
        return Diffusivity(float(np.mean(each)), error, n, window, True)
    reason = (
        f"The run of {duration:g} a/U is shorter than {PERSISTENCE_TIMES_WANTED:g} persistence times "
        f"({persistence_time:.3g} a/U each): the value is the slope from {window[0]:g} a/U on, no diffusivity yet."
    )
    return Diffusivity(float(np.mean(each)), error, n, window, False, reason)


def _lag(recorded: Tracks) -> np.ndarray:
    return recorded.time - recorded.time[:1]


def _squared_displacement(recorded: Tracks) -> np.ndarray:
    """(n_frames, n_swimmers), a^2."""
    return np.sum((recorded.position - recorded.position[:1]) ** 2, axis=2)


def _over_swimmers(recorded: Tracks, values: np.ndarray) -> Lagged:
    """Mean and standard error over swimmers of values (n_frames, n_swimmers); NaN counts as missing."""
    n = int(np.count_nonzero(~np.isnan(values).all(axis=0)))
    return Lagged(_lag(recorded), mean_of_known(values, axis=1), error_of_mean(values), n)


def mean_of_known(values: np.ndarray, *, axis: int) -> np.ndarray:
    """Mean of what is not NaN along an axis of (n, m); NaN where nothing is known."""
    known = ~np.isnan(values)
    if values.shape[axis] and known.all():
        return np.asarray(np.mean(values, axis=axis))
    count = known.sum(axis=axis)
    total = np.where(known, values, 0.0).sum(axis=axis)
    return np.divide(total, count, out=np.full(total.shape, math.nan), where=count > 0)


def error_of_mean(values: np.ndarray) -> np.ndarray:
    """Standard error of the mean of what is known over the second axis of (n_lags, n_swimmers).

    NaN for fewer than two swimmers.
    """
    known, n = ~np.isnan(values), values.shape[1]
    if n > 1 and known.all():
        return np.asarray(np.std(values, axis=1, ddof=1) / math.sqrt(n))
    count = known.sum(axis=1)
    squares = np.where(known, (values - mean_of_known(values, axis=1)[:, None]) ** 2, 0.0).sum(axis=1)
    missing = np.full(len(values), math.nan)
    return np.sqrt(np.divide(squares, (count - 1) * count, out=missing, where=count > 1))
