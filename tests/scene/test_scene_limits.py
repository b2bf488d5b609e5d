"""What cannot be computed is refused with key and bound, by `check` and `run` alike; what is just admitted is right."""

from __future__ import annotations

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.commands.check import describe

GOOD = {
    "swimmers": {"count": 50, "dipole_strength": 0.8, "release": {"kind": "parallel", "height": 1.0}},
    "noise": {"kind": "brownian", "translational_diffusion": 0.002},
    "obstacles": {"layout": "single", "radius": 20.0},
    "run": {"time_step": 0.02, "duration": 4.0, "seed": 1, "threads": 1},
    "record": {"every": 0.2, "swimmers": 50},
}
EULER = {"noise": {"kind": "none"}, "run.integrator": "euler"}
# the wall's rates 3 alpha/(4 gamma^3), alpha 10^6; kicks sqrt(2 D dt)
BAD = {
    "a dipole of 10^6": ({"swimmers.dipole_strength": 1e6}, "run.time_step: 0.02 is too long for dipole_strength 1e"),
    "a puller": ({"swimmers.dipole_strength": -1e3}, "with this step a dipole_strength of at most 66.7"),
    "by euler, without noise": ({"swimmers.dipole_strength": 1e3, **EULER}, "expected at most 0.0013"),
    "at a wall": (
        {"swimmers.dipole_strength": 1e3, "obstacles": {"layout": "wall", "normal": [0, 0, 1]}}, "at most 0.0013",
    ),
    "a thin rod": ({"swimmers.aspect_ratio": 0.1}, "expected at most 0.0017"),
    "a radius of 10^5 in f32": ({"obstacles.radius": 1e5}, "at most 1.68e+04 for swimmers of aspect ratio 1"),
    "a rod at a large colloid": ({"obstacles.radius": 5e3, "swimmers.aspect_ratio": 0.25}, "at most 4.19e"),
    "kicks across colloids": (
        {"noise": {"kind": "brownian", "translational_diffusion": 100.0, "rotational_diffusion": 0.1}},
        "moves a swimmer by 2 a in a step, through what stands in between: expected at most 0.005",
    ),
}  # fmt: skip


def scene_of(changes) -> ps.Scene:
    return ps.Scene.from_mapping(GOOD).replace(changes)


@pytest.mark.parametrize("case", BAD)
def test_check_and_run_refuse_it_in_the_same_words(case):
    changes, words = BAD[case]
    scene = scene_of(changes)
    said = []
    for do in (describe, ps.run):
        with pytest.raises(ps.SceneError) as error:
            do(scene)
        said.append(str(error.value))
    assert said[0] == said[1]
    assert words in said[0]


def test_a_located_run_takes_steps_as_short_as_the_flow_asks():
    describe(scene_of({"swimmers.dipole_strength": 1e3, "noise": {"kind": "none"}}))


def test_free_swimmers_may_be_kicked_as_far_as_one_likes():
    free = {"obstacles": {"layout": "none"}, "swimmers.release": {"kind": "point", "position": [0, 0, 0]}}
    noise = {"kind": "brownian", "translational_diffusion": 1e4, "rotational_diffusion": 0.1}
    describe(scene_of({**free, "noise": noise, "swimmers.dipole_strength": 1e6}))


@pytest.mark.parametrize(
    ("changes", "depth"),
    [
        # a quarter of the contact band's share: contact is held to 4 roundings of the radius, 4e-3 at the bound
        ({"obstacles.radius": 1.6e4}, 4e-3),
        ({"obstacles.radius": 3e3, "swimmers.aspect_ratio": 0.2, "swimmers.dipole_strength": 0.02}, 4e-3 * 0.2),
        # the rate of the flow times the step 0.99; offsets of 21 are rounded to 2e-6
        ({"swimmers.dipole_strength": 66.0}, 5e-6),
        ({"swimmers.dipole_strength": 66.0, **EULER, "run.precision": "f64"}, 2e-6),
    ],
)
def test_what_is_just_admitted_keeps_contact(changes, depth):
    scene = scene_of(changes)
    table = ps.run(scene).trajectory
    columns = {name: table[name].to_numpy() for name in table.column_names}
    position, director = (np.stack([columns[p + axis] for axis in "xyz"], axis=1) for p in ("", "e"))
    height, sine = scene.place_obstacles().stance(position, director, columns["colloid"])
    gamma = scene.swimmers.aspect_ratio
    least = ps.contact_height(np.arcsin(np.clip(sine, -1, 1)), radius=scene.obstacles.radius, aspect_ratio=gamma)
    assert (height - least).min() > -depth


def test_a_run_of_one_swimmer_has_no_error_rather_than_one_that_is_no_number():
    results = ps.run(scene_of({"swimmers.count": 1}))
    error = results.timeseries["msd_standard_error"]
    assert error.null_count == len(error) == 21
    assert not np.any(np.isnan(results.timeseries["msd"].to_numpy()))
    assert results.summary["msd"]["final"]["standard_error"] is None
    assert any("no standard errors" in warning for warning in results.summary["warnings"])
    assert ps.run(scene_of({})).timeseries["msd_standard_error"].null_count == 0
