"""The numbers of a run: what they mean, and what follows from them. In a, U and a/U."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from porous_swim.core.numbers import Given, HasNumbers, numbers_of


class Moves(Protocol):
    """What a parameter set is made of; a scene is one."""

    @property
    def movers(self) -> Sequence[HasNumbers]:
        """The parts that have numbers in the kernels."""

    @property
    def given(self) -> Given:
        """What these depend on."""


@dataclass(frozen=True, eq=False)
class Parameters:
    """A table of parameter sets: which numbers there are is compiled, their values are arguments."""

    names: tuple[str, ...]
    table: np.ndarray  # (n_sets, n_numbers) float64

    @classmethod
    def of(cls, scenes: Sequence[Moves]) -> Parameters:
        """A set for each scene. They are of one kind: ValueError where they have different numbers."""
        sets = [numbers_of(scene.movers, scene.given) for scene in scenes]
        names = tuple(sets[0])
        for each in sets:
            if tuple(each) != names:
                raise ValueError(f"scenes of one run have the same numbers: found {tuple(each)} beside {names}")
        return cls(names, np.array([[each[name] for name in names] for each in sets], np.float64))

    def __len__(self) -> int:
        return len(self.table)

    def __getitem__(self, name: str) -> np.ndarray:
        """(n_sets,) values of a number."""
        return np.asarray(self.table[:, self.names.index(name)])


@dataclass(frozen=True)
class Numbers:
    """The numbers of a run that all swimmers share, in a, U and a/U."""

    time_step: float
    escape_height: float
    contact_band: float
    seed: int
    flight_ticks: int = 1
    """Time steps that a free swimmer far from every colloid takes at once, from multiples of them on."""
    flight_height: float = 0.0
    """The height from which on it does: see `flight_height`."""


def flight_height(alpha: float, D: float, T: float) -> float:
    """The height from which on a swimmer may fly for T, a: it then touches a colloid nor feels its flow change.

    For swimmers with dipole strengths up to |alpha| and diffusivities up to D. It stays above 2: kicks reach 5.4
    standard deviations along each axis, and the reflected flow is no faster than 3 alpha/(4 h^2). In a flight the flow
    that the swimmer meets changes by at most 0.03.
    """
    alpha = abs(alpha)
    lowest = max(2.0, (50.0 * alpha * T) ** (1.0 / 3.0))  # there T dU/dh = 3 alpha T/(2 h^3) is 0.03
    return lowest + T * (1.0 + 0.75 * alpha / lowest**2) + 5.4 * math.sqrt(3.0 * 2.0 * D * T)
