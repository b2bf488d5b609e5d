"""Paired timings: contenders take turns, and a ratio is the median over the rounds, so that a busy machine hits all."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

Work = Callable[[], int]  # does some work and returns how many swimmer-steps it was


@dataclass(frozen=True)
class Ratio:
    """Median and quartiles over rounds."""

    median: float
    low: float
    high: float

    @classmethod
    def of(cls, ratios: np.ndarray) -> Ratio:
        """From the ratios of the rounds."""
        low, median, high = np.quantile(ratios, [0.25, 0.5, 0.75]).tolist()
        return cls(median, low, high)


def take_turns(
    contenders: Mapping[str, Work], rounds: int, *, clock: Callable[[], float] = time.process_time, pause: float = 0.0
) -> dict[str, np.ndarray]:
    """Nanoseconds per swimmer-step, (rounds,) for each contender, after one round that does not count.

    The default clock is CPU time of the process: what else the machine does matters little to one thread. Who sleeps
    for a `pause` (seconds) is owed time: a short turn after it runs at once, on as many cores as it asks for.
    """
    times: dict[str, list[float]] = {name: [] for name in contenders}
    for _ in range(rounds + 1):
        for name, work in contenders.items():
            time.sleep(pause)
            begin = clock()
            steps = work()
            times[name].append((clock() - begin) / steps * 1e9)
    return {name: np.array(taken[1:]) for name, taken in times.items()}


def fastest(times: Mapping[str, np.ndarray]) -> str:
    """The contender with the best round."""
    return min(times, key=lambda name: float(times[name].min()))
