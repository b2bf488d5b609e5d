"""Scenes: from YAML to checked numbers, and what is said where they do not hold together."""

from __future__ import annotations

import json
import pickle
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml

from porous_swim.core.errors import SceneError
from porous_swim.engine import backend
from porous_swim.scene import schema
from porous_swim.scene.scene import Scene, load_scene

SCENES = sorted(Path("scenes").glob("*.yaml"))

GOOD = """\
swimmers:
  count: 10
  dipole_strength: 0.8
obstacles: {layout: hexagonal, radius: 3.5, spacing: 10, cells: [4, 3]}
domain: {dimensions: 2}
noise: {kind: brownian, translational_diffusion: 0.006}
run: {time_step: 0.001, duration: 2}
"""


def load(tmp_path: Path, text: str) -> Scene:
    (tmp_path / "s.yaml").write_text(text)
    return load_scene(tmp_path / "s.yaml")


def complaint(tmp_path: Path, text: str) -> str:
    with pytest.raises(SceneError) as caught:
        load(tmp_path, text)
    lines = str(caught.value).split("\n")
    assert all(line.startswith(f"{tmp_path}/s.yaml:") for line in lines)  # one mistake, one line
    return lines[0].removeprefix(f"{tmp_path}/")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("count: 10", "coutn: 10", "2:3: swimmers.coutn: unknown key; did you mean `count`? allowed: "
         "count, dipole_strength, "
         "dipole, aspect_ratio, release"),
        ("swimmers:", "swimers:", "1:1: swimers: unknown key; did you mean `swimmers`?"),
        ("  count: 10\n", "", "1:1: swimmers.count: this key is required and missing (Number of swimmers"),
        ("run: {time_step: 0.001, duration: 2}\n", "", "1:1: run: this key is required and missing"),
        ("count: 10", "count: ten", "2:10: swimmers.count: expected a whole number, found 'ten'"),
        ("count: 10", "count: 2.5", "2:10: swimmers.count: expected a whole number, found 2.5"),
        ("count: 10", "count: 0", "2:10: swimmers.count: expected more than 0, found 0"),
        ("count: 10", "count: true", "2:10: swimmers.count: expected a whole number, found true"),
        ("0.8", "'0.8'", "3:20: swimmers.dipole_strength: expected a number, found '0.8'"),
        ("0.8", ".nan", "3:20: swimmers.dipole_strength: expected a finite number, found .nan"),
        ("0.8", "-.inf", "3:20: swimmers.dipole_strength: expected a finite number, found -.inf"),
        ("0.8", "1e999", "3:20: swimmers.dipole_strength: expected a finite number, found .inf"),
        ("0.8", "", "3:19: swimmers.dipole_strength: expected a number, found nothing"),
        ("0.8", "[0.8]", "3:20: swimmers.dipole_strength: expected a number, found a list"),
        ("hexagonal", "hexgonal", "4:21: obstacles.layout: expected `none`, `single`, `wall`, `square`, "
         "`hexagonal`, `sc`, `bcc`, "
         "`fcc`, `random`, `packing` or `file`, found 'hexgonal'; did you mean `hexagonal`?"),
        ("layout: hexagonal, ", "", "4:1: obstacles.layout: this key is required and missing"),
        ("spacing: 10", "spacing: 10, count: 3", "4:58: obstacles.count: unknown key; allowed with "
         "layout: hexagonal: "),
        ("spacing: 10", "spacing: 6", "4:54: obstacles.spacing: colloids of radius 3.5 overlap by 1"),
        ("[4, 3]", "[4, 3.5]", "4:69: obstacles.cells[1]: expected a whole number, found 3.5"),
        ("[4, 3]", "[4]", "4:65: obstacles.cells: expected at least 2 entries, found 1"),
        ("[4, 3]", "4", "4:65: obstacles.cells: expected a list, found 4"),
        ("{dimensions: 2}", "[2]", "5:9: domain: expected a map of keys, found a list"),
        ("dimensions: 2", "dimensions: 4", "5:22: domain.dimensions: expected `2` or `3`, found 4"),
        ("kind: brownian", "kind: brown", "6:15: noise.kind: expected `none` or `brownian`, found 'brown'"),
        ("0.006", "-1", "6:50: noise.translational_diffusion: expected at least 0, found -1"),
        ("0.006", "1 um^2/s", "6:50: noise.translational_diffusion: expected a number in a U (strings "
         "need a `units` "
         "section), found '1 um^2/s'"),
        ("0.006", "1, rotational_diffusion: from_spere", "6:75: noise.rotational_diffusion: expected a "
         "number, `from_sphere` or "
         "`from_spheroid`, found 'from_spere'; did you mean `from_sphere`?"),
        ("duration: 2", "duration: 2.0004", "7:35: run.duration: 2.0004 is not a whole number of steps of "
         "0.001: the nearest "
         "is 2"),
        ("duration: 2", "duration: 1e-9", "7:35: run.duration: 1e-09 is not a whole number of steps of "
         "0.001: the nearest "
         "is 0.001"),
        ("duration: 2", "duration: 2, seed: -1", "7:44: run.seed: expected at least 0, found -1"),
        ("duration: 2", "duration: 2, seed: 18446744073709551616", "7:44: run.seed: expected less than"),
        ("run:", "encounter: {escape_pitch: leading edge}\nrun:",
        "7:27: encounter.escape_pitch: expected a number, `leading` "
         "or `exact`, found 'leading edge'; did you mean `leading`?"),
        ("run:", "record: {swimmers: 3, trails: 4}\nrun:", "7:31: record.trails: expected at most "
         "record.swimmers (3), found 4"),
        ("run:", "record: {every: 0.0015}\nrun:", "7:17: record.every: 0.0015 is not a whole number of "
         "steps of 0.001: "
         "the nearest is 0.002"),
        ("run:", "name: a/b\nrun:", "7:7: name: expected letters, digits,"),
        ("dipole_strength: 0.8", "dipole: 1 pN um", "3:11: swimmers.dipole: a dipole needs a `units` "
         "section"),
        ("0.8", "0.8\n  dipole: 1 pN um", "4:11: swimmers.dipole: expected one of dipole and "
         "dipole_strength, found both"),
        ("0.8", "0.8\n  release: {kind: file, path: no.csv}",
        "4:31: swimmers.release.path: there is no file"),
        ("0.8", "0.8\n  release: {kind: point, position: [1, 2, 3]}",
        "4:36: swimmers.release.position: expected a z component"),
        ("count: 10", "count: 10\n  count: 11", "3:3: swimmers.count: duplicate key, first given at 2:3"),
    ],
)  # fmt: skip
def test_a_bad_key_is_named_with_its_place(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in GOOD
    found = complaint(tmp_path, GOOD.replace(old, new, 1))
    assert found.startswith(f"s.yaml:{message}"), found


def test_defaults_follow_from_what_is_given(tmp_path: Path) -> None:
    scene = load(tmp_path, GOOD)
    assert scene.name == "s"
    assert scene.domain.periodic
    assert (scene.n_steps, scene.record_period) == (2000, 10)
    assert (scene.n_recorded, scene.n_trails) == (10, 10)
    assert scene.precision == "f32"
    assert scene.rotational_diffusion == 0.75 * 0.006
    assert scene.unit_system is None
    quiet = scene.replace({"noise": {"kind": "none"}})
    assert quiet.precision == "f64"
    assert (quiet.translational_diffusion, quiet.rotational_diffusion) == (0.0, 0.0)


def test_a_name_that_is_no_folder_is_mended_from_the_file(tmp_path: Path) -> None:
    (tmp_path / "my scene (2).yaml").write_text(GOOD)
    assert load_scene(tmp_path / "my scene (2).yaml").name == "my_scene_2_"


def test_bretherton_of_a_rod(tmp_path: Path) -> None:
    assert load(tmp_path, GOOD).replace({"swimmers.aspect_ratio": 0.5}).bretherton == pytest.approx(0.6)


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_a_resolved_scene_is_the_same_scene(path: Path, tmp_path: Path) -> None:
    scene = load_scene(path)
    scene.save(tmp_path)
    again = load_scene(tmp_path / "scene.yaml")
    assert again.scene_id == scene.scene_id
    assert again.to_yaml() == (tmp_path / "scene.yaml").read_text()
    assert again.name == path.stem
    assert yaml.safe_load(scene.to_yaml())["run"]["seed"] == scene.run.seed


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_a_shipped_scene_can_be_placed_and_its_recording_is_small(path: Path) -> None:
    scene = load_scene(path)
    squared = scene.swimmers.aspect_ratio**2
    field = scene.place_obstacles()
    swimmers = scene.place_swimmers(field, lambda s, A: np.sqrt(s * s + squared * (1.0 - s * s)))
    assert swimmers.position.shape == (scene.swimmers.count, 3)
    # 13 bytes per recorded swimmer and frame and 52 per trail; the limit is 50 MB for the largest
    n_bytes = scene.n_steps / scene.record_period * (13 * scene.n_recorded + 52 * scene.n_trails)
    assert n_bytes < 25e6


def test_the_scene_id_is_of_what_decides_the_result(tmp_path: Path) -> None:
    scene = load(tmp_path, GOOD)
    same: list[dict[str, Any]] = [
        {"name": "b"},
        {"description": "b"},
        {"record": {"swimmers": 1}},
        {"run.device": "cpu"},
        {"run.threads": 1},
        {"run.precision": "f32"},
        {"hydrodynamics": {"kind": "image_dipole"}},
    ]
    other: list[dict[str, Any]] = [
        {"run.seed": 1},
        {"run.precision": "f64"},
        {"swimmers.dipole_strength": 0.81},
        {"obstacles.cells": [4, 4]},
    ]
    assert {scene.replace(change).scene_id for change in same} == {scene.scene_id}
    assert len({scene.replace(change).scene_id for change in other} | {scene.scene_id}) == 1 + len(other)
    assert re.fullmatch("[0-9a-f]{16}", scene.scene_id)


def test_the_scene_id_follows_the_content_of_named_files(tmp_path: Path) -> None:
    text = GOOD.replace("hexagonal, radius: 3.5, spacing: 10, cells: [4, 3]", "file, path: b.csv")
    text = text.replace("dimensions: 2", "dimensions: 2, size: [20, 20]")
    (tmp_path / "b.csv").write_text("x,y,radius\n1,1,2\n")
    first = load(tmp_path, text)
    before = first.scene_id
    (tmp_path / "b.csv").write_text("x,y,radius\n1,1,3\n")
    assert first.scene_id != before


def test_replace_puts_whole_values_at_dotted_keys(tmp_path: Path) -> None:
    scene = load(tmp_path, GOOD)
    changed = scene.replace({"swimmers.dipole_strength": np.float64(2.0), "run.seed": np.int64(7)})
    assert (changed.swimmers.dipole_strength, changed.run.seed) == (2.0, 7)
    assert changed.swimmers.count == 10
    assert scene.swimmers.dipole_strength == 0.8
    with pytest.raises(SceneError, match=r"s\.yaml:6:25: noise\.translational_diffusion: unknown key"):
        scene.replace({"noise.kind": "none"})  # the diffusion is still there, in the file
    assert scene.replace({"noise": {"kind": "none"}}).noise.kind == "none"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            {"swimmers.dipole_strenth": 2.0},
            "swimmers.dipole_strenth: unknown key; did you mean `dipole_strength`?",
        ),
        ({"swimmer.count": 2}, "swimmer: unknown key; did you mean `swimmers`?"),
        ({"run.seed": -1}, "run.seed: expected at least 0, found -1"),
        ({"run.duration": 1e300}, "run.duration: expected at most 1e+09, found 1e+300"),
        ({"run.time_step": 1e-300, "run.duration": 1.0}, "run.time_step: expected at least 1e-09, found"),
        ({"obstacles.cells": [10**6, 10**6]}, "obstacles.cells: expected at most 100000000 colloids"),
        ({"name": "x" * 200}, "name: expected at most 100 characters, found"),
        ({"noise": {1: 2}}, "a key must be a word, found 1"),
        ({"run.time_step.x": 1}, "run.time_step.x: run.time_step is not a map of keys"),
        ({"domain": {"dimensions": 3}}, "domain.dimensions: the layout hexagonal needs 2, found 3"),
        (
            {"run.integrator": "reflekted"},
            "run.integrator: expected `auto`, `euler`, `reflected` or `located`, "
            "found 'reflekted'; did you mean `reflected`?",
        ),
        (
            {"noise": {"kind": "none"}, "run.integrator": "reflected"},
            "run.integrator: reflected is for runs with noise: expected located, euler or auto",
        ),
    ],
)
def test_replace_names_the_key_and_no_place_in_the_file(tmp_path: Path, change: dict[str, Any], message: str) -> None:
    with pytest.raises(SceneError) as caught:
        load(tmp_path, GOOD).replace(change)
    assert str(caught.value).removeprefix(f"{tmp_path}/").startswith(message)


