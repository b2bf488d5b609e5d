"""What `check` says of a scene, against what was measured."""

from __future__ import annotations

import re

import pytest

from porous_swim.inspection import describe
from porous_swim.scene import Scene

SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0, "days": 86400.0}


def expected_seconds(
    *, noise: str, aspect_ratio: float = 1.0, radius: float = 3.5, precision: str = "auto", integrator: str = "auto"
) -> float:
    """The expected time of 1e9 steps of a swimmer near one colloid."""
    scene = Scene.from_mapping(
        {
            "swimmers": {"count": 100, "dipole_strength": 0.8, "aspect_ratio": aspect_ratio,
                         "release": {"kind": "point", "position": [9.0, 0.0, 0.0]}},
            "noise": {"kind": "brownian", "translational_diffusion": 0.01} if noise == "brownian" else {"kind": "none"},
            "obstacles": {"layout": "single", "radius": radius},
            "run": {"time_step": 0.001, "duration": 10_000, "precision": precision, "integrator": integrator},
        }
    )  # fmt: skip
    text = dict(describe(scene))["expected time"]
    found = re.match(r"about (\S+) (\w+) on one CPU core", text)
    assert found, text
    return float(found[1]) * SECONDS[found[2]]


# ns for a swimmer-step on one x86-64 core at several loads: the least and the largest of what was measured
EULER = dict(noise="brownian", integrator="euler")
MEASURED = [
    (EULER, (16.5, 31.0)),
    (EULER | dict(aspect_ratio=0.4), (40.0, 64.0)),
    (EULER | dict(aspect_ratio=0.05), (120.0, 310.0)),
    (EULER | dict(aspect_ratio=0.4, radius=0.9), (120.0, 310.0)),  # rods at small colloids are needles
    (EULER | dict(precision="f64"), (30.7, 30.7)),
    (EULER | dict(aspect_ratio=0.4, precision="f64"), (96.7, 96.7)),
    (dict(noise="brownian"), (31.6, 36.5)),
    (dict(noise="brownian", aspect_ratio=0.4), (65.6, 65.6)),
    (dict(noise="brownian", aspect_ratio=0.05), (240.9, 240.9)),
    (dict(noise="brownian", precision="f64"), (58.6, 58.6)),
    (dict(noise="none"), (852.0, 865.0)),
    (dict(noise="none", aspect_ratio=0.4), (4629.0, 4649.0)),
    (dict(noise="none", aspect_ratio=0.05), (14_860.0, 15_145.0)),
]


@pytest.mark.parametrize(("scene", "nanoseconds"), MEASURED)
def test_the_expected_time_is_within_a_factor_of_two_of_what_was_measured(scene, nanoseconds):
    least, largest = nanoseconds
    assert largest / 2.0 <= expected_seconds(**scene) <= 2.0 * least  # of 1e9 steps: ns in s
