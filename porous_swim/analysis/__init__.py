"""What the tables of a run say: functions of tables and arrays, frozen results with errors."""

from __future__ import annotations

from porous_swim.analysis import theory
from porous_swim.analysis.estimates import Estimate
from porous_swim.analysis.hops import (
    HopStatistics,
    Moves,
    flights,
    hop_lengths,
    hop_statistics,
    hops,
    moves,
    returns,
)
from porous_swim.analysis.residence import (
    bound_fraction,
    bound_fraction_at,
    contact_fraction,
    contact_fraction_of_encounters,
    escape_pitch_times,
    residence_survival,
    residence_times,
)
from porous_swim.analysis.summary import summarize, summary_lines
from porous_swim.analysis.survival import SurvivalCurve, WaitingTimes, survival_curve, waiting_times
from porous_swim.analysis.transport import (
    Diffusivity,
    Lagged,
    Tracks,
    diffusivity,
    director_correlation,
    msd,
    tracks,
)
from porous_swim.analysis.winding import Winding, winding

__all__ = [
    "Diffusivity",
    "Estimate",
    "HopStatistics",
    "Lagged",
    "Moves",
    "SurvivalCurve",
    "Tracks",
    "WaitingTimes",
    "Winding",
    "bound_fraction",
    "bound_fraction_at",
    "contact_fraction",
    "contact_fraction_of_encounters",
    "diffusivity",
    "director_correlation",
    "escape_pitch_times",
    "flights",
    "hop_lengths",
    "hop_statistics",
    "hops",
    "moves",
    "msd",
    "residence_survival",
    "residence_times",
    "returns",
    "summarize",
    "summary_lines",
    "survival_curve",
    "theory",
    "tracks",
    "waiting_times",
    "winding",
]
