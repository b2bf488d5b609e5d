"""Statistics by parameter set: a sweep gives each set the tables of its scene run alone."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from commands import small_scene

import porous_swim as ps
from porous_swim import sweeps

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
    swept = ps.sweep(scene, [{"swimmers.dipole_strength": strength} for strength in (0.5, 3.0)])
    assert repr(swept[0]) == (
        f"<Results of {scene.name}, finished: {scene.swimmers.count} swimmers, {DURATION:g} a/U, "
        f"{len(swept[0].encounters)} encounters, in memory>"
    )
    page = ps.report(swept, tmp_path).read_text()
    assert f"{scene.name} (dipole_strength 0.5) and {scene.name} (dipole_strength 3.0)</h1>" in page
    row = '<th scope="row">swimmers.dipole_strength</th><td>0.5</td><td>3.0</td>'
    assert row in page[page.index("What differs between the scenes.") :]
    assert "not known here" not in page  # scenes kept in memory


def test_a_set_that_is_no_scene_is_refused_before_anything_is_run(scene, tmp_path):
    with pytest.raises(ps.SceneError, match="dipole_strenth"):
        ps.sweep(scene, [*SETS, {"swimmers.dipole_strenth": 1.0}], out=tmp_path / "sweep")
    assert not (tmp_path / "sweep").exists()


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
