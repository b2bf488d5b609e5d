"""What `check` says of a scene, against what was measured."""

from __future__ import annotations

import re

import pytest

from porous_swim import costs
from porous_swim.engine.backend import Backend
from porous_swim.inspection import describe
from porous_swim.scene import Scene, load_scene
from porous_swim.simulation import _device_line

SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0, "days": 86400.0}


def expected_seconds(
    *, noise: str, aspect_ratio: float = 1.0, radius: float = 3.5, precision: str = "auto", integrator: str = "auto"
) -> float:
    """The expected time of 1e9 steps of a swimmer near one colloid, on one thread."""
    scene = Scene.from_mapping(
        {
            "swimmers": {"count": 100, "dipole_strength": 0.8, "aspect_ratio": aspect_ratio,
                         "release": {"kind": "point", "position": [9.0, 0.0, 0.0]}},
            "noise": {"kind": "brownian", "translational_diffusion": 0.01} if noise == "brownian" else {"kind": "none"},
            "obstacles": {"layout": "single", "radius": radius},
            "run": {"time_step": 0.001, "duration": 10_000, "precision": precision, "integrator": integrator,
                    "threads": 1},
        }
    )  # fmt: skip
    text = dict(describe(scene))["expected time"]
    found = re.match(r"about \S+ \w+ on 1 thread of an idle CPU \(swimming (\S+) (\w+), recording", text)
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
def test_the_expected_time_of_swimming_is_within_a_factor_of_two_of_what_was_measured(scene, nanoseconds):
    least, largest = nanoseconds
    assert largest / 2.0 <= expected_seconds(**scene) <= 2.0 * least  # of 1e9 steps: ns in s


# s on one thread of a machine with two, both at work: swimming; recording, tables and summary
RUNS = {"crystal": (4.4, 1.8), "takagi": (5.3, 1.3), "lattice_3d": (4.3, 1.9), "packing": (4.7, 2.5)}


@pytest.mark.parametrize("name", RUNS)
def test_the_parts_of_the_expected_time_are_those_of_runs_of_the_scenes(name):
    scene = load_scene(f"scenes/{name}.yaml").replace({"run.threads": 1})
    found = costs.expected_seconds(scene, scene.place_obstacles())
    for expected, measured in zip((found.swimming, found.recording), RUNS[name], strict=True):
        assert measured / 2.0 <= expected <= 2.0 * measured
    assert found.total > sum(RUNS[name]) / 2.0


def test_check_and_run_say_alike_how_long_compiling_takes():
    scene = load_scene("scenes/crystal.yaml")
    assert "10 s more to compile at the first time" in dict(describe(scene))["expected time"]
    assert "some 10 s at the first time" in _device_line(scene, Backend("cpu", None))


def seconds(count: int, threads: int | None, **more) -> costs.Seconds:
    scene = load_scene("scenes/crystal.yaml").replace({"swimmers.count": count, "run.threads": threads, **more})
    return costs.expected_seconds(scene, scene.place_obstacles())


def test_threads_share_blocks_of_eight_swimmers():
    one = seconds(8, 1)
    assert (one.n_threads, one.swimming) == (1, seconds(1, 4).swimming)
    assert seconds(16, 4).n_threads == 2
    assert seconds(16, 4).swimming == one.swimming
    assert seconds(800, 4).swimming == pytest.approx(25.0 * one.swimming)


def test_without_a_word_on_threads_all_are_expected_to_work(monkeypatch):
    monkeypatch.setattr("os.cpu_count", lambda: 6)
    assert seconds(2000, None).n_threads == 6


def test_frames_cost_time_even_where_swimming_costs_none():
    few, many = seconds(100, 1, **{"record.every": 4.0}), seconds(100, 1, **{"record.every": 0.04})
    assert many.recording == pytest.approx(100.0 * few.recording, rel=0.02)
    assert many.swimming == few.swimming
