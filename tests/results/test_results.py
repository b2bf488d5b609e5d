"""Tables, their information, and the run folder."""

from __future__ import annotations

import json

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

from porous_swim.core.errors import ResultsError
from porous_swim.results.encounter_table import Encounters
from porous_swim.results.loading import load_results
from porous_swim.results.results import Results
from porous_swim.results.run_folder import RunFolder
from porous_swim.results.tables import ENCOUNTERS_SCHEMA, SCHEMAS, TIMESERIES_SCHEMA, TableInfo, make_table, write_table
from tests.support import synthetic
from tests.support.run_folders import relisted

DIRECTORS = np.full((2, 2, 3), 3.0**-0.5)
ABOUT = synthetic.info(n_swimmers=2, box=(10.0, 20.0, 0.0))


def some_results(**replaced: object) -> Results:
    timeseries = {field.name: np.arange(3) for field in TIMESERIES_SCHEMA}
    timeseries |= {name: np.array([0.0, 0.5, 1.0]) for name in ("fraction_bound", "fraction_contact")}
    tables = {
        "encounters": synthetic.encounters(ABOUT, swimmer=[0, 1], start_time=[0.0, 1.0], end_time=[2.0, 3.0]),
        "colloids": synthetic.colloids(ABOUT, np.eye(3)),
        "timeseries": make_table(TIMESERIES_SCHEMA, timeseries, info=ABOUT),
        "lags": synthetic.lags(ABOUT, np.arange(2.0), np.ones((2, 2, 3)), DIRECTORS),
        "trajectory": synthetic.trajectory(ABOUT, np.arange(2.0), np.ones((2, 2, 3)), DIRECTORS),
    }
    stored = Encounters.in_memory(tables.pop("encounters"))
    others = {"summary": {"status": "finished"}, "folder": None, "info": ABOUT, **replaced}
    return Results(stored, **{**tables, **others})


@pytest.fixture
def folder(tmp_path):
    """A finished run folder."""
    return RunFolder.at(tmp_path / "run").write(some_results()).folder


def test_a_written_run_reads_back_the_same(folder) -> None:
    written, read = some_results(), load_results(folder)
    for name in SCHEMAS:
        table = getattr(read, name)
        assert table.equals(getattr(written, name))
        assert TableInfo.of(table) == ABOUT
    assert (read.summary["status"], read.info, read.folder) == ("finished", ABOUT, folder)
    assert not list(folder.glob("*.part"))


def test_columns_keep_their_units_on_disk(folder) -> None:
    schema = load_results(folder).encounters.schema
    units = {name: (schema.field(name).metadata or {}).get(b"unit") for name in schema.names}
    assert units["start_time"] == b"a/U"
    assert units["winding"] == b"turns"
    assert units["entry_pitch"] == b"rad"
    assert units["entry_x"] == b"a"
    assert units["swimmer"] is units["entry_ex"] is None


def test_nan_is_null_where_a_value_may_be_missing_and_refused_nowhere_else() -> None:
    table = synthetic.encounters(ABOUT, swimmer=[0, 1], escape_pitch_time=[np.nan, 2.5])
    assert table.column("escape_pitch_time").to_pylist() == [None, 2.5]
    nullable = {field.name for field in ENCOUNTERS_SCHEMA if field.nullable}
    assert nullable == {
        "signed_winding", "release_time", "release_pitch", "release_winding", "escape_pitch_time"
    }  # fmt: skip


def test_a_table_without_information_says_so() -> None:
    with pytest.raises(ResultsError, match="without the metadata of a porous_swim run"):
        TableInfo.of(pa.table({"swimmer": [1]}))


def test_a_missing_folder_is_named(tmp_path) -> None:
    with pytest.raises(ResultsError, match="nowhere: there is no such run folder"):
        load_results(tmp_path / "nowhere")


def test_a_folder_without_a_summary_is_a_run_that_died(folder) -> None:
    (folder / "summary.json").unlink()
    with pytest.raises(ResultsError, match=r"no summary\.json, .* its run died"):
        load_results(folder)


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_missing_or_damaged_table_is_named(folder, name: str) -> None:
    path = folder / f"{name}.parquet"
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(ResultsError, match=rf"{name}\.parquet: the table is damaged") as caught:
        load_results(folder)
    assert "\n" not in str(caught.value)
    path.unlink()
    with pytest.raises(ResultsError, match=rf"{name}\.parquet: the table is missing"):
        load_results(folder)


def test_a_table_of_other_columns_is_refused(folder) -> None:
    table = pq.read_table(folder / "encounters.parquet")
    write_table(table.drop_columns(["winding"]), folder / "encounters.parquet")
    with pytest.raises(ResultsError, match="lacks winding"):
        load_results(relisted(folder))


@pytest.mark.parametrize("text", ["{", "[1]"])
def test_a_damaged_summary_is_named(folder, text: str) -> None:
    (folder / "summary.json").write_text(text)
    with pytest.raises(ResultsError, match=r"summary\.json: (cannot be read as JSON|found a list)"):
        load_results(folder)


def test_a_second_run_of_a_name_gets_the_next_number(tmp_path) -> None:
    found = [RunFolder.next_free("crystal", parent=tmp_path / "runs").path.name for _ in range(3)]
    assert found == ["crystal", "crystal-2", "crystal-3"]


def test_a_given_folder_is_taken_when_it_is_new_or_empty(tmp_path) -> None:
    assert RunFolder.at(tmp_path / "deep" / "new").path.is_dir()
    assert RunFolder.at(tmp_path / "deep" / "new").path.is_dir()


def test_a_folder_with_anything_in_it_is_refused_and_left_alone(folder) -> None:
    before = sorted(path.name for path in folder.iterdir())
    with pytest.raises(ResultsError, match="not empty; name another, or replace a run in it with overwrite=True"):
        RunFolder.at(folder)
    assert sorted(path.name for path in folder.iterdir()) == before


def test_a_path_that_cannot_be_a_folder_is_named(tmp_path) -> None:
    (tmp_path / "file").write_text("")
    for create in (
        lambda: RunFolder.at(tmp_path / "file"),
        lambda: RunFolder.next_free("run", parent=tmp_path / "file"),
    ):
        with pytest.raises(ResultsError, match=r"cannot be (used|created) as a run folder"):
            create()


def test_a_summary_with_nan_never_reaches_the_disk(tmp_path) -> None:
    target = RunFolder.at(tmp_path / "run")
    with pytest.raises(ValueError, match="not JSON compliant"):
        target.write(some_results(summary={"value": float("nan")}))
    assert not (target.path / "summary.json").exists()


def test_the_summary_is_written_last(tmp_path, monkeypatch) -> None:
    def disk_full(*_: object) -> None:
        raise OSError("No space left on device")

    target = RunFolder.at(tmp_path / "run")
    monkeypatch.setattr("porous_swim.results.run_folder.write_table", disk_full)
    with pytest.raises(OSError, match="No space"):
        target.write(some_results())
    assert not (target.path / "summary.json").exists()


def test_a_summary_is_plain_json(folder) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    assert summary["status"] == "finished"
    assert summary["files"]["encounters.parquet"]["rows"] == 2
