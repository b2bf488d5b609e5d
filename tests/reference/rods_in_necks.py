"""How long rods stay in the neck between two spheres, by small steps in NumPy: makes rods_in_necks.json.

    python tests/reference/rods_in_necks.py

It shares no code with porous_swim. A rod (spheroid of semi-axes 1, gamma, gamma) swims at speed 1, diffuses and turns
freely; no flow, contact without torque or friction. Two spheres of radius 5 leave a gap between them on the y axis;
rods begin at x = -3.2 and head for it. Where a rod overlaps a sphere it is put back along the line of centres, at the
director that it has then; where it overlaps both, where both contact surfaces meet in its half-plane. The contact
height comes from a table of the contact curve: with the normal at p from the axis, the centres are A n + support apart.

Written for each case: the mean of min(T, LAST), T being the time at which a rod is first FAR from the middle of the
neck, looked at every LOOK; and the share of rods that are beyond it (x > 0) then or at LAST.
"""

from __future__ import annotations

import json
from itertools import product
from pathlib import Path

import numpy as np

A, D, D_R = 5.0, 0.02, 0.2
STEP, LOOK, LAST, N = 2e-3, 0.1, 20.0, 1000
START, FAR = 3.2, 4.2
CELLS = 20000  # of the table, linear between: heights to 1e-8
GAMMAS, GAPS = (0.15, 0.33, 0.7), (0.0, 1.0, 1.6, 2.0)  # gaps in units of gamma: closed, to the thickness of a rod


class Heights:
    """Contact heights of a rod above the spheres, by interpolation over the sine of the pitch."""

    def __init__(self, gamma: float):
        p = np.linspace(0.0, np.pi / 2, 200001)  # of the normal, from the axis
        S = np.sqrt(np.cos(p) ** 2 + gamma**2 * np.sin(p) ** 2)
        along, aside = A * np.cos(p) + np.cos(p) / S, A * np.sin(p) + gamma**2 * np.sin(p) / S
        R = np.hypot(along, aside)
        self.height = np.interp(np.linspace(0.0, 1.0, CELLS + 1), (along / R)[::-1], (R - A)[::-1])

    def above(self, v: np.ndarray, e: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distance from the centre, and that of contact, at offsets v (n, 3)."""
        R = np.sqrt(np.einsum("ij,ij->i", v, v))
        sine = np.abs(np.einsum("ij,ij->i", v, e)) / R * CELLS
        cell = np.minimum(sine.astype(int), CELLS - 1)
        low, high = self.height[cell], self.height[cell + 1]
        return R, A + low + (high - low) * (sine - cell)


def both(y: np.ndarray, e: np.ndarray, half: float, heights: Heights) -> np.ndarray:
    """Where both contact surfaces meet: the circle of both contact distances, as these are there, damped."""
    across = np.hypot(y[:, 0], y[:, 2])
    out = np.stack([y[:, 0] / across, np.zeros(len(y)), y[:, 2] / across], axis=1)
    center = np.array([0.0, half, 0.0])
    for _ in range(4000):
        _, r0 = heights.above(y + center, e)
        _, r1 = heights.above(y - center, e)
        up = (r0**2 - r1**2) / (4.0 * half)
        square = r0**2 - (up + half) ** 2
        z = out * np.sqrt(np.maximum(square, 1e-8))[:, None] + np.outer(up, [0.0, 1.0, 0.0])
        change = np.abs(z - y).max()
        y = y + 0.4 * (z - y)
        if change < 1e-5:
            return y
    raise RuntimeError("the contact surfaces were not found to meet")


def settled(x: np.ndarray, e: np.ndarray, half: float, heights: Heights) -> np.ndarray:
    """Positions that obey contact with both spheres."""
    near = np.flatnonzero(np.hypot(np.hypot(x[:, 0], x[:, 2]), np.abs(x[:, 1]) - half) < A + 1.0)
    if len(near) == 0:
        return x
    y, d = x[near], e[near]
    center = np.array([0.0, half, 0.0])
    deep = np.zeros((2, len(near)), bool)
    for k, c in enumerate((-center, center, -center)):
        R, least = heights.above(y - c, d)
        inside = least - R > 1e-7
        if k < 2:
            deep[k] = inside
        else:
            pinched = inside & deep[1]
        y = np.where(inside[:, None], c + (y - c) * (least / R)[:, None], y)
    R, least = heights.above(y - center, d)
    pinched |= (least - R > 1e-7) & deep[0]
    if pinched.any():
        y[pinched] = both(x[near][pinched], d[pinched], half, heights)
    x = x.copy()
    x[near] = y
    return x


def turned(e: np.ndarray, dimensions: int, rng: np.random.Generator) -> np.ndarray:
    """Directors after free rotational diffusion over a step."""
    kick = np.sqrt(2.0 * D_R * STEP) * rng.normal(size=e.shape)
    if dimensions == 2:
        c, s = np.cos(kick[:, 0]), np.sin(kick[:, 0])
        return np.stack([c * e[:, 0] - s * e[:, 1], s * e[:, 0] + c * e[:, 1], e[:, 2]], axis=1)
    w = kick - e * np.einsum("ij,ij->i", kick, e)[:, None]
    angle = np.linalg.norm(w, axis=1)[:, None]
    return e * np.cos(angle) + w * np.sinc(angle / np.pi)


def times(dimensions: int, gamma: float, gap: float, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Time to leave (n,), infinite beyond LAST, and where, x (n,)."""
    heights, half = Heights(gamma), A + 0.5 * gap
    x, e = np.zeros((2, N, 3))
    x[:, 0], e[:, 0] = -START, 1.0
    left, place, who = np.full(N, np.inf), np.zeros(N), np.arange(N)
    axes = np.arange(3) < dimensions
    for look in range(1, round(LAST / LOOK) + 1):
        for _ in range(round(LOOK / STEP)):
            x = x + e * STEP + np.sqrt(2.0 * D * STEP) * rng.normal(size=x.shape) * axes
            e = turned(e, dimensions, rng)
            x = settled(x, e, half, heights)
        out = np.linalg.norm(x, axis=1) > FAR
        left[who[out]] = look * LOOK
        place[who] = x[:, 0]
        x, e, who = x[~out], e[~out], who[~out]  # the rest go on alone
        if len(who) == 0:
            break
    return left, place


def main() -> None:
    rng = np.random.default_rng(20)
    cases = []
    for dimensions, gamma, gap in product((2, 3), GAMMAS, GAPS):
        left, place = times(dimensions, gamma, gap * gamma, rng)
        stay, beyond = np.minimum(left, LAST), place > 0.0
        cases.append({
            "dimensions": dimensions, "gamma": gamma, "gap": gap * gamma,
            "stay": float(stay.mean()), "stay_error": float(stay.std() / np.sqrt(N)),
            "beyond": float(beyond.mean()), "beyond_error": float(beyond.std() / np.sqrt(N)),
        })  # fmt: skip
        print(cases[-1], flush=True)
    numbers = dict(radius=A, D=D, D_r=D_R, step=STEP, look=LOOK, last=LAST, n=N, start=START, far=FAR)
    path = Path(__file__).with_suffix(".json")
    path.write_text(json.dumps({"about": __doc__.split("\n")[0], **numbers, "cases": cases}, indent=1) + "\n")


if __name__ == "__main__":
    main()
