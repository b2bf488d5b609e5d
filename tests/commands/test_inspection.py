"""What `check` says of a scene, against what was measured."""

from __future__ import annotations

import re

import pytest

from porous_swim.commands.check import describe
from porous_swim.engine.backend import Backend
from porous_swim.running import costs
from porous_swim.running.run import _device_line
from porous_swim.running.simulation import Simulation
from porous_swim.scene.scene import Scene, load_scene
from tests.support.commands import ROOT

SECONDS = {"s": 1.0, "min": 60.0, "h": 3600.0, "days": 86400.0}


def expected_seconds(
    *, noise: str, aspect_ratio: float = 1.0, radius: float = 3.5, precision: str = "auto", integrator: str = "auto"
) -> float:
    """The expected time of 1e9 steps of a swimmer near one colloid, on one thread."""
    scene = Scene.from_mapping(
        {
            "swimmers": {"count": 128, "dipole_strength": 0.1, "aspect_ratio": aspect_ratio,
                         "release": {"kind": "point", "position": [9.0, 0.0, 0.0]}},
            "noise": {"kind": "brownian", "translational_diffusion": 0.01} if noise == "brownian" else {"kind": "none"},
            "obstacles": {"layout": "single", "radius": radius},
            "run": {"time_step": 0.001, "duration": 7812.5, "precision": precision, "integrator": integrator,
                    "threads": 1},
        }
    )  # fmt: skip
    text = dict(describe(scene))["expected time"]
    found = re.match(r"about \S+ \w+ on 1 thread of an idle CPU \(swimming (\S+) (\w+), recording", text)
    assert found, text
    return float(found[1]) * SECONDS[found[2]]


# ns for a swimmer-step on one x86-64 core, at one colloid and in a crystal, on a machine at rest and busy: the least
# and the largest of what was measured
EULER = dict(noise="brownian", integrator="euler")
MEASURED = [
    (EULER, (7.4, 13.7)),
    (EULER | dict(aspect_ratio=0.4), (11.1, 26.5)),
    (EULER | dict(aspect_ratio=0.05), (25.3, 90.4)),
    (EULER | dict(aspect_ratio=0.4, radius=0.9), (25.2, 90.4)),  # rods at small colloids are needles
    (EULER | dict(precision="f64"), (12.2, 16.0)),
    (EULER | dict(aspect_ratio=0.4, precision="f64"), (23.1, 47.0)),
    (dict(noise="brownian"), (9.7, 18.6)),
    (dict(noise="brownian", aspect_ratio=0.4), (18.5, 39.9)),
    (dict(noise="brownian", aspect_ratio=0.05), (47.8, 135.3)),
    (dict(noise="brownian", precision="f64"), (18.6, 29.0)),
    (dict(noise="none"), (842.0, 865.0)),
    (dict(noise="none", aspect_ratio=0.4), (4111.0, 4649.0)),
    (dict(noise="none", aspect_ratio=0.05), (14_860.0, 15_145.0)),
]


@pytest.mark.parametrize(("scene", "nanoseconds"), MEASURED)
def test_the_expected_time_of_swimming_is_within_a_factor_of_two_of_what_was_measured(scene, nanoseconds):
    least, largest = nanoseconds
    assert largest / 2.0 <= expected_seconds(**scene) <= 2.0 * least  # of 1e9 steps: ns in s


# s on one thread: swimming; recording, tables and summary
RUNS = {"crystal": (12.8, 4.6), "takagi": (2.3, 3.0), "lattice_3d": (1.9, 2.1), "packing": (2.1, 2.2)}


@pytest.mark.parametrize("name", RUNS)
def test_the_parts_of_the_expected_time_are_those_of_runs_of_the_scenes(name):
    scene = load_scene(f"scenes/{name}.yaml").replace({"run.threads": 1})
    found = costs.expected_seconds(scene, scene.place_obstacles())
    for expected, measured in zip((found.swimming, found.recording), RUNS[name], strict=True):
        assert measured / 2.0 <= expected <= 2.0 * measured
    assert found.total > sum(RUNS[name]) / 2.0


def test_check_and_run_say_alike_how_long_compiling_takes():
    scene = load_scene("scenes/crystal.yaml")
    assert "10 s more to compile the first time" in dict(describe(scene))["expected time"]
    assert "some 10 s the first time" in _device_line(scene, Backend("cpu", None))


def seconds(count: int, threads: int | None, **more) -> costs.Seconds:
    scene = load_scene("scenes/crystal.yaml").replace({"swimmers.count": count, "run.threads": threads, **more})
    return costs.expected_seconds(scene, scene.place_obstacles())


def test_threads_share_blocks_of_swimmers():
    one = seconds(32, 1)
    assert (one.n_threads, one.swimming) == (1, seconds(1, 4).swimming)
    assert seconds(64, 4).n_threads == 2
    assert seconds(64, 4).swimming == one.swimming
    assert seconds(3200, 4).swimming == pytest.approx(25.0 * one.swimming)


def test_without_a_word_on_threads_all_are_expected_to_work(monkeypatch):
    monkeypatch.setattr("porous_swim.running.costs.usable_processors", lambda: 6)
    assert seconds(2000, None).n_threads == 6


def test_frames_cost_time_even_where_swimming_costs_none():
    few, many = seconds(100, 1, **{"record.every": 4.0}), seconds(100, 1, **{"record.every": 0.04})
    assert many.recording == pytest.approx(100.0 * few.recording, rel=0.02)
    assert many.swimming == few.swimming


@pytest.mark.parametrize("precision", ["f32", "f64"])
@pytest.mark.parametrize("layout", ["hexagonal", "fcc"])
def test_the_memory_said_is_that_of_the_arrays(tmp_path, layout, precision):
    dimensions = {"hexagonal": 2, "fcc": 3}[layout]
    (tmp_path / "scene.yaml").write_text(
        f"swimmers: {{count: 100, dipole_strength: 1.0}}\n"
        f"noise: {{kind: brownian, translational_diffusion: 0.01}}\n"
        f"obstacles: {{layout: {layout}, radius: 3, spacing: 10, cells: {[2] * dimensions}}}\n"
        f"domain: {{dimensions: {dimensions}}}\n"
        f"run: {{time_step: 0.02, duration: 20, precision: {precision}, device: cpu}}\n"
    )
    scene = load_scene(tmp_path / "scene.yaml")
    simulation = Simulation(scene)
    survey = simulation.survey
    lists = [*simulation.engine._swimmers[:3], survey._origin, survey._origin_int]
    held = sum(array.to_numpy().nbytes for array in lists)
    said = dict(describe(scene))["memory"]
    assert f" at the peak, {held / 1e3:.0f} kB of it for the swimmers on the device" in said


def test_a_scene_with_units_says_its_diffusivities_in_them_too():
    # D = kT/(6 pi mu a) = 0.2454 um^2/s and D_r = 3 D/(4 a^2) for a sphere of radius a = 1 um
    noise = dict(describe(load_scene(ROOT / "scenes" / "crystal_thermal.yaml")))["noise"]
    assert noise.endswith("in the laboratory D = 0.2454 µm²/s, D_r = 0.184 s⁻¹")
