"""When windows in time begin and end, over which displacements of all swimmers are summed: no trajectory is kept.

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

from porous_swim.core.state import State, fitting
from porous_swim.engine.kernel.ensemble_sums import EnsembleSums, Groups

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
    longest = longest_lag(n_frames)
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


def longest_lag(n_frames: int) -> float:
    """Of a run of `n_frames` after the first, in frames."""
    return max(1.0, LONGEST * n_frames)


class Windows:
    """Those of a run. `look` at every frame of its record, at multiples of `period` steps."""

    def __init__(self, survey: EnsembleSums, *, period: int, n_frames: int, burn_in: int = 0) -> None:
        """Windows begin from frame `burn_in` on; the q-th of the k-th spacing has level 1 + 4 k + q of `survey`."""
        self._survey, self._period, self._burn_in = survey, period, burn_in
        self._windows = [(spacing, q) for spacing in spacings(n_frames - burn_in) for q in range(OPEN)]
        begun = [burn_in == 0 and spacing.begins(0, q) for spacing, q in self._windows]
        self._born: list[int | None] = [0 if now else None for now in begun]  # frame of the present origin
        self._last = 0

    def look(self, step: int) -> tuple[Groups, list[tuple[int, Groups]]]:
        """All swimmers at `step`, since the start; and since the beginning of each window looked back to, with its lag.

        The latter are none unless this is a new frame of the record. Lags in frames.
        """
        frame = step // self._period
        if step % self._period or frame <= self._last:
            return self._survey.look([0])[0], []
        self._last = frame
        lags = [0 if born is None else frame - born for born in self._born]
        begin = [i for i, (spacing, q) in enumerate(self._windows) if spacing.begins(frame - self._burn_in, q)]
        wanted = [i for i, (spacing, _) in enumerate(self._windows) if lags[i] in spacing.lags]
        due = sorted({*wanted, *begin})
        start, *groups = self._survey.look([0, *(i + 1 for i in due)], renew=[i + 1 for i in begin])
        for i in begin:
            self._born[i] = frame
        return start, [(lags[i], found) for i, found in zip(due, groups, strict=True) if i in wanted]

    def state(self) -> dict[str, np.ndarray]:
        """The frames at which windows began, and all swimmers then."""
        born = [-1 if born is None else born for born in self._born]
        return {"last": np.array(self._last), "born": np.array(born, dtype=np.int64), **self._survey.state()}

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such run."""
        born = fitting(state, "born", np.zeros(len(self._windows), np.int64))
        self._last, self._born = int(state["last"]), [None if frame < 0 else frame for frame in born.tolist()]
        self._survey.restore(state)
