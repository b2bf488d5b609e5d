"""Whether a fitted law could have made the lengths that were seen."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from porous_swim.analysis.lifetimes.lifetime_fits import LifetimeFit
from porous_swim.analysis.lifetimes.lifetime_laws import LAWS, Sample
from porous_swim.analysis.lifetimes.lifetimes import Lifetimes
from porous_swim.analysis.lifetimes.survival import survival_curve


@dataclass(frozen=True)
class GoodnessOfFit:
    """Largest distance between the fitted survival and the Kaplan-Meier curve, and how often chance exceeds it."""

    distance: float
    p_value: float
    """Share of samples drawn from the fitted law, cut off and fitted alike, that lie at least as far from their fit."""
    n_repeats: int


def goodness_of_fit(lifetimes: Lifetimes, fit: LifetimeFit, *, n_repeats: int = 199, seed: int = 0) -> GoodnessOfFit:
    """Kolmogorov-Smirnov test by parametric bootstrap, for lengths that are cut off at their `limit`.

    Each repeat draws a length for each one that was used in `fit`, cuts it off where the run would have, and fits the
    law again. Lengths are multiples of the time step in a run by Euler steps: samples so large that they resolve it
    reject every smooth law. Source: Stute, Gonzalez Manteiga and Presedo Quindimil, Metrika 40, 243 (1993).
    """
    used = lifetimes.select(lifetimes.start_seen & (lifetimes.length > fit.cutoff))
    if not np.all(np.isfinite(fit.coordinates)):
        return GoodnessOfFit(math.nan, math.nan, 0)
    rng = np.random.default_rng(seed)
    distance = _distance(Sample(used.length, used.ended, fit.cutoff), fit)
    n_further = 0
    for _ in range(n_repeats):
        length = fit.draw(rng, len(used))
        ended = length < used.limit
        if not ended.any():  # no fit and no curve to lie away from
            continue
        sample = Sample(np.minimum(length, used.limit), ended, fit.cutoff)
        again = replace(fit, coordinates=LAWS[fit.law].most_likely(sample))
        n_further += not _distance(sample, again) < distance  # no fit (NaN) counts as far
    return GoodnessOfFit(distance, (1 + n_further) / (1 + n_repeats), n_repeats)


def _distance(sample: Sample, fit: LifetimeFit) -> float:
    """Supremum over all times up to the last end, on both sides of each step of the curve."""
    curve = survival_curve(sample.length, ended=sample.ended)
    law = fit.survival(curve.time)
    before = np.concatenate([[1.0], curve.probability[:-1]])
    return float(np.max(np.maximum(np.abs(curve.probability - law), np.abs(before - law))))
