"""The fixed part of a recording: colloids, the periodic box, the colours of the states."""

from __future__ import annotations

from typing import Any

import numpy as np
import rerun as rr
from scipy.spatial.transform import Rotation

from porous_swim.observers.rerun.palette import COLLOID, DOMAIN, STATE_COLORS, STATE_NAMES
from porous_swim.observers.rerun.stream import RecordingFile
from porous_swim.observers.rerun.view import Scenery
from porous_swim.obstacles.bodies import Solids
from porous_swim.obstacles.field import ObstacleField

MAX_TRANSLUCENT = 2000  # more take seconds a picture without a GPU; points are always quick, and opaque


def log_world(file: RecordingFile, field: ObstacleField, scenery: Scenery) -> None:
    """Log what never changes; bodies without an end are drawn by `log_endless`."""
    states = [rr.AnnotationInfo(id=state, label=name, color=STATE_COLORS[state]) for state, name in STATE_NAMES.items()]
    file.log("world", rr.ViewCoordinates.RIGHT_HAND_Z_UP, rr.AnnotationContext(states))
    if len(field.centers) > MAX_TRANSLUCENT:
        colors = _depth_shade(field.centers)
        file.log("world/colloids", rr.Points3D(_single(field.centers), radii=_single(field.radii), colors=colors))
    else:
        log_translucent(file, "world/colloids", field, scenery)
    if field.periodic:
        box = rr.Boxes3D(
            mins=[np.zeros(3)], sizes=[field.box], colors=[DOMAIN], fill_mode="majorwireframe", radii=-0.75
        )
        file.log("world/domain", box)


def log_translucent(
    file: RecordingFile, entity: str, field: ObstacleField, scenery: Scenery, *, which: np.ndarray | None = None
) -> None:
    """Log the colloids `which` (indices, all by default) that can be seen whole, as see-through bodies."""
    _log(file, entity, field, scenery, which=which, endless=False)


def log_endless(file: RecordingFile, field: ObstacleField, scenery: Scenery) -> None:
    """Log the part of bodies without an end that belongs to the scenery, as see-through bodies."""
    _log(file, "world/colloids", field, scenery, which=None, endless=True)


def _log(
    file: RecordingFile, entity: str, field: ObstacleField, scenery: Scenery, *, which: np.ndarray | None, endless: bool
) -> None:
    chosen = np.arange(len(field.radii)) if which is None else which
    for solids in field.solids(chosen, scenery.lower, scenery.upper, endless=endless):
        file.log(entity, _drawn(solids, (*COLLOID, _alpha(field))))


def _drawn(solids: Solids, color: tuple[int, int, int, int]) -> rr.Ellipsoids3D | rr.Boxes3D:
    """What Rerun calls them."""
    places: dict[str, Any] = dict(centers=_single(solids.centers), half_sizes=_single(solids.half_sizes))
    if solids.shape == "ellipsoid":
        return rr.Ellipsoids3D(**places, colors=[color], fill_mode="solid")
    turn = _single(Rotation.from_matrix(solids.axes.T).as_quat()[None, :])
    return rr.Boxes3D(**places, quaternions=turn, colors=[color], fill_mode="solid")


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