def test_replacing_one_way_to_give_the_dipole_takes_the_other_away() -> None:
    thermal = load_scene("scenes/crystal_thermal.yaml")
    assert thermal.replace({"swimmers.dipole_strength": 1.5}).swimmers.dipole_strength == 1.5
    doubled = thermal.replace({"swimmers.dipole": "0.90 pN um"})
    assert doubled.swimmers.dipole_strength == pytest.approx(2.0 * thermal.swimmers.dipole_strength, rel=1e-12)


def test_a_scene_survives_a_worker_process(tmp_path: Path) -> None:
    scene = pickle.loads(pickle.dumps(load(tmp_path, GOOD)))
    assert scene.replace({"run.seed": 3}).run.seed == 3


def test_a_scene_cannot_be_changed(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="frozen"):
        load(tmp_path, GOOD).swimmers.count = 3


def test_warnings_name_what_is_legal_and_seldom_meant(tmp_path: Path) -> None:
    scene = load(tmp_path, GOOD)
    (jump,) = scene.warnings()
    (clamp, _) = scene.replace({"run.integrator": "euler"}).warnings()
    assert "1.3 % long" in clamp
    assert "0.13 U" in jump
    assert scene.replace({"noise": {"kind": "none"}, "hydrodynamics": {"kind": "none"}}).warnings() == []
    large = {"obstacles": {"layout": "single", "radius": 5000.0}, "domain": {"dimensions": 3, "boundary": "open"}}
    point = {"swimmers.release": {"kind": "point", "position": [0, 6000, 0], "director": [1, 0, 0]}}
    assert any("set run.precision: f64" in sentence for sentence in scene.replace(large | point).warnings())
    exact = scene.replace(large | point | {"run.precision": "f64"})
    assert not any("f32" in sentence for sentence in exact.warnings())
    coarse = scene.replace({"run": {"time_step": 1.0, "duration": 2.0}}).warnings()
    assert any("D = 0.006" in sentence for sentence in coarse)
    # the flow at contact changes at a rate of 3 alpha/4 = 0.6; a bias of 1 % by docs/convergence.md
    assert any("residence times may be 7 % short; keep it below 0.15" in sentence for sentence in coarse)
    euler = scene.replace({"run": {"time_step": 1.0, "duration": 2.0, "integrator": "euler"}}).warnings()
    assert any("keep it below 0.05" in sentence for sentence in euler)


