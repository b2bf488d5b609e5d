"""A run of which one file cannot be written: the others are those of a run on an empty disk."""

from __future__ import annotations

import errno
from pathlib import Path

import pytest

import porous_swim as ps
from porous_swim.core.errors import ResultsError, RunError
from porous_swim.observers.rerun.stream import RecordingFile
from porous_swim.observers.trajectory import Trajectory
from porous_swim.results.encounter_table import ENCOUNTERS, Encounters
from porous_swim.results.manifest import RUN_FILES
from porous_swim.results.tables import SCHEMAS, writer_of
from tests.support.commands import small_scene

FULL = OSError(errno.ENOSPC, "No space left on device")


@pytest.fixture(scope="module")
def scene(tmp_path_factory) -> ps.Scene:
    return ps.load_scene(small_scene(tmp_path_factory.mktemp("scene")))


@pytest.fixture(scope="module")
def whole(scene) -> ps.Results:
    return ps.run(scene)


def raises(*_: object, **__: object) -> None:
    raise FULL


def check(folder: Path, whole: ps.Results, *, missing: set[str]) -> ps.Results:
    """The results of a folder that lacks some files: all others are there and right, and nothing else lies about."""
    found = ps.load_results(folder, verify=True)
    assert found.summary["status"] == "failed"
    assert set(found.summary["missing"]) == missing
    assert {path.name for path in folder.iterdir()} == set(RUN_FILES) - missing
    for name in SCHEMAS:
        lost = f"{name}.parquet" in missing
        table = getattr(found, name)
        assert table.to_pydict() == (table.schema.empty_table() if lost else getattr(whole, name)).to_pydict()
    for name in missing:
        assert any(name in warning for warning in found.summary["warnings"])
    return found


@pytest.mark.parametrize("name", ["timeseries.parquet", "lags.parquet", "trajectory.parquet", "recording.rrd"])
def test_a_file_that_fails_at_the_end_takes_no_other_with_it(name, scene, whole, tmp_path, monkeypatch):
    def full_for_one(path: Path, *others: object, **more: object) -> object:
        return raises() if path.name == f"{name}.part" else writer_of(path, *others, **more)

    monkeypatch.setattr("porous_swim.results.tables.writer_of", full_for_one)
    monkeypatch.setattr("porous_swim.observers.trajectory.writer_of", full_for_one)
    if name == "recording.rrd":
        monkeypatch.setattr(RecordingFile, "close", raises)
    with pytest.raises(RunError, match=rf"No space left on device.*; the rest of the run is kept, without {name}"):
        ps.run(scene, out=tmp_path / "run")
    found = check(tmp_path / "run", whole, missing={name})
    statistics = set(found.summary) - {"status", "provenance", "warnings", "files", "missing"}
    assert {key: found.summary[key] for key in statistics} == {key: whole.summary[key] for key in statistics}


@pytest.mark.parametrize(("observer", "name"), [(Trajectory, "trajectory.parquet"), (RecordingFile, "recording.rrd")])
def test_a_file_that_fails_on_the_way_does_not_end_the_run(observer, name, scene, whole, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("porous_swim.running.observation.KEEP_SECONDS", 0.0)
    method = "_write" if observer is Trajectory else "flush"
    works, calls = getattr(observer, method), []

    def full_at_the_third(self: object) -> None:
        calls.append(self)
        if len(calls) > 2:
            raise RunError("the disk is full")
        works(self)

    monkeypatch.setattr(observer, method, full_at_the_third)
    with pytest.raises(RunError, match=f"the disk is full; the rest of the run is kept, without {name}"):
        ps.run(scene, out=tmp_path / "run", progress=True)
    check(tmp_path / "run", whole, missing={name})
    assert f"the disk is full; the run goes on without {name}\n" in capsys.readouterr().err
    assert len(calls) == 3


def test_recording_and_trajectory_make_room_for_the_encounters(scene, whole, tmp_path, monkeypatch):
    written = Encounters.written
    spare = [tmp_path / "run/recording.rrd.part", tmp_path / "run/trajectory.parquet.rows.part"]

    def full_while_they_are_there(parts: object, path: Path | None) -> Encounters:
        return raises() if any(each.exists() for each in spare) else written(parts, path)

    monkeypatch.setattr(Encounters, "written", full_while_they_are_there)
    with pytest.raises(RunError, match=r"recording\.rrd: given up for encounters\.parquet: the disk is full"):
        ps.run(scene, out=tmp_path / "run")
    check(tmp_path / "run", whole, missing={"recording.rrd", "trajectory.parquet"})


def test_encounters_for_which_there_is_no_room_at_all_are_said_to_be_missing(scene, whole, tmp_path, monkeypatch):
    monkeypatch.setattr(Encounters, "written", raises)
    monkeypatch.setattr("porous_swim.running.outputs.Outputs._may_fit", lambda _: False)
    with pytest.raises(RunError, match=rf"without {ENCOUNTERS}"):
        ps.run(scene, out=tmp_path / "run")
    found = check(tmp_path / "run", whole, missing={ENCOUNTERS})
    assert any("mean nothing" in warning for warning in found.summary["warnings"])
    ps.report(found, tmp_path / "report")


def test_without_its_colloids_a_folder_says_why_it_cannot_be_read(scene, tmp_path, monkeypatch):
    def full_for_colloids(path: Path, *others: object, **more: object) -> object:
        return raises() if "colloids" in path.name else writer_of(path, *others, **more)

    monkeypatch.setattr("porous_swim.results.tables.writer_of", full_for_colloids)
    with pytest.raises(RunError):
        ps.run(scene, out=tmp_path / "run")
    with pytest.raises(ResultsError, match=r"could not write its colloids \(.*No space left on device"):
        ps.load_results(tmp_path / "run")


def test_statistics_that_fail_cost_no_table_and_are_not_hidden(scene, whole, tmp_path, monkeypatch):
    def wrong(*_: object, **__: object) -> None:
        raise ZeroDivisionError("a mistake of ours")

    monkeypatch.setattr("porous_swim.running.outcome.summarize", wrong)
    with pytest.raises(ZeroDivisionError, match="a mistake of ours"):
        ps.run(scene, out=tmp_path / "run")
    found = ps.load_results(tmp_path / "run", verify=True)
    assert found.summary["missing"] == {"statistics": "a mistake of ours"}
    assert all(getattr(found, name).equals(getattr(whole, name)) for name in SCHEMAS)
    ps.report(found, tmp_path / "report")


def test_a_mistake_on_the_way_leaves_what_was_seen_before(scene, tmp_path, monkeypatch):
    advance = ps.Simulation.advance

    def wrong_at_500(simulation: ps.Simulation, n_steps: int) -> None:
        if simulation.step == 500:
            raise MemoryError
        advance(simulation, n_steps)

    monkeypatch.setattr(ps.Simulation, "advance", wrong_at_500)
    with pytest.raises(MemoryError):
        ps.run(scene, out=tmp_path / "run")
    found = ps.load_results(tmp_path / "run", verify=True)
    assert (found.summary["status"], found.info.last_time) == ("failed", 0.5)
    assert found.timeseries["time"].to_numpy()[-1] == 0.5
