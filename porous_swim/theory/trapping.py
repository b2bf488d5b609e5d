"""How long noise leaves a pusher at a colloid that would hold it: first passage of the escape angle.

Near-wall equations in contact at small pitch: an Ornstein-Uhlenbeck process dtheta = -k (theta - theta*) dt +
sqrt(2 D_r) dW with k = 3 alpha (2 + Gamma)/(16 gamma^3), from theta = 0 to theta_e = 3 alpha/(8 gamma^2).
"""

from __future__ import annotations

import math
import warnings
from typing import Any, Literal

import numpy as np
from scipy.integrate import quad
from scipy.linalg import eigh_tridiagonal
from scipy.special import erfcx
from scipy.stats import invgauss

from porous_swim.theory.capture import escape_angle
from porous_swim.theory.domain import bretherton, check_aspect_ratio, check_order, check_positive
from porous_swim.theory.motion import contact_height, rates

_CELLS = 2000  # of the finite volumes; the error of a survival probability falls as their square, below 1e-5
_TRUSTED = 1.5  # factor between integrals, near-wall and full


def mean_trapping_time(
    dipole_strength: float, radius: float, rotational_diffusion: float, aspect_ratio: float = 1.0,
    *, order: Literal["integral", "estimate"] = "integral",
) -> float:  # fmt: skip
    """Mean first-passage time E[T], in a/U; `rotational_diffusion` is D_r, 3 D/4 in the paper.

    `integral` is sqrt(pi)/k times the integral of exp(u^2) (1 + erf u) over u = (theta - theta*) sqrt(k/(2 D_r)) from
    0 to theta_e; `estimate` its expansion to second order in u. Each warns where it does not hold: see
    `trapping_warnings`.
    """
    check_order(order, ("integral", "estimate"))
    process = _process(dipole_strength, radius, rotational_diffusion, aspect_ratio)
    for each in trapping_warnings(dipole_strength, radius, rotational_diffusion, aspect_ratio, order=order):
        warnings.warn(f"mean_trapping_time: {each}", stacklevel=2)
    if order == "integral":
        return _integral(*process, rotational_diffusion)
    k = process[0]
    first, last = _ends(*process, rotational_diffusion)
    return math.sqrt(math.pi) / k * (last - first) + (last**2 - first**2) / k


def trapping_warnings(
    dipole_strength: float, radius: float, rotational_diffusion: float, aspect_ratio: float = 1.0,
    *, order: Literal["integral", "estimate"] = "integral",
) -> list[str]:  # fmt: skip
    """Why `mean_trapping_time` of that order is out of its range, a sentence for each reason.

    Both need small pitches and A >> 1: theta_e and the turning at theta = 0 enter in an exponential, so the integral
    is not trusted where those of the full equations change it by half. (Simulations at alpha = 0.2 and 0.8 differ from
    it by 23 % and more where that is so, and by 17 % and less where not.) The estimate also needs |u| below 1/2.
    """
    process = k, _, leave = _process(dipole_strength, radius, rotational_diffusion, aspect_ratio)
    height = contact_height(0.0, radius, aspect_ratio)
    turning = rates(0.0, height, radius, dipole_strength, aspect_ratio)[1]
    lift_off = escape_angle(dipole_strength, radius, aspect_ratio)
    near_wall, full = (_integral(*each, rotational_diffusion) for each in (process, (k, turning / k, lift_off)))
    found = []
    if math.isinf(full) or not near_wall / _TRUSTED < full < near_wall * _TRUSTED:
        found.append(
            "near-wall theory at small pitch does not hold here: with the turning and the escape angle of the full "
            f"equations ({lift_off:.3g} rad, not {leave:.3g} rad) the integral is {full:.2g} a/U"
        )
    largest = max(map(abs, _ends(*process, rotational_diffusion)))
    if order == "estimate" and largest > 0.5:
        found.append(f"the estimate is an expansion for u below 0.5, here {largest:.2g}: the integral is better")
    return found


def _ends(k: float, rest: float, leave: float, D_r: float) -> tuple[float, float]:
    """u at theta = 0 and at theta_e."""
    scale = math.sqrt(k / (2.0 * D_r))
    return -rest * scale, (leave - rest) * scale


def _integral(k: float, rest: float, leave: float, D_r: float) -> float:
    first, last = _ends(k, rest, leave, D_r)
    if last > 26.0:  # exp(u^2) is beyond what a double holds
        return math.inf
    return math.sqrt(math.pi) / k * float(quad(lambda u: erfcx(-u), first, last, epsabs=0.0, limit=500)[0])


def trapping_survival(
    times: Any, dipole_strength: float, radius: float, rotational_diffusion: float, aspect_ratio: float = 1.0
) -> np.ndarray:
    """Probability (n,) that the first passage comes later than `times` (n,), a/U.

    Backward equation of the same process on finite volumes, from six standard deviations below rest to theta_e, by
    its eigenvalues.
    """
    k, rest, leave = _process(dipole_strength, radius, rotational_diffusion, aspect_ratio)
    spread = math.sqrt(rotational_diffusion / k)
    bottom = min(rest, 0.0) - 8.0 * spread
    width = (leave - bottom) / _CELLS
    centers, faces = bottom + (np.arange(_CELLS) + 0.5) * width, bottom + np.arange(_CELLS + 1) * width

    def weight(pitch: np.ndarray) -> np.ndarray:
        return np.asarray(np.exp(-0.5 * ((pitch - rest) / spread) ** 2))

    mass = weight(centers)
    flux = rotational_diffusion * weight(faces) / width**2
    flux[0], flux[-1] = 0.0, 2.0 * flux[-1]  # reflecting below; absorbing half a cell beyond the last centre
    root = np.sqrt(mass)
    values, vectors = eigh_tridiagonal((flux[:-1] + flux[1:]) / mass, -flux[1:-1] / (root[:-1] * root[1:]))
    share = vectors.T @ root  # of S = 1 at t = 0, weighted
    start = np.array([np.interp(0.0, centers, vectors[:, n] / root) for n in range(_CELLS)])
    decay = np.exp(-np.outer(np.atleast_1d(np.asarray(times, dtype=float)), np.maximum(values, 0.0)))
    return np.asarray(decay @ (start * share))


def inverse_gaussian(mean: float, standard_deviation: float) -> Any:
    """The inverse-Gaussian law with that mean and deviation (lambda = mean^3/variance), as a frozen `scipy.stats` law.

    It has `pdf`, `cdf`, `mean`, `std`: the paper's description of histograms of trapping times.
    """
    check_positive(mean=mean, standard_deviation=standard_deviation)
    shape = mean**3 / standard_deviation**2
    return invgauss(mu=mean / shape, scale=shape)


def _process(alpha: float, A: float, D_r: float, gamma: float) -> tuple[float, float, float]:
    """k, theta*, theta_e."""
    check_positive(dipole_strength=alpha, radius=A, rotational_diffusion=D_r)
    check_aspect_ratio(gamma)
    k = 3.0 * alpha * (2.0 + bretherton(gamma)) / (16.0 * gamma**3)
    return k, 1.0 / (A * k), escape_angle(alpha, aspect_ratio=gamma, order="leading")
