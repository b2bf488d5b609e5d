"""Straight lines through mean squared displacements against lag."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space
from scipy.special import fdtrc

from porous_swim.analysis.transport.lagged import TimeAverages, error_of_mean

ALIKE = 1e-10  # relative spread of squared displacements


@dataclass(frozen=True)
class Line:
    """A line through averages at some lags."""

    slope: float
    standard_error: float  # of the slope, over swimmers
    offset: float  # at lag 0
    p_value: float
    """That averages of a straight line deviate as much by chance: Hotelling's T^2."""

    @classmethod
    def of(cls, offset: np.ndarray, slope: np.ndarray, p_value: float) -> Line:
        """From those of swimmers, (n,) each."""
        return cls(float(np.mean(slope)), float(error_of_mean(slope[None])[0]), float(np.mean(offset)), p_value)


def fit_line(squares: TimeAverages) -> Line | None:
    """The mean of the lines of swimmers, and whether a line fits; None where they are alike or too few.

    The weights follow from the lags alone (`brownian_covariance`): no noise comes in by them, where a line fits the
    slope has no bias, and its error is that of a mean.
    """
    n, n_lags = squares.n, len(squares.lag)
    if n <= n_lags or not np.all(squares.value > 0.0):
        return None
    relative = squares.each / squares.value[:, None]  # lags differ by decades
    if np.max(np.var(relative, axis=1)) < ALIKE**2:
        return None
    design = _design(squares.lag)
    bend = null_space((design / squares.value[:, None]).T).T @ relative  # 0 on average where a line fits
    spread = np.cov(bend)
    if np.linalg.matrix_rank(spread, hermitian=True) < n_lags - 2:
        return None
    middle = np.mean(bend, axis=1)
    hotelling = n * float(middle @ np.linalg.solve(spread, middle))
    excess, freedom = n_lags - 2, n - n_lags + 2
    p_value = float(fdtrc(excess, freedom, hotelling * freedom / ((n - 1) * excess)))
    return Line.of(*lines_of(squares), p_value)


def lines_of(squares: TimeAverages) -> tuple[np.ndarray, np.ndarray]:
    """Offset and slope of each swimmer, (n,) each, by least squares weighted as for Brownian motion."""
    design = _design(squares.lag)
    weighted = np.linalg.solve(brownian_covariance(squares.lag), design)  # (n_lags, 2)
    offset, slope = np.linalg.solve(design.T @ weighted, weighted.T) @ squares.each
    return offset, slope


def mean_slope(squares: TimeAverages) -> Line:
    """From the first lag to the last, whatever lies between; no p-value."""
    rise = (squares.each[-1] - squares.each[0]) / (squares.lag[-1] - squares.lag[0])
    return Line.of(squares.each[0] - rise * squares.lag[0], rise, np.nan)


def _design(lag: np.ndarray) -> np.ndarray:
    return np.stack([np.ones(len(lag)), lag], axis=1)


def brownian_covariance(lag: np.ndarray) -> np.ndarray:
    """Of time-averaged squared displacements at lags (n,), up to a factor: (n, n).

    Squares of displacements over two intervals have a covariance that goes as their overlap squared; its average over
    starts is s^2 (t - s/3) for lags s <= t that are short against the run. Source: Qian, Sheetz and Elson, Biophys. J.
    60, 910 (1991), for many starts.
    """
    short, long = np.minimum.outer(lag, lag), np.maximum.outer(lag, lag)
    return np.asarray(short**2 * (long - short / 3.0))
