"""Predictions for one swimmer at one colloid. Lengths in a, speeds in U, times in a/U, angles in rad.

Source: Spagnolie, Moreno-Flores, Bartolo and Lauga, Soft Matter 11, 3396 (2015); its near-wall formulas with
(2 + Gamma) where (2 - Gamma) is printed, the sign that its Appendix B has. `exact` are roots and integrals of the full
equations of a force dipole at a no-slip sphere, `leading` the closed forms of small alpha and large A.
"""

from __future__ import annotations

from porous_swim.theory.capture import (
    basin_depth,
    critical_radius,
    equilibrium_pitch,
    escape_angle,
)
from porous_swim.theory.motion import contact_height, near_wall_rates, rates
from porous_swim.theory.scattering import scattering_angle, sliding_time, winding
from porous_swim.theory.trapping import (
    inverse_gaussian,
    mean_trapping_time,
    trapping_survival,
    trapping_warnings,
)

__all__ = [
    "basin_depth",
    "contact_height",
    "critical_radius",
    "equilibrium_pitch",
    "escape_angle",
    "inverse_gaussian",
    "mean_trapping_time",
    "near_wall_rates",
    "rates",
    "scattering_angle",
    "sliding_time",
    "trapping_survival",
    "trapping_warnings",
    "winding",
]
