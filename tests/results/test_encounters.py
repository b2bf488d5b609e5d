"""Encounters that do not fit into memory: the log on disk, the table in parts, and statistics of parts."""

from __future__ import annotations

import errno
import math
from functools import partial
from itertools import pairwise
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import porous_swim as ps
from porous_swim.analysis import summarize
from porous_swim.core.errors import ResultsError, RunError
from porous_swim.engine import engine as engine_module
from porous_swim.engine.kernel.device_log import LogInt, LogLong
from porous_swim.engine.spill import Spill, row_type
from porous_swim.results import encounter_table as encounters_module
from porous_swim.results.encounter_table import ENCOUNTERS, ROWS, Encounters
from porous_swim.results.tables import TIMESERIES_SCHEMA, TableInfo, make_table, write_table
from tests.support import synthetic

N_SWIMMERS = 300


def log_rows(n: int, *, seed: int, real: type = np.float32) -> np.ndarray:
    """Rows of swimmers in any order; START tells them apart."""
    rng = np.random.default_rng(seed)
    rows = np.zeros(n, row_type(2, real))
    rows["int"][:, LogInt.SWIMMER] = rng.integers(0, N_SWIMMERS, n)
    rows["long"][:, LogLong.START] = 1_000_000 * seed + np.arange(n)
    rows["real"] = rng.standard_normal(rows["real"].shape)
    return rows


@pytest.mark.parametrize("on_disk", [False, True])
def test_a_store_returns_every_row_once_and_all_rows_of_a_swimmer_together(tmp_path, on_disk: bool) -> None:
    path = tmp_path / ROWS if on_disk else None
    store = Spill(N_SWIMMERS, path, piece=500, at_once=400)
    added = [log_rows(n, seed=seed) for seed, n in enumerate((130, 0, 900, 501, 77, 499), start=1)]
    for rows in added:
        store.add(rows)
    more = log_rows(40, seed=9, real=np.float64)
    assert on_disk == (path is not None and path.stat().st_size >= 1000 * added[0].itemsize)
    parts = [np.concatenate([rows.astype(more.dtype) for rows in part]) for part in store.parts(more)]
    assert len(parts) > 3
    ranges = [(part["int"][:, 0].min(), part["int"][:, 0].max()) for part in parts]
    assert all(before[1] < after[0] for before, after in pairwise(ranges))
    assert max(len(part) for part in parts) <= 400
    found, expected = np.concatenate(parts), np.concatenate([rows.astype(more.dtype) for rows in (*added, more)])
    key = ("long", LogLong.START)
    found, expected = (rows[np.argsort(rows[key[0]][:, key[1]])] for rows in (found, expected))
    assert np.array_equal(found, expected)
    store.close()
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("on_disk", [False, True])
def test_a_store_that_takes_over_from_another_one_returns_the_rows_of_both(tmp_path, on_disk: bool) -> None:
    path = tmp_path / ROWS if on_disk else None
    before, after = (
        [log_rows(n, seed=seed + 10 * part) for seed, n in enumerate((130, 900, 501, 77))] for part in (1, 2)
    )
    first = Spill(N_SWIMMERS, path, piece=500, at_once=400)
    assert first.state() == {}
    for rows in before:
        first.add(rows)
    state = first.state()
    assert (len(state["bytes"]) > 1, len(state["real"]) < 500) == (on_disk, on_disk)
    for rows in after[:3]:
        first.add(rows)  # lost with it
    second = Spill(N_SWIMMERS, path, piece=500, at_once=400)
    second.add(after[0])  # of the beginning, which the state replaces
    second.restore(state)
    for rows in after:
        second.add(rows)
    found = np.concatenate([rows for part in second.parts(after[0][:0]) for rows in part])
    expected = np.concatenate([*before, *after])
    found, expected = (rows[np.argsort(rows["long"][:, LogLong.START])] for rows in (found, expected))
    assert np.array_equal(found, expected)
    if on_disk:
        with pytest.raises(RunError, match=r"other: expected [0-9,]+ bytes of encounters on disk, found 0"):
            Spill(N_SWIMMERS, tmp_path / "other").restore(state)


