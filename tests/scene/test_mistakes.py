"""Scenes with mistakes: all are named at once, each where it stands, in sentences that command no terminal."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import pytest

import porous_swim as ps
from porous_swim.commands.check import describe
from porous_swim.core.console import printable
from porous_swim.core.errors import SceneError
from porous_swim.running.simulation import Start
from porous_swim.scene.scene import Scene, load_scene
from tests.support import fuzz

N_SCENES = 300  # 24 000 by `python -m tests.support.fuzz 24000`
BASE: dict[str, Any] = {
    "swimmers": {"count": 10, "dipole_strength": 0.8, "release": {"kind": "point", "position": [0, 0, 0]}},
    "noise": {"kind": "brownian", "translational_diffusion": 1e-6, "rotational_diffusion": 1e-6},
    "obstacles": {"layout": "none"},
    "run": {"time_step": 0.001, "duration": 100.0},
}


def lines(path: Path, text: str) -> list[str]:
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    return str(caught.value).replace(f"{path}:", "").split("\n")


def test_mutated_scenes_end_in_errors_of_ours(tmp_path: Path) -> None:
    trials = [fuzz.trial(tmp_path, number) for number in range(N_SCENES)]
    assert [wrong for _, wrong in trials if wrong] == []
    assert sum(outcome == "" for outcome, _ in trials) > N_SCENES // 10  # some of them can be run


NINE = """\
naem: x
swimmers: {count: ten, dipole_strength: 0.8, aspect_ratio: 2}
obstacles: {layout: hexagonal, radius: 3.5, spacing: 6, cells: [4, 3]}
domain: {dimensions: 2}
noise: {kind: brown}
encounter: {escape_height: 0.5}
run: {time_step: 0.001, duration: 2.0004, seed: -1}
record: {every: 1, every: 2}
"""


def test_a_scene_with_nine_mistakes_lists_nine(tmp_path: Path) -> None:
    found = lines(tmp_path / "s.yaml", NINE)
    assert [line.split(": ", 2)[:2] for line in found] == [
        ["1:1", "naem"], ["2:19", "swimmers.count"], ["2:60", "swimmers.aspect_ratio"], ["3:54", "obstacles.spacing"],
        ["5:15", "noise.kind"], ["6:28", "encounter.escape_height"], ["7:35", "run.duration"], ["7:49", "run.seed"],
        ["8:20", "record.every"],
    ]  # fmt: skip


def test_at_most_ten_are_listed_and_the_others_counted(tmp_path: Path) -> None:
    found = lines(tmp_path / "s.yaml", NINE + "".join(f"key{i}: 1\n" for i in range(30)))
    assert len(found) == 11
    assert found[-1] == "and 29 more mistakes"


def test_files_that_are_not_there_are_listed_with_the_rest(tmp_path: Path) -> None:
    text = "swimmers: {count: 0, dipole_strength: 1}\nobstacles: {layout: file, path: no.csv}\n"
    text += "domain: {size: [9, 9, 9]}\nrun: {time_step: 0.1, duration: 1}\n"
    first, second = lines(tmp_path / "s.yaml", text)
    assert first == "1:19: swimmers.count: expected more than 0, found 0"
    assert second.startswith("2:33: obstacles.path: there is no file")


def test_wrong_units_are_no_fault_of_the_strings_that_need_them(tmp_path: Path) -> None:
    text = "units: {length: 1 furlong, speed: 0 um/s}\nswimmers: {count: 1, dipole: 1 pN um}\n"
    text += "obstacles: {layout: single, radius: 10 um}\nrun: {time_step: 0.1 s, duration: -1}\n"
    found = lines(tmp_path / "s.yaml", text)
    assert [line.split(": ")[1] for line in found] == ["units.length", "units.speed", "run.duration"]


def test_no_control_character_of_a_file_comes_through(tmp_path: Path) -> None:
    key, value = '"\\e[31mRED\\e]0;pwn\\a": 1\n', 'swimmers: "\\e[1m\\0\\x9b\\u202e"\n'
    message = "\n".join(lines(tmp_path / "s.yaml", key + value))
    assert "\\x1b[31mRED\\x1b]0;pwn\\x07: unknown key" in message
    assert all(letter == "\n" or letter.isprintable() for letter in message)
    scene = Scene.from_mapping(BASE | {"description": "\x1b[31mred\x1b[0m \x07 \x00"})
    assert printable(scene.description) == "\\x1b[31mred\\x1b[0m \\x07 \\x00"
    assert str(ps.ResultsError("runs/\x1b[2J\udc80")) == "runs/\\x1b[2J\\udc80"


def test_printable_text_stays_as_it_is() -> None:
    text = "Größe 5 µm, x² ≤ 3\n\tnext"
    assert printable(text) == text
    assert printable(printable("\x1b")) == printable("\x1b") == "\\x1b"


def test_a_file_too_large_for_a_scene_is_refused_at_once(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_bytes(b"a: [1, 2, 3]\n" * 4_000_000)  # 52 MB
    begin = time.process_time()
    with pytest.raises(SceneError, match="too large for a scene: expected at most 1 MB"):
        load_scene(path)
    assert time.process_time() - begin < 1.0  # to read it would take minutes


def test_a_unit_of_many_letters_is_refused_at_once() -> None:
    obstacles = {"layout": "single", "radius": "1 " + "k" * 100_000}
    units = {"length": "1 um", "speed": "5 um/s"}
    begin = time.process_time()
    with pytest.raises(SceneError, match=r"obstacles.radius: expected a length .* found 100,002 letters"):
        Scene.from_mapping(BASE | {"obstacles": obstacles, "units": units})
    assert time.process_time() - begin < 5.0  # pint takes 40 s


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"run.flight_step": 10_000.0, "run.duration": 1e7},
         "run.flight_step: expected at most 1048.58, 1,048,576 steps of 0.001, found 10000"),
        ({"run.flight_step": 0.005, "run.device": "vulkan"},
         "run.flight_step: expected at most 0.004, 4 steps of 0.001"),
        ({"record.every": 101.0}, r"record.every: expected at most run.duration \(100\), found 101"),
        ({"run.time_step": 1e-10}, "run.time_step: expected at least 1e-09, found 1e-10"),
        ({"run.time_step": 5e-7}, "run.time_step: expected at least 7.1e-07 in f32, in which shorter steps turn"),
        ({"noise": {"kind": "none"}, "run.precision": "f32", "run.time_step": 1e-6},
         "run.time_step: expected at least 1.2e-05 in f32, .* or set run.precision: f64"),
        ({"noise.translational_diffusion": 1e30}, r"expected at most 1e\+06, found 1e\+30"),
        ({"obstacles": {"layout": "single", "radius": 1e300}}, r"obstacles.radius: expected at most 1e\+06"),
        ({"swimmers.release.position": [1e200, 0, 0]}, r"swimmers.release.position\[0\]: expected at most 1e\+09"),
        ({"units": {"length": "1e-300 um", "speed": "5 um/s"}}, "units.length: expected 0.001 to 1e.06 um"),
        ({"encounter.escape_pitch": 2.0}, "encounter.escape_pitch: expected less than 1.571, found 2.0"),
    ],
)  # fmt: skip
def test_what_no_run_can_do_is_refused_when_the_scene_is_read(changes: dict[str, Any], sentence: str) -> None:
    with pytest.raises(SceneError, match=sentence):
        Scene.from_mapping(BASE).replace(changes)


def test_the_same_step_is_long_enough_where_the_noise_is_stronger_or_the_precision_double() -> None:
    # 10 spacings of single precision, 1.19e-6, are sqrt(2 D_r dt) at dt = 7.1e-7 and D_r = 1e-6
    scene = Scene.from_mapping(BASE)
    for changes in ({"noise.rotational_diffusion": 1e-5}, {"run.precision": "f64"}, {"run.time_step": 1e-6}):
        assert scene.replace({"run.time_step": 5e-7} | changes).n_steps > 0


@pytest.mark.parametrize(
    ("obstacles", "domain", "encounter", "sentence"),
    [
        ({"layout": "single", "radius": 3.0}, [1e6, 10.0], {},
         "domain.size: the box is 1e.06 long and 10 wide: expected at"),
        ({"layout": "random", "radius": 3.0, "count": 9}, [60.0, 60.0], {"escape_height": 1e4},
         r"encounter.escape_height: expected at most 100 times the shortest edge of the box \(60\), found 10000"),
        ({"layout": "random", "radius": 1.0, "count": 9000}, [600.0, 600.0], {"escape_height": 300.0},
         "encounter.escape_height: 300 reaches about .* of 9,000 colloids at once"),
    ],
)  # fmt: skip
def test_boxes_and_heights_beyond_any_index_are_refused_with_the_true_reason(
    obstacles, domain, encounter, sentence
) -> None:
    scene = BASE | {"obstacles": obstacles, "encounter": encounter}
    scene |= {
        "domain": {"dimensions": 2, "boundary": "periodic", "size": domain},
        "swimmers": {"count": 1, "dipole_strength": 1},
    }
    begin = time.process_time()
    with pytest.raises(SceneError, match=sentence):
        Scene.from_mapping(scene).place_obstacles()
    assert time.process_time() - begin < 5.0


def test_check_refuses_what_a_run_refuses_for_want_of_a_device() -> None:
    scene = Scene.from_mapping(BASE | {"run": BASE["run"] | {"device": "metal"}})
    for attempt in (describe, Start.of):
        with pytest.raises(ps.DeviceError, match="no metal device was found"):
            attempt(scene)


def test_values_given_from_outside_mend_mistakes_of_the_file(tmp_path: Path) -> None:
    path = tmp_path / "s.yaml"
    path.write_text(
        "swimmers: {count: -3, dipole_strength: !!float xx, release: {kind: point, position: [0, 0, 6]}}\n"
        "obstacles: {layout: single, radius: 5}\n"
        "run: {time_step: 0.01, duration: 1}\n"
    )
    with pytest.raises(SceneError) as caught:
        load_scene(path, {"swimmers.count": 10})
    assert str(caught.value) == f"{path}:1:40: swimmers.dipole_strength: 'xx' cannot be read as float"
    with pytest.raises(SceneError) as caught:
        load_scene(path, {"swimmers.count": -4, "swimmers.dipole_strength": 0.3})
    assert str(caught.value) == "swimmers.count: expected more than 0, found -4"
    scene = load_scene(path, {"swimmers.count": 10, "swimmers.dipole_strength": 0.3})
    assert (scene.swimmers.count, scene.swimmers.dipole_strength) == (10, 0.3)
