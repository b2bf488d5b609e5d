"""From a scene to its results, without a command line."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from rerun.chunk import RrdReader

import porous_swim as ps
from porous_swim.engine import backend
from tests.support.commands import SMALL, small_scene

NOBODY = {"record.swimmers": 0, "record.trails": 0}
TABLES = ("encounters", "colloids", "timeseries", "trajectory")


@pytest.fixture
def scene(tmp_path: Path) -> ps.Scene:
    return ps.load_scene(small_scene(tmp_path))


def columns_of(table) -> dict[str, list]:
    """The values alone: the metadata tells the threads."""
    return table.to_pydict()


def test_without_a_folder_nothing_is_written(scene, tmp_path, monkeypatch):
    empty = tmp_path / "empty"
    empty.mkdir()
    monkeypatch.chdir(empty)
    results = ps.run(scene)
    assert list(empty.iterdir()) == []
    assert results.folder is None
    assert results.timeseries.num_rows == 11  # time 0 and every 0.1 up to 1
    assert results.trajectory.num_rows == 11 * 20


def test_loaded_results_are_those_that_the_run_returned(scene, tmp_path):
    returned = ps.run(scene, out=tmp_path / "run")
    loaded = ps.load_results(tmp_path / "run")
    for name in TABLES:
        assert getattr(loaded, name).equals(getattr(returned, name), check_metadata=True)
    assert loaded.summary == returned.summary
    assert loaded.info == returned.info
    assert loaded.folder == returned.folder == tmp_path / "run"


def test_a_folder_changes_no_result(scene, tmp_path):
    kept, written = ps.run(scene), ps.run(scene, out=tmp_path / "run", recording=False)
    for name in TABLES:
        assert columns_of(getattr(kept, name)) == columns_of(getattr(written, name))


@pytest.mark.parametrize("changes", [{"run.threads": 2}, {"record.every": 0.03}, NOBODY])
def test_threads_and_looking_change_no_encounter(changes, scene):
    base = {"run.duration": 0.99, "record.every": 0.33, "run.threads": 1}
    one, other = (ps.run(scene.replace(each)) for each in (base, base | changes))
    assert one.encounters.num_rows > 0
    assert columns_of(one.encounters) == columns_of(other.encounters)
    if "run.threads" in changes:
        assert all(columns_of(getattr(one, name)) == columns_of(getattr(other, name)) for name in TABLES)
        assert other.summary["provenance"]["threads"] == 2


def test_another_seed_is_another_run(scene):
    one, other = (ps.run(scene.replace({"run.seed": seed})) for seed in (1, 2))
    assert columns_of(one.trajectory) != columns_of(other.trajectory)


@pytest.mark.parametrize(("every", "frames"), [(0.001, 6), (0.002, 4), (0.005, 2)])
def test_frames_are_at_the_start_at_every_interval_and_at_the_end(every, frames, scene):
    results = ps.run(scene.replace({"run.duration": 0.005, "record.every": every}))
    times = results.timeseries["time"].to_numpy()
    expected = np.unique(np.append(np.arange(0.0, 0.005 - 1e-9, every), 0.005))
    assert len(expected) == frames
    np.testing.assert_allclose(times, expected, rtol=1e-12)  # times are steps times 0.001, in double
    assert len(set(results.trajectory["time"].to_pylist())) == frames


def test_a_scene_as_saved_is_the_same_run(scene, tmp_path):
    first = ps.run(scene, out=tmp_path / "first", recording=False)
    again = ps.run(ps.load_scene(tmp_path / "first/scene.yaml"))
    assert columns_of(again.trajectory) == columns_of(first.trajectory)
    assert again.summary["provenance"]["scene_id"] == first.summary["provenance"]["scene_id"]


def test_units_are_told_in_summary_and_tables(tmp_path):
    units = "units: {length: 2.0 um, speed: 4.0 um/s, viscosity: 0.89 mPa s, temperature: 300 K}\n"
    results = ps.run(ps.load_scene(small_scene(tmp_path, units + SMALL)), out=tmp_path / "run", recording=False)
    told = {"length_um": 2.0, "time_s": 0.5}  # a, and a/U = 2 um / (4 um/s)
    assert results.summary["units"] == results.info.units == told
    assert ps.load_results(tmp_path / "run").info.units == told


def test_without_units_none_are_told(scene):
    results = ps.run(scene)
    assert results.summary["units"] is results.info.units is None


def test_a_folder_in_use_is_an_error_before_anything_is_computed(scene, tmp_path):
    (tmp_path / "run").mkdir()
    (tmp_path / "run/notes.txt").write_text("mine")
    with pytest.raises(ps.ResultsError, match="not empty"):
        ps.run(scene, out=tmp_path / "run")
    assert [path.name for path in (tmp_path / "run").iterdir()] == ["notes.txt"]


def test_auto_is_the_best_device_there_is(scene):
    best = next(name for name in ("cuda", "metal", "cpu") if backend.available(name))
    assert ps.run(scene.replace({"run.duration": 0.01, "record.every": 0.01})).summary["provenance"]["device"] == best


def test_a_run_in_a_thread_leaves_signals_alone(scene):
    from concurrent.futures import ThreadPoolExecutor

    with ThreadPoolExecutor(1) as pool:
        assert pool.submit(ps.run, scene).result().summary["status"] == "finished"


def test_steps_by_hand_are_those_of_a_run(scene):
    simulation = ps.Simulation(scene)
    for n_steps in (1, 299, 700):
        simulation.advance(n_steps)
    frame, results = simulation.frame(), ps.run(scene)
    last = results.trajectory.slice(results.trajectory.num_rows - 20)
    assert (frame.step, frame.time) == (1000, 1.0)
    np.testing.assert_array_equal(frame.position[:20, 0], last["x"].to_numpy())
    np.testing.assert_array_equal(frame.state[:20], last["state"].to_numpy())


@pytest.mark.skipif(not hasattr(os, "fork"), reason="reads the symbols of a POSIX process")
def test_the_next_signal_after_a_run_is_handled_as_before(scene):
    import signal

    before = signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)
    ps.run(scene)
    assert (signal.getsignal(signal.SIGINT), signal.getsignal(signal.SIGTERM)) == before


def test_a_swimmer_that_fails_is_named_and_what_was_seen_is_kept(scene, tmp_path, monkeypatch):
    advance = ps.Simulation.advance

    def spoil_at_500(simulation: ps.Simulation, n_steps: int) -> None:
        if simulation.step == 500:
            real = simulation.engine._swimmers.real.to_numpy()
            real[:, 7] = np.nan
            simulation.engine._swimmers.real.from_numpy(real)
        advance(simulation, n_steps)

    whole = ps.run(scene)
    monkeypatch.setattr(ps.Simulation, "advance", spoil_at_500)
    with pytest.raises(ps.RunError, match=r"swimmer 7 stopped at step 500 \(time 0.5\) near \("):
        ps.run(scene, out=tmp_path / "run")
    kept = ps.load_results(tmp_path / "run")
    assert kept.summary["status"] == "failed"
    assert "swimmer 7" in kept.summary["warnings"][0]
    assert kept.info.last_time == 0.5
    assert columns_of(kept.timeseries) == columns_of(whole.timeseries.slice(0, 6))
    assert columns_of(kept.trajectory) == columns_of(whole.trajectory.slice(0, 6 * 20))
    ended = whole.encounters.filter(whole.encounters["end_time"].to_numpy() <= 0.5)
    assert columns_of(kept.encounters.select(["swimmer", "end_time"])) == columns_of(
        ended.select(["swimmer", "end_time"])
    )
    RrdReader(tmp_path / "run/recording.rrd").store()


@pytest.mark.parametrize("seconds", [0.0, 1e9])
def test_a_run_that_is_killed_leaves_on_disk_what_was_recorded_until_a_minute_before(
    seconds, scene, tmp_path, monkeypatch
):
    monkeypatch.setattr("porous_swim.running.observation.KEEP_SECONDS", seconds)
    advance, there = ps.Simulation.advance, tmp_path / "run"
    whole = ps.run(scene)

    def copy_at_500(simulation: ps.Simulation, n_steps: int) -> None:
        if simulation.step == 500:
            shutil.copytree(there, tmp_path / "killed")
        advance(simulation, n_steps)

    monkeypatch.setattr(ps.Simulation, "advance", copy_at_500)
    results = ps.run(scene, out=there)
    assert columns_of(results.trajectory) == columns_of(whole.trajectory)
    n_frames = 6 if seconds == 0.0 else 0  # times 0 to 0.5
    rows = tmp_path / "killed/trajectory.parquet.rows.part"
    kept = [] if rows.stat().st_size == 0 else list(pa.ipc.open_stream(rows.read_bytes()))
    assert sum(len(batch) for batch in kept) == 20 * n_frames
    if kept:
        assert columns_of(pa.Table.from_batches(kept)) == columns_of(whole.trajectory.slice(0, 20 * n_frames))
    for entity in ("/world/swimmers", "/series/msd"):
        chunks = RrdReader(tmp_path / "killed/recording.rrd.part").stream().filter(content=entity)
        assert sum(chunk.num_rows for chunk in chunks if not chunk.is_static) == n_frames
