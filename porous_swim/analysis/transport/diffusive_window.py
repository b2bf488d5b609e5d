"""From which lag on displacements tell an effective diffusivity. Lengths in a, times in a/U.

Swimmers must have forgotten which way they went, and from which place between colloids; this is read off directors and
distances. And the mean squared displacement must have become a straight line: a test
rejects windows, and the one that is taken starts twice as late as the first that passed, for where a line just fits,
what is left of the start still biases it by about its error, but after as long again by a small part of it.

Swimmers whose directors happen to turn fast have windows that start early, and small slopes: so each half of the
swimmers tells where the window of the other half starts, and the noise of the one is not that of the other.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from porous_swim.analysis.transport.lagged import LONGEST, TimeAverages
from porous_swim.analysis.transport.straight_line import Line, fit_line

LITTLE = 0.25  # of the error, that what is left of the memory may come to
LINEAR = 0.01  # p-value from which a window counts as linear: it wrongly refuses one in a hundred


@dataclass(frozen=True)
class Memory:
    """How long displacements remember what diffusing swimmers have forgotten, in a/U; infinite beyond the lags."""

    turning: float
    """Until the correlation of directors has fallen to 1/e; 0 where none turns."""
    directors: float
    """The lag from which on what is left of it no longer shows in displacements."""
    medium: float
    """The same of the place between colloids from which swimmers went."""

    @property
    def lag(self) -> float:
        """The later of both."""
        return max(self.directors, self.medium)


def memory_of(
    squares: TimeAverages, directors: TimeAverages, *, n_swimmers: int, dimensions: int, spacing: float | None
) -> Memory:
    """Find it from averages at the same lags, the last one half of the run, and the mean distance of colloids in a.

    Of a persistent walk of speed 1 the slope at a lag t is below the last one by 2 turning exp(-t/turning). Among
    colloids that repeat at `spacing` it is off by parts that fall as exp(-k^2 MSD/(2 d)), k = 2 pi/spacing, as a
    density of that wavelength does. Either is gone where it is `LITTLE` of sqrt(t/(n_swimmers T)) of the slope, about
    the error of a slope over lags from t on in a run of length T. Directors that do not turn at all say nothing.
    """
    lag, correlation = squares.lag, directors.value
    little = LITTLE * np.sqrt(lag * LONGEST / (lag[-1] * n_swimmers))  # (n_lags,)
    crossed = 0.0
    if spacing is not None:
        decay = (2.0 * math.pi / spacing) ** 2 * squares.value / (2.0 * dimensions)
        crossed = _first(lag, np.exp(-decay) <= little)
    if np.ptp(correlation) <= 1e-9 * np.max(np.abs(correlation)):
        return Memory(0.0, 0.0, crossed)
    turning = _turning_time(lag, correlation, least=little[0] / LITTLE)
    if math.isinf(turning):
        return Memory(math.inf, math.inf, crossed)
    slope = squares.value[-1] / lag[-1]
    return Memory(turning, _first(lag, 2.0 * turning / slope * np.exp(-lag / turning) <= little), crossed)


def _first(lag: np.ndarray, holds: np.ndarray) -> float:
    return float(lag[np.argmax(holds)]) if holds.any() else math.inf


def _turning_time(lag: np.ndarray, correlation: np.ndarray, *, least: float) -> float:
    """Where |correlation| falls to 1/e for the last time, by exponentials between lags; `least` is its noise."""
    lag, size = np.append(0.0, lag), np.append(1.0, np.abs(correlation))
    last = int(np.flatnonzero(size >= math.exp(-1.0))[-1])
    if last + 1 == len(lag):
        return math.inf
    high, low = math.log(size[last]), math.log(max(size[last + 1], min(least, math.exp(-2.0))))
    return float(lag[last] + (lag[last + 1] - lag[last]) * (high + 1.0) / (high - low))


@dataclass(frozen=True)
class Fitted:
    """A window of lags and the line through it."""

    squares: TimeAverages
    line: Line

    @property
    def linear(self) -> bool:
        """Whether the line passes the test."""
        return self.line.p_value > LINEAR


@dataclass(frozen=True)
class Choice:
    """Where a window may start."""

    start: float  # a/U; infinite where none may
    memory: Memory
    tried: Fitted | None
    """The first window that passed the test, else the last of all; None where no line could be laid through any."""


def choose(window_from: Callable[[float], TimeAverages | None], *, first: float, last: float, memory: Memory) -> Choice:
    """Twice the start of the first linear window, or where the memory is gone: what is later.

    `window_from(start)` gives averages at lags from `start` to `last`, None where they are too few; windows start at
    halves, quarters, ... of `last`, down to `first`.
    """
    # the rounding of a whole number of doublings must not give the first window twice
    starts = [last / 2.0**k for k in range(math.ceil(math.log2(last / first) - 1e-9), 0, -1)] if last > first else []
    tried = None
    for start in starts:
        fitted = fitted_to(window_from(start))
        tried = tried if fitted is None else fitted
        if fitted is not None and fitted.linear:
            late = max(2.0 * start, memory.lag)
            return Choice(late if late <= 0.5 * last * (1.0 + 1e-9) else math.inf, memory, tried)
    return Choice(math.inf, memory, tried)


def fitted_to(squares: TimeAverages | None) -> Fitted | None:
    """The line through averages, where there are enough of them."""
    line = None if squares is None else fit_line(squares)
    return None if squares is None or line is None else Fitted(squares, line)
