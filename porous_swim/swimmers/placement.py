"""Swimmers as they are released: where they are, where they point, and whether they fit."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from porous_swim.core.parts import ContactHeight, KeyedError
from porous_swim.obstacles.field import ObstacleField

HIGHEST_CONTACT = 1.0  # a: a swimmer standing on its tip; at any pitch the contact height is at most this
_AT_ONCE = 1 << 14  # swimmers
_ROUNDING = 1e-9  # a; a swimmer placed exactly in contact fits


@dataclass(frozen=True, eq=False)
class Swimmers:
    """Position and director of every swimmer at t = 0."""

    position: np.ndarray  # (n, 3) float64, a, absolute
    director: np.ndarray  # (n, 3) float64, unit


def fits(
    position: np.ndarray, director: np.ndarray, *, field: ObstacleField, contact_height: ContactHeight
) -> np.ndarray:
    """Return (n,) whether each swimmer keeps its contact height above every colloid and image."""
    lack = shortfall(position, director, field=field, contact_height=contact_height)
    return np.asarray(lack[0] <= _ROUNDING)


def shortfall(
    position: np.ndarray, director: np.ndarray, *, field: ObstacleField, contact_height: ContactHeight
) -> tuple[np.ndarray, np.ndarray]:
    """Return how far each swimmer lies below contact (n,), -inf if nothing is near, and the colloid (n,)."""
    if len(position) > _AT_ONCE:  # pairs of swimmer and colloid take memory
        parts = [
            shortfall(
                position[i : i + _AT_ONCE], director[i : i + _AT_ONCE], field=field, contact_height=contact_height
            )
            for i in range(0, len(position), _AT_ONCE)
        ]
        return np.concatenate([part[0] for part in parts]), np.concatenate([part[1] for part in parts])
    lack = np.full(len(position), -np.inf)
    blame = np.full(len(position), -1, dtype=np.int64)
    point, colloid, offset = field.near(position, HIGHEST_CONTACT)
    height, sine = field.stance(offset, director[point], colloid)
    least = contact_height(np.clip(sine, -1.0, 1.0), field.radii[colloid])
    lacking = least - height
    order = np.argsort(lacking, kind="stable")  # so that the worst colloid is written last
    lack[point[order]], blame[point[order]] = lacking[order], colloid[order]
    return lack, blame


def checked_swimmers(
    position: np.ndarray,
    director: np.ndarray,
    *,
    field: ObstacleField,
    contact_height: ContactHeight,
    key: str,
) -> Swimmers:
    """Return the swimmers; a `KeyedError` for `key` names the first that does not fit."""
    lack, blame = shortfall(position, director, field=field, contact_height=contact_height)
    if np.any(lack > _ROUNDING):
        i = int(np.argmax(lack > _ROUNDING))
        place = ", ".join(f"{x:.6g}" for x in position[i])
        raise KeyedError(
            key,
            f"swimmer {i} at ({place}) lies {lack[i]:.6g} too near to {field.name(int(blame[i]))}: "
            f"expected at least the contact height above its surface",
        )
    return Swimmers(position, director)


def random_directors(rng: np.random.Generator, count: int, dimensions: int) -> np.ndarray:
    """Return isotropic unit vectors (count, 3), in the plane z = 0 in two dimensions."""
    u = rng.random((count, 2))  # row by row: the first swimmers do not depend on how many follow
    angle = 2.0 * np.pi * u[:, 0]
    z = 2.0 * u[:, 1] - 1.0 if dimensions == 3 else np.zeros(count)
    across = np.sqrt(1.0 - z * z)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], axis=1)


def frame_of(normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit vectors (n, 3) that complete each of `normals` (n, 3) to a right-handed frame.

    For normals in the plane z = 0 the second is the z axis, so the first stays in the plane.
    """
    helper = np.where(np.abs(normals[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(helper, normals)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return first, np.cross(normals, first)
