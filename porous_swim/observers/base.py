"""What an observer sees of a run, and when it wants to look."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

FREE, BOUND, CONTACT = 0, 1, 2  # states of a swimmer: in no encounter; above the contact band; in contact


@dataclass(frozen=True)
class Every:
    """Stateless schedule: the steps that are multiples of `period`. Safe to share and to resume."""

    period: int

    def next_step(self, step: int) -> int:
        """The first scheduled step after `step`."""
        return (step // self.period + 1) * self.period


@dataclass(frozen=True)
class Counts:
    """How often each event has happened since the start, over all swimmers."""

    n_captures: int
    n_escapes: int
    n_hops: int
    n_returns: int


@dataclass(frozen=True)
class Ensemble:
    """All swimmers of a run together."""

    n_swimmers: int
    fraction_bound: float  # in an encounter, in contact or not
    fraction_contact: float
    msd: float  # a^2, mean squared displacement from the start
    msd_standard_error: float  # over swimmers; NaN for a single one


@dataclass(frozen=True)
class Frame:
    """A run at one step: the swimmers that are looked at one by one, and all together. Arrays are copies."""

    step: int
    time: float  # a/U
    position: np.ndarray  # (n, 3) float64, a, unwrapped, of the first n swimmers
    director: np.ndarray  # (n, 3) float64, unit
    colloid: np.ndarray  # (n,) int32, the nearest; -1 where the field is empty
    image: np.ndarray  # (n, 3) int32, periodic image of that colloid
    state: np.ndarray  # (n,) uint8: FREE, BOUND or CONTACT
    ensemble: Ensemble
    has_colloids: bool
    counts: Counts
    # What is new since the last frame that says so; empty where `has_news` is not set.
    residence: np.ndarray  # (n,) float64, a/U: lengths of the encounters that ended
    winding: np.ndarray  # (n,) float64, turns: of those encounters
    under_way: np.ndarray  # (m,) float64, a/U: how long the encounters under way have lasted
    hop_time: np.ndarray  # (n_hops,) float64, a/U: lengths of the flights (hops) that ended
    hops: np.ndarray  # (n_hops, 2, 4) int32, of the same: colloid and periodic image, that left and that entered
    has_news: bool = True


class Observer(Protocol):
    """Looks at a run at its scheduled steps (and at step 0 and the last step). Never changes it."""

    schedule: Every

    def observe(self, frame: Frame) -> None:
        """Take in one frame; frames come in order of time."""

    def finish(self, *, interrupted: bool) -> None:
        """Close what is open. Called once, also after an interrupt or an error."""
