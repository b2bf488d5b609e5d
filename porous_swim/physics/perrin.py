"""Diffusion of a prolate spheroid (semi-axes 1, gamma, gamma) over that of the sphere of radius a around it.

In an unbounded fluid at no slip. Sources: F. Perrin, J. Phys. Radium 5, 497 (1934) and 7, 1 (1936); Kim and Karrila,
Microhydrodynamics (1991), section 3.3, whose resistance functions X^A, Y^A and Y^C are the inverses of these factors.
"""

from __future__ import annotations

from math import asinh, sqrt
from typing import NamedTuple

_ROUND, _N_TERMS = 0.1, 16  # e^2 below which the series is summed: its 17th term is below 1e-17


class SpheroidDiffusion(NamedTuple):
    """Diffusivities of a spheroid in those of a sphere of radius a: kT/(6 pi mu a), and kT/(8 pi mu a^3) in turning."""

    along: float
    """Of the centre along the axis."""
    across: float
    """Of the centre across the axis."""
    turning: float
    """Of the direction of the axis."""

    def mean(self, dimensions: int) -> float:
        """Diffusivity of the centre, averaged over axes in a plane (2 `dimensions`) or in space (3)."""
        return (self.along + (dimensions - 1) * self.across) / dimensions


def spheroid_diffusion(aspect_ratio: float) -> SpheroidDiffusion:
    """Factors of a spheroid of `aspect_ratio` gamma in (0, 1], to 1e-14; exactly 1 for a sphere.

    With e^2 = 1 - gamma^2, G = artanh(e)/e and T = (G - 1)/e^2: 3 (G + T)/4 along, 3 (3 G - T)/8 across, and in turning
    3 (G + T)/(2 (1 + gamma^2)). `ValueError` for an aspect ratio outside of its range.
    """
    if not 0.0 < aspect_ratio <= 1.0:
        raise ValueError(f"aspect_ratio: expected 0 < gamma <= 1, found {aspect_ratio!r}")
    squared = (1.0 - aspect_ratio) * (1.0 + aspect_ratio)
    if squared < _ROUND:  # artanh(e)/e = 1 + e^2/3 + e^4/5 + ...: G - 1 would cancel
        T = sum(squared**k / (2 * k + 3) for k in range(_N_TERMS))
        G = 1.0 + squared * T
    else:
        e = sqrt(squared)
        G = asinh(e / aspect_ratio) / e  # artanh(e) where e is near 1
        T = (G - 1.0) / squared
    along = 0.75 * (G + T)
    return SpheroidDiffusion(along, 0.375 * (3.0 * G - T), 2.0 * along / (1.0 + aspect_ratio**2))
