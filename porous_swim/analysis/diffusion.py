"""Effective diffusivity by generalised least squares over a window of lags that the data choose. In a U."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pyarrow as pa
from scipy.special import fdtrc
from scipy.stats import t as student

from porous_swim.analysis.estimates import Estimate
from porous_swim.analysis.lagged import LONGEST, Lags, even_frames, geometric_frames, lag_averages
from porous_swim.results import TableInfo

LINEAR = 0.1  # p-value from which a window counts as linear
FEWEST_LAGS, MOST_LAGS = 4, 8
SWIMMERS_PER_LAG = 5  # fewer leave the covariance of the lags too uncertain to invert


@dataclass(frozen=True)
class EffectiveDiffusivity:
    """Slope of the mean squared displacement over twice the dimensions, with a free offset."""

    value: float
    standard_error: float
    interval: tuple[float, float]
    level: float  # coverage of `interval`
    offset: float
    """Of the fitted line at lag 0, a^2: below 0 after a ballistic start, above 0 after one that is trapped."""
    window: tuple[float, float]  # a/U, the lags of the fit
    n_lags: int  # in the window
    p_value: float
    """That a straight line in the window deviates from the data as much by chance."""
    linear: bool
    """False where no window of the run is linear, so that `value` is no diffusivity yet."""
    n: int  # swimmers

    def estimate(self) -> Estimate:
        """The diffusivity with its error and count."""
        return Estimate(self.value, self.standard_error, self.n, 0, "a U")


def effective_diffusivity(
    trajectory: pa.Table, *, window: tuple[float, float] | None = None, level: float = 0.95
) -> EffectiveDiffusivity:
    """Fit time-averaged mean squared displacements at 4 to 8 lags. The table needs its `TableInfo`.

    Displacements at different lags share their way and so are correlated: the covariance is that of the swimmers.
    It is estimated, not known; the interval allows for that (Rao, Biometrika 46, 49 (1959), growth curves).
    `window`, in a/U, fixes the lags; by default it ends at half of the run and starts at the first of its halves,
    quarters, ..., from the shortest on, in which the line fits with p > 0.1. Needs 20 swimmers or more: NaN else.
    """
    recorded = even_frames(trajectory)
    n = len(recorded.swimmer)
    n_lags = min(MOST_LAGS, n // SWIMMERS_PER_LAG)
    n_frames = len(recorded.time)
    interval = float(recorded.time[1] - recorded.time[0]) if n_frames > 1 else math.nan
    if window is None:
        last = int(LONGEST * (n_frames - 1))
        starts = [last >> k for k in range(last.bit_length())][::-1] if last > 0 else []
    else:
        last = min(int(window[1] / interval + 1e-6), n_frames - 1) if n_frames > 1 else 0
        starts = [max(math.ceil(window[0] / interval - 1e-6), 1)] if n_frames > 1 else []
    found = None
    for start in starts:
        frames = geometric_frames(start, last, n_lags)
        if len(frames) < FEWEST_LAGS:
            continue
        squares = lag_averages(recorded, lambda step, before, after: np.sum(step**2, axis=2), lags=frames * interval)
        found = _line(squares, dimensions=TableInfo.of(trajectory).dimensions, level=level)
        if found.linear:
            return found
    return found or _nothing(n, level)


def _nothing(n: int, level: float) -> EffectiveDiffusivity:
    none = (math.nan, math.nan)
    return EffectiveDiffusivity(math.nan, math.nan, none, level, math.nan, none, 0, math.nan, False, n)


def _line(squares: Lags, *, dimensions: int, level: float) -> EffectiveDiffusivity:
    """Generalised least squares of offset and slope, with the covariance of the swimmers' averages."""
    n, n_lags, freedom = squares.n, len(squares.lag), squares.n - 1
    scale = squares.value  # lags differ by decades: the covariance is inverted in relative units
    design = np.stack([np.ones(n_lags), squares.lag], axis=1) / scale[:, None]
    spread = np.cov(squares.each / scale[:, None])
    if np.linalg.matrix_rank(spread, hermitian=True) < n_lags:  # swimmers alike: no error to weight with
        return _nothing(n, level)
    weight = np.linalg.inv(spread)
    covariance = np.linalg.inv(design.T @ weight @ design)
    offset, slope = covariance @ design.T @ weight @ np.ones(n_lags)
    residual = 1.0 - design @ np.array([offset, slope])
    excess = n_lags - 2
    hotelling = n * float(residual @ weight @ residual)
    p_value = float(fdtrc(excess, freedom - excess + 1, hotelling * (freedom - excess + 1) / (freedom * excess)))
    # Conditional on the residual, the slope has (1 + T^2/f) times the error that a known covariance would give, and
    # the estimated covariance is too small by (f - excess)/f: Rao's t with f - excess degrees of freedom.
    factor = (1.0 + hotelling / freedom) * freedom / (freedom - excess)
    per_slope = 0.5 / dimensions
    error = per_slope * math.sqrt(factor * covariance[1, 1] / n)
    reach = float(student.ppf(0.5 + 0.5 * level, freedom - excess)) * error
    value = per_slope * float(slope)
    return EffectiveDiffusivity(
        value, error, (value - reach, value + reach), level, float(offset),
        (float(squares.lag[0]), float(squares.lag[-1])), n_lags, p_value, p_value > LINEAR, n,
    )  # fmt: skip