def test_colloids_that_do_not_fit_are_named_at_their_place_in_the_file(tmp_path: Path) -> None:
    text = GOOD.replace("hexagonal, radius: 3.5, spacing: 10, cells: [4, 3]", "file, path: b.csv")
    text = text.replace("dimensions: 2", "dimensions: 2, size: [20, 20]")
    (tmp_path / "b.csv").write_text("x,y,radius\n1,1,2\n2,1,2\n")
    with pytest.raises(SceneError, match=r"s\.yaml:4:33: obstacles\.path: colloids 0 and 1 overlap by 3"):
        load(tmp_path, text).place_obstacles()


def test_a_table_of_colloids_that_is_no_text_is_refused_in_plain_words(tmp_path: Path) -> None:
    text = GOOD.replace("hexagonal, radius: 3.5, spacing: 10, cells: [4, 3]", "file, path: b.csv")
    text = text.replace("dimensions: 2", "dimensions: 2, size: [20, 20]")
    (tmp_path / "b.csv").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(SceneError, match=r"obstacles\.path: the file '.*b\.csv' cannot be read: it is not UTF-8 text$"):
        load(tmp_path, text).place_obstacles()


def test_no_other_device_is_guessed_and_threads_have_a_limit() -> None:
    scene = load_scene(SCENES[0])
    with pytest.raises(SceneError, match=r"run\.device: expected .* found 'gpu'$"):
        scene.replace({"run.device": "gpu"})
    with pytest.raises(SceneError, match=r"run\.threads: expected at most 1024, found 100000$"):
        scene.replace({"run.threads": 100000})  # a process may have some 30 000, and then waits for ever


