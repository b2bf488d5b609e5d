"""What the tables of a run say: functions of tables and arrays, frozen results with errors."""

from __future__ import annotations

from porous_swim import theory
from porous_swim.analysis.density import cell_density, height_pitch_density
from porous_swim.analysis.estimates import Estimate
from porous_swim.analysis.groups import by_column, by_radius, encounter_radii
from porous_swim.analysis.histogram import Histogram, Map, Profile, binned_mean, histogram, histogram_2d
from porous_swim.analysis.hopping.hop_network import Symmetry, hop_counts, hop_degrees, hop_network, hop_symmetry
from porous_swim.analysis.hopping.hop_table import Shells, hop_shells, hop_table
from porous_swim.analysis.hopping.hops import (
    HopStatistics,
    Moves,
    flight_lifetimes,
    flights,
    hop_lengths,
    hop_statistics,
    hops,
    moves,
    returns,
)
from porous_swim.analysis.lifetimes.departures import Departures, departures
from porous_swim.analysis.lifetimes.goodness_of_fit import GoodnessOfFit, goodness_of_fit
from porous_swim.analysis.lifetimes.lifetime_fits import FittedParameter, LifetimeFit, fit_lifetimes
from porous_swim.analysis.lifetimes.lifetimes import Lifetimes
from porous_swim.analysis.lifetimes.log_rank import LogRank, one_sample_log_rank
from porous_swim.analysis.lifetimes.residence import (
    bound_fraction,
    bound_fraction_at,
    contact_fraction,
    contact_fraction_of_encounters,
    escape_pitch_lifetimes,
    escape_pitch_times,
    residence_lifetimes,
    residence_survival,
    residence_times,
)
from porous_swim.analysis.lifetimes.survival import SurvivalCurve, WaitingTimes, survival_curve, waiting_times
from porous_swim.analysis.lifetimes.survival_band import SurvivalBand, survival_at, survival_band
from porous_swim.analysis.orbits import Orbits, orbits
from porous_swim.analysis.scattering import scattering
from porous_swim.analysis.summary import summarize, summary_lines
from porous_swim.analysis.transport.diffusion import EffectiveDiffusivity, effective_diffusivity
from porous_swim.analysis.transport.displacements import (
    displacement_histogram,
    msd_exponent,
    non_gaussian_parameter,
)
from porous_swim.analysis.transport.ensemble import (
    director_memory,
    ensemble_diffusivity,
    ensemble_director_correlation,
    ensemble_msd,
    ensemble_non_gaussian_parameter,
)
from porous_swim.analysis.transport.lagged import (
    TimeAverages,
    straightness,
    time_averaged_director_correlation,
    time_averaged_msd,
)
from porous_swim.analysis.transport.persistence import Persistence, persistence
from porous_swim.analysis.transport.transport import (
    Diffusivity,
    Lagged,
    Tracks,
    diffusivity,
    director_correlation,
    msd,
    tracks,
)
from porous_swim.analysis.transport.travel import travel_times
from porous_swim.analysis.winding import Winding, winding

__all__ = [
    "Departures",
    "Diffusivity",
    "EffectiveDiffusivity",
    "Estimate",
    "FittedParameter",
    "GoodnessOfFit",
    "Histogram",
    "HopStatistics",
    "Lagged",
    "LifetimeFit",
    "Lifetimes",
    "LogRank",
    "Map",
    "Moves",
    "Orbits",
    "Persistence",
    "Profile",
    "Shells",
    "SurvivalBand",
    "SurvivalCurve",
    "Symmetry",
    "TimeAverages",
    "Tracks",
    "WaitingTimes",
    "Winding",
    "binned_mean",
    "bound_fraction",
    "bound_fraction_at",
    "by_column",
    "by_radius",
    "cell_density",
    "contact_fraction",
    "contact_fraction_of_encounters",
    "departures",
    "diffusivity",
    "director_correlation",
    "director_memory",
    "displacement_histogram",
    "effective_diffusivity",
    "encounter_radii",
    "ensemble_diffusivity",
    "ensemble_director_correlation",
    "ensemble_msd",
    "ensemble_non_gaussian_parameter",
    "escape_pitch_lifetimes",
    "escape_pitch_times",
    "fit_lifetimes",
    "flight_lifetimes",
    "flights",
    "goodness_of_fit",
    "height_pitch_density",
    "histogram",
    "histogram_2d",
    "hop_counts",
    "hop_degrees",
    "hop_lengths",
    "hop_network",
    "hop_shells",
    "hop_statistics",
    "hop_symmetry",
    "hop_table",
    "hops",
    "moves",
    "msd",
    "msd_exponent",
    "non_gaussian_parameter",
    "one_sample_log_rank",
    "orbits",
    "persistence",
    "residence_lifetimes",
    "residence_survival",
    "residence_times",
    "returns",
    "scattering",
    "straightness",
    "summarize",
    "summary_lines",
    "survival_at",
    "survival_band",
    "survival_curve",
    "theory",
    "time_averaged_director_correlation",
    "time_averaged_msd",
    "tracks",
    "travel_times",
    "waiting_times",
    "winding",
]
