"""Displacements over lags, of all swimmers, summed on the device while a run goes on: no trajectory is kept for them.

Windows begin every 1, 4, 16, 64, ... frames, and each is looked back to up to a length of four times that: at lags of
1, 2, 3, 4 frames; 5, 6, 7, 8, 10, 12, 14, 16; 20, 24, 28, 32, 40, ... So windows of one lag overlap up to four times,
and all of the run counts at every lag; errors come from groups of swimmers, which are independent whatever overlaps.
"""

from __future__ import annotations

import itertools

import numpy as np

from porous_swim.engine.survey import Groups, Survey

COLUMNS = ("lag", "group", "n_swimmers", "n_windows", "msd", "fourth_moment", "director_correlation")
OPEN = 4  # windows of a spacing that are under way at a time
MOST_SPACINGS = 7  # levels have a bit each in 32: lags up to 16384 frames
LONGEST = 0.5  # of the run: beyond, too few windows would be there to add anything to those of `timeseries`


def ages(spacing: int) -> list[int]:
    """The lags, in frames, of windows that begin every `spacing` frames."""
    return [1, 2, 3, 4] if spacing == 1 else [part * (spacing // 4) for part in (5, 6, 7, 8, 10, 12, 14, 16)]


def spacings(n_frames: int) -> list[int]:
    """From window to window, in frames: those that a run of `n_frames` after the first needs."""
    wanted = (4**k for k in range(1, MOST_SPACINGS))
    return [1, *itertools.takewhile(lambda spacing: ages(spacing)[0] <= LONGEST * n_frames, wanted)]


def n_levels(n_frames: int) -> int:
    """Levels of the survey of such a run: the start, and four windows under way for each spacing."""
    return 1 + OPEN * len(spacings(n_frames))


class Lags:
    """The sums of a run. `note` every frame that there is, at multiples of `period` steps."""

    def __init__(self, survey: Survey, *, period: int, n_frames: int) -> None:
        """Windows that begin at frames q, q + 4, ... times the k-th spacing have level 1 + 4 k + q of `survey`."""
        self._survey, self._period = survey, period
        self._windows = [(spacing, q) for spacing in spacings(n_frames) for q in range(OPEN)]
        self._longest = max(1.0, LONGEST * n_frames)
        self._born: list[int | None] = [0 if q == 0 else None for _, q in self._windows]  # frame of the present origin
        self._last = 0
        self._sums: dict[int, np.ndarray] = {}  # by lag in frames: rows of squares, their squares, overlaps
        self._n_windows: dict[int, int] = {}

    def note(self, step: int) -> Groups:
        """All swimmers now, at `step`, since the start; their lags are taken in, too, unless this is no new frame."""
        frame = step // self._period
        if step % self._period or frame <= self._last:
            return self._survey.look([0])[0]
        self._last = frame
        lags = [0 if born is None else frame - born for born in self._born]
        begin = [i for i, (spacing, q) in enumerate(self._windows) if (frame - q * spacing) % (OPEN * spacing) == 0]
        wanted = [i for i, (spacing, _) in enumerate(self._windows) if lags[i] in ages(spacing)]
        wanted = [i for i in wanted if lags[i] <= self._longest]
        due = sorted({*wanted, *begin})
        start, *groups = self._survey.look([0, *(i + 1 for i in due)], renew=[i + 1 for i in begin])
        for i, found in zip(due, groups, strict=True):
            if i in wanted:
                self._add(lags[i], found)
        for i in begin:
            self._born[i] = frame
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
