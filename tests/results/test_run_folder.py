"""Whose a run folder is: its lock, what replacing a run deletes, and whether files are those of one run."""

from __future__ import annotations

import errno
import fcntl
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest

import porous_swim as ps
from porous_swim.core.errors import ResultsError, RunError
from porous_swim.results import encounter_table as encounters_module
from porous_swim.results import loading as loading_module
from porous_swim.results.manifest import RUN_FILES, SCRATCH
from porous_swim.results.run_folder import RunFolder
from porous_swim.results.tables import SCHEMAS, TableInfo
from porous_swim.running.interrupts import Interrupts
from tests.results.test_results import ABOUT, some_results
from tests.support import synthetic
from tests.support.commands import environment, small_scene
from tests.support.run_folders import relisted

HOLD = "import sys, time; from porous_swim.results.run_folder import RunFolder; f = RunFolder.at(sys.argv[1]); print(flush=True); time.sleep(99)"  # noqa: E501


def of_run(run_id: str) -> ps.Results:
    """Results whose tables say of which run they are."""
    results = some_results()
    info = replace(ABOUT, provenance={"seed": 1, "run_id": run_id})
    tables = {name: info.attach(getattr(results, name)) for name in SCHEMAS if name != "encounters"}
    stored = encounters_module.Encounters.in_memory(info.attach(results.encounters))
    return replace(
        results, stored=stored, info=info, summary={**results.summary, "provenance": info.provenance}, **tables
    )


@pytest.fixture
def folder(tmp_path) -> Path:
    """A finished run."""
    return RunFolder.at(tmp_path / "run").write(of_run("one")).folder


