"""Displacements over lags, of all swimmers, summed on the device while a run goes on: no trajectory is kept for them.

Windows begin every 1, 4, 16, 64, ... frames, and each is looked back to up to a length of four times that: at lags of
1, 2, 3, 4 frames; 5, 6, 7, 8, 10, 12, 14, 16; 20, 24, 28, 32, 40, ... Those of the longest lags begin more often, so
that four or more have such a lag. Each stands for the frames about its beginning, half the way to the next on either
side: so every part of the run counts alike at every lag, the release too. Windows of one lag overlap up to four times;
errors come from groups of swimmers, which are independent whatever overlaps.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass

import numpy as np

from porous_swim.engine.kernel.survey import Groups, Survey

COLUMNS = ("lag", "group", "n_swimmers", "n_windows", "msd", "fourth_moment", "director_correlation")
OPEN = 4  # windows of a spacing that are under way at a time
MOST_SPACINGS = 7  # levels have a bit each in 32: lags up to 16384 frames
LONGEST = 0.5  # of the run: beyond, too few windows would be there to add anything to those of `timeseries`


@dataclass(frozen=True)
class Spacing:
    """Windows that begin every `frames` frames, from half of that on, and the lags at which they are looked back to."""

    frames: int
    lags: tuple[int, ...]  # in frames

    def begins(self, frame: int, q: int) -> bool:
        """Whether the q-th window of the `OPEN` under way begins anew at `frame`."""
        since = frame - self.frames // 2 - q * self.frames
        return since >= 0 and since % (OPEN * self.frames) == 0


def spacings(n_frames: int) -> list[Spacing]:
    """Those that a run of `n_frames` after the first needs, up to its longest lag."""
    longest = _longest(n_frames)
    every = [(1, (1, 2, 3, 4))]
    every += [
        (4**k, tuple(part * 4 ** (k - 1) for part in (5, 6, 7, 8, 10, 12, 14, 16))) for k in range(1, MOST_SPACINGS)
    ]
    wanted = itertools.takewhile(lambda each: each[1][0] <= longest, every)
    found = [Spacing(frames, tuple(lag for lag in lags if lag <= longest)) for frames, lags in wanted]
    last = found[-1]
    return [*found[:-1], Spacing(min(last.frames, -(-last.lags[-1] // OPEN)), last.lags)]


def n_levels(n_frames: int, *, burn_in: int = 0) -> int:
    """Levels of the survey of such a run: the start, and four windows under way for each spacing."""
    return 1 + OPEN * len(spacings(n_frames - burn_in))


class Lags:
    """The sums of a run. `note` every frame that there is, at multiples of `period` steps."""

    def __init__(self, survey: Survey, *, period: int, n_frames: int, burn_in: int = 0) -> None:
        """Windows begin from frame `burn_in` on; the q-th of the k-th spacing has level 1 + 4 k + q of `survey`."""
        self._survey, self._period, self._burn_in = survey, period, burn_in
        self._windows = [(spacing, q) for spacing in spacings(n_frames - burn_in) for q in range(OPEN)]
        begun = [burn_in == 0 and spacing.begins(0, q) for spacing, q in self._windows]
        self._born: list[int | None] = [0 if now else None for now in begun]  # frame of the present origin
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
        begin = [i for i, (spacing, q) in enumerate(self._windows) if spacing.begins(frame - self._burn_in, q)]
        wanted = [i for i, (spacing, _) in enumerate(self._windows) if lags[i] in spacing.lags]
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
        longest = _longest(self._last - self._burn_in)  # of a run that was interrupted less than of the whole
        lags = sorted(lag for lag in self._sums if lag <= longest)
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


def _longest(n_frames: int) -> float:
    return max(1.0, LONGEST * n_frames)
