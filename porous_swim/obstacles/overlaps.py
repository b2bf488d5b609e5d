"""Colloids must neither overlap nor reach their own images."""

from __future__ import annotations

import numpy as np

from porous_swim.core.parts import KeyedError
from porous_swim.core.scales import Scales, told
from porous_swim.obstacles.domain import Domain
from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.nearest import NearestSphere, wrap

TOUCH = 1e-9  # share of the summed radii by which touching spheres may overlap from rounding


def checked_field(
    centers: np.ndarray, radii: np.ndarray, *, box: np.ndarray, domain: Domain, key: str, tolerance: float = TOUCH,
    notes: tuple[str, ...] = (),
) -> ObstacleField:  # fmt: skip
    """Return the field of `centers` (n, 3), wrapped into `box`; a `KeyedError` where colloids overlap.

    They may do so by `tolerance`, a share of their summed radii.
    """
    if len(radii):
        _check_own_images(radii, box, tolerance, domain.scales)
    field = ObstacleField.of_spheres(wrap(centers, box), radii, box, domain.dimensions, notes=notes)
    if len(radii) > 1:
        _check_pairs(field, key, tolerance, domain.scales)
    return field


def _check_own_images(radii: np.ndarray, box: np.ndarray, tolerance: float, scales: Scales | None) -> None:
    largest = float(radii.max())
    for axis, edge in zip("xyz", box, strict=True):
        if 0.0 < edge < 2.0 * largest * (1.0 - tolerance):
            long, radius, least = (told(value, "a", scales) for value in (float(edge), largest, 2.0 * largest))
            raise KeyedError(
                "domain.size",
                f"the box is {long} long in {axis}, so a colloid of radius {radius} overlaps its own image: expected "
                f"at least {least}",
            )


def _check_pairs(field: ObstacleField, key: str, tolerance: float, scales: Scales | None) -> None:
    other, gap = NearestSphere(field.centers, field.radii, field.box).nearest_other()
    worst = int(np.argmin(gap / (field.radii + field.radii[other])))
    first, second = sorted((worst, int(other[worst])))
    reach = float(field.radii[first] + field.radii[second])
    if gap[worst] >= -tolerance * reach:
        return
    distance = reach + float(gap[worst])
    apart = float(np.linalg.norm(field.centers[first] - field.centers[second]))
    through = " through the periodic boundary" if apart > distance * (1.0 + TOUCH) + TOUCH else ""
    raise KeyedError(
        key,
        f"colloids {first} and {second} overlap by {told(-gap[worst], 'a', scales, digits='.6g')}{through}: centres "
        f"{told(distance, 'a', scales, digits='.6g')} apart, radii {told(field.radii[first], 'a', scales)} and "
        f"{told(field.radii[second], 'a', scales)}",
    )
