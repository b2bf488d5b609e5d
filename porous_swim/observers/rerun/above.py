"""Scenes in a plane as they look from above, without perspective, and their scale bar. Lengths in a.

The viewer has no parallel projection. A pinhole camera so far away that nothing is nearer to it than the rest does as
well, and its picture is a view in two dimensions, in which one unit is one a.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from porous_swim.core.scales import Scales, shown_in
from porous_swim.observers.rerun.palette import DIRECTOR
from porous_swim.observers.rerun.stream import RecordingFile
from porous_swim.observers.rerun.view import Scenery

CAMERA = "world/above"
# distance of the camera over the scenery's size. At 4 the outline of a sphere is within 1 % that of its middle section;
# from further off the viewer draws dots ragged: it finds them from differences of squares in single precision
_FAR = 4.0
_BAR_SHARE = 0.2  # of the width, at most, that a scale bar takes
_MARGIN = 0.04  # of the longer edge, around the scenery; thrice that below, for the bar


def log_camera(file: RecordingFile, scenery: Scenery) -> None:
    """Log the camera whose picture is the plane, x to the right and y upwards."""
    width, height = (scenery.upper - scenery.lower)[:2].tolist()
    distance = _FAR * max(width, height)
    place = rr.Transform3D(
        translation=scenery.center + np.array([0.0, 0.0, distance]),
        mat3x3=np.diag([1.0, -1.0, -1.0]),  # it looks down, and its picture's second axis too
    )
    camera = rr.Pinhole(
        focal_length=distance, width=width, height=height, principal_point=[0.5 * width, 0.5 * height],
        image_plane_distance=1.0,
    )  # fmt: skip
    file.log(CAMERA, place, camera)


def log_scale_bar(file: RecordingFile, entity: str, scenery: Scenery, scales: Scales | None) -> None:
    """Log a bar below the lower left corner of `scenery`, of a round length that it says."""
    factor, unit = shown_in("a", scales)
    corner, edges = scenery.lower, (scenery.upper - scenery.lower)[:2]
    length = round_below(_BAR_SHARE * float(edges[0]) * factor)
    start = np.array([corner[0], corner[1] - _MARGIN * float(edges.max()), scenery.center[2]])
    end = start + np.array([length / factor, 0.0, 0.0])
    bar = rr.LineStrips3D(
        [np.array([start, end], dtype=np.float32)],
        radii=[-1.5], colors=[DIRECTOR], labels=[f"{length:g} {unit}"], show_labels=True,
    )  # fmt: skip
    file.log(entity, bar)


def round_below(length: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is not above `length`."""
    power = 10.0 ** np.floor(np.log10(length))
    return float(power * max(digit for digit in (1.0, 2.0, 5.0) if digit * power <= length * (1.0 + 1e-9)))


def from_above(
    name: str, shown: Sequence[str], scenery: Scenery, whole: Scenery, overrides: Mapping[Any, Any],
    background: tuple[int, int, int],
) -> rrb.Spatial2DView:  # fmt: skip
    """The picture of the camera for `whole`, cut to `scenery`; `shown` are entities, as of any view."""
    corner = np.array([whole.lower[0], whole.upper[1]])
    left, right = (scenery.lower[0] - corner[0], scenery.upper[0] - corner[0])
    top, bottom = (corner[1] - scenery.upper[1], corner[1] - scenery.lower[1])
    margin = _MARGIN * max(right - left, bottom - top)
    bounds = rrb.VisualBounds2D(
        x_range=(left - margin, right + margin), y_range=(top - margin, bottom + 3.0 * margin)
    )  # fmt: skip
    return rrb.Spatial2DView(
        name=name, origin=f"/{CAMERA}", contents=list(shown), visual_bounds=bounds, background=background,
        overrides=overrides,
    )  # fmt: skip
