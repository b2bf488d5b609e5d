"""How far swimmers get: mean squared displacement, effective diffusivity, director correlation.

Displacements and lags run from the start of the run, so that the swimmers are independent samples at
every lag. Lengths in a, times in a/U.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import column, numbered, vectors
from porous_swim.analysis.estimates import Estimate
from porous_swim.errors import ResultsError
from porous_swim.tables import TableInfo

PERSISTENCE_TIMES_WANTED = 10.0  # the ballistic start then changes a late slope by less than 1 %


@dataclass(frozen=True)
class Tracks:
    """The recorded swimmers as arrays, frame by frame."""

    time: np.ndarray  # (n_frames,) a/U
    swimmer: np.ndarray  # (n_swimmers,)
    position: np.ndarray  # (n_frames, n_swimmers, 3) a, unwrapped
    director: np.ndarray  # (n_frames, n_swimmers, 3)


@dataclass(frozen=True)
class Lagged:
    """A quantity averaged over swimmers against lag: the time since the start, or between any two frames."""

    lag: np.ndarray  # (n_lags,) a/U
    value: np.ndarray  # (n_lags,)
    standard_error: np.ndarray  # (n_lags,), over swimmers; NaN for a single one
    n: int  # swimmers


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


def tracks(trajectory: pa.Table) -> Tracks:
    """Arrays from a table of trajectories; `ResultsError` unless each swimmer is once in each frame."""
    time, swimmer = column(trajectory, "time"), column(trajectory, "swimmer")
    if np.any(np.diff(time) < 0.0) or np.any((np.diff(time) == 0.0) & (np.diff(swimmer) < 0)):
        order = np.lexsort((swimmer, time))
        trajectory = trajectory.take(pa.array(order))
        time, swimmer = time[order], swimmer[order]
    times, swimmers = time[np.append(True, np.diff(time) > 0.0)[: len(time)]], numbered(swimmer)[0]
    shape = (len(times), len(swimmers))
    # Rows as many as the grid has places, and each place taken: every swimmer once in every frame.
    if len(time) != shape[0] * shape[1] or np.any(swimmer.reshape(shape) != swimmers):
        raise ResultsError(
            f"trajectory: found {len(time)} rows for {shape[0]} times and {shape[1]} swimmers; "
            "each swimmer must be there once at each time"
        )
    position = vectors(trajectory, "x", "y", "z").reshape(*shape, 3)
    director = vectors(trajectory, "ex", "ey", "ez").reshape(*shape, 3)
    return Tracks(times, swimmers, position, director)


def msd(trajectory: pa.Table) -> Lagged:
    """Mean squared displacement from the start over the recorded swimmers, a^2."""
    recorded = tracks(trajectory)
    return _over_swimmers(recorded, _squared_displacement(recorded))


def director_correlation(trajectory: pa.Table) -> Lagged:
    """Mean of e(t).e(0) over the recorded swimmers."""
    recorded = tracks(trajectory)
    return _over_swimmers(recorded, np.sum(recorded.director * recorded.director[:1], axis=2))


def diffusivity(trajectory: pa.Table, *, persistence_time: float) -> Diffusivity:
    """Effective diffusivity from the second half of the run. The table needs its `TableInfo`.

    Each recorded swimmer gives one independent estimate, the least-squares slope of its squared
    displacement over 2 x dimensions; their mean is the slope of the MSD. `persistence_time` is
    1/((dimensions - 1) D_r), in a/U.
    """
    recorded = tracks(trajectory)
    n = len(recorded.swimmer)
    lag = _lag(recorded)
    duration = float(lag[-1]) if len(lag) else 0.0
    late = lag >= 0.5 * duration
    window = (float(lag[late][0]), duration) if len(lag) else (0.0, 0.0)
    reliable = duration >= PERSISTENCE_TIMES_WANTED * persistence_time
    if n == 0 or np.count_nonzero(late) < 2:
        reason = "There is no diffusivity: it needs swimmers and two frames in the second half of the run."
        return Diffusivity(math.nan, math.nan, 0, window, False, reason)
    centred = lag[late] - lag[late].mean()
    slope = centred @ _squared_displacement(recorded)[late] / np.sum(centred**2)  # (n_swimmers,)
    each = slope / (2.0 * TableInfo.of(trajectory).dimensions)
    error = float(np.std(each, ddof=1)) / math.sqrt(n) if n > 1 else math.nan
    if reliable:
        return Diffusivity(float(np.mean(each)), error, n, window, True)
    doubt = (
        f"The run of {duration:g} a/U is shorter than {PERSISTENCE_TIMES_WANTED:g} persistence times "
        f"({persistence_time:.3g} a/U each): the value is the slope from {window[0]:g} a/U on, no diffusivity yet."
    )
    return Diffusivity(float(np.mean(each)), error, n, window, False, doubt)


def _lag(recorded: Tracks) -> np.ndarray:
    return recorded.time - recorded.time[:1]


def _squared_displacement(recorded: Tracks) -> np.ndarray:
    """(n_frames, n_swimmers), a^2."""
    return np.sum((recorded.position - recorded.position[:1]) ** 2, axis=2)


def _over_swimmers(recorded: Tracks, values: np.ndarray) -> Lagged:
    """Mean and standard error over swimmers of values (n_frames, n_swimmers)."""
    n = len(recorded.swimmer)
    missing = np.full(len(recorded.time), math.nan)
    error = np.std(values, axis=1, ddof=1) / math.sqrt(n) if n > 1 else missing
    return Lagged(_lag(recorded), np.mean(values, axis=1) if n else missing, error, n)
