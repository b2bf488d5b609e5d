"""At which pitch swimmers leave a colloid. Angles in rad."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import column, needs
from porous_swim.analysis.estimates import Estimate, Swimmers, ratio_of_sums
from porous_swim.analysis.histogram import Histogram, histogram


@dataclass(frozen=True)
class Departures:
    """Pitch at the end of completed encounters; errors over swimmers."""

    release: Estimate
    """Mean pitch when contact was last left: the escape pitch. Without noise that of lift-off."""
    release_distribution: Histogram
    exit: Estimate
    """Mean pitch when the height passed `encounter.escape_height`."""
    exit_distribution: Histogram


@needs(encounters="swimmer end_censored release_pitch exit_pitch")
def departures(encounters: pa.Table, *, n_bins: int = 60) -> Departures:
    """Pitches of release and exit, over `n_bins` bins from -pi/2 to pi/2."""
    completed = ~column(encounters, "end_censored")
    swimmer = column(encounters, "swimmer")[completed]
    edges = np.linspace(-0.5 * math.pi, 0.5 * math.pi, n_bins + 1)

    def mean(pitch: np.ndarray) -> Estimate:
        known = ~np.isnan(pitch)
        swimmers = Swimmers.of(swimmer[known])
        value, error = ratio_of_sums(swimmers.sums(pitch[known]), swimmers.sums(np.ones(known.sum())))
        return Estimate(value, error, int(known.sum()), int(np.count_nonzero(~completed)), "rad")

    release, leave = (column(encounters, name)[completed] for name in ("release_pitch", "exit_pitch"))
    return Departures(
        release=mean(release),
        release_distribution=histogram(release, edges=edges, swimmer=swimmer),
        exit=mean(leave),
        exit_distribution=histogram(leave, edges=edges, swimmer=swimmer),
    )
