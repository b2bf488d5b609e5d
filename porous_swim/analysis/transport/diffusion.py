"""Effective diffusivity: a line through mean squared displacements in a window of lags that the data choose. In a U."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pyarrow as pa
from scipy.stats import t as student

from porous_swim.analysis.columns import DIRECTORS, PLACES, needs
from porous_swim.analysis.estimates import Estimate
from porous_swim.analysis.transport.diffusive_window import LINEAR, Choice, Fitted, choose, fitted_to, memory_of
from porous_swim.analysis.transport.lagged import (
    LONGEST,
    TimeAverages,
    director_overlap,
    even_frames,
    geometric_frames,
    lag_averages,
    squared_step,
)
from porous_swim.analysis.transport.straight_line import Line, fit_line, lines_of, mean_slope
from porous_swim.results.tables import TableInfo

FEWEST_LAGS, MOST_LAGS = 4, 8
SWIMMERS_PER_LAG = 5  # fewer leave the covariance of the lags too uncertain to invert
FEWEST_SWIMMERS = FEWEST_LAGS * SWIMMERS_PER_LAG


@dataclass(frozen=True)
class EffectiveDiffusivity:
    """Slope of the mean squared displacement over twice the dimensions, with a free offset."""

    value: float
    """NaN where the run tells none; of a window that was given and is not linear the mean slope from end to end."""
    standard_error: float  # over swimmers
    interval: tuple[float, float]
    level: float  # coverage of `interval`
    offset: float
    """Of the fitted line at lag 0, a^2: below 0 after a ballistic start, above 0 after one that is trapped."""
    window: tuple[float, float]
    """a/U, the lags of the fit. Where two halves of the swimmers have different ones, those of the later one; without a
    diffusivity those of the window that came nearest."""
    n_lags: int  # in the window
    p_value: float
    """That a straight line in the window deviates as much by chance."""
    linear: bool
    """Whether `value` is a diffusivity. Where it is not, `reason` says why."""
    n: int  # swimmers
    reason: str | None = None
    """Why there is no diffusivity, or why `value` is none: a sentence for reports and summaries."""

    def estimate(self) -> Estimate:
        """The diffusivity with its error and count."""
        return Estimate(self.value, self.standard_error, self.n, 0, "a U")


@needs(trajectory=f"{PLACES} {DIRECTORS}")
def effective_diffusivity(
    trajectory: pa.Table, *, window: tuple[float, float] | None = None, level: float = 0.95
) -> EffectiveDiffusivity:
    """Fit time-averaged mean squared displacements at 4 to 8 lags. The table needs its `TableInfo`.

    Each swimmer gives a slope, by least squares with the weights that are best for Brownian motion; value and error are
    their mean and its error. Whether a line fits is tested by Hotelling's T^2. `window`, in a/U, fixes the lags. By
    default it ends at half of the run; its start, and whether there is one, follows from `diffusive_window`. Needs 20
    swimmers or more: NaN else.
    """
    recorded = even_frames(trajectory)
    n, n_frames = len(recorded.swimmer), len(recorded.time)
    interval = float(recorded.time[1] - recorded.time[0]) if n_frames > 1 else math.nan
    last = int(LONGEST * (n_frames - 1)) if n_frames > 1 else 0
    if window is not None and n_frames > 1:
        last = min(int(window[1] / interval + 1e-6), n_frames - 1)
    n_lags = min(MOST_LAGS, n // SWIMMERS_PER_LAG)

    def window_from(start: float) -> TimeAverages | None:
        frames = geometric_frames(max(math.ceil(start / interval - 1e-6), 1), last, n_lags)
        if len(frames) < FEWEST_LAGS:
            return None
        return lag_averages(recorded, squared_step, lags=frames * interval).complete()

    about = DiffusivityFit(n, TableInfo.of(trajectory), level)
    if window is not None:
        return about.given(window_from(window[0]) if last else None)
    if last < 1 or n_lags < FEWEST_LAGS:
        return about.nothing(none_for(n))
    lags = geometric_frames(1, last, 4 * last.bit_length()) * interval
    squares, directors = (lag_averages(recorded, of, lags=lags) for of in (squared_step, director_overlap))
    return about.chosen(window_from, squares, directors)


def none_for(n: int) -> str:
    """Why there is none for `n` swimmers: a sentence for reports and summaries."""
    return (
        f"There is no effective diffusivity: it needs {FEWEST_SWIMMERS} swimmers whose trajectories differ, of {n} "
        f"here, and {2 * FEWEST_LAGS} frames after the first (record.every)."
    )


@dataclass(frozen=True)
class DiffusivityFit:
    """What holds for every fit to the displacements of `n` swimmers."""

    n: int
    info: TableInfo
    level: float

    def nothing(self, reason: str, tried: Fitted | None = None) -> EffectiveDiffusivity:
        """None, and why."""
        none = (math.nan, math.nan)
        lag = np.array(none) if tried is None else tried.squares.lag
        p_value = math.nan if tried is None else tried.line.p_value
        return EffectiveDiffusivity(
            math.nan, math.nan, none, self.level, math.nan, (float(lag[0]), float(lag[-1])),
            0 if tried is None else len(lag), p_value, False, self.n, reason,
        )  # fmt: skip

    def given(self, squares: TimeAverages | None) -> EffectiveDiffusivity:
        """The line in a window; where none fits, the mean slope from end to end."""
        if squares is None:
            return self.nothing(f"There is no effective diffusivity: the window has fewer than {FEWEST_LAGS} lags.")
        line = fit_line(squares)
        if line is None:
            return self.nothing(none_for(self.n))
        if line.p_value > LINEAR:
            return self.fitted(squares, line)
        ends = replace(mean_slope(squares), p_value=line.p_value)
        return self.fitted(squares, ends, _not_linear(squares, line.p_value))

    def chosen(
        self, window_from: Callable[[float], TimeAverages | None], squares: TimeAverages, directors: TimeAverages
    ) -> EffectiveDiffusivity:
        """The mean slope of two halves of the swimmers, each in the window that the other half tells to take."""
        if not np.all(squares.value > 0.0):
            return self.nothing(none_for(self.n))
        halves = slice(0, None, 2), slice(1, None, 2)
        last = float(squares.lag[-1])

        def choice(half: slice) -> Choice:
            memory = memory_of(
                _of(squares, half), _of(directors, half), n_swimmers=self.n, dimensions=self.info.dimensions,
                spacing=self.info.spacing,
            )  # fmt: skip

            def from_half(start: float) -> TimeAverages | None:
                found = window_from(start)
                return None if found is None else _of(found, half)

            return choose(from_half, first=float(squares.lag[0]), last=last, memory=memory)

        choices = [choice(half) for half in halves]
        starts = np.array([told.start for told in choices[::-1]])
        while np.max(starts) <= 0.5 * last * (1.0 + 1e-9):
            late = fitted_to(window_from(float(np.max(starts))))
            parts = [window_from(float(start)) for start in starts]
            if late is not None and late.linear:
                lines = [
                    lines_of(_of(part, half)) for part, half in zip(parts, halves, strict=True) if part is not None
                ]
                offset, slope = (np.concatenate(each) for each in zip(*lines, strict=True))
                return self.fitted(late.squares, Line.of(offset, slope, late.line.p_value))
            starts *= 2.0
        worst = max(choices, key=lambda told: (told.start, told.memory.lag))
        if worst.tried is None:
            return self.nothing(none_for(self.n))
        return self.nothing(_why_none(worst, squares, self.info), worst.tried)

    def fitted(self, squares: TimeAverages, line: Line, reason: str | None = None) -> EffectiveDiffusivity:
        """That of a line; with a `reason` a mean slope that is none."""
        scale = 0.5 / self.info.dimensions
        value, error = scale * line.slope, scale * line.standard_error
        reach = float(student.ppf(0.5 + 0.5 * self.level, squares.n - 1)) * error
        return EffectiveDiffusivity(
            value, error, (value - reach, value + reach), self.level, line.offset,
            (float(squares.lag[0]), float(squares.lag[-1])), len(squares.lag), line.p_value, reason is None, self.n,
            reason,
        )  # fmt: skip


def _not_linear(squares: TimeAverages, p_value: float) -> str:
    return (
        f"No straight line fits the mean squared displacement from {squares.lag[0]:g} to {squares.lag[-1]:g} a/U "
        f"(p = {p_value:.2g}): the value is the mean slope from end to end, and no diffusivity."
    )


def _of(squares: TimeAverages, half: slice) -> TimeAverages:
    return TimeAverages(squares.lag, squares.each[:, half])


def _why_none(told: Choice, squares: TimeAverages, info: TableInfo) -> str:
    memory, tried = told.memory, told.tried
    what, last, time = "There is no effective diffusivity: ", float(squares.lag[-1]), memory.turning
    if math.isinf(time):
        return f"{what}swimmers keep their directors for longer than {last:g} a/U, about half of the run."
    if memory.directors > 0.5 * last:
        wanted = f"some {memory.directors / (0.5 * LONGEST * time):.2g}" if math.isfinite(memory.directors) else "more"
        found = (info.duration - info.burn_in) / time
        return (
            f"{what}the run lasts for {found:.2g} persistence times of the directors ({time:.3g} a/U each), and "
            f"{wanted} are needed."
        )
    if memory.medium > 0.5 * last:
        return (
            f"{what}within {0.5 * last:g} a/U, a quarter of the run, swimmers go too short a way (in half of it "
            f"{math.sqrt(squares.value[-1]):.3g} a, root mean square) among colloids {info.spacing:.3g} a apart."
        )
    if tried is None or tried.linear:
        return (
            f"{what}the mean squared displacement grows linearly in the last windows of lags alone, up to {last:g} "
            "a/U, and no later ones confirm that the motion is diffusive."
        )
    return (
        f"{what}in no window of lags up to {last:g} a/U does the mean squared displacement grow linearly "
        f"(p = {tried.line.p_value:.2g} in the last): the motion is not yet diffusive."
    )
