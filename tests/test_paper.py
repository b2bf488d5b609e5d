"""The figures of the paper, made again by `reproduce`, against an independent simulator of the same model."""

import csv

import pytest
from commands import porous_swim

from porous_swim.errors import SceneError
from porous_swim.paper import FIGURES
from porous_swim.paper.figure import AGREES, DIFFERS, REPORTED, Row
from porous_swim.paper.report import chosen
from porous_swim.paper.scan import paper_scene


@pytest.mark.parametrize("name", FIGURES)
def test_every_number_of_a_figure_agrees(name, tmp_path):
    # without noise to 0.1 % or the last digit known; with noise to 4 combined standard errors, at reduced counts
    _, make = FIGURES[name]
    _all_agree(make(True), tmp_path, name)


@pytest.mark.slow
@pytest.mark.parametrize("name", FIGURES)
def test_every_number_of_a_full_figure_agrees(name, tmp_path):
    _, make = FIGURES[name]
    _all_agree(make(False), tmp_path, name)


def _all_agree(figure, folder, name):
    assert [row.cells() for row in figure.rows if row.verdict == DIFFERS] == []
    paths = figure.write(folder, name)
    assert {path.suffix for path in paths} == {".csv", ".png", ".svg"}
    assert all(path.stat().st_size > 100 for path in paths)


@pytest.mark.parametrize(
    ("row", "verdict"),
    [
        (Row("without noise", 10.009, independent=10.0), AGREES),  # 0.1 % is 0.01
        (Row("without noise", 10.011, independent=10.0), DIFFERS),
        (Row("one digit known", 0.105, independent=0.1, digit=0.01), AGREES),
        (Row("one digit known", 0.111, independent=0.1, digit=0.01), DIFFERS),
        (Row("with noise", 10.0, 0.3, independent=12.0, independent_error=0.4), AGREES),  # 4 x 0.5 = 2
        (Row("with noise", 9.9, 0.3, independent=12.0, independent_error=0.4), DIFFERS),
        (Row("nothing to compare with", 1.0, 0.1), REPORTED),
    ],
)
def test_a_verdict_follows_from_the_errors(row, verdict):
    assert row.verdict == verdict


def test_an_unknown_figure_is_named_with_the_nearest():
    with pytest.raises(SceneError, match=r"reproduce Bulseye: there is no such figure \(did you mean Bullseye\?\)"):
        chosen(["Bulseye"])


def test_figures_are_made_in_the_order_of_the_paper():
    assert chosen(["WindingNumber", "Bullseye"]) == ["Bullseye", "WindingNumber"]
    assert chosen([]) == list(FIGURES)


def test_reproduce_leaves_a_comparison(tmp_path):
    done = porous_swim("reproduce", "WindingNumber", "--quick", "--out", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "7 numbers agree, 0 differ" in done.stdout
    with (tmp_path / "out" / "comparison.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["verdict"] for row in rows] == ["agrees"] * 7
    assert "![WindingNumber](WindingNumber.png)" in (tmp_path / "out" / "comparison.md").read_text()


def test_reproduce_refuses_an_unknown_figure_in_one_sentence(tmp_path):
    done = porous_swim("reproduce", "Bulseye", "--out", "out", cwd=tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert "did you mean Bullseye?" in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ["random_swimming", "trajectories_a", "trajectories_b", "trapping", "mean_trapping"])
def test_noisy_figures_step_as_the_paper_does(name):
    scene = paper_scene(name)
    assert (scene.integrator, scene.run.time_step) == ("euler", 0.001)
    assert scene.noise.translational_diffusion == 0.002
