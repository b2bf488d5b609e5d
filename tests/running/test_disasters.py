"""Runs that are killed, and disks that are full: nothing half-written passes for finished, nothing whole is lost.

A few cases by default; all of them, which takes some minutes: `python -m pytest tests/running/test_disasters.py -m ""`.
"""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

import porous_swim as ps
from porous_swim.core.errors import ResultsError
from porous_swim.results.manifest import RUN_FILES
from porous_swim.results.run_folder import RunFolder
from tests.support.commands import ROOT, porous_swim, small_scene, start

pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals and disks of POSIX")
# in the order in which they appear
APPEARING = (
    "run.lock", "summary.json.part", "scene.yaml", "trajectory.parquet.rows.part", "recording.rrd.part",
    "encounters.parquet.part", "encounters.parquet", "colloids.parquet", "timeseries.parquet", "lags.parquet",
    "trajectory.parquet.part", "trajectory.parquet", "recording.rrd", "summary.json",
)  # fmt: skip
SHORT = {
    ("scene.yaml", signal.SIGTERM), ("recording.rrd.part", signal.SIGKILL), ("encounters.parquet", signal.SIGKILL)
}  # fmt: skip
SIZES = (4, 16, 48, 80, 100, 128, 160, 200, 256, 320, 400, 512, 700, 1000, 1400, 2000, 5000, 20000)  # kB
SECONDS = 240.0  # a run takes 5 on a machine of its own


def all_but(short: bool) -> list[pytest.MarkDecorator]:
    return [] if short else [pytest.mark.slow]


def check_folder(folder: Path) -> str | None:
    """The status of a run folder whose run is over; None where it holds no results, and says so."""
    if not (folder / "summary.json").exists():
        with pytest.raises(ResultsError):
            ps.load_results(folder)
        return None
    results = ps.load_results(folder, verify=True)
    status, missing = results.summary["status"], results.summary.get("missing", {})
    whole = {path.name for path in folder.iterdir()} & set(RUN_FILES) - {"summary.json"}
    assert whole == set(results.summary["files"])
    assert whole.isdisjoint(missing)
    assert {*whole, *missing} >= set(RUN_FILES) - {"summary.json"}
    if status != "failed":
        assert not missing
        assert results.timeseries["time"].to_numpy()[-1] == results.info.last_time
        assert results.trajectory["time"].to_numpy()[-1] == results.info.last_time
    assert not list(folder.glob("*.part"))
    return status


def no_foreign_words(stderr: str) -> None:
    """Rerun logs failures of the disk of its own, with a time in front."""
    own = [line for line in stderr.splitlines() if not re.search(r"\b(ERROR|WARN)\b", line)]
    assert not any("Traceback" in line or "Warning" in line or "panicked" in line for line in own), stderr


@pytest.mark.parametrize(
    ("name", "number"),
    [
        pytest.param(name, number, marks=all_but((name, number) in SHORT), id=f"{name}-{number.name}")
        for name in APPEARING
        for number in (signal.SIGTERM, signal.SIGKILL)
    ],
)
def test_a_run_that_is_killed_as_a_file_appears_is_whole_or_none(name, number, tmp_path):
    folder = tmp_path / "run"
    scene = small_scene(tmp_path)
    child = start("run", scene, "--threads", 1, "--out", folder, "--set", "record.every=0.005", cwd=tmp_path)
    end = time.monotonic() + SECONDS
    while not (folder / name).exists() and child.poll() is None and time.monotonic() < end:
        time.sleep(0.0002)
    child.send_signal(number)
    _, stderr = child.communicate(timeout=SECONDS)
    no_foreign_words(stderr)
    status = check_folder(folder)
    if number == signal.SIGKILL:
        assert child.returncode in (-number, 0)
        assert status in (None, "finished")
    else:  # behind the last step it changes nothing any more
        assert (child.returncode, status) in {(128 + number, "interrupted"), (0, "finished")}, stderr
    RunFolder.at(folder, overwrite=True).close()  # nobody holds it
    assert {path.name for path in folder.iterdir()} == {"run.lock", "summary.json.part"}


