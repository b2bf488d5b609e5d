"""Displacements over lags, of all swimmers, summed while a run goes on: see `engine.windows`."""

from __future__ import annotations

import numpy as np

from porous_swim.core.state import State
from porous_swim.engine.kernel.ensemble_sums import Groups
from porous_swim.engine.windows import longest_lag
from porous_swim.observers.base import Every, Frame, Observer

COLUMNS = ("lag", "group", "n_swimmers", "n_windows", "msd", "fourth_moment", "director_correlation")


class Lags(Observer):
    """The sums of a run, over windows that end at frames of its record, multiples of `period` steps.

    Swimmers come in groups of `group_sizes`, (n_groups,). Windows begin from frame `burn_in` on.
    """

    def __init__(self, group_sizes: np.ndarray, *, period: int, burn_in: int = 0) -> None:
        self.schedule = Every(period)
        self._group_sizes, self._period, self._burn_in = group_sizes, period, burn_in
        self._last = 0  # frame
        self._sums: dict[int, np.ndarray] = {}  # by lag in frames: rows of squares, their squares, overlaps
        self._n_windows: dict[int, int] = {}

    def observe(self, frame: Frame) -> None:
        """Take in the windows that end now."""
        if frame.step % self._period == 0:
            self._last = frame.step // self._period
        for lag, groups in frame.ensemble.windows:
            self._add(lag, groups)

    def state(self) -> dict[str, np.ndarray]:
        """The sums; where windows began is in the state of the simulation."""
        lags = list(self._sums)
        return {
            "last": np.array(self._last),
            "lags": np.array(lags, dtype=np.int64),
            "n_windows": np.array([self._n_windows[lag] for lag in lags], dtype=np.int64),
            "sums": np.array([self._sums[lag] for lag in lags], dtype=float).reshape(-1, 3, len(self._group_sizes)),
        }

    def restore(self, state: State) -> None:
        """Go on from the `state` of another such run."""
        self._last, lags = int(state["last"]), state["lags"].tolist()
        self._sums = {lag: sums.copy() for lag, sums in zip(lags, state["sums"], strict=True)}
        self._n_windows = dict(zip(lags, state["n_windows"].tolist(), strict=True))

    def columns(self) -> dict[str, np.ndarray]:
        """Columns of the table of lags: a row for each lag and group, shortest lag first; the lag counted in frames."""
        longest = longest_lag(self._last - self._burn_in)  # of a run that was interrupted less than of the whole
        lags = sorted(lag for lag in self._sums if lag <= longest)
        n = self._group_sizes
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