def contents(folder: Path) -> dict[str, bytes]:
    """All files below a folder."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


# the lock


@pytest.mark.parametrize("overwrite", [False, True])
def test_a_second_run_is_refused_while_the_first_lives_and_told_which_it_is(tmp_path, overwrite: bool) -> None:
    first = RunFolder.at(tmp_path / "run")
    before = contents(first.path)
    with pytest.raises(
        ResultsError, match=f"under way in this folder .process {os.getpid()} on {socket.gethostname()}"
    ):
        RunFolder.at(tmp_path / "run", overwrite=overwrite)
    assert contents(first.path) == before
    first.close()
    RunFolder.at(tmp_path / "run").close()  # it wrote nothing


def test_the_death_of_a_run_lets_go_of_its_folder(tmp_path) -> None:
    command = [sys.executable, "-c", HOLD, str(tmp_path / "run")]
    with subprocess.Popen(command, env=environment(), stdout=subprocess.PIPE) as holder:
        assert holder.stdout is not None
        holder.stdout.readline()
        with pytest.raises(ResultsError, match=f"process {holder.pid} on"):
            RunFolder.at(tmp_path / "run", overwrite=True)
        holder.kill()
        holder.wait()
    with pytest.raises(ResultsError, match=f"under way or died .process {holder.pid} on"):
        ps.load_results(tmp_path / "run")
    RunFolder.at(tmp_path / "run", overwrite=True).close()


def test_a_file_system_without_locks_is_told(tmp_path, monkeypatch) -> None:
    def none(*_: object) -> None:
        raise OSError(errno.ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", none)
    scene = ps.load_scene(small_scene(tmp_path)).replace({"run.duration": 0.1})
    results = ps.run(scene, out=tmp_path / "run", recording=False)
    assert any("has no locks" in warning for warning in results.summary["warnings"])


def test_a_folder_that_another_run_took_is_left_alone(tmp_path, monkeypatch) -> None:
    scene = ps.load_scene(small_scene(tmp_path))
    advance, there = ps.Simulation.advance, tmp_path / "run"

    def lose_the_folder(simulation: ps.Simulation, n_steps: int) -> None:
        if simulation.step == 500:
            shutil.rmtree(there)
            RunFolder.at(there).write(of_run("other"))
        advance(simulation, n_steps)

    monkeypatch.setattr(ps.Simulation, "advance", lose_the_folder)
    with pytest.raises(RunError, match="no longer the folder of the run; nothing is written into it"):
        ps.run(scene, out=there, recording=False)
    assert ps.load_results(there).summary["provenance"]["run_id"] == "other"


def test_a_run_whose_lock_was_deleted_keeps_its_results(tmp_path, monkeypatch) -> None:
    scene = ps.load_scene(small_scene(tmp_path)).replace({"run.duration": 0.1})
    advance = ps.Simulation.advance

    def delete_the_lock(simulation: ps.Simulation, n_steps: int) -> None:
        (tmp_path / "run/run.lock").unlink(missing_ok=True)
        advance(simulation, n_steps)

    monkeypatch.setattr(ps.Simulation, "advance", delete_the_lock)
    ps.run(scene, out=tmp_path / "run", recording=False)
    assert ps.load_results(tmp_path / "run").summary["status"] == "finished"


# what replacing a run deletes


def test_a_folder_that_is_no_run_is_left_as_it_is(tmp_path) -> None:
    (tmp_path / "report").mkdir()
    for name in ("summary.json", "scene.yaml", "checkpoint.npz", "report/thesis.tex", "run.lock"):
        (tmp_path / name).write_text('{"provenance": {}, "files": {"scene.yaml": {}}}')
    before = contents(tmp_path)
    with pytest.raises(ResultsError, match="nothing in this folder says that it holds a run"):
        RunFolder.at(tmp_path, overwrite=True)
    assert contents(tmp_path) == before


def test_replacing_a_run_deletes_what_it_lists_says_so_before_and_keeps_the_users_files(folder) -> None:
    mine = ["checkpoint.npz", "notes.txt", "report/thesis.tex", "plots/a.png"]
    ps.report(ps.load_results(folder), folder / "report")
    for name in mine:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_text("mine")
    said: list[str] = []

    def say(line: str) -> None:
        said.append(line)
        assert (folder / "summary.json").exists()

    RunFolder.at(folder, overwrite=True, say=say).close()
    assert sorted(set(contents(folder)) - {"run.lock", "summary.json.part"}) == sorted(mine)
    for name in (*(f"{name}.parquet" for name in SCHEMAS), "summary.json", "report/report.html"):
        assert name in said[0]
    assert not any(name in said[0] for name in mine)
    assert not (folder / "report/figures").exists()


def test_replacing_a_run_leaves_no_empty_report(folder) -> None:
    ps.report(ps.load_results(folder), folder / "report")
    RunFolder.at(folder, overwrite=True).close()
    assert {path.name for path in folder.iterdir()} == {"run.lock", "summary.json.part"}


def test_a_list_that_names_files_elsewhere_deletes_none_of_them(folder) -> None:
    victim = folder.parent / "victim.txt"
    victim.write_text("mine")
    summary = json.loads((folder / "summary.json").read_text())
    record = summary["files"]["lags.parquet"]
    summary["files"] |= {"../victim.txt": record, str(victim): record, "..": record}
    (folder / "summary.json").write_text(json.dumps(summary))
    (folder / "report").mkdir()
    (folder / "report/files.json").write_text(
        '{"program": "porous_swim", "files": ["../../victim.txt", "figures/../../.."]}'
    )
    RunFolder.at(folder, overwrite=True).close()
    assert victim.read_text() == "mine"


def test_a_file_of_the_user_that_has_a_name_of_a_run_is_not_overwritten(folder) -> None:
    (folder / "recording.rrd").write_text("mine")
    before = contents(folder)
    with pytest.raises(ResultsError, match=r"recording\.rrd is not of the run in this folder"):
        RunFolder.at(folder, overwrite=True)
    assert contents(folder) == before


def test_a_run_is_refused_where_its_inputs_lie(folder) -> None:
    before = contents(folder)
    with pytest.raises(ResultsError, match=r"scene\.yaml, which this run reads, lies in this folder"):
        RunFolder.at(folder, overwrite=True, inputs=[folder / "scene.yaml"])
    (folder.parent / "link").symlink_to(folder / "lags.parquet")
    with pytest.raises(ResultsError, match="which this run reads, lies in this folder"):
        RunFolder.at(folder, overwrite=True, inputs=[folder.parent / "link"])
    assert contents(folder) == before


def test_a_run_that_was_killed_while_it_replaced_another_can_be_replaced(folder, monkeypatch) -> None:
    def killed(_: Path, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "unlink", killed)
    with pytest.raises(KeyboardInterrupt):
        RunFolder.at(folder, overwrite=True)
    monkeypatch.undo()
    RunFolder.at(folder, overwrite=True).close()
    assert set(contents(folder)) == {"run.lock", "summary.json.part"}


@pytest.mark.parametrize("name", ["lags.parquet", "Summary.json", "scene.yaml.part", "run.lock", "beads.csv"])
def test_a_table_of_beads_keeps_clear_of_the_files_of_a_run(tmp_path, name: str) -> None:
    beads = "x,y,radius\n10,10,4\n30,10,5\n"
    (tmp_path / name).write_text(beads)
    text = f"""\