@pytest.fixture
def disk(tmp_path) -> Iterator:
    """Make a disk of so many kB, gone after the test."""
    place = tmp_path / "disk"
    place.mkdir()

    def mount(size: int) -> Path:
        command = ["mount", "-t", "tmpfs", "-o", f"size={size}k", "tmpfs", str(place)]
        if sys.platform != "linux" or subprocess.run(command, capture_output=True, check=False).returncode:
            pytest.skip("small disks cannot be mounted here: that needs Linux and root")
        return place

    yield mount
    subprocess.run(["umount", "-l", str(place)], capture_output=True, check=False)


@pytest.mark.parametrize("size", [pytest.param(size, marks=all_but(size in (16, 320))) for size in SIZES])
def test_a_full_disk_keeps_what_has_room_and_names_what_has_none(size, disk, tmp_path):
    folder = disk(size) / "run"
    options = ["--set", "record.every=0.005", "--set", "swimmers.count=200", "--set", "record.swimmers=200"]
    done = porous_swim("run", small_scene(tmp_path), "--threads", 1, "--out", folder, *options, cwd=tmp_path)
    no_foreign_words(done.stderr)
    assert done.returncode in (0, 1, 2), done.stderr
    status = check_folder(folder)
    # what is sure to have room: 64 kB are kept for the summary, and the scene and the lock take a page each
    assert status is not None or size < 80
    assert (done.returncode == 0) == (status == "finished")
    if done.returncode:
        assert str(folder) in done.stderr.splitlines()[-1]


@pytest.mark.slow
def test_a_log_of_encounters_that_fills_the_disk_leaves_all_else(disk, tmp_path):
    folder = disk(150_000) / "run"
    changes = {"swimmers.count": 2000, "run.duration": 10, "record.every": 1, "record.swimmers": 20, "record.trails": 2}
    options = [f"--set={key}={value}" for key, value in changes.items()]
    noise = "--set=noise.translational_diffusion=1000"
    scene = ROOT / "scenes/crystal.yaml"
    done = porous_swim("run", scene, "--threads", 1, "--out", folder, *options, noise, cwd=tmp_path)
    assert done.returncode == 1
    assert check_folder(folder) == "failed"
    assert set(ps.load_results(folder).summary["missing"]) == {"encounters.parquet"}


@pytest.mark.parametrize("stderr", ["full", "closed"])
def test_a_run_that_cannot_tell_how_far_it_is_goes_on_to_its_end(stderr, tmp_path):
    scene = small_scene(tmp_path)
    child = start(
        "run", scene, "--threads", 1, "--out", "run", cwd=tmp_path, stderr=os.open("/dev/full", os.O_WRONLY)
    ) if stderr == "full" else subprocess.Popen(
        ["sh", "-c", 'exec "$@" 2>&-', "sh", sys.executable, "-m", "porous_swim", "run", str(scene), "--out", "run"],
        cwd=tmp_path, stdout=subprocess.PIPE, text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip
    stdout, _ = child.communicate(timeout=SECONDS)
    assert child.returncode == 0
    assert stdout.splitlines()[-1] == "run"
    assert check_folder(tmp_path / "run") == "finished"


def test_two_runs_that_start_at_once_in_one_folder_are_one(tmp_path):
    scene = small_scene(tmp_path)
    runs = [
        start("run", scene, "--threads", 1, "--quiet", "--force", "--out", "run", "--seed", seed, cwd=tmp_path)
        for seed in (1, 2)
    ]
    ends = {seed: (run.communicate(timeout=SECONDS)[1], run.returncode) for seed, run in enumerate(runs, start=1)}
    assert check_folder(tmp_path / "run") == "finished"
    seed = ps.load_results(tmp_path / "run").summary["provenance"]["seed"]
    assert ends[seed][1] == 0
    refused = [said for said, status in ends.values() if status == 2]
    assert all("a run is under way in this folder (process" in said for said in refused)
    assert refused or all(status == 0 for _, status in ends.values())  # one after the other
