"""What a swimmer does that meets no colloid: a persistent random walk. Lengths in a, times in a/U.

With the speed 1 along a director of correlation exp(-l t), l = (d - 1) D_r in d dimensions, and diffusion D:

    MSD = 2 d D t + (2/l^2) (l t - 1 + exp(-l t))

Source: Fuerth, Z. Phys. 2, 244 (1920), with diffusion added.
"""

from __future__ import annotations

import numpy as np


def squared_displacement(time: np.ndarray, D: float, D_r: float, *, dimensions: int) -> np.ndarray:
    """Mean squared displacement (n,), a^2."""
    x = (dimensions - 1) * D_r * time
    small = x < 1e-3  # the series: the closed form cancels
    safe = np.where(small, 1.0, x)
    bent = np.where(small, 1.0 - x / 3.0 + x**2 / 12.0, 2.0 * (safe + np.expm1(-safe)) / safe**2)
    return np.asarray(2.0 * dimensions * D * time + bent * time**2)


def director_correlation(time: np.ndarray, D_r: float, *, dimensions: int) -> np.ndarray:
    """Mean of e(t).e(0), (n,)."""
    return np.exp(-(dimensions - 1) * D_r * time)