def test_the_committed_schema_and_page_are_those_of_the_models() -> None:
    assert json.loads(schema.SCHEMA_FILE.read_text()) == schema.json_schema()
    assert schema.PAGE_FILE.read_text() == schema.scene_page()


def test_the_page_says_that_auto_takes_no_vulkan_device_and_it_takes_none(monkeypatch: pytest.MonkeyPatch) -> None:
    (row,) = [line for line in schema.scene_page().splitlines() if line.startswith("| `device`")]
    assert "`auto` takes CUDA or Metal where there is one, else the CPU. It never takes Vulkan" in row
    for here, taken in (({"vulkan", "cpu"}, "cpu"), ({"vulkan", "cuda", "cpu"}, "cuda"), ({"metal", "cpu"}, "metal")):
        monkeypatch.setattr(backend, "available", here.__contains__)
        assert backend.choose("auto") == taken


def test_every_key_says_what_it_is() -> None:
    rows = [line for line in schema.scene_page().splitlines() if line.startswith("| `")]
    assert len(rows) > 60
    assert all(row.split("|")[2].strip() for row in rows)


def test_frames_too_far_apart_for_an_orbit_are_warned_of() -> None:
    # at speed 1 around a colloid of radius 3.5, 4.5 from its centre, half a radian takes 2.25 a/U
    crystal = load_scene("scenes/crystal.yaml")
    close, far = (crystal.replace({"record.every": every, "run.duration": 110 * every}) for every in (2.2, 2.3))
    assert not any("record.every" in sentence for sentence in close.warnings())
    (sentence,) = (sentence for sentence in far.warnings() if "record.every" in sentence)
    assert "frames are 2.3 a/U apart, in which a swimmer goes 0.51 rad around a colloid of radius 3.5" in sentence
    assert "keep record.every below 2.2" in sentence
    for unseen in (
        {"record.swimmers": 0, "record.trails": 0},
        {"obstacles": {"layout": "none"}, "domain.size": [9, 9]},
    ):
        assert not any("record.every" in sentence for sentence in far.replace(unseen).warnings())
    wall = load_scene("scenes/wall.yaml").replace({"record.every": 40.0})
    assert not any("orbit" in sentence for sentence in wall.warnings())
