"""Orbits: how far swimmers wind around a colloid during an encounter. In turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import column
from porous_swim.analysis.estimates import Estimate, Swimmers, ratio_of_sums
from porous_swim.analysis.places import at_wall
from porous_swim.analysis.residence import residence_lengths


@dataclass(frozen=True)
class Winding:
    """Winding of encounters. Means over completed ones favour short encounters; the rate does not."""

    completed: Estimate
    """Mean winding of the completed encounters."""
    net: Estimate
    """Mean |signed winding| of the completed encounters; no value in three dimensions."""
    rate: Estimate
    """Total winding over total time in encounters, censored ones included, in turns per a/U."""
    above_one_turn: Estimate
    """Fraction of the completed encounters that wound more than one turn."""


def winding(encounters: pa.Table, colloids: pa.Table | None = None) -> Winding:
    """Winding statistics of a table of encounters; errors are a jackknife over swimmers.

    There are none where `colloids` is a plane wall: nobody winds around it.
    """
    if colloids is not None and at_wall(colloids):
        nothing = Estimate.none("turns")
        return Winding(nothing, nothing, Estimate.none("turns U/a"), Estimate.none(""))
    turns = column(encounters, "winding")
    net = np.abs(column(encounters, "signed_winding"))
    ended, seen = ~column(encounters, "end_censored"), ~column(encounters, "start_censored")
    completed = ended & seen
    swimmers = Swimmers.of(column(encounters, "swimmer"))

    def ratio(values: np.ndarray, over: np.ndarray, counted: np.ndarray, unit: str) -> Estimate:
        value, error = ratio_of_sums(swimmers.sums(values), swimmers.sums(over))
        n = int(np.count_nonzero(counted))
        return Estimate(value, error, n, len(counted) - n, unit)

    signed = completed & ~np.isnan(net)
    return Winding(
        completed=ratio(np.where(completed, turns, 0.0), completed, completed, "turns"),
        net=ratio(np.where(signed, net, 0.0), signed, signed, "turns"),
        rate=ratio(turns, residence_lengths(encounters), ended, "turns U/a"),
        above_one_turn=ratio(completed & (turns > 1.0), completed, completed, ""),
    )
