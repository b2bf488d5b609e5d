"""Statistics by parameter set: a sweep gives each set the tables of its scene run alone."""

from __future__ import annotations

import json
import pickle
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.results.manifest import RUN_FILES, lock_content
from porous_swim.results.run_lock import LOCK
from porous_swim.running import simulation, sweeps
from tests.support.commands import small_scene

an = ps.analysis
DURATION = 20.0
SETS = [
    {"swimmers.dipole_strength": 0.8, "swimmers.count": 20},
    {"swimmers.dipole_strength": 4.0, "swimmers.count": 30},
]


@pytest.fixture
def scene(tmp_path: Path) -> ps.Scene:
    return ps.load_scene(small_scene(tmp_path)).replace({"run.duration": DURATION, "run.time_step": 0.01})


def test_each_set_of_a_sweep_is_its_scene_run_alone_and_so_are_its_statistics(scene, tmp_path):
    swept = ps.sweep(scene, SETS, out=tmp_path / "sweep", recording=False)
    for number, (results, change) in enumerate(zip(swept, SETS, strict=True), start=1):
        alone = ps.run(scene.replace(change))
        assert results.encounters.to_pydict() == alone.encounters.to_pydict()
        assert results.trajectory.to_pydict() == alone.trajectory.to_pydict()
        assert ps.load_results(tmp_path / "sweep" / str(number)).summary == results.summary
        n = change["swimmers.count"]  # fractions and rates are over the swimmers of the set
        stays = results.encounters["end_time"].to_numpy() - results.encounters["start_time"].to_numpy()
        assert an.bound_fraction(results.encounters).value == pytest.approx(np.sum(stays) / (DURATION * n), rel=1e-12)
        hops = an.hop_statistics(results.encounters, results.colloids)
        n_moves = len(stays) - len(np.unique(results.encounters["swimmer"].to_numpy()))
        assert (hops.hop_rate.value + hops.return_rate.value) * DURATION * n == pytest.approx(n_moves, rel=1e-12)
        assert n_moves > 0


def test_a_report_of_a_sweep_says_what_differs(scene, tmp_path):
    swept = ps.sweep(scene, [{"swimmers.dipole_strength": strength} for strength in (0.5, 3.14159265)])
    assert repr(swept[0]) == (
        f"<Results of {scene.name}, finished: {scene.swimmers.count} swimmers, {DURATION:g} a/U, "
        f"{len(swept[0].encounters)} encounters, in memory>"
    )
    page = ps.report(swept, tmp_path).read_text()
    assert f"{scene.name} (dipole_strength 0.5) and {scene.name} (dipole_strength 3.142)</h1>" in page
    row = '<th scope="row">swimmers.dipole_strength</th><td>0.5</td><td>3.14159265</td>'
    assert row in page[page.index("What differs between the scenes.") :]
    assert "not known here" not in page  # scenes kept in memory


def test_a_set_that_is_no_scene_is_refused_before_anything_is_run(scene, tmp_path):
    with pytest.raises(ps.SceneError, match="dipole_strenth"):
        ps.sweep(scene, [*SETS, {"swimmers.dipole_strenth": 1.0}], out=tmp_path / "sweep")
    assert not (tmp_path / "sweep").exists()


def test_sets_that_cannot_be_placed_are_all_named_before_anything_is_run(scene, tmp_path):
    inside = {"swimmers.release": {"kind": "point", "position": [0, 0]}}
    wrong = [SETS[0], {"obstacles.radius": 6.0}, inside, *[{"run.seed": -n} for n in range(1, 12)]]
    with pytest.raises(ps.SceneError) as caught:
        ps.sweep(scene, wrong, out=tmp_path / "sweep")
    lines = str(caught.value).splitlines()
    assert len(lines) == 11  # ten, and how many more
    assert lines[0].startswith("set 2 (obstacles.radius=6.0): ")
    assert lines[1].startswith("set 3 (swimmers.release={'kind': 'point', 'position': [0, 0]}): ")
    assert lines[2].startswith("set 4 (run.seed=-1): ")
    assert lines[-1] == "and 3 more sets"
    assert not (tmp_path / "sweep").exists()


def test_sets_that_do_not_fit_into_memory_and_devices_that_are_not_here_are_named_at_once(scene, tmp_path):
    wrong = [SETS[0], {"swimmers.count": 2_000_000_000}, {"run.device": "metal"}]
    with pytest.raises(ps.SceneError) as caught:
        ps.sweep(scene, wrong, out=tmp_path / "sweep")
    first, second = str(caught.value).splitlines()
    assert first.startswith("set 2 (swimmers.count=2000000000): ")
    assert "memory" in first
    assert second.startswith("set 3 (run.device=metal): device: no metal device was found")
    with pytest.raises(ps.DeviceError, match=r"set 1 \(run.device=metal\): "):
        ps.sweep(scene, wrong[2:], out=tmp_path / "sweep")
    assert not (tmp_path / "sweep").exists()


