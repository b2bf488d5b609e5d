"""Schedules, tables, progress and histograms: what observers make of frames."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest

from porous_swim.core.errors import RunError
from porous_swim.observers.base import CONTACT, FREE, Every
from porous_swim.observers.progress import NoProgress, ProgressBar, ProgressLines, make_progress
from porous_swim.observers.rerun.histogram import MAX_BINS, GrowingHistogram
from porous_swim.observers.timeseries import TimeSeries
from porous_swim.observers.trajectory import Trajectory
from porous_swim.results.tables import TIMESERIES_SCHEMA, TRAJECTORY_SCHEMA, TableInfo
from tests.support.frames import hexagonal_crystal, walk

INFO = TableInfo(
    n_swimmers=30,
    dimensions=2,
    box=(120.0, 121.2, 0.0),
    first_time=0.0,
    last_time=9.5,
    time_step=0.01,
    units=None,
    provenance={"seed": 1},
)
FRAMES = list(walk(hexagonal_crystal(), n_swimmers=30, n_frames=20))


def test_a_schedule_names_the_next_multiple_of_its_period_and_never_the_same_step():
    assert [Every(5).next_step(step) for step in (0, 4, 5, 9)] == [5, 5, 10, 10]


def test_a_trajectory_holds_the_frames_of_its_swimmers_bit_for_bit():
    swimmers = np.array([3, 17, 4])
    trajectory = Trajectory(Every(50), swimmers=swimmers)
    for frame in FRAMES:
        trajectory.observe(frame)
    trajectory.finish(interrupted=False)
    table = trajectory.table(INFO)
    assert table.schema.equals(TRAJECTORY_SCHEMA)
    assert TableInfo.of(table) == INFO
    position = np.column_stack([table[name] for name in "xyz"]).reshape(len(FRAMES), 3, 3)
    assert np.array_equal(position, [frame.position[swimmers] for frame in FRAMES])
    director = np.column_stack([table[name] for name in ("ex", "ey", "ez")]).reshape(len(FRAMES), 3, 3)
    assert np.array_equal(director, [frame.director[swimmers] for frame in FRAMES])
    image = np.column_stack([table[f"image_{name}"] for name in "xyz"]).reshape(len(FRAMES), 3, 3)
    assert np.array_equal(image, [frame.image[swimmers] for frame in FRAMES])
    for name in ("state", "colloid"):
        assert np.array_equal(table[name], np.concatenate([getattr(frame, name)[swimmers] for frame in FRAMES]))
    assert table["swimmer"].to_pylist() == [3, 17, 4] * len(FRAMES)
    assert np.array_equal(table["time"], np.repeat([frame.time for frame in FRAMES], 3))


def test_a_trajectory_on_disk_is_the_one_in_memory_and_is_named_when_complete(tmp_path: Path, monkeypatch):
    monkeypatch.setattr("porous_swim.observers.trajectory._GROUP_ROWS", 70)  # several row groups
    path = tmp_path / "trajectory.parquet"
    on_disk = Trajectory(Every(50), swimmers=np.arange(30), path=path)
    in_memory = Trajectory(Every(50), swimmers=np.arange(30))
    for trajectory in (on_disk, in_memory):
        for frame in FRAMES:
            trajectory.observe(frame)
        trajectory.finish(interrupted=True)
    assert not path.exists()
    assert on_disk.table(INFO).equals(in_memory.table(INFO))
    stored = pq.read_table(path)
    assert stored.equals(in_memory.table(INFO))
    assert TableInfo.of(stored) == INFO
    assert pq.ParquetFile(path).num_row_groups > 1
    assert [file.name for file in tmp_path.iterdir()] == [path.name]


def test_a_trajectory_keeps_its_rows_when_the_arrays_of_a_frame_change_later():
    trajectory = Trajectory(Every(50), swimmers=np.arange(30))
    frame = next(walk(hexagonal_crystal(), n_swimmers=30, n_frames=1))
    expected = frame.position[:, 0].copy()
    trajectory.observe(frame)
    frame.position[:] = 0.0
    assert np.array_equal(trajectory.table(INFO)["x"], expected)


def test_a_trajectory_in_a_missing_folder_is_one_sentence(tmp_path: Path):
    with pytest.raises(RunError, match=r"trajectory\.parquet: the trajectory cannot be written"):
        Trajectory(Every(1), swimmers=np.arange(3), path=tmp_path / "none" / "trajectory.parquet")


def test_a_time_series_counts_states_and_displacements_from_the_first_frame():
    series = TimeSeries(Every(50))
    for frame in FRAMES:
        series.observe(frame)
    series.finish(interrupted=False)
    table = series.table(INFO)
    assert table.schema.equals(TIMESERIES_SCHEMA)
    last, row = FRAMES[-1], table.to_pylist()[-1]
    squared = ((last.position - FRAMES[0].position) ** 2).sum(axis=1)
    assert table["msd"][0].as_py() == 0.0
    # sums of 30 numbers in another order: a few roundings
    assert row["msd"] == pytest.approx(squared.mean(), rel=1e-14)
    assert row["msd_standard_error"] == pytest.approx(squared.std(ddof=1) / np.sqrt(30), rel=1e-14)
    assert row["fraction_bound"] == np.mean(last.state != FREE)
    assert row["fraction_contact"] == np.mean(last.state == CONTACT)
    assert row["n_hops"] == last.counts.n_hops > 0


def test_the_error_of_one_swimmers_displacement_is_unknown():
    series = TimeSeries(Every(50))
    for frame in walk(hexagonal_crystal(), n_swimmers=1, n_frames=2):
        series.observe(frame)
    assert series.table(INFO)["msd_standard_error"].to_pylist() == [None, None]


def test_a_growing_histogram_is_the_histogram_of_all_its_values():
    values = np.random.default_rng(1).exponential(20.0, (50, 40))
    histogram = GrowingHistogram(resolution=0.01, discrete=False)
    for part in values:
        histogram.add(part)
    assert len(histogram.counts) <= MAX_BINS
    assert np.array_equal(histogram.counts, np.histogram(values, histogram.edges)[0])
    assert histogram.counts.sum() == values.size


def test_a_growing_histogram_takes_negative_values_in_any_order():
    histogram = GrowingHistogram(resolution=2.0**-10, discrete=False)
    values = np.array([0.3, -0.2, 5.0, -7.25, 0.0])
    for value in values:
        histogram.add(np.array([value]))
    assert np.array_equal(histogram.counts, np.histogram(values, histogram.edges)[0])
    assert 0.0 in histogram.edges


def test_bins_show_no_comb_for_times_that_are_whole_steps():
    step = 0.001
    histogram = GrowingHistogram(resolution=step, discrete=True)
    histogram.add(np.arange(4096) * step)  # uniform: each bin must hold as many
    assert len(set(histogram.counts.tolist())) == 1
    assert histogram.counts.sum() == 4096


class Terminal(io.StringIO):
    """A stream that says it is a terminal."""

    def isatty(self) -> bool:
        """Whether rich may draw here."""
        return True


def test_progress_is_nothing_when_quiet_lines_in_a_log_and_a_bar_on_a_terminal():
    kinds = [
        type(make_progress(Every(50), n_steps=950, n_swimmers=30, quiet=quiet, stream=stream))
        for quiet, stream in ((True, Terminal()), (False, io.StringIO()))
    ]
    assert kinds == [NoProgress, ProgressLines]
    stream = Terminal()
    bar = make_progress(Every(50), n_steps=950, n_swimmers=30, quiet=False, stream=stream)
    assert isinstance(bar, ProgressBar)
    bar.start(step=0)
    for frame in FRAMES:
        bar.observe(frame)
    bar.finish(interrupted=False)
    assert "% bound" in stream.getvalue()


@pytest.fixture
def log(monkeypatch):
    """The progress of a log, what it has written, and its clock, which the test moves."""
    now, stream = [100.0], io.StringIO()
    monkeypatch.setattr("porous_swim.observers.progress.time.monotonic", lambda: now[0])
    return make_progress(Every(50), n_steps=950, n_swimmers=30, quiet=False, stream=stream), stream, now


def test_a_log_of_a_short_run_is_one_line_with_rate_and_fraction_bound(log):
    progress, stream, now = log
    now[0] = 160.0  # compiling: not part of the rate
    progress.start(step=0)
    for frame in FRAMES:
        now[0] += 1.0
        progress.observe(frame)
    progress.finish(interrupted=True)
    progress.finish(interrupted=True)
    (line,) = stream.getvalue().splitlines()
    assert f"{950 * 30 / 20:.2e} swimmer-steps/s" in line
    assert "% bound" in line
    assert "interrupted" in line


def test_a_log_of_a_long_run_has_a_line_in_thirty_seconds_with_the_time_left(log):
    progress, stream, now = log
    progress.start(step=0)
    for frame in FRAMES[1:]:
        now[0] += 10.0  # 190 s in all
        progress.observe(frame)
    lines = stream.getvalue().splitlines()
    assert len(lines) == 6
    assert lines[0].endswith("2 min 40 s left")  # 3 of 19 frames took 30 s


def test_a_log_tells_of_a_table_that_takes_long_and_counts_it_in_no_rate(log):
    progress, stream, now = log
    progress.start(step=0)
    now[0] += 20.0
    progress.observe(FRAMES[-1])
    progress.end(interrupted=False)
    for share in (0.2, 0.4, 0.6, 0.8, 1.0):
        now[0] += 20.0
        progress.tabulate(share)
    progress.finish(interrupted=False)
    swum, *written = stream.getvalue().splitlines()
    assert f"{950 * 30 / 20:.2e} swimmer-steps/s" in swum
    assert written == [" 40.0 % of the encounters are in their table", " 80.0 % of the encounters are in their table"]


def test_a_bar_begins_anew_for_the_tables():
    stream = Terminal()
    bar = make_progress(Every(50), n_steps=950, n_swimmers=30, quiet=False, stream=stream)
    bar.start(step=0)
    bar.observe(FRAMES[-1])
    bar.end(interrupted=False)
    bar.tabulate(0.5)
    bar.finish(interrupted=False)
    assert "writing encounters" in stream.getvalue()


def test_progress_of_a_scene_with_units_tells_seconds_too():
    stream = io.StringIO()
    last = FRAMES[-1]  # at t = 9.5 a/U
    lines = make_progress(Every(50), n_steps=950, n_swimmers=30, quiet=False, stream=stream, seconds=0.2)
    lines.observe(last)
    lines.end(interrupted=False)
    assert "t = 9.5 a/U (1.9 s), " in stream.getvalue()