def test_a_full_disk_is_named(tmp_path, monkeypatch) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    store = Spill(N_SWIMMERS, tmp_path / ROWS, piece=10)
    monkeypatch.setattr(Path, "open", full)
    with pytest.raises(RunError, match=r"encounters\.rows: the encounters cannot be written: No space left"):
        store.add(log_rows(20, seed=1))


@pytest.fixture
def on_disk(tmp_path, monkeypatch) -> Encounters:
    """A table in a file whose row groups cut swimmers apart, too large to be read whole."""
    info = synthetic.info(n_swimmers=60, last_time=100.0, dimensions=2, box=(20.0, 20.0, 0.0))
    rng = np.random.default_rng(4)
    swimmer = np.sort(rng.integers(0, 60, 500))
    start = np.sort(rng.uniform(0.0, 99.0, 500))
    end = np.minimum(start + rng.exponential(2.0, 500), 100.0)
    start, end = start[np.argsort(swimmer, kind="stable")], end[np.argsort(swimmer, kind="stable")]
    table = synthetic.encounters(
        info, swimmer=swimmer, colloid=rng.integers(0, 3, 500), start_time=start, end_time=end,
        end_censored=end == 100.0, contact_time=0.5 * (end - start), winding=rng.exponential(1.0, 500),
        escape_pitch_time=np.where(rng.random(500) < 0.5, start + 0.1, np.nan),
    )  # fmt: skip
    pq.write_table(table, tmp_path / ENCOUNTERS, row_group_size=37)
    monkeypatch.setattr(encounters_module, "MANY", 100)
    return Encounters.at(tmp_path / ENCOUNTERS)


def test_parts_of_a_file_are_whole_swimmers(on_disk) -> None:
    assert isinstance(on_disk.source, Path)
    parts = list(on_disk.parts("start_time"))
    assert parts[0].column_names == ["swimmer", "start_time"]
    assert len(parts) > 10
    who = [set(part.column("swimmer").to_pylist()) for part in parts]
    assert sum(len(each) for each in who) == len(set().union(*who))
    whole = on_disk.table()
    assert len(whole) == len(on_disk) == 500
    assert pa.concat_tables(parts).equals(whole.select(["swimmer", "start_time"]))


def test_the_summary_of_a_file_is_that_of_its_table(on_disk) -> None:
    info = TableInfo.of(on_disk)
    clock, still = np.arange(3.0), np.zeros((3, 2, 3))
    centers = np.array([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0], [0.0, 10.0, 0.0]])
    series = make_table(TIMESERIES_SCHEMA, {field.name: clock for field in TIMESERIES_SCHEMA}, info=info)
    lags = synthetic.lags(info, clock, still, np.ones((3, 2, 3)))
    others = synthetic.colloids(info, centers), series, lags
    whole, parts = (summarize(encounters, *others, persistence_time=10.0) for encounters in (on_disk.table(), on_disk))
    assert whole == parts
    assert whole["hops"]["rate"]["n"] > 100


def test_a_file_that_is_not_in_order_of_swimmers_is_refused(on_disk) -> None:
    table = on_disk.table()
    write_table(table.take(pa.array(np.arange(len(table))[::-1])), on_disk.source)
    with pytest.raises(ResultsError, match=r"encounters\.parquet: the rows are not in order of swimmers"):
        list(Encounters.at(on_disk.source).parts("start_time"))


def test_one_swimmer_in_three_stands_for_a_run_of_a_third(on_disk) -> None:
    some, whole = on_disk.of_one_in(3), on_disk.table()
    chosen = set(some.column("swimmer").to_pylist())
    assert some.column("swimmer").to_pylist() == [i for i in whole.column("swimmer").to_pylist() if i in chosen]
    assert len(chosen) <= TableInfo.of(some).n_swimmers
    assert TableInfo.of(some).n_swimmers == pytest.approx(20, abs=4.0 * math.sqrt(60 * 2 / 9))  # binomial, 4 sigma
    assert on_disk.of_one_in(3).equals(some)


