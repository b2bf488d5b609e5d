"""Rates of height and pitch, and the contact height of a spheroid, in plain floating point.

With s = sin(theta), R = A + h, H = h (2 A + h), a = (A/R)^2 and b = a (3 - a) the drift of a force dipole at a no-slip
sphere (Soft Matter 11, 3396, Appendix B) gives

    dh/dt     = s + K (3 s^2 - 1),                        K = 3 alpha A R/(2 H^2)
    dtheta/dt = cos(theta) [(1 + K b s)/R - alpha W s],   W = (3 A R^2/(2 H^3)) (b + Gamma P/4)
    P         = 5 a^3 - 17 a^2 + 22 a - 6 + s^2 (-9 a^3 + 29 a^2 - 34 a + 18)

where 1/R is the turning of the tangent plane under a swimmer that moves along the sphere, K b s/R the same for the
velocity that the flow adds, and alpha W s the rotation by the flow.
"""

from __future__ import annotations

import math

from scipy.optimize import brentq

from porous_swim.theory.domain import bretherton, check_aspect_ratio, check_positive


def rates(
    pitch: float, height: float, radius: float, dipole_strength: float, aspect_ratio: float = 1.0
) -> tuple[float, float]:
    """(dh/dt, dtheta/dt) of a swimmer at `height` above a sphere of `radius` (infinite: a plane), full equations."""
    check_positive(height=height, radius=radius)
    check_aspect_ratio(aspect_ratio)
    s, gamma = math.sin(pitch), bretherton(aspect_ratio)
    K, turning = _strengths(s, height, radius, dipole_strength, gamma)
    return s + K * (3.0 * s * s - 1.0), math.cos(pitch) * turning


def turning_over_cosine(s: float, height: float, radius: float, dipole_strength: float, aspect_ratio: float) -> float:
    """(dtheta/dt)/cos(theta), which is finite at |theta| = pi/2."""
    return _strengths(s, height, radius, dipole_strength, bretherton(aspect_ratio))[1]


def _strengths(s: float, h: float, A: float, alpha: float, gamma: float) -> tuple[float, float]:
    """K and (dtheta/dt)/cos(theta)."""
    if math.isinf(A):
        K = 0.375 * alpha / h**2
        return K, -K / h * (1.0 + 0.5 * gamma * (1.0 + s * s)) * s
    R, H = A + h, h * (2.0 * A + h)
    a = (A / R) ** 2
    b = a * (3.0 - a)
    K = 1.5 * alpha * A * R / (H * H)
    P = ((5.0 * a - 17.0) * a + 22.0) * a - 6.0 + s * s * (((29.0 - 9.0 * a) * a - 34.0) * a + 18.0)
    W = 1.5 * A * R * R / H**3 * (b + 0.25 * gamma * P)
    return K, (1.0 + K * b * s) / R - alpha * W * s


def near_wall_rates(
    pitch: float, height: float, radius: float, dipole_strength: float, aspect_ratio: float = 1.0
) -> tuple[float, float]:
    """The same to leading order for h << A, the paper's reduced model (with its sign of Gamma mended)."""
    check_positive(height=height, radius=radius)
    check_aspect_ratio(aspect_ratio)
    gamma, s = bretherton(aspect_ratio), math.sin(pitch)
    rise = s - 0.375 * dipole_strength / height**2 * (1.0 - 3.0 * s * s)
    torque = 3.0 * dipole_strength / (64.0 * height**3) * (4.0 + gamma * (3.0 - math.cos(2.0 * pitch)))
    return rise, math.cos(pitch) / radius - torque * math.sin(2.0 * pitch)


def contact_height(pitch: float, radius: float, aspect_ratio: float = 1.0) -> float:
    """Height at which a prolate spheroid (semi-axes 1, gamma, gamma) touches a sphere of `radius` (infinite: a plane).

    With p the angle of the contact normal from the axis and S(p) its support function, p - p_r + atan(S'/(S + A)) = 0
    on [p_r, pi/2], p_r = pi/2 - |pitch|.
    """
    return height_and_slope(pitch, radius, aspect_ratio)[0]


def height_and_slope(pitch: float, radius: float, aspect_ratio: float) -> tuple[float, float]:
    """The contact height and its derivative with respect to the pitch."""
    check_positive(radius=radius)
    check_aspect_ratio(aspect_ratio)
    if aspect_ratio == 1.0:
        return 1.0, 0.0
    g, start, sign = aspect_ratio**2, 0.5 * math.pi - abs(pitch), math.copysign(1.0, pitch)

    def support(p: float) -> tuple[float, float]:
        S = math.sqrt(math.cos(p) ** 2 + g * math.sin(p) ** 2)
        return S, -(1.0 - g) * math.cos(p) * math.sin(p) / S

    if math.isinf(radius):
        S, turn = support(start)
        return S, -sign * turn

    def off(p: float) -> float:
        S, turn = support(p)
        return p - start + math.atan(turn / (S + radius))

    p, end = start, 0.5 * math.pi
    if off(start) < 0.0:  # rounding may leave the other end below zero for a swimmer that lies flat
        p = end if off(end) <= 0.0 else float(brentq(off, start, end, xtol=1e-15, rtol=1e-15))
    S, turn = support(p)
    R = math.hypot(S + radius, turn)
    return (S * S + turn * turn + 2.0 * radius * S) / (R + radius), -sign * R * turn / (radius + S)
