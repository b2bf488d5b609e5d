"""Damaged run folders: an error that names a file, or a right answer, and nothing else. `damage.py` makes them."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import porous_swim as ps
from porous_swim.core.errors import ResultsError
from porous_swim.reporting import fractions, medium, provenance, write
from porous_swim.reporting.run import runs_of
from porous_swim.results.check import check_info
from porous_swim.results.encounter_table import ENCOUNTERS
from porous_swim.results.table_check import Limits
from tests.support.damage import make_run, trial
from tests.support.run_folders import relisted

N_FOLDERS = 100  # 1000 by `python -m tests.support.damage 1000`


@pytest.fixture(scope="module")
def run(tmp_path_factory) -> Path:
    return make_run(tmp_path_factory.mktemp("damage") / "whole")


@pytest.fixture
def folder(run: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(run, tmp_path / "copy"))


@pytest.mark.filterwarnings("ignore")
def test_damaged_folders_end_in_errors_that_name_a_file(run: Path) -> None:
    trials = [trial(run, number, draws=False) for number in range(N_FOLDERS)]
    assert [(what, wrong) for what, wrong in trials if wrong] == []


def test_a_whole_folder_is_read(run: Path) -> None:
    assert ps.load_results(run).summary["status"] == "finished"


@pytest.mark.parametrize(
    ("table", "column", "number", "message"),
    [
        ("encounters", "swimmer", 30, r"column swimmer, row 0: found 30, expected 0 to 29"),
        ("encounters", "colloid", 4, r"column colloid, row 0: found 4, expected 0 to 3"),
        ("encounters", "end_time", 61.0, r"column end_time, row 0: found 61, expected -6e-05 to 60.0001"),
        ("encounters", "wall_push", float("nan"), r"column wall_push, row 0: found nan, expected"),
        ("encounters", "exit_pitch", 1.6, r"column exit_pitch, row 0: found 1.6, expected -1.5708 to 1.5708"),
        ("colloids", "radius", -1.0, r"column radius, row 0: found -1, expected"),
        ("timeseries", "fraction_bound", 1.1, r"column fraction_bound, row 0: found 1.1, expected 0 to 1"),
        ("lags", "n_swimmers", 2, r"column n_swimmers, row 0: found 31, expected 30 in all groups"),
        ("trajectory", "state", 3, r"column state, row 0: found 3, expected 0 to 2"),
        ("trajectory", "swimmer", 9, r"column swimmer, row 10: found 0, expected the same 10 for each time, once each"),
    ],
)
def test_a_number_that_no_run_writes_is_named_with_its_file(folder, table, column, number, message) -> None:
    path = folder / f"{table}.parquet"
    read = pq.read_table(path)
    field = read.schema.field(column)
    values = pa.array([number, *read.column(column).to_pylist()[1:]], field.type)
    pq.write_table(read.set_column(read.schema.get_field_index(column), field, values), path)
    with pytest.raises(ResultsError, match=rf"{table}\.parquet: {message}"):
        ps.load_results(relisted(folder))


def test_an_encounter_that_begins_within_the_one_before_is_named(folder) -> None:
    path = folder / ENCOUNTERS
    read = pq.read_table(path)
    pq.write_table(pa.concat_tables([read.slice(0, 1), read]), path)
    with pytest.raises(
        ResultsError, match=r"encounters\.parquet: column start_time, row 1: .* at least the end_time of"
    ):
        ps.load_results(relisted(folder))


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("n_swimmers", None, "n_swimmers: found None, expected a count of swimmers"),
        ("box", [1.0, -2.0, 0.0], r"box: found \(1.0, -2.0, 0.0\), expected three edges"),
        ("last_time", -5.0, "last_time: found -5.0, expected at least first_time, 0"),
        ("units", {"length_um": "long"}, "units: found .* expected length_um and time_s above 0"),
    ],
)
def test_metadata_that_no_run_writes_is_named_with_its_file(folder, key, value, message) -> None:
    path = folder / ENCOUNTERS
    read = pq.read_table(path)
    info = json.loads(read.schema.metadata[b"porous_swim"]) | {key: value}
    pq.write_table(read.replace_schema_metadata({b"porous_swim": json.dumps(info).encode()}), path)
    with pytest.raises(ResultsError, match=rf"encounters\.parquet: metadata: {message}"):
        ps.load_results(relisted(folder))


def test_metadata_without_a_map_of_provenance_is_of_no_run(folder) -> None:
    info = replace(ps.load_results(folder).info, provenance=[[]])
    with pytest.raises(ResultsError, match=r"x\.parquet: metadata: provenance: found \[\[\]\], expected a map"):
        check_info(info, Path("x.parquet"))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"warnings": "none"}, "warnings: found 'none', expected a list of sentences"),
        ({"residence": {"mean": {"value": "1", "standard_error": 0.1, "n": 3, "unit": "a/U"}}},
         "residence.mean.value: found '1', expected a number, or null"),
        ({"status": 3}, "status: found 3, expected a word"),
    ],
)  # fmt: skip
def test_a_summary_that_no_run_writes_is_named(folder, change, message) -> None:
    path = folder / "summary.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | change))
    with pytest.raises(ResultsError, match=rf"summary\.json: {message}"):
        ps.load_results(folder)


def test_a_long_table_is_checked_part_by_part(folder, monkeypatch) -> None:
    path = folder / ENCOUNTERS
    read = pq.read_table(path)
    values = read.column("wall_push").to_pylist()
    field = read.schema.field("wall_push")
    bad = pa.array([*values[:-1], float("inf")], field.type)
    pq.write_table(read.set_column(read.schema.get_field_index("wall_push"), field, bad), path, row_group_size=50)
    monkeypatch.setattr("porous_swim.results.encounter_table.MANY", 10)
    monkeypatch.setattr("porous_swim.results.loading.MANY", 10)
    results = ps.load_results(relisted(folder))  # reads no row
    for read_all in (lambda: results.encounters, lambda: list(results.stored.parts("wall_push"))):
        with pytest.raises(ResultsError, match=r"encounters\.parquet: column wall_push, row \d+: found inf"):
            read_all()


def test_the_scene_of_another_run_is_not_taken_for_this_one(folder) -> None:
    scene = folder / "scene.yaml"
    scene.write_text(scene.read_text().replace("count: 30", "count: 31"))
    found = runs_of([ps.load_results(folder)])[0]
    assert found.scene is None
    assert "scene.yaml: the file is of another run" in found.no_scene


def test_strings_of_a_folder_command_nothing(folder, tmp_path, monkeypatch) -> None:
    nasty = "\x1b[31m\x00</script><b>$\\foo$"
    scene = folder / "scene.yaml"
    scene.write_text(scene.read_text().replace("thirty swimmers in a crystal", '"\\e[31mred\\0<b>"', 1))
    summary = json.loads((folder / "summary.json").read_text())
    summary["warnings"] = [nasty]
    summary["provenance"] |= {"device": nasty, nasty: nasty}
    (folder / "summary.json").write_text(json.dumps(summary))
    named = folder.rename(folder.parent / "_$x$ \x1b[1m")
    other = Path(shutil.copytree(named, folder.parent / "-->$"))
    monkeypatch.setattr(write, "SECTIONS", (medium.section, fractions.section, provenance.section))
    made = ps.report([ps.load_results(named), ps.load_results(other)], tmp_path / "report")
    for path in (made, *(made.parent / "figures").glob("*.svg")):
        text = path.read_text(encoding="utf-8")
        assert not [letter for letter in text if ord(letter) < 32 and letter not in "\n\t"], path
        assert "<b>" not in text
    assert "\\x1b[31mred\\x00&lt;b&gt;" in made.read_text()


def test_limits_are_those_of_the_run(run) -> None:
    results = ps.load_results(run)
    limits = Limits.of(results.info, results.colloids, run / "colloids.parquet")
    assert (limits.n_swimmers, limits.n_colloids, limits.last_time, limits.flat) == (30, 4, 60.0, False)
