"""What every release must do."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from porous_swim.engine.probe import height_at_sine
from porous_swim.obstacles.field import ObstacleField
from porous_swim.scene.scene import Scene
from porous_swim.swimmers.placement import Swimmers
from porous_swim.testing.models import check_described, check_keys

_ROUNDING = 1e-8  # a; of heights, of which placing itself allows 1e-9
_COLLOID = {"layout": "single", "radius": 3.0, "position": [10.0, 10.0, 10.0]}
_BOX = {"boundary": "periodic", "size": [20.0, 20.0, 20.0]}


def check_release(
    release: Mapping[str, Any], *, obstacles: Mapping[str, Any] = _COLLOID, domain: Mapping[str, Any] = _BOX,
    count: int = 100, folder: Path | str = ".",
) -> None:  # fmt: skip
    """Require of the release in `swimmers.release` of a scene:

    its keys are described, and mistakes in them are told at the key; the same seed releases the same swimmers, to the
    bit; shapes are those of the contract in `ps.Release`, directors are unit vectors, in 2-D z = 0; spheres and rods
    keep their contact height above every colloid and image.

    Args:
        release: the part, as a scene file has it.
        obstacles: the section with the colloids around which it releases; spheres.
        domain: the section `domain`.
        count: number of swimmers.
        folder: where the files are that it names.
    """
    given = dict(release)

    def load(data: dict[str, Any], seed: int = 7, aspect_ratio: float = 1.0) -> Scene:
        swimmers = {"count": count, "dipole_strength": 0.0, "aspect_ratio": aspect_ratio, "release": data}
        run = {"time_step": 0.01, "duration": 1.0, "seed": seed}
        sections = {"swimmers": swimmers, "obstacles": dict(obstacles), "domain": dict(domain), "run": run}
        return Scene.from_mapping(sections, folder=folder)

    part = load(given).swimmers.release
    name = type(part).__name__
    check_described(type(part))
    check_keys(part, given, load, key="swimmers.release")
    first, again = _released(load(given))[1], _released(load(given))[1]
    for mine, other in ((first.position, again.position), (first.director, again.director)):
        assert np.array_equal(mine, other), f"{name}: the same seed releases other swimmers: use `rng` alone"
    for seed, aspect_ratio in product((7, 8), (1.0, 0.5)):
        _check_swimmers(*_released(load(given, seed, aspect_ratio)), count, aspect_ratio, name)


def _released(scene: Scene) -> tuple[ObstacleField, Swimmers]:
    field, ratio = scene.place_obstacles(), scene.swimmers.aspect_ratio
    return field, scene.place_swimmers(field, lambda s, A: height_at_sine(s, A, aspect_ratio=ratio))


def _check_swimmers(field: ObstacleField, swimmers: Swimmers, count: int, aspect_ratio: float, name: str) -> None:
    for array in (swimmers.position, swimmers.director):
        assert array.shape == (count, 3), f"{name}: expected the shape {(count, 3)}, found {array.shape}"
        assert array.dtype == np.float64, f"{name}: expected float64, found {array.dtype}"
        assert np.all(np.isfinite(array)), f"{name}: a position or director is not finite"
        assert field.dimensions == 3 or not np.any(array[:, 2]), f"{name}: in two dimensions z is not 0"
    length = np.linalg.norm(swimmers.director, axis=1)
    assert np.abs(length - 1.0).max() < 1e-12, f"{name}: a director has the length {length[np.argmax(abs(length - 1))]}"
    repeats = field.box > 0.0
    inside = np.where(repeats, np.mod(swimmers.position, np.where(repeats, field.box, 1.0)), swimmers.position)
    for center, radius in zip(field.centers, field.radii, strict=True):
        for shift in product(*((-1, 0, 1) if edge > 0.0 else (0,) for edge in field.box)):
            offset = inside - center - np.array(shift) * field.box
            distance = np.linalg.norm(offset, axis=1)
            sine = np.sum(offset * swimmers.director, axis=1) / distance
            least = height_at_sine(sine, np.full(count, radius), aspect_ratio=aspect_ratio)
            lack = least - (distance - radius)
            assert lack.max() <= _ROUNDING, f"{name}: swimmer {np.argmax(lack)} is {lack.max():g} below contact"
