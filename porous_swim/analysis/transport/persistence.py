"""How far swimmers keep their direction. Lengths in a, times in a/U."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import DIRECTORS, PLACES, needs
from porous_swim.analysis.estimates import Estimate
from porous_swim.analysis.transport.lagged import (
    TimeAverages,
    director_overlap,
    error_of_mean,
    even_frames,
    lag_averages,
    scalar_products,
)


@dataclass(frozen=True)
class Persistence:
    """Persistence length: mean displacement along the first director, once the director has forgotten it."""

    length: Estimate
    """U/((d - 1) D_r) for a free swimmer in d dimensions."""
    lag: float  # a/U, where it is read
    reached: bool
    """False where the correlation of directors does not vanish in the run: `length` is then too small."""
    projection: TimeAverages
    """Mean displacement along the first director against lag, a."""
    correlation: TimeAverages
    """Mean of e(t + lag).e(t)."""

    @property
    def reason(self) -> str | None:
        """Why `length` is not to be trusted: a sentence for reports and summaries; None where it is."""
        if self.reached:
            return None
        if len(self.correlation.lag) == 0:
            return "There is no persistence length: it needs three frames at equal intervals (record.every)."
        return (
            f"Directors are remembered for longer than {self.lag:g} a/U, half of the run: the persistence length is "
            "longer than what was seen of it."
        )


@needs(trajectory=f"{PLACES} {DIRECTORS}")
def persistence(trajectory: pa.Table, *, lags: np.ndarray | None = None) -> Persistence:
    """Project displacements on the director at their start, as far as the first lag at which that is forgotten.

    That is the first lag at which the correlation of directors is less than two standard errors above 0. What is
    left of it there is taken to decay exponentially: the length is projection/(1 - correlation), without which some
    two errors were missing. Where swimmers orbit the correlation crosses 0 after a quarter of an orbit: the length is
    then that of the arc. See `lag_averages` for `lags`.
    """
    recorded = even_frames(trajectory)
    projection = lag_averages(recorded, lambda step, before, after: scalar_products(step, before), lags=lags)
    correlation = lag_averages(recorded, director_overlap, lags=lags)
    forgotten = np.flatnonzero(correlation.value < 2.0 * correlation.standard_error)
    if len(projection.lag) == 0:
        return Persistence(Estimate(math.nan, math.nan, 0, 0, "a"), math.nan, False, projection, correlation)
    reached = len(forgotten) > 0
    at = int(forgotten[0]) if reached else len(projection.lag) - 1
    lost = 1.0 - float(correlation.value[at]) if reached else 1.0
    value = float(projection.value[at]) / lost
    # What each swimmer adds to the ratio, to first order (infinitesimal jackknife).
    each = (projection.each[at] + (value * correlation.each[at] if reached else 0.0)) / lost
    length = Estimate(value, float(error_of_mean(each[None])[0]), projection.n, 0, "a")
    return Persistence(length, float(projection.lag[at]), reached, projection, correlation)
