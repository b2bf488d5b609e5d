"""Displacements over lags, of all swimmers, summed on the device while a run goes on: no trajectory is kept for them.

Windows of a lag do not overlap. Origins are renewed every 1, 4, 16, 64, ... frames, and each serves the lags up to its
age then that the one before is too young for: 1; 2, 3, 4; 5, 6, 7, 8, 10, 12, 14, 16; 20, 24, 28, 32, 40, ...
"""

from __future__ import annotations

import numpy as np

from porous_swim.engine.survey import Groups, Survey

COLUMNS = ("lag", "group", "n_swimmers", "n_windows", "msd", "fourth_moment", "director_correlation")
LONGEST = 0.5  # of the run: beyond, too few windows would be there to add anything to those of `timeseries`


def ages(period: int) -> list[int]:
    """The ages, in frames, at which an origin that is renewed every `period` is looked back to."""
    if period == 1:
        return [1]
    if period == 4:
        return [2, 3, 4]
    return [part * (period // 16) for part in (5, 6, 7, 8, 10, 12, 14, 16)]


def periods(n_frames: int) -> list[int]:
    """Frames between renewals of the origins that a run of `n_frames` after the first needs."""
    found = [1]
    while ages(4 * found[-1])[0] <= LONGEST * n_frames:
        found.append(4 * found[-1])
    return found


def n_levels(n_frames: int) -> int:
    """Levels of the survey of such a run."""
    return 1 + len(periods(n_frames))


class Lags:
    """The sums of a run. `note` every frame that there is, at multiples of `period` steps."""

    def __init__(self, survey: Survey, *, period: int, n_frames: int) -> None:
        """Level k + 1 of `survey` keeps the origin of the k-th of `periods(n_frames)`, level 0 the start."""
        self._survey, self._period, self._periods = survey, period, periods(n_frames)
        self._ages = [[age for age in ages(p) if age <= max(1.0, LONGEST * n_frames)] for p in self._periods]
        self._born = [0] * len(self._periods)  # frame of the present origin
        self._last = 0
        self._sums: dict[int, np.ndarray] = {}  # by lag in frames: rows of squares, their squares, overlaps
        self._n_windows: dict[int, int] = {}

    def note(self, step: int) -> Groups:
        """All swimmers now, at `step`, since the start; their lags are taken in, too, unless this is no new frame."""
        frame = step // self._period
        if step % self._period or frame <= self._last:
            return self._survey.look([0])[0]
        self._last = frame
        lags = [frame - born for born in self._born]
        ends = [level for level, period in enumerate(self._periods) if frame % period == 0]
        wanted = [level for level, lag in enumerate(lags) if lag in self._ages[level]]
        due = sorted({*wanted, *ends})
        start, *groups = self._survey.look([0, *(level + 1 for level in due)], renew=[level + 1 for level in ends])
        for level, found in zip(due, groups, strict=True):
            if level in wanted:
                self._add(lags[level], found)
        for level in ends:
            self._born[level] = frame
        return start

    def columns(self) -> dict[str, np.ndarray]:
        """Columns of the table of lags: a row for each lag and group, shortest lag first; the lag counted in frames."""
        lags = sorted(self._sums)
        n = self._survey.group_sizes
        if not lags:
            return {name: np.zeros(0) for name in COLUMNS}
        means = np.stack([self._sums[lag] / self._n_windows[lag] for lag in lags])  # (n_lags, 3, n_groups)
        values = np.repeat(lags, len(n)), np.tile(np.arange(len(n)), len(lags)), np.tile(n, len(lags))
        windows = np.repeat([self._n_windows[lag] for lag in lags], len(n))
        return dict(zip(COLUMNS, (*values, windows, *(means[:, k].ravel() for k in range(3))), strict=True))

    def _add(self, lag: int, groups: Groups) -> None:
        fourth = groups.spread / groups.n + groups.square**2
        values = np.stack([groups.square, fourth, groups.overlap])
        self._sums[lag] = self._sums.get(lag, 0.0) + values
        self._n_windows[lag] = self._n_windows.get(lag, 0) + 1
