"""Orbits: how the turns that swimmers wind around colloids are distributed. In turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import column, needs
from porous_swim.analysis.estimates import Estimate, Swimmers, ratio_of_sums
from porous_swim.analysis.histogram import Histogram, histogram


@dataclass(frozen=True)
class Orbits:
    """Distribution of winding over the completed encounters, which favour short ones; errors over swimmers."""

    winding: Histogram
    """Turns along the director, whichever way round."""
    signed_winding: Histogram
    """Net turns counterclockwise about +z; empty in three dimensions."""
    above_one_turn: Estimate
    """Share that wound more than one turn."""
    net_above_one_turn: Estimate
    """Share whose net winding exceeds one turn either way round; no value in three dimensions."""
    counterclockwise: Estimate
    """Share with a net winding above 0: one half where nothing tells left from right; no value in 3-D."""


@needs(encounters="swimmer start_censored end_censored winding signed_winding")
def orbits(encounters: pa.Table, *, edges: np.ndarray | None = None) -> Orbits:
    """Distributions over bins of |turns| (n_bins + 1,), by default a tenth of a turn wide up to the largest.

    The signed distribution has the same bins on either side of 0.
    """
    completed = ~(column(encounters, "end_censored") | column(encounters, "start_censored"))
    turns, net = column(encounters, "winding")[completed], column(encounters, "signed_winding")[completed]
    swimmer = column(encounters, "swimmer")[completed]
    if edges is None:
        largest = max((float(np.nanmax(np.abs(v))) for v in (turns, net) if np.any(~np.isnan(v))), default=0.0)
        edges = np.arange(int(10.0 * largest) + 2) / 10.0
    both_sides = np.unique(np.concatenate([-edges, edges]))
    swimmers = Swimmers.of(swimmer)
    known = ~np.isnan(net)

    def share(of: np.ndarray, counted: np.ndarray) -> Estimate:
        value, error = ratio_of_sums(swimmers.sums(of & counted), swimmers.sums(counted))
        return Estimate(value, error, int(np.count_nonzero(counted)), int(np.count_nonzero(~completed)), "")

    return Orbits(
        winding=histogram(turns, edges=edges, swimmer=swimmer),
        signed_winding=histogram(net, edges=both_sides, swimmer=swimmer),
        above_one_turn=share(turns > 1.0, np.ones(len(turns), bool)),
        net_above_one_turn=share(np.abs(net) > 1.0, known),
        counterclockwise=share(net > 0.0, known),
    )
