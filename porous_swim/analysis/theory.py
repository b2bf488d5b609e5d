"""Predictions for one swimmer at one colloid, without noise. Lengths in a, speeds in U, angles in rad.

Source: Spagnolie, Moreno-Flores, Bartolo and Lauga, Soft Matter 11, 3396 (2015); its near-wall formulas
with (2 + Gamma) where (2 - Gamma) is printed.

With s = sin(theta), R = A + 1 and H = R^2 - A^2 the motion of a sphere in contact follows from the drift of
a force dipole at a no-slip sphere (ibid., Appendix B):

    dh/dt     = s + K (3 s^2 - 1),                        K = 3 alpha A R/(2 H^2)
    dtheta/dt = cos(theta) [(1 + K b s)/R - alpha W s],   b = a (3 - a),  a = (A/R)^2,  W = 3 A R^2 b/(2 H^3)

1/R is the turning of the tangent plane under a swimmer that moves along the sphere, K b s/R the same for
the velocity that the flow adds, alpha W s the rotation by the flow.
"""

from __future__ import annotations

import math
from typing import Literal

from scipy.optimize import brentq

Order = Literal["exact", "leading"]


def critical_radius(dipole_strength: float, aspect_ratio: float = 1.0, *, order: Order = "exact") -> float:
    """Radius A_c, in a, from which on a colloid holds a swimmer of `dipole_strength` alpha that touches it.

    `exact` is the root of the full equations in contact, for a sphere: pushers (alpha > 0) are held where
    they turn inwards at the pitch of lift-off, pullers where nose-on rest is stable. `leading` is the limit
    of small alpha: 128 gamma^5/(9 alpha^2 (2 + Gamma)) for pushers (2.4, 17, 35 % low for a sphere at
    alpha = 0.2, 0.6, 1), 8/(3 |alpha| (1 + Gamma)) for pullers. Infinite at alpha = 0. `ValueError` for
    `exact` with an aspect ratio below 1.
    """
    _check(aspect_ratio, order)
    alpha = dipole_strength
    if alpha == 0.0:
        return math.inf
    bretherton = (1.0 - aspect_ratio**2) / (1.0 + aspect_ratio**2)
    if alpha > 0.0:
        leading = 128.0 * aspect_ratio**5 / (9.0 * alpha**2 * (2.0 + bretherton))
    else:
        leading = 8.0 / (3.0 * -alpha * (1.0 + bretherton))
    if order == "leading":
        return leading

    def turning(radius: float) -> float:
        """dtheta/dt over cos(theta): at lift-off for a pusher, at nose-on rest for a puller."""
        return _turning_rate(radius, alpha, _lift_off_sine(radius, alpha) if alpha > 0.0 else -1.0)

    # Small spheres hold nothing. The exact radius lies above the leading one: 6 times at alpha = 4.
    return float(brentq(turning, 1e-6, 2.0 * leading + 100.0, xtol=1e-12, rtol=1e-14))


def escape_angle(
    dipole_strength: float, radius: float = math.inf, aspect_ratio: float = 1.0, *, order: Order = "exact"
) -> float:
    """Pitch theta_e, in rad, above which a swimmer in contact with a colloid of `radius` leaves it.

    `exact` is where dh/dt vanishes in contact, for a sphere; `leading` is 3 alpha/(8 gamma^2) whatever the
    radius, not bounded by pi/2. Below zero for a puller. `ValueError` for `exact` with an aspect ratio
    below 1.
    """
    _check(aspect_ratio, order)
    if order == "leading":
        return 3.0 * dipole_strength / (8.0 * aspect_ratio**2)
    return math.asin(_lift_off_sine(radius, dipole_strength))


def _check(aspect_ratio: float, order: Order) -> None:
    if not 0.0 < aspect_ratio <= 1.0:
        raise ValueError(f"aspect_ratio: found {aspect_ratio:g}, allowed are 0 < aspect_ratio <= 1")
    if order not in ("exact", "leading"):
        raise ValueError(f'order: found {order!r}, allowed are "exact" and "leading"')
    if order == "exact" and aspect_ratio < 1.0:
        raise ValueError(
            f'aspect_ratio: found {aspect_ratio:g}, and order "exact" is for spheres (1) only, '
            'since the contact height of a rod depends on its pitch; use order="leading"'
        )


def _wall_strength(radius: float, alpha: float) -> float:
    """K of the module's text; 3 alpha/8 at a plane wall (infinite radius)."""
    if math.isinf(radius):
        return 0.375 * alpha
    return 1.5 * alpha * radius * (radius + 1.0) / (2.0 * radius + 1.0) ** 2


def _lift_off_sine(radius: float, alpha: float) -> float:
    """Sine of the pitch at which dh/dt = 0 in contact: the small root of s + K (3 s^2 - 1) = 0."""
    k = _wall_strength(radius, alpha)
    return 2.0 * k / (1.0 + math.sqrt(1.0 + 12.0 * k * k))  # the form without cancellation


def _turning_rate(radius: float, alpha: float, s: float) -> float:
    """dtheta/dt over cos(theta) in contact at sine s of the pitch, in U/a."""
    distance = radius + 1.0
    a = (radius / distance) ** 2
    b = a * (3.0 - a)
    k = _wall_strength(radius, alpha)
    rotation = 1.5 * alpha * radius * distance**2 * b / (2.0 * radius + 1.0) ** 3  # alpha W
    return (1.0 + k * b * s) / distance - rotation * s
