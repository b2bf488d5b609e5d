"""What every motility must do."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from porous_swim.running.simulation import Simulation
from porous_swim.scene.scene import Scene
from porous_swim.testing.models import check_described, check_keys
from porous_swim.testing.steppers import check_lanes

_STEPS = 10


def check_motility(motility: Mapping[str, Any]) -> None:
    """Require of the motility in `swimmers.motility` of a scene:

    its keys are described, and mistakes in them are told at the key; in two and three dimensions and in both precisions
    it compiles, and directors stay unit vectors; around a colloid, with noise and without, one
    lane and full ones move swimmers to the same bits.

    Args:
        motility: the part, as a scene file has it, such as `{"kind": "steady"}`.
    """
    given = dict(motility)
    part = _free(given).swimmers.motility
    check_described(type(part))
    check_keys(part, given, _free, key="swimmers.motility")
    for dimensions, precision in ((2, "f32"), (3, "f64")):
        _check_directors(_free(given, dimensions, precision))
    check_lanes(motility=given, integrator="reflected", precision="f32")
    check_lanes(motility=given, integrator="euler", precision="f64", noise=None)


def _free(motility: dict[str, Any], dimensions: int = 2, precision: str = "f64") -> Scene:
    """Swimmers without noise where nothing is."""
    release = {"kind": "point", "position": [0.0] * dimensions}
    return Scene.from_mapping(
        {
            "swimmers": {"count": 100, "dipole_strength": 0.5, "release": release, "motility": motility},
            "obstacles": {"layout": "none"},
            "domain": {"dimensions": dimensions},
            "run": {
                "time_step": 0.05, "duration": 0.05 * _STEPS, "seed": 5, "device": "cpu", "threads": 1,
                "integrator": "euler", "precision": precision,
            },
        }
    )  # fmt: skip


def _check_directors(scene: Scene) -> None:
    """Within some ten roundings a step: each of three components is made of a few."""
    simulation = Simulation(scene)
    simulation.advance(_STEPS)
    now = simulation.engine.snapshot()
    name, where = type(scene.swimmers.motility).__name__, f"{scene.domain.dimensions} dimensions, {scene.precision}"
    off = np.abs(np.linalg.norm(now.director.astype(float), axis=1) - 1.0).max()
    # directors may come from the generator's circle, which is of single precision in either
    assert off <= 10 * _STEPS * 1.2e-7, f"{name}: in {where} the length of a director is {off:g} from 1"
