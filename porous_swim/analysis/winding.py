"""Orbits: how far swimmers wind around a colloid during an encounter. In turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import column, needs
from porous_swim.analysis.estimates import Estimate, Swimmers, joined, ratio_of_sums
from porous_swim.analysis.lifetimes.residence import WHEN, residence_lengths
from porous_swim.analysis.places import all_round
from porous_swim.results.encounter_table import Encounters, parts_of


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


@needs(encounters=" ".join((*WHEN, "winding", "signed_winding")), colloids="colloid radius")
def winding(encounters: pa.Table | Encounters, colloids: pa.Table | None = None) -> Winding:
    """Winding statistics of a table of encounters; errors are a jackknife over swimmers.

    There are none where `colloids` are such that nobody can go round them.
    """
    if colloids is not None and not all_round(colloids):
        nothing = Estimate.none("turns")
        return Winding(nothing, nothing, Estimate.none("turns U/a"), Estimate.none(""))
    sums = joined(_sums(part) for part in parts_of(encounters, *WHEN, "winding", "signed_winding"))
    n_rows = int(sums["rows"].sum())

    def ratio(values: str, over: str, counted: str, unit: str) -> Estimate:
        n = int(sums[counted].sum())
        return Estimate(*ratio_of_sums(sums[values], sums[over]), n, n_rows - n, unit)

    return Winding(
        completed=ratio("turns_completed", "completed", "completed", "turns"),
        net=ratio("net", "signed", "signed", "turns"),
        rate=ratio("turns", "length", "ended", "turns U/a"),
        above_one_turn=ratio("above", "completed", "completed", ""),
    )


def _sums(encounters: pa.Table) -> dict[str, np.ndarray]:
    """Of each swimmer that occurs, over its encounters: turns, times and numbers."""
    turns = column(encounters, "winding")
    net = np.abs(column(encounters, "signed_winding"))
    ended = ~column(encounters, "end_censored")
    completed = ended & ~column(encounters, "start_censored")
    signed = completed & ~np.isnan(net)
    values = {
        "rows": np.ones(len(turns)), "ended": ended, "completed": completed, "signed": signed,
        "turns": turns, "length": residence_lengths(encounters),
        "turns_completed": np.where(completed, turns, 0.0), "net": np.where(signed, net, 0.0),
        "above": completed & (turns > 1.0),
    }  # fmt: skip
    swimmers = Swimmers.of(column(encounters, "swimmer"))
    return {name: swimmers.sums(value) for name, value in values.items()}
