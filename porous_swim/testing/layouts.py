"""What every layout must do."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from porous_swim.core.errors import SceneError
from porous_swim.obstacles.field import ObstacleField
from porous_swim.scene.scene import Scene
from porous_swim.testing.models import check_described, check_keys

_TOUCH = 1e-9  # share of the summed radii by which touching spheres may overlap from rounding
_MOST = 1000  # colloids that are compared pair by pair


def check_layout(
    obstacles: Mapping[str, Any], *, domain: Mapping[str, Any] | None = None, folder: Path | str = ".",
    overlap: float = _TOUCH,
) -> None:  # fmt: skip
    """Require of the layout in the section `obstacles` of a scene:

    its keys are described, and mistakes in them are told at the key; the same seed places the same colloids, to the
    bit, as many as `n_colloids` says; shapes, the box and, in 2-D, z = 0 are those of the contract in `ps.Layout`; no
    two colloids and images overlap, but by the share `overlap` of their summed radii; in another domain they are placed
    as well, or a SceneError says why not.

    Args:
        obstacles: the section, small: some hundred colloids.
        domain: the section `domain` that goes with it.
        folder: where the files are that it names.
        overlap: share of their summed radii by which colloids may overlap.
    """
    given, space = dict(obstacles), dict(domain or {})

    def load(data: dict[str, Any], **more: Any) -> Scene:
        return _scene(data, {**space, **more}, Path(folder))

    scene = load(given)
    name = type(scene.obstacles).__name__
    check_described(type(scene.obstacles))
    check_keys(scene.obstacles, given, load, key="obstacles")
    field, again = scene.place_obstacles(), load(given).place_obstacles()
    for mine, other in ((field.centers, again.centers), (field.radii, again.radii), (field.box, again.box)):
        assert np.array_equal(mine, other), f"{name}: the same seed places other colloids: use `rng` alone"
    for placed in (field, scene.replace({"run.seed": 1234567}).place_obstacles()):
        _check_field(placed, scene, name, overlap)
    for dimensions, boundary in product((2, 3), ("open", "periodic")):
        try:
            load(given, dimensions=dimensions, boundary=boundary).place_obstacles()
        except SceneError:
            continue  # any other error is a fault


def _check_field(field: ObstacleField, scene: Scene, name: str, overlap: float) -> None:
    n, flat = len(field.radii), field.dimensions == 2
    assert field.dimensions == scene.domain.dimensions, f"{name}: the field has {field.dimensions} dimensions"
    for array, shape in ((field.centers, (n, 3)), (field.radii, (n,)), (field.box, (3,))):
        assert array.shape == shape, f"{name}: expected the shape {shape}, found {array.shape}"
        assert array.dtype == np.float64, f"{name}: expected float64, found {array.dtype}"
    assert np.all(np.isfinite(field.centers)), f"{name}: a centre is not finite"
    assert np.all(field.radii > 0.0), f"{name}: a radius is not above 0"
    assert field.periodic == scene.domain.periodic, f"{name}: expected a box that repeats: {scene.domain.periodic}"
    inside = (field.centers >= 0.0) & (field.centers < field.box) | (field.box == 0.0)
    assert np.all(inside), f"{name}: a centre lies outside of the box [0, box)"
    if flat:
        assert not np.any(field.centers[:, 2]), f"{name}: in two dimensions a centre has z other than 0"
        assert field.box[2] == 0.0, f"{name}: in two dimensions the box has an edge along z"
    assert abs(scene.n_colloids - n) <= 1 + n // 20, f"{name}: n_colloids says {scene.n_colloids} of {n} colloids"
    if n <= _MOST and np.all(np.isfinite(field.radii)):
        least = least_gap(field)
        assert least >= -overlap, f"{name}: colloids overlap by {-least:g} of their summed radii"


def least_gap(field: ObstacleField) -> float:
    """Return the least distance of two surfaces, in their summed radii, over all pairs and images."""
    reach, least = field.radii[:, None] + field.radii, np.inf
    for shift in product(*((-1, 0, 1) if edge > 0.0 else (0,) for edge in field.box)):
        offset = field.centers[:, None] - field.centers - np.array(shift) * field.box
        gap = np.linalg.norm(offset, axis=2) / reach - 1.0
        if not any(shift):
            np.fill_diagonal(gap, np.inf)
        least = min(least, float(gap.min(initial=np.inf)))
    return least


def _scene(obstacles: dict[str, Any], domain: dict[str, Any], folder: Path) -> Scene:
    swimmers = {"count": 1, "dipole_strength": 0.0, "release": {"kind": "point", "position": [0.0, 0.0, 0.0]}}
    run = {"time_step": 0.01, "duration": 1.0, "seed": 7}
    return Scene.from_mapping(
        {"swimmers": swimmers, "obstacles": obstacles, "domain": domain, "run": run}, folder=folder
    )
