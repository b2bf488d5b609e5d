"""Maximum-likelihood fits of laws to lengths of time of which some were cut off. Times in a/U."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np
from scipy.stats import t as student

from porous_swim.analysis.estimates import Swimmers
from porous_swim.analysis.lifetimes.lifetime_laws import LAWS, Law, Sample
from porous_swim.analysis.lifetimes.lifetimes import Lifetimes

LawName = Literal["exponential", "inverse_gaussian", "power_law"]
_STEP = 1e-3  # of finite differences in a logarithm: they are off by some 1e-6 of themselves


@dataclass(frozen=True)
class FittedParameter:
    """A parameter of a law."""

    value: float
    standard_error: float
    """Over swimmers (sandwich): holds too where one swimmer's lengths are alike, or the law is not quite right."""
    model_error: float
    """From the observed information, which takes the lengths for independent and the law for right."""
    interval: tuple[float, float]
    """Confidence interval from `standard_error`, symmetric in the parameter's logarithm."""
    unit: str


@dataclass(frozen=True, eq=False)
class LifetimeFit:
    """A law fitted to lengths above a cutoff; NaN in errors that there are none of."""

    law: LawName
    parameters: dict[str, FittedParameter]
    cutoff: float
    log_likelihood: float
    """Of the lengths above the cutoff, given that they are above it. Compare laws at one cutoff only."""
    n: int  # ends seen
    n_censored: int  # lengths cut off
    n_below: int  # lengths at or below the cutoff, left out
    level: float  # coverage of the intervals
    coordinates: np.ndarray  # (k,) see `lifetime_laws`

    @property
    def aic(self) -> float:
        """Akaike's information criterion: the law with the least is nearest to the data, as far as they tell."""
        return 2.0 * len(self.coordinates) - 2.0 * self.log_likelihood

    def survival(self, length: np.ndarray) -> np.ndarray:
        """Probability (n,) to exceed lengths (n,), given that the cutoff is exceeded."""
        beyond = np.maximum(length, self.cutoff)
        return np.exp(LAWS[self.law].log_survival(beyond, self.coordinates, self.cutoff))

    def draw(self, rng: np.random.Generator, n: int) -> np.ndarray:
        """Random lengths (n,) of the fitted law, above the cutoff."""
        return LAWS[self.law].draw(rng, n, self.coordinates, self.cutoff)


def fit_lifetimes(lifetimes: Lifetimes, law: LawName, *, cutoff: float = 0.0, level: float = 0.95) -> LifetimeFit:
    """Fit a law to the lengths above `cutoff` whose start was seen; ends not seen count as such.

    The power law needs a cutoff above 0. Without an end above the cutoff there is no fit: its values are NaN. So they
    are where the likelihood has no maximum: an inverse Gaussian for equal lengths, or for so few ends that its mean may
    be infinite.

    Raises:
        ValueError: an unknown law, or a cutoff that the law does not take.
    """
    if law not in LAWS:
        raise ValueError(f"law: found {law!r}, allowed are {', '.join(LAWS)}")
    rules = LAWS[law]
    if not (cutoff > 0.0 or (cutoff == 0.0 and not rules.needs_cutoff)):
        raise ValueError(f"cutoff: found {cutoff:g}, {law} takes {'> 0' if rules.needs_cutoff else '>= 0'}")
    seen = lifetimes.select(lifetimes.start_seen)
    used = seen.select(seen.length > cutoff)
    sample = Sample(used.length, used.ended, cutoff)
    n = int(np.count_nonzero(sample.ended))
    coordinates = rules.most_likely(sample) if n else np.full(len(rules.parameters), math.nan)
    robust, model = _errors(rules, sample, coordinates, Swimmers.of(used.swimmer))
    return LifetimeFit(
        law=law,
        parameters=_parameters(rules, coordinates, robust, model, n_swimmers=len(np.unique(used.swimmer)), level=level),
        cutoff=cutoff,
        log_likelihood=float(np.sum(rules.log_likelihoods(sample, coordinates))) if n else math.nan,
        n=n,
        n_censored=len(used) - n,
        n_below=len(seen) - len(used),
        level=level,
        coordinates=coordinates,
    )


def _errors(rules: Law, sample: Sample, coordinates: np.ndarray, swimmers: Swimmers) -> tuple[np.ndarray, np.ndarray]:
    """Standard errors of the coordinates, (k,) each: over swimmers, and from the information alone."""
    k = len(coordinates)
    nothing = np.full(k, math.nan)
    if not np.all(np.isfinite(coordinates)):
        return nothing, nothing
    moves = _STEP * np.eye(k)

    def total(at: np.ndarray) -> float:
        return float(np.sum(rules.log_likelihoods(sample, at)))

    information = np.empty((k, k))
    for i, a in enumerate(moves):
        for j, b in enumerate(moves):
            corners = total(coordinates + a + b) - total(coordinates + a - b)
            corners -= total(coordinates - a + b) - total(coordinates - a - b)
            information[i, j] = -corners / (4.0 * _STEP**2)
    if not np.all(np.linalg.eigvalsh(information) > 0.0):  # no maximum inside: the data do not bound a parameter
        return nothing, nothing
    covariance = np.linalg.inv(information)
    model = np.sqrt(np.diag(covariance))
    if swimmers.n < 2:
        return nothing, model
    scores = [
        swimmers.sums(rules.log_likelihoods(sample, coordinates + a) - rules.log_likelihoods(sample, coordinates - a))
        for a in moves
    ]
    influence = covariance @ np.array(scores) / (2.0 * _STEP)  # (k, n_swimmers)
    return np.sqrt(swimmers.n / (swimmers.n - 1) * np.sum(influence**2, axis=1)), model


def _parameters(
    rules: Law, coordinates: np.ndarray, robust: np.ndarray, model: np.ndarray, *, n_swimmers: int, level: float
) -> dict[str, FittedParameter]:
    reach = float(student.ppf(0.5 + 0.5 * level, max(n_swimmers - 1, 1))) * robust
    value, low, high = (rules.values(at) for at in (coordinates, coordinates - reach, coordinates + reach))
    scale = np.exp(coordinates)
    return {
        name: FittedParameter(
            float(value[i]), float(scale[i] * robust[i]), float(scale[i] * model[i]),
            (float(low[i]), float(high[i])), rules.units[i],
        )
        for i, name in enumerate(rules.parameters)
    }  # fmt: skip