def test_a_run_that_fails_leaves_its_error_in_place_and_the_others_go_on(scene, tmp_path, monkeypatch):
    # one set gets a drift that single precision cannot hold, which no scene may ask for: its first step is no number
    dynamics, strong = simulation.dynamics_of, {"swimmers.dipole_strength": 2.0, "swimmers.count": 20}

    def of(scenes: Sequence[ps.Scene]):
        found = dynamics(scenes)
        factor = 1e35 if scenes[0].swimmers.dipole_strength == 2.0 else 1.0
        strengths = np.array(found.parameters.names) == "alpha"
        table = found.parameters.table * np.where(strengths, factor, 1.0)
        return replace(found, parameters=replace(found.parameters, table=table))

    monkeypatch.setattr(simulation, "dynamics_of", of)
    first, failed, last = ps.sweep(scene, [SETS[0], strong, SETS[1]], out=tmp_path / "sweep", recording=False)
    assert [results.info.n_swimmers for results in (first, last)] == [20, 30]
    assert isinstance(failed, ps.FailedRun)
    assert isinstance(failed.error, ps.RunError)
    assert (failed.point.number, failed.point.changes) == (2, strong)
    assert str(failed).startswith("set 2 (swimmers.dipole_strength=2.0, swimmers.count=20) failed: swimmer ")
    with pytest.raises(AttributeError, match=r"there is no encounters, as set 2 .* failed: swimmer "):
        failed.encounters  # noqa: B018
    assert str(pickle.loads(pickle.dumps(failed))) == str(failed)


def test_a_sweep_goes_on_where_it_stopped(scene, tmp_path, monkeypatch):
    out, begun = tmp_path / "sweep", []
    before = ps.sweep(scene, SETS[:1], out=out, recording=False)
    ps.run(scene.replace(SETS[1]), out=out / "2", recording=False)
    summary = json.loads((out / "2" / "summary.json").read_text()) | {"status": "interrupted"}
    (out / "2" / "summary.json").write_text(json.dumps(summary))
    died = {"swimmers.count": 10}
    (out / "3").mkdir()
    scene.replace(died).save(out / "3")  # as one that was killed leaves it
    (out / "3" / LOCK).write_text(json.dumps(lock_content("killed", RUN_FILES)))
    monkeypatch.setattr(sweeps, "run", lambda each, **options: begun.append(each) or ps.run(each, **options))
    swept = ps.sweep(scene, [*SETS, died], out=out, recording=False)
    assert [each.swimmers.count for each in begun] == [30, 10]
    assert swept[0].summary == before[0].summary
    assert [results.summary["status"] for results in swept] == ["finished"] * 3
    ps.sweep(scene, SETS[:1], out=out, overwrite=True, recording=False)
    assert [each.swimmers.count for each in begun] == [30, 10, 20]


@pytest.mark.parametrize("other", ["run", "notes", "file"])
def test_a_folder_with_something_else_is_left_alone_and_named_before_anything_is_run(other, scene, tmp_path):
    out = tmp_path / "sweep"
    if other == "run":
        ps.run(scene, out=out / "2", recording=False)
    elif other == "notes":
        (out / "2").mkdir(parents=True)
        (out / "2" / "notes.txt").write_text("mine")
    else:
        out.mkdir()
        (out / "2").write_text("mine")
    before = sorted(out.rglob("*"))
    with pytest.raises(ps.ResultsError, match=r"set 2 \(swimmers.dipole_strength=4.0, swimmers.count=30\): .*/2 holds"):
        ps.sweep(scene, SETS, out=out, recording=False)
    assert sorted(out.rglob("*")) == before


def test_an_interrupt_ends_the_sweep_and_not_only_its_run(scene, tmp_path, monkeypatch):
    begun = []

    def interrupted(each: ps.Scene, **options: object) -> ps.Results:
        begun.append(each)
        results = ps.run(each, **options)
        return replace(results, summary=results.summary | {"status": "interrupted"})

    monkeypatch.setattr(sweeps, "run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        ps.sweep(scene, SETS, out=tmp_path / "sweep", recording=False)
    assert len(begun) == 1
    assert ps.load_results(tmp_path / "sweep" / "1").info.n_swimmers == 20