def test_a_run_with_its_log_on_disk_leaves_what_one_in_memory_leaves(tmp_path, monkeypatch) -> None:
    scene = ps.load_scene("scenes/crystal.yaml").replace({"swimmers.count": 400, "run.duration": 60.0})
    kept = ps.run(scene)
    monkeypatch.setattr("porous_swim.engine.encounter_log.Spill", partial(Spill, piece=100, at_once=64))
    monkeypatch.setattr(engine_module, "LOG_ROWS", 64)
    monkeypatch.setattr(encounters_module, "MANY", 100)
    writes: list[int] = []
    write = Spill._write
    monkeypatch.setattr(Spill, "_write", lambda store, rows: (writes.append(len(rows)), write(store, rows))[1])
    spilled = ps.run(scene, out=tmp_path / "run", recording=False)
    assert isinstance(spilled.stored.source, Path)
    assert len(writes) > 3
    assert pq.ParquetFile(tmp_path / "run" / ENCOUNTERS).num_row_groups > 5
    names = kept.encounters.column_names
    assert all(spilled.encounters.column(name).equals(kept.encounters.column(name)) for name in names)
    loaded = ps.load_results(tmp_path / "run")
    assert loaded.encounters.equals(spilled.encounters)
    assert {key: value for key, value in loaded.summary.items() if key not in ("provenance", "files")} == {
        key: value for key, value in kept.summary.items() if key != "provenance"
    }
    assert not (tmp_path / "run" / ROWS).exists()


def test_a_log_that_was_cut_short_is_no_shorter_table(tmp_path) -> None:
    store = Spill(N_SWIMMERS, tmp_path / ROWS, piece=100, at_once=50)
    store.add(log_rows(300, seed=1))
    with (tmp_path / ROWS).open("r+b") as file:
        file.truncate(100 * log_rows(1, seed=1).itemsize)
    with pytest.raises(RunError, match="cannot be read: the file was cut short"):
        list(store.parts(log_rows(0, seed=2)))


@pytest.mark.parametrize("always", [False, True])
def test_a_disk_that_is_full_for_the_log_leaves_what_was_seen(tmp_path, monkeypatch, always: bool) -> None:
    scene = ps.load_scene("scenes/crystal.yaml").replace({"swimmers.count": 400, "run.duration": 60.0})
    kept = ps.run(scene)
    monkeypatch.setattr("porous_swim.engine.encounter_log.Spill", partial(Spill, piece=100, at_once=64))
    monkeypatch.setattr(engine_module, "LOG_ROWS", 64)
    begun: list[int] = []
    write, written = Spill._write, Encounters.written

    def full(store: Spill, rows: np.ndarray) -> tuple[int, np.dtype]:
        begun.append(len(rows))
        if len(begun) < 2:
            return write(store, rows)
        raise RunError(f"{store._path}: the encounters cannot be written: no space")

    def no_room(parts: object, path: Path | None) -> Encounters:
        if next(tmp_path.rglob(ROWS), None) is not None:
            raise OSError(errno.ENOSPC, "No space left on device")
        return written(parts, path)

    monkeypatch.setattr(Spill, "_write", full)
    if always:
        monkeypatch.setattr(Encounters, "written", no_room)
    with pytest.raises(RunError, match="cannot be written: no space"):
        ps.run(scene, out=tmp_path / "run", recording=False)
    found = ps.load_results(tmp_path / "run")
    assert found.summary["status"] == "failed"
    assert len(found.timeseries) > 10
    assert not list((tmp_path / "run").glob("*.part"))
    assert not (tmp_path / "run" / ROWS).exists()
    if always:
        assert len(found.encounters) == 0
        assert "encounters.parquet could not be written and is missing" in found.summary["warnings"][1]
        assert list(found.summary["missing"]) == ["trajectory.parquet", "encounters.parquet"]
        return
    last = found.info.last_time
    ended = kept.encounters.filter(
        pa.array((kept.encounters["end_time"].to_numpy() <= last) & ~kept.encounters["end_censored"].to_numpy())
    )
    same = [name for name in ended.column_names if name != "escape_pitch_time"]  # which may come after the end
    assert len(ended) > 100
    assert all(found.encounters.column(name).equals(ended.column(name)) for name in same)
