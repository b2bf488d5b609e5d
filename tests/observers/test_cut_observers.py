"""An observer that takes over from another one leaves what that one would have left."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from test_observers import INFO
from test_recording import N_FRAMES, PERIOD, TIME_STEP, column, recording

from porous_swim.core.errors import RunError
from porous_swim.observers.base import Every, Observer
from porous_swim.observers.timeseries import TimeSeries
from porous_swim.observers.trajectory import Trajectory
from tests.support.frames import cubic_lattice, hexagonal_crystal, walk

FIELDS = {"plane": hexagonal_crystal(), "space": cubic_lattice(cells=2)}
FRAMES = {
    name: list(walk(field, n_swimmers=30, n_frames=N_FRAMES, period=PERIOD, time_step=TIME_STEP, seed=2))
    for name, field in FIELDS.items()
}
CUTS = (1, 23, N_FRAMES - 1)


def seen(observer: Observer, frames: list) -> Observer:
    for frame in frames:
        observer.observe(frame)
    return observer


def handed_over(first: Observer, second: Observer, path: Path) -> Observer:
    """The second, with the memory of the first as a file brings it."""
    np.savez(path, **first.state())
    with np.load(path, allow_pickle=False) as stored:
        second.restore(dict(stored))
    return second


@pytest.mark.parametrize("cut", CUTS)
@pytest.mark.parametrize("kind", ["series", "trajectory"])
def test_tables_in_memory(kind, cut, tmp_path):
    def made() -> TimeSeries | Trajectory:
        return TimeSeries(Every(PERIOD)) if kind == "series" else Trajectory(Every(PERIOD), swimmers=np.arange(9))

    frames = FRAMES["plane"]
    whole = seen(made(), frames).table(INFO)
    first = seen(made(), frames[:cut])
    second = handed_over(first, made(), tmp_path / "state.npz")
    assert seen(second, frames[cut:]).table(INFO).equals(whole, check_metadata=True)
    assert seen(first, frames[cut:]).table(INFO).equals(whole)


def test_a_time_series_of_one_swimmer_keeps_what_is_unknown(tmp_path):
    frames = list(walk(hexagonal_crystal(), n_swimmers=1, n_frames=4))
    second = handed_over(seen(TimeSeries(Every(50)), frames[:2]), TimeSeries(Every(50)), tmp_path / "state.npz")
    assert seen(second, frames[2:]).table(INFO)["msd_standard_error"].to_pylist() == [None] * 4


@pytest.mark.parametrize("cut", CUTS)
def test_a_trajectory_on_disk_goes_on_behind_the_rows_of_its_state(cut, tmp_path, monkeypatch):
    monkeypatch.setattr("porous_swim.observers.trajectory._GROUP_ROWS", 70)  # several to a run
    frames, path = FRAMES["plane"], tmp_path / "trajectory.parquet"
    whole = seen(Trajectory(Every(PERIOD), swimmers=np.arange(9)), frames).table(INFO)
    first = seen(Trajectory(Every(PERIOD), swimmers=np.arange(9), path=path), frames[:cut])
    np.savez(tmp_path / "state.npz", **first.state())
    seen(first, frames[cut:]).keep()  # killed then: what it wrote behind the state counts no more
    second = Trajectory(Every(PERIOD), swimmers=np.arange(9), path=path)
    with np.load(tmp_path / "state.npz", allow_pickle=False) as stored:
        second.restore(dict(stored))
    seen(second, frames[cut:]).finish(interrupted=False)
    assert second.table(INFO).equals(whole)
    assert not path.with_name("trajectory.parquet.rows.part").exists()


def test_a_trajectory_whose_rows_are_gone_says_so(tmp_path):
    first = seen(Trajectory(Every(PERIOD), swimmers=np.arange(9), path=tmp_path / "one"), FRAMES["plane"][:5])
    with pytest.raises(RunError, match=r"other\.rows\.part: expected 45 rows of the trajectory, found 0"):
        Trajectory(Every(PERIOD), swimmers=np.arange(9), path=tmp_path / "other").restore(first.state())


@pytest.mark.parametrize("cut", CUTS)
@pytest.mark.parametrize("name", FIELDS)
def test_a_recording_goes_on_in_another_file_with_all_that_was_counted_before(name, cut, tmp_path):
    paths = {part: tmp_path / f"{part}.rrd" for part in ("whole", "first", "second")}
    field, frames = FIELDS[name], FRAMES[name]
    seen(recording(paths["whole"], field), frames).finish(interrupted=False)
    first = seen(recording(paths["first"], field), frames[:cut])
    second = handed_over(first, recording(paths["second"], field), tmp_path / "state.npz")
    seen(second, frames[cut:]).finish(interrupted=False)
    first.finish(interrupted=True)
    pictures = [(f"/histograms/{name}", "BarChart:values") for name in ("residence", "survival", "winding", "hop_time")]
    for entity, component in (*pictures, ("/world/hops", "hops"), ("/world/hops", "LineStrips3D:strips")):
        whole, later = (column(paths[part], entity, component) for part in ("whole", "second"))
        assert len(whole) > 5
        assert 0 < len(later) <= len(whole)
        assert later == whole[-len(later) :]
    for entity, component in (
        ("/world/swimmers", "Points3D:positions"), ("/world/tracked/trails", "LineStrips3D:strips"),
        ("/followed/height", "Scalars:scalars"), ("/series/msd", "Scalars:scalars"),
        ("/states/swimmer_000007", "StateChange:state"),
    ):  # fmt: skip
        whole, *parts = (column(paths[part], entity, component) for part in paths)
        assert len(whole) > 1
        assert [*parts[0], *parts[1]] == whole
    visited = [
        column(paths[part], "/world/followed/colloids", "Ellipsoids3D:centers", static=True)[-1:]
        for part in ("whole", "second")
    ]
    assert visited[0] == visited[1]
    assert bool(visited[0]) == (name == "space")
