"""Laws that lengths of time may follow: density, survival, random samples, parameters. Times in a/U.

A law is fitted in coordinates (k,) that are logarithms of positive quantities, so that no fit can leave its domain.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from scipy.optimize import minimize
from scipy.special import erfcx, log_ndtr

_FARTHEST = math.log(1e12)  # from the mean length to a parameter: beyond, the likelihood has no maximum


@dataclass(frozen=True, eq=False)
class Sample:
    """Lengths above a cutoff, those that ended and those that were cut off, in one array."""

    length: np.ndarray  # (n,)
    ended: np.ndarray  # (n,) bool
    cutoff: float
    """Only lengths above it are there: likelihoods are conditional on that."""


class Law(ABC):
    """One family of laws on lengths above 0 (above the cutoff for the power law)."""

    parameters: ClassVar[tuple[str, ...]]
    units: ClassVar[tuple[str, ...]]
    needs_cutoff: ClassVar[bool] = False
    offsets: ClassVar[tuple[float, ...]] = (0.0, 0.0)
    """A parameter is its offset plus the exponential of its coordinate."""

    def values(self, coordinates: np.ndarray) -> np.ndarray:
        """Parameters (k,) of coordinates (k,)."""
        return np.asarray(self.offsets[: len(coordinates)]) + np.exp(coordinates)

    @abstractmethod
    def log_density(self, length: np.ndarray, coordinates: np.ndarray, cutoff: float) -> np.ndarray:
        """Logarithm of the density at lengths (n,), given that they exceed the cutoff: (n,), per a/U."""

    @abstractmethod
    def log_survival(self, length: np.ndarray, coordinates: np.ndarray, cutoff: float) -> np.ndarray:
        """Logarithm of the probability to exceed lengths (n,), given that they exceed the cutoff: (n,)."""

    @abstractmethod
    def draw(self, rng: np.random.Generator, n: int, coordinates: np.ndarray, cutoff: float) -> np.ndarray:
        """Random lengths (n,) above the cutoff."""

    @abstractmethod
    def most_likely(self, sample: Sample) -> np.ndarray:
        """Coordinates (k,) of the maximum-likelihood fit to a sample with at least one end; NaN where there is none."""

    def log_likelihoods(self, sample: Sample, coordinates: np.ndarray) -> np.ndarray:
        """What each length adds to the logarithm of the likelihood, (n,)."""
        ended = self.log_density(sample.length, coordinates, sample.cutoff)
        return np.where(sample.ended, ended, self.log_survival(sample.length, coordinates, sample.cutoff))


class Exponential(Law):
    """A constant rate of ending, 1/mean."""

    parameters, units = ("mean",), ("a/U",)

    def log_density(self, length: np.ndarray, coordinates: np.ndarray, cutoff: float) -> np.ndarray:
        """See `Law`."""
        return self.log_survival(length, coordinates, cutoff) - coordinates[0]

    def log_survival(self, length: np.ndarray, coordinates: np.ndarray, cutoff: float) -> np.ndarray:
        """See `Law`."""
        return -(length - cutoff) * math.exp(-coordinates[0])

    def draw(self, rng: np.random.Generator, n: int, coordinates: np.ndarray, cutoff: float) -> np.ndarray:
        """See `Law`."""
        return cutoff + rng.exponential(math.exp(coordinates[0]), n)

    def most_likely(self, sample: Sample) -> np.ndarray:
        """Total time over ends seen."""
        return np.log([np.sum(sample.length - sample.cutoff) / np.count_nonzero(sample.ended)])


class PowerLaw(Law):
    """A density length^-exponent above the cutoff (Pareto's law)."""

    parameters, units, needs_cutoff, offsets = ("exponent",), ("",), True, (1.0,)

    def log_density(self, length: np.ndarray, coordinates: np.ndarray, cutoff: float) -> np.ndarray:
        """See `Law`."""
        return coordinates[0] - np.log(length) + self.log_survival(length, coordinates, cutoff)

    def log_survival(self, length: np.ndarray, coordinates: np.ndarray, cutoff: float) -> np.ndarray:
        """See `Law`."""
        return -math.exp(coordinates[0]) * np.log(length / cutoff)

    def draw(self, rng: np.random.Generator, n: int, coordinates: np.ndarray, cutoff: float) -> np.ndarray:
        """See `Law`: the logarithm of length/cutoff is exponential."""
        with np.errstate(over="ignore"):  # longer than any run
            return np.asarray(cutoff * np.exp(rng.exponential(math.exp(-coordinates[0]), n)))

    def most_likely(self, sample: Sample) -> np.ndarray:
        """Hill's estimate, ends seen over the sum of log(length/cutoff): Clauset et al., SIAM Rev. 51, 661 (2009)."""
        return np.log([np.count_nonzero(sample.ended) / np.sum(np.log(sample.length / sample.cutoff))])


class InverseGaussian(Law):
    """First passage of a drifting Brownian motion; variance = mean^3/shape."""

    parameters, units = ("mean", "shape"), ("a/U", "a/U")

    def log_density(self, length: np.ndarray, coordinates: np.ndarray, cutoff: float) -> np.ndarray:
        """See `Law`."""
        mean, shape = np.exp(coordinates)
        whole = (
            0.5 * (coordinates[1] - np.log(2.0 * math.pi * length**3))
            - 0.5 * shape * (length / mean - 1.0) ** 2 / length
        )
        return np.asarray(whole - self._log_survival(cutoff, coordinates))

    def log_survival(self, length: np.ndarray, coordinates: np.ndarray, cutoff: float) -> np.ndarray:
        """See `Law`."""
        return self._log_survival(length, coordinates) - self._log_survival(cutoff, coordinates)

    def draw(self, rng: np.random.Generator, n: int, coordinates: np.ndarray, cutoff: float) -> np.ndarray:
        """See `Law`; above a cutoff by bisection, which takes as long however few lengths get there."""
        mean, shape = np.exp(coordinates)
        if cutoff == 0.0:
            return rng.wald(mean, shape, n)
        aim = np.log(1.0 - rng.uniform(size=n))
        low, high = np.full(n, cutoff), np.full(n, 2.0 * cutoff)
        while np.any(short := self.log_survival(high, coordinates, cutoff) > aim):
            high = np.where(short, 2.0 * high, high)
        for _ in range(52):  # bits of a double
            middle = 0.5 * (low + high)
            short = self.log_survival(middle, coordinates, cutoff) > aim
            low, high = np.where(short, middle, low), np.where(short, high, middle)
        return high

    def most_likely(self, sample: Sample) -> np.ndarray:
        """By a simplex search from the closed form that would hold had nothing been cut off."""
        ends, cut = sample.length[sample.ended], sample.length[~sample.ended]
        n, total, inverse, logs = len(ends), np.sum(ends), np.sum(1.0 / ends), np.sum(np.log(ends))

        def cost(coordinates: np.ndarray) -> float:
            mean, shape = np.exp(coordinates)
            squares = total / mean**2 - 2.0 * n / mean + inverse
            density = 0.5 * n * (coordinates[1] - math.log(2.0 * math.pi)) - 1.5 * logs - 0.5 * shape * squares
            rest = np.sum(self._log_survival(cut, coordinates))
            return float((len(sample.length) * self._log_survival(sample.cutoff, coordinates) - density - rest) / n)

        mean = np.mean(sample.length)
        start = np.log([mean, 1.0 / max(inverse / n - n / total, 1e-6 / mean)])
        low, high = math.log(mean) - _FARTHEST, math.log(mean) + _FARTHEST
        found = minimize(
            cost, start, method="Nelder-Mead", bounds=[(low, high)] * 2,
            options={"xatol": 1e-8, "fatol": 1e-14, "maxiter": 2000},
        )  # fmt: skip
        inside = np.all((found.x > low + 1.0) & (found.x < high - 1.0))
        return np.asarray(found.x) if inside else np.full(2, math.nan)

    @staticmethod
    def _log_survival(length: np.ndarray | float, coordinates: np.ndarray) -> np.ndarray:
        """Phi(-u) - exp(2 shape/mean) Phi(-v), in the one of two forms in which nothing overflows or cancels."""
        mean, shape = np.exp(coordinates)
        x = np.maximum(length, 1e-200)  # so that a cutoff of 0 is no division by it
        scale = np.sqrt(shape / x)
        u, v = scale * (x / mean - 1.0), scale * (x / mean + 1.0)
        far = np.maximum(u, 0.0)
        with np.errstate(divide="ignore"):
            late = np.log(0.5 * (erfcx(far / math.sqrt(2.0)) - erfcx(v / math.sqrt(2.0)))) - 0.5 * far**2
            early = log_ndtr(-u) + np.log1p(-np.exp(np.minimum(2.0 * shape / mean + log_ndtr(-v) - log_ndtr(-u), 0.0)))
        return np.asarray(np.where(u > 0.0, late, early))


LAWS: dict[str, Law] = {"exponential": Exponential(), "inverse_gaussian": InverseGaussian(), "power_law": PowerLaw()}
