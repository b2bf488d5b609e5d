"""Lengths of time of which some were cut off: one row for each thing that lasts. Times in a/U."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from porous_swim.analysis.survival import SurvivalCurve, WaitingTimes, survival_curve, waiting_times


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
        """Means with errors: see `waiting_times`."""
        return waiting_times(
            self.length, ended=self.ended, swimmer=self.swimmer, start_seen=self.start_seen, horizon=horizon
        )

    def survival(self) -> SurvivalCurve:
        """Kaplan-Meier curve of those whose start was seen."""
        return survival_curve(self.length[self.start_seen], ended=self.ended[self.start_seen])
