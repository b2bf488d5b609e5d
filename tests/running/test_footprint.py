"""The memory that a run takes, said and refused from counts alone."""

from __future__ import annotations

import subprocess
import sys
import time
from pathlib import Path

import pytest

import porous_swim as ps
from porous_swim.commands.check import describe
from porous_swim.core.errors import SceneError
from porous_swim.core.machine import Memory
from porous_swim.running import footprint as module
from porous_swim.running.footprint import footprint, require_memory
from porous_swim.scene.scene import Scene, load_scene
from tests.support.commands import ROOT, SCENES, environment, porous_swim, small_scene

TOO_MUCH = [
    ("crystal", {"swimmers.count": 10**9}, "swimmers.count: a run with 1,000,000,000 swimmers takes about 1."),
    ("crystal", {"obstacles.cells": [10_000, 5_000]}, "obstacles: a run with 100,000,000 colloids takes about "),
    ("packing", {"obstacles.count": 10**8}, "obstacles: a run with 100,000,000 colloids takes about "),
]


@pytest.mark.parametrize(("name", "changes", "message"), TOO_MUCH)
def test_what_cannot_fit_is_refused_at_once_with_numbers_and_the_key(monkeypatch, name, changes, message):
    monkeypatch.setattr(module, "available_memory", lambda: Memory(16e9, "free on this machine"))
    scene = load_scene(f"scenes/{name}.yaml").replace(changes)
    for call in (lambda: describe(scene), lambda: ps.run(scene)):
        begin = time.process_time()
        with pytest.raises(SceneError) as caught:
            call()
        assert time.process_time() - begin < 1.0
        assert str(caught.value).startswith(message)
        assert "of memory, and 16 GB are free on this machine: expected at most some " in str(caught.value)


def test_the_count_that_is_named_fits(monkeypatch):
    monkeypatch.setattr(module, "available_memory", lambda: Memory(16e9, "left to its control group"))
    scene = load_scene("scenes/crystal.yaml")
    with pytest.raises(SceneError, match="left to its control group: expected at most some ") as caught:
        require_memory(scene.replace({"swimmers.count": 10**9}))
    count = int(str(caught.value).rsplit(" ", 1)[1].replace(",", ""))
    require_memory(scene.replace({"swimmers.count": count}))
    with pytest.raises(SceneError):
        require_memory(scene.replace({"swimmers.count": int(1.2 * count)}))


def test_memory_may_be_forced(monkeypatch, tmp_path):
    monkeypatch.setattr(module, "available_memory", lambda: Memory(1e6, "free on this machine"))
    scene = load_scene(small_scene(tmp_path))
    with pytest.raises(SceneError, match="1 MB are free on this machine"):
        ps.run(scene)
    assert ps.run(scene, force_memory=True).summary["status"] == "finished"


def test_the_command_refuses_with_the_status_of_what_can_be_mended(tmp_path):
    for command in ("check", "run"):
        done = porous_swim(command, small_scene(tmp_path), "--set", "swimmers.count=2147483647", cwd=tmp_path)
        assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
        assert done.stderr.startswith("swimmers.count: a run with 2,147,483,647 swimmers takes about ")
    assert not (tmp_path / "runs").exists()


@pytest.mark.parametrize("path", SCENES, ids=lambda path: path.stem)
def test_colloids_are_counted_before_they_are_placed(path: Path):
    scene = load_scene(path)
    n = len(scene.place_obstacles().radii)
    assert n <= scene.n_colloids <= n + 1  # the first line of a file names the columns


def test_a_random_layout_in_a_box_counts_as_it_is_placed():
    scene = Scene.from_mapping(
        {
            "swimmers": {"count": 1, "dipole_strength": 0.0},
            "obstacles": {"layout": "random", "radius": [1.0, 2.0], "fractions": [3, 1], "packing_fraction": 0.2},
            "domain": {"dimensions": 2, "size": [80, 70]},
            "run": {"time_step": 0.01, "duration": 1},
        }
    )
    assert len(scene.place_obstacles().radii) == scene.n_colloids


# VmHWM and not ru_maxrss, which a child inherits: it would tell the peak of this process, if that is greater.
PROGRAM = """
import sys
import porous_swim as ps
scene = ps.load_scene(sys.argv[1]).replace({
    "swimmers.count": int(sys.argv[2]), "run.duration": 0.1, "record.every": 0.01, "run.time_step": 0.01,
    "run.device": "cpu",
})
from porous_swim.running.footprint import footprint
ps.run(scene)
peak = next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM:"))
print(footprint(scene).host, 1024 * int(peak))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="kB are those of Linux")
@pytest.mark.parametrize("name", ["crystal", "lattice_3d"])
def test_the_memory_said_is_the_peak_within_a_fifth(name):
    for n in ("300", "300000"):  # a kernel that is not in the cache takes some 200 MB to compile: the first run's
        command = [sys.executable, "-c", PROGRAM, str(ROOT / f"scenes/{name}.yaml"), n]
        done = subprocess.run(command, env=environment(), capture_output=True, text=True, timeout=300, check=True)
    said, peak = map(float, done.stdout.split()[-2:])
    assert said == pytest.approx(peak, rel=0.2)


def test_more_swimmers_and_frames_take_more():
    scene = load_scene("scenes/crystal.yaml")
    few, many = footprint(scene), footprint(scene.replace({"swimmers.count": 20_000}))
    assert many.swimmers == pytest.approx(2.0 * few.swimmers)
    rows = (footprint(scene.replace({"record.every": every})).disk - few.disk for every in (0.5, 0.25))
    once, thrice = rows  # 400 frames more, and 1200
    assert thrice == pytest.approx(3.0 * once)
