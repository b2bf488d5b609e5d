"""Whether a colloid holds a swimmer without noise: critical radius, pitches of rest and of lift-off, basin."""

from __future__ import annotations

import math
from typing import Literal

from scipy.optimize import brentq

from porous_swim.theory.domain import (
    bretherton,
    check_aspect_ratio,
    check_finite,
    check_order,
    check_positive,
)
from porous_swim.theory.motion import height_and_slope, rates, turning_over_cosine

Order = Literal["exact", "leading", "improved"]
_FLAT = math.asin(1.0 / math.sqrt(3.0))  # a pusher's wall flow draws it in at flatter pitches than this


def critical_radius(dipole_strength: float, aspect_ratio: float = 1.0, *, order: Order = "exact") -> float:
    """Radius A_c, in a, from which on a colloid holds a swimmer of `dipole_strength` alpha that touches it.

    `exact` is the root of the full equations in contact: pushers (alpha > 0) are held where they turn inwards at the
    pitch of lift-off, pullers where nose-on rest is stable. `leading` is the limit of small alpha:
    128 gamma^5/(9 alpha^2 (2 + Gamma)) for pushers (2.4, 17, 35 % low for a sphere at alpha = 0.2, 0.6, 1),
    8/(3 |alpha| (1 + Gamma)) for pullers. `improved`, for spherical pushers, is 8/(3 alpha s) + 3/2 with s the sine of
    the pitch of lift-off at a plane: within 0.17 % for alpha <= 1, 10 % high at 4. Infinite at alpha = 0.

    Weak pushers thinner than gamma = 1/3 can rest at smaller radii already, below an unstable pitch that is itself
    below lift-off: from 0.987 A_c on at gamma = 0.25, alpha = 0.1, and 0.88 A_c at gamma = 0.15.

    Raises:
        ValueError: an argument outside of its range; no sphere of radius above 1e-3 lets the swimmer go.
    """
    check_finite(dipole_strength=dipole_strength)
    check_aspect_ratio(aspect_ratio)
    check_order(order, ("exact", "leading", "improved"))
    alpha = dipole_strength
    if alpha == 0.0:
        return math.inf
    if order == "improved":
        if alpha < 0.0 or aspect_ratio < 1.0:
            raise ValueError("order: 'improved' is for spherical pushers, use 'exact'")
        return 8.0 / (3.0 * alpha * _lift_off_sine(0.375 * alpha)) + 1.5
    if alpha > 0.0:
        leading = 128.0 * aspect_ratio**5 / (9.0 * alpha**2 * (2.0 + bretherton(aspect_ratio)))
    else:
        leading = 8.0 / (3.0 * -alpha * (1.0 + bretherton(aspect_ratio)))
    if order == "leading":
        return leading

    def turning(radius: float) -> float:
        """dtheta/dt over cos(theta): at lift-off for a pusher, at nose-on rest for a puller."""
        pitch = escape_angle(alpha, radius, aspect_ratio) if alpha > 0.0 else -0.5 * math.pi
        height, _ = height_and_slope(pitch, radius, aspect_ratio)
        return turning_over_cosine(math.sin(pitch), height, radius, alpha, aspect_ratio)

    smallest, largest = (1e-6 if aspect_ratio == 1.0 else 1e-3), 2.0 * leading + 100.0
    if turning(smallest) <= 0.0:
        raise ValueError(f"dipole_strength: {alpha:g} is held by spheres of every radius above {smallest:g}")
    return float(brentq(turning, smallest, largest, xtol=1e-12, rtol=1e-14))


def escape_angle(
    dipole_strength: float, radius: float = math.inf, aspect_ratio: float = 1.0, *, order: Order = "exact"
) -> float:
    """Pitch theta_e, in rad, above which a swimmer in contact with a colloid of `radius` leaves it.

    `exact` is the least pitch at which dh/dt = 0 at the contact height: that of lift-off of a sphere; of a spheroid
    at the critical radius, where its pitch is at rest. `leading` is 3 alpha/(8 gamma^2) whatever the radius, not
    bounded by pi/2. Below zero for a puller. `ValueError` for an argument outside of its range.
    """
    check_finite(dipole_strength=dipole_strength)
    check_aspect_ratio(aspect_ratio)
    check_order(order, ("exact", "leading"))
    check_positive(radius=radius)
    alpha = dipole_strength
    if order == "leading":
        return 3.0 * alpha / (8.0 * aspect_ratio**2)
    if aspect_ratio == 1.0:
        return math.asin(_lift_off_sine(_wall_strength(radius, alpha)))
    if alpha == 0.0:
        return 0.0

    def rise(pitch: float) -> float:
        return rates(pitch, height_and_slope(pitch, radius, aspect_ratio)[0], radius, alpha, aspect_ratio)[0]

    low, high = (0.0, _FLAT) if alpha > 0.0 else (-_FLAT, 0.0)
    return float(brentq(rise, low, high, xtol=1e-15))


def equilibrium_pitch(
    dipole_strength: float, radius: float, aspect_ratio: float = 1.0, *, order: Order = "exact"
) -> float | None:
    """Pitch theta*, in rad, at which a pusher orbits a colloid of `radius` that holds it; None where none does.

    At a plane wall (infinite radius) it is 0.
    `exact` is where dtheta/dt = 0 in contact; `leading` is 16 gamma^3/(3 A alpha (2 + Gamma)), None where it exceeds
    the leading escape angle. A puller rests nose-on, at -pi/2, where that is stable.
    """
    check_order(order, ("exact", "leading"))
    check_positive(radius=radius)
    alpha = dipole_strength
    if radius < critical_radius(alpha, aspect_ratio, order=order):
        return None
    if alpha < 0.0:
        return -0.5 * math.pi
    if order == "leading":
        return 16.0 * aspect_ratio**3 / (3.0 * radius * alpha * (2.0 + bretherton(aspect_ratio)))

    def turning(pitch: float) -> float:
        height, _ = height_and_slope(pitch, radius, aspect_ratio)
        return turning_over_cosine(math.sin(pitch), height, radius, alpha, aspect_ratio)

    return float(brentq(turning, 0.0, escape_angle(alpha, radius, aspect_ratio), xtol=1e-15))


def basin_depth(dipole_strength: float, radius: float) -> float:
    """Height h*, in a, from which a spherical pusher parallel to the surface is still captured: 0.96 (alpha^2 A)^(1/5).

    The exponent is that of the near-wall equations; the printed prefactor is 3 to 5 % high for alpha^2 A > 100, where
    integrations of the full equations give 0.9285 (alpha^2 A)^0.2002.
    """
    check_positive(radius=radius, dipole_strength=dipole_strength)
    return 0.96 * float(dipole_strength**2 * radius) ** 0.2


def _wall_strength(radius: float, alpha: float) -> float:
    """K of `motion` for a sphere in contact; 3 alpha/8 at a plane wall (infinite radius)."""
    if math.isinf(radius):
        return 0.375 * alpha
    return 1.5 * alpha * radius * (radius + 1.0) / (2.0 * radius + 1.0) ** 2


def _lift_off_sine(k: float) -> float:
    """The small root of s + K (3 s^2 - 1) = 0, dh/dt = 0 in contact, in the form without cancellation."""
    return 2.0 * k / (1.0 + math.sqrt(1.0 + 12.0 * k * k))
