"""A figure of the benchmark: one number, what it was measured with, and the target where there is one."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from porous_swim.bench.reference import References
from porous_swim.bench.timing import Ratio


@dataclass(frozen=True)
class Counts:
    """How much is measured."""

    n_swimmers: int = 2048
    n_steps: int = 1000  # to a turn
    rounds: int = 11
    populations: tuple[int, ...] = (10**3, 10**4, 10**5, 10**6)
    lattices: tuple[int, ...] = (3, 6, 14, 29)  # cells along an edge: 10^2, 10^3, 10^4, 10^5 colloids
    frames: int = 800  # of the recording: the whole scene
    tolerance: float = 0.01  # total relative error of an answer


QUICK = Counts(n_swimmers=64, n_steps=8, rounds=2, populations=(64, 128), lattices=(1, 2), frames=2, tolerance=0.1)


@dataclass(frozen=True)
class Setting:
    """What every group of figures gets."""

    counts: Counts
    folder: Path  # for what is built and written
    references: References


@dataclass(frozen=True)
class Conditions:
    """What a figure depends on. One thread is timed by CPU time, more by wall time."""

    precision: str
    threads: int
    n_swimmers: int
    n_colloids: int
    n_steps: int
    dimensions: int = 3
    rounds: int = 1


@dataclass(frozen=True)
class Figure:
    """A measured number."""

    name: str
    value: float
    conditions: Conditions
    target: float | None = None
    at_least: bool = False  # the target is a lower bound
    unit: str = "ratio"
    quartiles: tuple[float, float] | None = None
    nanoseconds: dict[str, float] = field(default_factory=dict)  # per swimmer-step, best round of each contender

    @property
    def verdict(self) -> str:
        """Whether the target is met; empty without a target."""
        if self.target is None:
            return ""
        return "met" if (self.value >= self.target if self.at_least else self.value <= self.target) else "missed"

    def as_dict(self) -> dict[str, Any]:
        """Plain data, for machines."""
        return {**asdict(self), "verdict": self.verdict}


def compared(
    name: str, times: Mapping[str, np.ndarray], ours: str, theirs: str, conditions: Conditions,
    *, target: float | None = None,
) -> Figure:  # fmt: skip
    """The figure `ours` over `theirs` from paired times."""
    ratio = Ratio.of(times[ours] / times[theirs])
    best = {contender: float(times[contender].min()) for contender in (ours, theirs)}
    quartiles = ratio.low, ratio.high
    return Figure(name, ratio.median, conditions, target=target, quartiles=quartiles, nanoseconds=best)


Group = Callable[[Setting], Sequence[Figure]]
