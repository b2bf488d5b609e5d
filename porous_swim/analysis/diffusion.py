"""Effective diffusivity by generalised least squares over a window of lags that the data choose. In a U."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import pyarrow as pa
from scipy.special import fdtrc
from scipy.stats import t as student

from porous_swim.analysis.columns import PLACES, needs
from porous_swim.analysis.estimates import Estimate
from porous_swim.analysis.lagged import LONGEST, TimeAverages, even_frames, geometric_frames, lag_averages, squared_step
from porous_swim.tables import TableInfo

LINEAR = 0.05  # p-value from which a window counts as linear
FEWEST_LAGS, MOST_LAGS = 4, 8
SWIMMERS_PER_LAG = 5  # fewer leave the covariance of the lags too uncertain to invert
FEWEST_SWIMMERS = FEWEST_LAGS * SWIMMERS_PER_LAG
MOST_GROUPS = 200  # of swimmers, left out in turn: its error is then known to 5 %
ALIKE = 1e-10  # relative spread of squared displacements


@dataclass(frozen=True)
class EffectiveDiffusivity:
    """Slope of the mean squared displacement over twice the dimensions, with a free offset."""

    value: float
    standard_error: float  # jackknife over swimmers
    interval: tuple[float, float]
    level: float  # coverage of `interval`
    offset: float
    """Of the fitted line at lag 0, a^2: below 0 after a ballistic start, above 0 after one that is trapped."""
    window: tuple[float, float]  # a/U, the lags of the fit
    n_lags: int  # in the window
    p_value: float
    """That a straight line in the window deviates from the data as much by chance."""
    linear: bool
    """False where no two windows in a row are, so that `value`, of the last one, may be no diffusivity yet."""
    n: int  # swimmers

    def estimate(self) -> Estimate:
        """The diffusivity with its error and count."""
        return Estimate(self.value, self.standard_error, self.n, 0, "a U")


@needs(trajectory=PLACES)
def effective_diffusivity(
    trajectory: pa.Table, *, window: tuple[float, float] | None = None, level: float = 0.95
) -> EffectiveDiffusivity:
    """Fit time-averaged mean squared displacements at 4 to 8 lags. The table needs its `TableInfo`.

    Displacements at different lags share their way and so are correlated: they are weighted by the inverse of their
    covariance over swimmers. Value and error are a delete-group jackknife of that, weights included (Busing, Meijer
    and van der Leeden, Stat. Comput. 9, 3 (1999)); the line is tested by Hotelling's T^2 of the residuals.
    `window`, in a/U, fixes the lags. By default it ends at half of the run and starts at twice the first lag, among
    halves of that half, halves of halves, ..., from which on the line fits with p > 0.05: where a line just fits, what
    is left of the start still biases it by about its error, but no more after as long again. Needs 20 swimmers or
    more: NaN else.
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
    windows = (geometric_frames(start, last, n_lags) for start in starts)
    squares = (
        lag_averages(recorded, squared_step, lags=frames * interval).complete()
        for frames in windows
        if len(frames) >= FEWEST_LAGS
    )
    dimensions = TableInfo.of(trajectory).dimensions
    return first_linear(squares, n=n, dimensions=dimensions, level=level, given=window is not None)


def first_linear(
    windows: Iterable[TimeAverages], *, n: int, dimensions: int, level: float, given: bool
) -> EffectiveDiffusivity:
    """The line in the first window that fits where the one before fitted too; in the only one that was `given`.

    The windows start later and later. Where none fits it is that of the last, and not `linear`; `n` samples are there.
    """
    found, fits_before = _nothing(n, level), given
    for squares in windows:
        found = _line(squares, dimensions=dimensions, level=level)
        if found.linear and fits_before:
            return found
        fits_before = found.linear
    return replace(found, linear=False)


def doubt_of(fit: EffectiveDiffusivity) -> str | None:
    """Why a fit is no diffusivity yet: a sentence for reports and summaries; None where it is."""
    if fit.linear:
        return None
    if fit.p_value > LINEAR:
        return (
            f"The mean squared displacement grows linearly in the last window of lags alone, {fit.window[0]:g} to "
            f"{fit.window[1]:g} a/U (p = {fit.p_value:.2g}): no later one confirms that the motion is diffusive."
        )
    return (
        f"In no window of lags up to {fit.window[1]:g} a/U does the mean squared displacement grow linearly "
        f"(p = {fit.p_value:.2g} in the last): the motion is not yet diffusive, or the windows are too short."
    )


