"""How often intervals cover the truth, over repeats of a made-up experiment."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import t as student

from porous_swim.analysis.estimates import Estimate

LEVEL = 0.95


@dataclass(frozen=True)
class Statistic:
    """What is found in the data of an experiment, and what is true."""

    find: Callable[[Any], Any]
    """Gives estimates, a distribution, or values and errors."""
    truth: Any  # as many numbers as `find` gives
    rate: float = LEVEL  # at which its intervals are known to cover the truth, where not at the nominal one


@dataclass(frozen=True)
class Experiment:
    """Data of so many swimmers that can be drawn as often as needed, and the statistics of them."""

    draw: Callable[[np.random.Generator], Any]
    n_swimmers: int
    statistics: dict[str, Statistic]

    def coverage(self, *, repeats: int, seed: int = 1) -> dict[str, np.ndarray]:
        """Share of the repeats in which Student's interval of 95 % has the truth in it, for each number found."""
        rng = np.random.default_rng(seed)
        reach = student.ppf(0.5 + 0.5 * LEVEL, self.n_swimmers - 1)
        inside = {name: np.zeros(len(statistic.truth)) for name, statistic in self.statistics.items()}
        for _ in range(repeats):
            data = self.draw(rng)
            for name, statistic in self.statistics.items():
                value, error = _values_and_errors(statistic.find(data))
                inside[name] += np.abs(value - statistic.truth) <= reach * error  # a missing error covers nothing
        return {name: count / repeats for name, count in inside.items()}


def _values_and_errors(found: Any) -> tuple[np.ndarray, np.ndarray]:
    if hasattr(found, "density"):
        return found.density.ravel(), found.standard_error.ravel()
    if hasattr(found, "lag"):
        return found.value, found.standard_error
    if isinstance(found, tuple):
        return found
    estimates: list[Estimate] = list(found)
    return np.array([e.value for e in estimates]), np.array([e.standard_error for e in estimates])


def within(share: np.ndarray, rate: float, *, repeats: int) -> np.ndarray:
    """Whether shares of repeats are within four binomial standard errors of a rate: one false alarm in 16 000."""
    return np.abs(share - rate) <= 4.0 * math.sqrt(rate * (1.0 - rate) / repeats)
