"""Where the swimmers of a run will be, roughly and before it is made: what decides how much a step costs."""

from __future__ import annotations

import numpy as np

from porous_swim.engine.kernel.budget import PARTNER_WITHIN
from porous_swim.obstacles.field import ObstacleField
from porous_swim.running.dynamics import lowest_flight
from porous_swim.scene.scene import Scene

_POINTS = 4000  # looked at: shares to 1 %
_STAY = 10.0  # a/U, that a swimmer stays at a colloid: 6 to 36 in the shipped scenes


def far_share(scene: Scene, field: ObstacleField) -> float:
    """The share of time that a swimmer of a scene with `run.flight_step` flies in."""
    if scene.run.flight_step is None:
        return 0.0
    if len(field.radii) == 0 or not field.periodic:  # in the open hardly anyone comes back
        return 1.0
    lowest, gamma = lowest_flight([scene]), scene.swimmers.aspect_ratio
    points = np.random.default_rng(0).random((_POINTS, 3)) * field.box
    _, _, height = field.nearest(points)
    free = height[height >= gamma]
    if len(free) == 0:
        return 0.0
    return float(np.mean(free >= lowest)) * (1.0 - _bound_share(field))


def pair_share(scene: Scene, field: ObstacleField) -> float:
    """The share of time in which a rod is so near two colloids that both have to be looked at."""
    gamma, d = scene.swimmers.aspect_ratio, field.dimensions
    if gamma == 1.0 or len(field.radii) == 0 or not field.is_round:
        return 0.0
    rng = np.random.default_rng(0)
    surface = field.radii ** (d - 1)
    colloid = rng.choice(len(surface), _POINTS, p=surface / surface.sum())
    direction = np.zeros((_POINTS, 3))
    direction[:, :d] = rng.normal(size=(_POINTS, d))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    points = field.centers[colloid] + (field.radii[colloid] + gamma)[:, None] * direction
    reach = 1.0 + scene.encounter.contact_band + PARTNER_WITHIN
    point, near, offset = field.near(points, reach)
    height, _ = field.stance(offset, direction[point], near)
    inside = np.bincount(point[height < gamma - 1e-6], minlength=_POINTS) > 0
    paired = np.bincount(point, minlength=_POINTS) > 1
    return float(np.mean(paired[~inside])) * _bound_share(field) if np.any(~inside) else 1.0


def _bound_share(field: ObstacleField) -> float:
    """The share of time at colloids of a swimmer that meets them as a straight swimmer in their box does."""
    if not field.periodic:
        return 0.5
    d = field.dimensions
    room = max(0.0, float(np.prod(field.box[:d]) - field.bulk))
    surface = np.sum(2.0 * np.pi * field.radii) / np.pi if d == 2 else np.sum(4.0 * np.pi * field.radii**2) / 4.0
    return float(_STAY / (_STAY + room / surface))
