"""Pores that no swimmer leaves, against exact throats of lattices and against a fine grid."""

from __future__ import annotations

from math import sqrt
from typing import Any

import numpy as np
import pytest
from scipy.ndimage import label

from porous_swim.obstacles.field import ObstacleField
from porous_swim.obstacles.pores import closed_share
from porous_swim.scene.scene import Scene


def scene_of(obstacles: dict[str, Any], *, dimensions: int, aspect_ratio: float = 1.0, **domain: Any) -> Scene:
    release = {"kind": "point", "position": [0, 0, 0]}
    return Scene.from_mapping(
        {
            "swimmers": {"count": 1, "dipole_strength": 0.0, "aspect_ratio": aspect_ratio, "release": release},
            "obstacles": obstacles,
            "domain": {"dimensions": dimensions, **domain},
            "run": {"time_step": 0.01, "duration": 1},
        }
    )


# the least clearance at which the widest throat is closed: half the gap of a square, and the radius of the circle
# through the four centres around a face, or the three of a triangle, less that of the spheres
LATTICES = [
    ("square", 2, 10.5, [20, 20], 0.25),
    ("square", 2, 10.5, [1, 1], 0.25),
    ("hexagonal", 2, 10.5, [10, 6], 0.25),
    ("sc", 3, 12.0, [4, 4, 4], 12.0 / sqrt(2.0) - 5.0),
    ("fcc", 3, 12.0, [3, 3, 3], 12.0 / sqrt(3.0) - 5.0),
]


@pytest.mark.parametrize(("layout", "dimensions", "spacing", "cells", "closing"), LATTICES)
def test_all_room_of_a_lattice_is_closed_beyond_the_width_of_its_throats(layout, dimensions, spacing, cells, closing):
    obstacles = {"layout": layout, "radius": 5.0, "spacing": spacing, "cells": cells}
    field = scene_of(obstacles, dimensions=dimensions).place_obstacles()
    assert closed_share(field, closing - 1e-3) == 0.0  # ties are decided within some 1e-5
    assert closed_share(field, closing + 1e-3) == 1.0


def test_an_open_lattice_is_closed_inside():
    obstacles = {"layout": "square", "radius": 5.0, "spacing": 10.5, "cells": [20, 20]}
    assert closed_share(scene_of(obstacles, dimensions=2, boundary="open").place_obstacles(), 1.0) == 1.0


def share_on_a_grid(field: ObstacleField, clearance: float, *, cell: float) -> float:
    """The same by cells of a periodic plane whose middles a centre can enter, joined across four sides.

    A pore is open where it meets itself, or anything that leads on, across the edge of a patch of three boxes.
    """
    n = np.round(field.box[:2] / cell).astype(int)
    ticks = [(np.arange(count) + 0.5) * edge / count for count, edge in zip(n, field.box, strict=False)]
    points = np.stack([*np.meshgrid(*ticks, indexing="ij"), np.zeros(n)], axis=-1).reshape(-1, 3)
    free = np.tile((field.nearest(points)[2] > clearance).reshape(n), (3, 3))
    pore = label(free)[0]
    open_ones = np.unique(np.concatenate([pore[0], pore[-1], pore[:, 0], pore[:, -1]]))
    third = tuple(slice(count, 2 * count) for count in n)
    return float(np.sum(free[third] & ~np.isin(pore[third], open_ones)) / free[third].sum())


@pytest.mark.parametrize("fraction", [0.45, 0.5])
def test_closed_pores_of_discs_of_many_sizes_are_those_of_a_fine_grid(fraction):
    obstacles = {"layout": "random", "radius": [3.0, 5.0, 9.0], "count": 60, "packing_fraction": fraction}
    field = scene_of(obstacles, dimensions=2).place_obstacles()
    expected = share_on_a_grid(field, 1.0, cell=0.1)  # throats narrower than the cells count as closed there
    assert 0.0 < expected < 1.0
    # 4 standard errors of 2000 points, and what the grid takes for closed
    assert closed_share(field, 1.0) == pytest.approx(expected, abs=4.0 * sqrt(expected * (1 - expected) / 2000) + 0.02)


def test_a_scene_whose_pores_are_closed_says_so_and_whose_width_matters():
    obstacles = {"layout": "square", "radius": 5.0, "spacing": 10.5, "cells": [20, 20]}
    text = [text for text in scene_of(obstacles, dimensions=2).warnings() if "closed pores" in text]
    assert len(text) == 1
    assert text[0].startswith("about 100 % of the room for swimmers is in closed pores: ")
    assert "nearer to each other than 2, the width of a swimmer" in text[0]
    slim = scene_of(obstacles, dimensions=2, aspect_ratio=0.2)  # rods 0.4 thick pass lengthwise
    assert not [text for text in slim.warnings() if "closed pores" in text]


@pytest.mark.parametrize("layout", ["none", "single"])
def test_open_space_has_no_pores(layout):
    obstacles = {"layout": layout} | ({} if layout == "none" else {"radius": 5.0})
    assert closed_share(scene_of(obstacles, dimensions=3).place_obstacles(), 1.0) == 0.0
