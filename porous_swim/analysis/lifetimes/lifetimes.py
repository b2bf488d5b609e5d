"""Lengths of time of which some were cut off: one row for each thing that lasts. Times in a/U."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from porous_swim.analysis.lifetimes.survival import SurvivalCurve, WaitingTimes, survival_curve, waiting_times

_FOLLOWED = 0.25  # share of the samples that could have been seen to last to the end of a mean


@dataclass(frozen=True, eq=False)
class Lifetimes:
    """How long each of n things lasted, and what was seen of it."""

    length: np.ndarray  # (n,) a/U, as far as it was seen
    ended: np.ndarray  # (n,) bool, whether the end was seen
    start_seen: np.ndarray  # (n,) bool; only those have a known length
    limit: np.ndarray  # (n,) a/U, the longest length that could have been seen
    swimmer: np.ndarray  # (n,)

    def __len__(self) -> int:
        """Number of lifetimes."""
        return len(self.length)

    @classmethod
    def joined(cls, parts: Iterable[Lifetimes]) -> Lifetimes:
        """All lifetimes of `parts`, one or more, in their order."""
        every = [vars(part) for part in parts]
        return cls(**{name: np.concatenate([part[name] for part in every]) for name in every[0]})

    def select(self, chosen: np.ndarray) -> Lifetimes:
        """The lifetimes where the mask `chosen` (n,) holds."""
        return Lifetimes(**{name: values[chosen] for name, values in vars(self).items()})

    def summary(self, *, horizon: float | None = None) -> WaitingTimes:
        """Means with errors: see `waiting_times`, which has `horizon` too."""
        return waiting_times(
            self.length, ended=self.ended, swimmer=self.swimmer, start_seen=self.start_seen,
            horizon=horizon, follow_up=self.follow_up() if horizon is None else None,
        )  # fmt: skip

    def follow_up(self) -> float | None:
        """A time, a/U, to which at least a quarter of those whose start was seen could be followed, however long.

        It is the `limit` itself where a quarter have the greatest one (all were released together, say), else rounded
        down to 1, 2 or 5 times a power of ten. So runs alike have it in common, and it does not depend on how long
        anything lasted. None where no limit is known.
        """
        limit = self.limit[self.start_seen]
        if len(limit) == 0:
            return None
        reached = float(np.quantile(limit, 1.0 - _FOLLOWED, method="lower"))
        if not 0.0 < reached < math.inf:
            return None
        if reached == float(np.max(limit)):
            return reached
        power = 10.0 ** math.floor(math.log10(reached))
        return max(step * power for step in (1.0, 2.0, 5.0) if step * power <= reached)

    def survival(self) -> SurvivalCurve:
        """Kaplan-Meier curve of those whose start was seen."""
        return survival_curve(self.length[self.start_seen], ended=self.ended[self.start_seen])
