"""The fixed part of a recording: colloids, the periodic box, the colours of the states."""

from __future__ import annotations

import numpy as np
import rerun as rr
from scipy.spatial.transform import Rotation

from porous_swim.observers.rerun.palette import COLLOID, DOMAIN, STATE_COLORS, STATE_NAMES
from porous_swim.observers.rerun.stream import RecordingFile
from porous_swim.observers.rerun.view import Scenery
from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.wall import WallField

WALL_THICKNESS = 1.0  # a, as drawn
MAX_TRANSLUCENT = 2000  # more take seconds a picture without a GPU; points are always quick, and opaque


def log_world(file: RecordingFile, field: ObstacleField) -> None:
    """Log what never changes; a wall is drawn by `log_wall`."""
    states = [rr.AnnotationInfo(id=state, label=name, color=STATE_COLORS[state]) for state, name in STATE_NAMES.items()]
    file.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, rr.AnnotationContext(states))
    if len(field.centers) > MAX_TRANSLUCENT:
        colors = _depth_shade(field.centers)
        file.log("world/colloids", rr.Points3D(_single(field.centers), radii=_single(field.radii), colors=colors))
    elif len(field.centers) and not isinstance(field, WallField):
        log_translucent(file, "world/colloids", field)
    if field.periodic:
        box = rr.Boxes3D(
            mins=[np.zeros(3)], sizes=[field.box], colors=[DOMAIN], fill_mode="majorwireframe", radii=-0.75
        )
        file.log("world/domain", box)


def log_translucent(file: RecordingFile, entity: str, field: ObstacleField, *, which: np.ndarray | None = None) -> None:
    """Log the colloids `which` (indices, all by default) as see-through spheres."""
    chosen = slice(None) if which is None else which
    half_sizes = np.repeat(field.radii[chosen, None], 3, axis=1)
    spheres = rr.Ellipsoids3D(
        centers=_single(field.centers[chosen]),
        half_sizes=_single(half_sizes),
        colors=[(*COLLOID, _alpha(field))],
        fill_mode="solid",
    )
    file.log(entity, spheres)


def log_wall(file: RecordingFile, field: WallField, scenery: Scenery) -> None:
    """Log the part of the wall that belongs to the scenery, as a see-through slab below its plane."""
    size, last = np.full(3, 0.75 * scenery.size), field.dimensions - 1
    size[last] = 0.5 * WALL_THICKNESS
    size[last + 1 :] = WALL_THICKNESS  # across the plane of two dimensions
    middle = field.outline(scenery.center[None, :]) - size[last] * field.normal
    slab = rr.Boxes3D(
        centers=_single(middle),
        half_sizes=_single(size[None, :]),
        quaternions=_single(Rotation.from_matrix(field.axes.T).as_quat()[None, :]),
        colors=[(*COLLOID, _alpha(field))],
        fill_mode="solid",
    )
    file.log("world/colloids", slab)


def _alpha(field: ObstacleField) -> int:
    # light passes n pi r^2 / edge^2 spheres on its way through a box: let the same share of it through any
    clear, most = 0.45, 70  # share of the background's light; opacity of 255 at which a sphere hides no orbit
    if field.dimensions == 2 or not field.periodic:
        return most
    n_layers = float(np.pi * np.sum(field.radii**2) / np.prod(field.box) ** (2.0 / 3.0))
    return int(np.clip(255.0 * (1.0 - clear ** (1.0 / n_layers)), 12, most))


def _depth_shade(centers: np.ndarray) -> np.ndarray:
    # opaque spheres of one grey melt into a wall: let the shade vary with depth along the view's diagonal
    depth = centers @ np.array([0.55, -0.85, 0.5])
    shade = 0.55 + 0.45 * (depth - depth.min()) / max(float(np.ptp(depth)), 1e-9)
    return np.asarray(shade[:, None] * np.array(COLLOID), dtype=np.uint8)


def _single(array: np.ndarray) -> np.ndarray:
    return np.array(array, dtype=np.float32)  # always a copy: the SDK keeps a reference
