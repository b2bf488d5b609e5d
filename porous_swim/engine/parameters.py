"""The numbers of a run: what they mean, and what follows from them. In a, U and a/U."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True, eq=False)
class Laws:
    """A table of parameter sets, one row each: structure is compiled, these are arguments."""

    dipole_strength: np.ndarray  # (n_sets,) alpha
    aspect_ratio: np.ndarray  # (n_sets,) gamma
    translational_diffusion: np.ndarray  # (n_sets,) a U
    rotational_diffusion: np.ndarray  # (n_sets,) U/a
    escape_sine: np.ndarray  # (n_sets,); above 1: never; below -1: the lift-off pitch of each colloid

    def table(self, time_step: float) -> np.ndarray:
        """(n_sets, len(Law)) float64, the columns in the order of `Law`."""
        squared = self.aspect_ratio**2
        kick = np.sqrt(2.0 * self.translational_diffusion * time_step)
        turn = np.sqrt(2.0 * self.rotational_diffusion * time_step)
        bretherton = (1.0 - squared) / (1.0 + squared)
        return np.stack([self.dipole_strength, bretherton, kick, turn, self.aspect_ratio, self.escape_sine], axis=1)


@dataclass(frozen=True)
class Numbers:
    """The numbers of a run that all swimmers share, in a, U and a/U."""

    time_step: float
    escape_height: float
    contact_band: float
    seed: int
    flight_ticks: int = 1
    """Time steps that a free swimmer far from every colloid takes at once, from multiples of them on."""


def flight_height(laws: Laws, numbers: Numbers) -> float:
    """The height from which on a swimmer may fly, a: no flight then touches a colloid or feels its flow change.

    It stays above 2: kicks reach 5.4 standard deviations along each axis, and the reflected flow is no faster than
    3 alpha/(4 h^2). In a flight the flow that the swimmer meets changes by at most 0.03.
    """
    T = numbers.flight_ticks * numbers.time_step
    alpha, D = float(np.abs(laws.dipole_strength).max()), float(laws.translational_diffusion.max())
    lowest = max(2.0, (50.0 * alpha * T) ** (1.0 / 3.0))  # there T dU/dh = 3 alpha T/(2 h^3) is 0.03
    return lowest + T * (1.0 + 0.75 * alpha / lowest**2) + 5.4 * math.sqrt(3.0 * 2.0 * D * T)
