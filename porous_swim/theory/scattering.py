"""A pusher that slides along a colloid and leaves: how long, how far round, and into which direction.

Near-wall equations in contact at height gamma (exact for a sphere to leading order in 1/A):
dtheta/dt = cos(theta)/A - (3 alpha/(64 gamma^3)) [4 + Gamma (3 - cos 2 theta)] sin 2 theta, from the pitch of arrival
to the escape angle 3 alpha/(8 gamma^2), while the swimmer moves round by cos(theta)/A.
"""

from __future__ import annotations

import math

from scipy.integrate import quad

from porous_swim.theory.capture import escape_angle
from porous_swim.theory.domain import check_aspect_ratio, check_positive
from porous_swim.theory.motion import near_wall_rates


def sliding_time(
    dipole_strength: float, radius: float, aspect_ratio: float = 1.0, *, arrival_pitch: float = 0.0
) -> float:
    """Time t_e in contact, in a/U, from `arrival_pitch` (rad) to escape; infinite where the swimmer is held."""
    return _slide(dipole_strength, radius, aspect_ratio, arrival_pitch)[0]


def winding(dipole_strength: float, radius: float, aspect_ratio: float = 1.0, *, arrival_pitch: float = 0.0) -> float:
    """Turns made round the colloid in that time: the angle swept, over 2 pi. The paper's W = t_e/(2 pi A) takes
    cos(theta) = 1. Infinite where the swimmer is held."""
    return _slide(dipole_strength, radius, aspect_ratio, arrival_pitch)[1] / (2.0 * math.pi)


def scattering_angle(dipole_strength: float, radius: float, impact_parameter: float) -> float | None:
    """Angle, in rad, by which a spherical pusher leaves turned away from its incoming direction; None if it is held.

    It comes in straight, `impact_parameter` y0 beside the centre (0 < y0 <= A + 1), slides, and leaves straight;
    positive: turned to the side on which it passes. Diverges where 8/(3 A alpha) = sin(3 alpha/8), near the leading
    critical radius 64/(9 alpha^2).
    """
    check_positive(radius=radius, impact_parameter=impact_parameter)
    reach = radius + 1.0
    if impact_parameter > reach:
        raise ValueError(f"impact_parameter: found {impact_parameter:g}, allowed are up to radius + 1 = {reach:g}")
    arrival = -math.acos(impact_parameter / reach)
    _, swept = _slide(dipole_strength, radius, 1.0, arrival)
    if math.isinf(swept):
        return None
    # the director turns with the tangent, against the pitch
    return escape_angle(dipole_strength, order="leading") - arrival - swept


def _slide(alpha: float, A: float, gamma: float, arrival: float) -> tuple[float, float]:
    """Time and angle swept between arrival and escape."""
    check_aspect_ratio(gamma)
    check_positive(radius=A, dipole_strength=alpha)
    if not -0.5 * math.pi < arrival < 0.5 * math.pi:
        raise ValueError(f"arrival_pitch: found {arrival:g}, allowed are values between -pi/2 and pi/2")
    leave = escape_angle(alpha, aspect_ratio=gamma, order="leading")
    if leave >= 0.5 * math.pi:
        raise ValueError(f"dipole_strength: found {alpha:g}, but near-wall theory needs 3 alpha/(8 gamma^2) < pi/2")
    if arrival >= leave:
        return 0.0, 0.0

    def turning(pitch: float) -> float:
        return near_wall_rates(pitch, gamma, A, alpha, gamma)[1]

    # 1/A against a torque that grows with the pitch: the sum is least at the end
    if turning(leave) <= 0.0:
        return math.inf, math.inf
    time, _ = quad(lambda pitch: 1.0 / turning(pitch), arrival, leave, epsabs=1e-12, limit=500)
    swept, _ = quad(lambda pitch: math.cos(pitch) / (A * turning(pitch)), arrival, leave, epsabs=1e-12, limit=500)
    return float(time), float(swept)
