"""Where swimmers are: in the cell of a lattice, and in height and pitch about the nearest colloid. Lengths in a."""

from __future__ import annotations

import math

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import DIRECTORS, column, needs, vectors
from porous_swim.analysis.histogram import Map, histogram_2d
from porous_swim.analysis.places import centers_of, sphere_radii_of
from porous_swim.core.errors import ResultsError
from porous_swim.results.tables import TableInfo, steady_frames


@needs(trajectory="swimmer x y")
def cell_density(trajectory: pa.Table, *, cell: tuple[float, float] | None = None, n_bins: int = 60) -> Map:
    """Distribution of positions in the plane, folded into the rectangle from 0 to `cell`, all heights together.

    `cell`, in a, is that of the lattice (the box over its number of cells); by default the whole box.
    Frames are those after the burn-in of the run. They share swimmers: the errors are over swimmers. The table needs
    its `TableInfo`.

    Raises:
        ValueError: a cell without area, as in an open field.
    """
    trajectory = steady_frames(trajectory)
    box = TableInfo.of(trajectory).box
    edge_x, edge_y = cell or box[:2]
    if not (edge_x > 0.0 and edge_y > 0.0):
        raise ValueError(f"cell: found {edge_x:g} by {edge_y:g}, allowed are edges above 0")
    x, y = column(trajectory, "x"), column(trajectory, "y")
    return histogram_2d(
        x - np.floor(x / edge_x) * edge_x,
        y - np.floor(y / edge_y) * edge_y,
        x_edges=np.linspace(0.0, edge_x, n_bins + 1),
        y_edges=np.linspace(0.0, edge_y, n_bins + 1),
        swimmer=column(trajectory, "swimmer"),
    )


@needs(trajectory=f"swimmer x y z {DIRECTORS} colloid image_x image_y image_z", colloids="colloid x y z radius")
def height_pitch_density(trajectory: pa.Table, colloids: pa.Table, *, heights: np.ndarray, n_pitches: int = 60) -> Map:
    """Distribution over pitch (x, rad, from -pi/2 to pi/2) and height above the nearest colloid (y).

    `heights` (n_y + 1,), in a, are the edges of the bins; samples above the last count as outside. The
    trajectory needs its `TableInfo`.

    Raises:
        ResultsError: a field without colloids, or a plane wall.
    """
    trajectory = steady_frames(trajectory)
    colloid = column(trajectory, "colloid")
    if len(colloids) == 0 or np.any(colloid < 0):
        raise ResultsError("trajectory: found a field without any, where heights have no meaning")
    image = vectors(trajectory, "image_x", "image_y", "image_z") * np.asarray(TableInfo.of(trajectory).box)
    offset = vectors(trajectory, "x", "y", "z") - centers_of(colloids)[colloid] - image
    distance = np.linalg.norm(offset, axis=1)
    sine = np.sum(offset * vectors(trajectory, "ex", "ey", "ez"), axis=1) / distance
    return histogram_2d(
        np.arcsin(np.clip(sine, -1.0, 1.0)),
        distance - sphere_radii_of(colloids)[colloid],
        x_edges=np.linspace(-0.5 * math.pi, 0.5 * math.pi, n_pitches + 1),
        y_edges=heights,
        swimmer=column(trajectory, "swimmer"),
    )