def none_for(n: int) -> str:
    """Why there is none for `n` swimmers: a sentence for reports and summaries."""
    return (
        f"There is no effective diffusivity: it needs {FEWEST_SWIMMERS} swimmers whose ways differ, of {n} here, "
        f"and {2 * FEWEST_LAGS} frames after the first (record.every)."
    )


def _nothing(n: int, level: float) -> EffectiveDiffusivity:
    none = (math.nan, math.nan)
    return EffectiveDiffusivity(math.nan, math.nan, none, level, math.nan, none, 0, math.nan, False, n)


def _line(squares: TimeAverages, *, dimensions: int, level: float) -> EffectiveDiffusivity:
    """Generalised least squares of offset and slope, with the covariance of the swimmers' averages."""
    n, n_lags = squares.n, len(squares.lag)
    if not np.all(squares.value > 0.0):
        return _nothing(n, level)
    relative = squares.each / squares.value[:, None]  # lags differ by decades
    spread = np.cov(relative)
    # Swimmers alike but for rounding give no error to weight with.
    if np.max(np.diag(spread)) < ALIKE**2 or np.linalg.matrix_rank(spread, hermitian=True) < n_lags:
        return _nothing(n, level)
    design = np.stack([np.ones(n_lags), squares.lag], axis=1) / squares.value[:, None]
    line = _fit(np.ones(n_lags), spread, design)
    residual = 1.0 - design @ line
    hotelling = n * float(residual @ np.linalg.solve(spread, residual))
    excess, freedom = n_lags - 2, n - n_lags + 2
    p_value = float(fdtrc(excess, freedom, hotelling * freedom / ((n - 1) * excess)))
    slope, error, n_groups = _jackknife(relative, design, float(line[1]))
    value, error = 0.5 * slope / dimensions, 0.5 * error / dimensions
    reach = float(student.ppf(0.5 + 0.5 * level, n_groups - 1)) * error
    return EffectiveDiffusivity(
        value, error, (value - reach, value + reach), level, float(line[0]),
        (float(squares.lag[0]), float(squares.lag[-1])), n_lags, p_value, p_value > LINEAR, n,
    )  # fmt: skip


def _fit(mean: np.ndarray, spread: np.ndarray, design: np.ndarray) -> np.ndarray:
    """Offset and slope (..., 2) from means (..., m) with covariances (..., m, m)."""
    weighted = np.linalg.solve(spread, np.broadcast_to(design, (*spread.shape[:-1], 2)))  # (..., m, 2)
    turned = np.swapaxes(weighted, -1, -2)
    return np.asarray(np.linalg.solve(turned @ design, turned @ mean[..., None])[..., 0])


def _jackknife(relative: np.ndarray, design: np.ndarray, slope: float) -> tuple[float, float, int]:
    """Slope without its bias of order 1/n, its standard error, and the number of groups of swimmers left out in turn.

    The bias is that swimmers with small displacements have small variances and get the larger weights.
    """
    n = relative.shape[1]
    n_groups = min(n, MOST_GROUPS)
    begin = np.arange(n_groups) * n // n_groups
    size = np.diff(np.append(begin, n))
    rest = (n - size)[:, None]
    off = relative - 1.0  # from the mean, so that nothing cancels
    products = np.stack([np.add.reduceat(row * off, begin, axis=1) for row in off])  # (m, m, n_groups)
    mean = (np.sum(off, axis=1)[:, None] - np.add.reduceat(off, begin, axis=1)).T / rest  # (n_groups, m)
    second = (np.sum(products, axis=2)[..., None] - products).transpose(2, 0, 1) / rest[..., None]
    spread = second - mean[:, :, None] * mean[:, None, :]  # a common factor does not matter
    left_out = _fit(1.0 + mean, spread, design)[:, 1]
    share = n / size
    corrected = n_groups * slope - float(np.sum((1.0 - 1.0 / share) * left_out))
    pseudo = share * slope - (share - 1.0) * left_out
    return corrected, math.sqrt(float(np.mean((pseudo - corrected) ** 2 / (share - 1.0)))), n_groups
