"""The figures of the paper, made again by `reproduce`, against an independent simulator of the same model."""

import csv

import pytest

from porous_swim.core.errors import SceneError
from porous_swim.paper import FIGURES
from porous_swim.paper.figure import AGREES, DIFFERS, REPORTED, Row
from porous_swim.paper.report import chosen, summary_lines
from porous_swim.paper.scan import paper_scene
from tests.support.commands import ROOT, porous_swim


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


@pytest.mark.parametrize(
    ("paper", "ours", "error", "verdict"),
    [
        ("38.4", 22.069, 0.22, DIFFERS), ("38.4", 38.963, 0.44, AGREES), ("38.4", 38.44, 0.0, AGREES),
        ("38.4", 38.46, 0.0, DIFFERS),  # rounding hides 0.05
        ("about 15.1", 15.061, 0.0, AGREES), ("about 2.5", 2.4008, 0.0, AGREES), ("about 2.5", 2.3992, 0.0, DIFFERS),
        ("about -18", -20.176, 0.0, DIFFERS), ("1/5", 0.20008, 0.0, AGREES), ("1/5", 0.2021, 0.0, DIFFERS),
        ("178 (leading order)", 182.23, 0.0, DIFFERS), ("1 (held)", 1.0, 0.0, AGREES), ("1 (held)", 0.0, 0.0, DIFFERS),
        ("", 1.0, 0.0, ""), ("positive", 1.0, 0.0, ""),
    ],
)  # fmt: skip
def test_a_verdict_against_the_paper_follows_from_what_it_prints(paper, ours, error, verdict):
    # an independent program that agrees does not change it
    assert Row("", ours, error, paper=paper, independent=ours).paper_verdict == verdict


def test_agreement_with_one_source_hides_no_difference_from_the_other():
    rows = [Row("", 22.069, 0.22, paper="38.4", independent=21.83, independent_error=0.14), Row("", 1.0, paper="1.0")]
    first = summary_lines(rows)[0]
    assert first.startswith("Of 2 numbers the paper prints 2: 1 agree and 1 differ.")
    assert first.endswith("An independent program of the same model has 1: 1 agree and 0 differ.")
    assert rows[0].cells()[-2:] == [DIFFERS, AGREES]


def test_the_stored_comparison_counts_both():
    text = (ROOT / "docs" / "paper" / "comparison.md").read_text()
    rows = [line.split(" | ")[-2:] for line in text.splitlines() if line.startswith("| ") and "quantity" not in line]
    paper, independent = ([row[i].strip(" |") for row in rows] for i in (0, 1))
    counted = [f"{found.count(AGREES)} agree and {found.count(DIFFERS)} differ" for found in (paper, independent)]
    assert counted == ["8 agree and 20 differ", "95 agree and 0 differ"]
    assert all(words in text for words in counted)
    # means with the standard noise: all four of the paper's are off
    means = [line for line in text.splitlines() if line.startswith("| A = ") and "E[T_h] |" in line]
    assert [line.split(" | ")[-2] for line in means] == [DIFFERS] * 4


def test_an_unknown_figure_is_named_with_the_nearest():
    with pytest.raises(SceneError, match=r"reproduce Bulseye: there is no such figure \(did you mean Bullseye\?\)"):
        chosen(["Bulseye"])


def test_figures_are_made_in_the_order_of_the_paper():
    assert chosen(["WindingNumber", "Bullseye"]) == ["Bullseye", "WindingNumber"]
    assert chosen([]) == list(FIGURES)


def test_reproduce_leaves_a_comparison(tmp_path):
    done = porous_swim("reproduce", "WindingNumber", "--quick", "--out", "out", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    last = done.stdout.splitlines()[-1]
    assert last.startswith(
        "against the paper 0 agree and 0 differ; against the independent program 7 agree and 0 differ"
    )
    with (tmp_path / "out" / "comparison.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["against the independent"] for row in rows] == ["agrees"] * 7
    assert [row["against the paper"] for row in rows] == [""] * 7  # it prints none
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