swimmers: {{count: 20, dipole_strength: 2.0}}
noise: {{kind: brownian, translational_diffusion: 0.006}}
obstacles: {{layout: file, path: {name}}}
domain: {{dimensions: 2, boundary: periodic, size: [50, 40]}}
run: {{time_step: 0.02, duration: 0.2, seed: 1}}
record: {{every: 0.1}}
"""
    scene = ps.load_scene(small_scene(tmp_path, text))
    results = ps.run(scene, out=tmp_path / "run", recording=False)
    copy = name if name == "beads.csv" else f"obstacles_{name}"
    assert (tmp_path / "run" / copy).read_text() == beads == (tmp_path / name).read_text()
    assert copy in results.summary["files"]
    again = ps.run(ps.load_scene(tmp_path / "run/scene.yaml"), out=tmp_path / "again", recording=False)
    assert again.colloids.equals(results.colloids)
    ps.run(scene, out=tmp_path / "run", overwrite=True, recording=False)
    assert set(contents(tmp_path / "run")) == {*RUN_FILES, copy} - {"recording.rrd"}


# the files of one run


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_table_of_another_run_is_refused_by_name(folder, tmp_path, name: str) -> None:
    other = RunFolder.at(tmp_path / "other").write(of_run("two")).folder
    shutil.copy(other / f"{name}.parquet", folder)
    for each in (folder, relisted(folder)):  # the second: of the right size
        with pytest.raises(ResultsError, match=rf"{name}\.parquet: the table is of another run"):
            ps.load_results(each)


@pytest.mark.parametrize("how", ["doubled", "cut", "turned round"])
@pytest.mark.parametrize("name", SCHEMAS)
def test_a_table_of_other_rows_is_refused_by_name(folder, name: str, how: str) -> None:
    table = pq.read_table(folder / f"{name}.parquet")
    changed = {
        "doubled": pa.concat_tables([table, table]), "cut": table.slice(1),
        "turned round": table.take(pa.array(range(len(table))[::-1], pa.int64())),
    }[how]  # fmt: skip
    pq.write_table(changed, folder / f"{name}.parquet")
    with pytest.raises(ResultsError, match=rf"{name}\.parquet: the table is damaged"):
        ps.load_results(folder)


def test_every_flipped_bit_in_a_table_is_noticed(folder) -> None:
    rng = np.random.default_rng(1)
    for name in SCHEMAS:
        path = folder / f"{name}.parquet"
        whole = path.read_bytes()
        for _ in range(20):
            flipped = bytearray(whole)
            flipped[rng.integers(len(whole))] ^= 1 << rng.integers(8)
            path.write_bytes(flipped)
            with pytest.raises(ResultsError, match=rf"{name}\.parquet: the table is damaged"):
                ps.load_results(folder)
        path.write_bytes(whole)
    ps.load_results(folder)


def test_a_long_table_of_encounters_is_checked_by_rows_at_once_and_page_by_page_as_it_is_read(
    tmp_path, monkeypatch
) -> None:
    monkeypatch.setattr(encounters_module, "MANY", 100)
    monkeypatch.setattr(loading_module, "MANY", 100)
    monkeypatch.setattr(loading_module, "checked", lambda results, folder: results)  # tables of several sizes
    n = 2000
    about = synthetic.info(n_swimmers=n)
    rng = np.random.default_rng(1)
    table = synthetic.encounters(about, swimmer=np.arange(n), start_time=rng.random(n), end_time=1.0 + rng.random(n))
    results = replace(some_results(), stored=encounters_module.Encounters.in_memory(table))
    folder = RunFolder.at(tmp_path / "run").write(results).folder
    path = folder / "encounters.parquet"
    whole = path.read_bytes()
    column = pq.ParquetFile(path).metadata.row_group(0).column(table.column_names.index("end_time"))
    first, last = column.data_page_offset, column.data_page_offset + column.total_compressed_size
    for place in rng.integers(first + 100, last, 20):
        flipped = bytearray(whole)
        flipped[place] ^= 1
        path.write_bytes(flipped)
        with pytest.raises(ResultsError, match=r"encounters\.parquet: the table is damaged"):
            list(ps.load_results(folder).stored.parts("end_time"))
        with pytest.raises(ResultsError, match=r"encounters\.parquet: the table is damaged"):
            ps.load_results(folder, verify=True)
    summary = json.loads((folder / "summary.json").read_text())
    path.write_bytes(whole)
    summary["files"]["encounters.parquet"]["rows"] = n + 1
    (folder / "summary.json").write_text(json.dumps(summary))
    with pytest.raises(ResultsError, match="has 2,000 rows, and its run wrote 2,001"):
        ps.load_results(folder)


def test_a_damaged_recording_is_found_where_that_is_asked_for(tmp_path) -> None:
    scene = ps.load_scene(small_scene(tmp_path)).replace({"run.duration": 0.1})
    folder = ps.run(scene, out=tmp_path / "run").folder
    recording = bytearray((folder / "recording.rrd").read_bytes())
    recording[len(recording) // 2] ^= 1
    (folder / "recording.rrd").write_bytes(recording)
    ps.load_results(folder)
    with pytest.raises(ResultsError, match=r"recording\.rrd: the file is damaged"):
        ps.load_results(folder, verify=True)


@pytest.mark.parametrize("files", [None, [], 3, {"lags.parquet": None}, {"lags.parquet": {"bytes": "x", "crc32": 1}}])
def test_a_damaged_list_of_files_is_one_sentence(folder, files: object) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    (folder / "summary.json").write_text(json.dumps({**summary, "files": files}))
    with pytest.raises(ResultsError, match=r"summary\.json: its list of files is damaged"):
        ps.load_results(folder)


# paths and signals


def test_a_home_is_expanded_once(tmp_path, monkeypatch) -> None:
    (tmp_path / "here").mkdir()
    scene = ps.load_scene(small_scene(tmp_path)).replace({"run.duration": 0.1})
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.chdir(tmp_path / "here")
    results = ps.run(scene, out="~/x")
    assert results.folder == tmp_path / "home/x"
    assert set(contents(tmp_path / "home")) == {f"x/{name}" for name in RUN_FILES}
    assert not list((tmp_path / "here").iterdir())
    assert ps.load_results("~/x").summary == results.summary
    assert ps.report(results, "~/page") == tmp_path / "home/page/report.html"


def test_a_folder_of_the_working_directory_stays_where_it_was_made(tmp_path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    folder = RunFolder.at("run")
    monkeypatch.chdir("/")
    assert folder.write(of_run("one")).folder == tmp_path / "run"
    assert ps.load_results(tmp_path / "run").folder == tmp_path / "run"


@pytest.mark.skipif(sys.platform != "linux", reason="other systems take no such names")
def test_a_path_that_is_no_text_is_refused_in_a_sentence(tmp_path) -> None:
    path = os.fsdecode(os.fsencode(tmp_path) + b"/r\xff")
    for use in (RunFolder.at, ps.load_results):
        with pytest.raises(ResultsError, match=r"r\\xff': the path is not UTF-8") as caught:
            use(path)
        str(caught.value).encode()  # can be printed
    assert not list(tmp_path.iterdir())


@pytest.mark.skipif(not hasattr(signal, "SIGHUP"), reason="signals of POSIX")
def test_a_lost_connection_is_noted_once_and_not_where_it_is_to_be_ignored() -> None:
    before = signal.getsignal(signal.SIGHUP)
    try:
        with Interrupts() as interrupts:
            signal.raise_signal(signal.SIGHUP)
            signal.raise_signal(signal.SIGHUP)  # from the terminal and from the shell
            assert interrupts.name == "SIGHUP"
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(signal.SIGTERM)
        signal.signal(signal.SIGHUP, signal.SIG_IGN)  # as nohup does
        with Interrupts() as interrupts:
            signal.raise_signal(signal.SIGHUP)
            assert not interrupts
    finally:
        signal.signal(signal.SIGHUP, before)


def test_a_table_that_could_not_be_written_is_empty_and_named(folder) -> None:
    summary = json.loads((folder / "summary.json").read_text())
    del summary["files"]["trajectory.parquet"]
    (folder / "summary.json").write_text(json.dumps(summary | {"missing": {"trajectory.parquet": "No space"}}))
    (folder / "trajectory.parquet").unlink()
    results = ps.load_results(folder)
    assert len(results.trajectory) == 0
    assert TableInfo.of(results.trajectory) == results.info
    assert "without trajectory.parquet" in repr(results)
    assert set(SCRATCH).isdisjoint(summary["files"])
