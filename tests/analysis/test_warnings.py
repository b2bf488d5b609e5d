"""What is not to be trusted is marked where it stands: in the summary, its lines, the report's tables, the terminal."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

import porous_swim as ps
from porous_swim.analysis.lifetimes.residence import escape_pitch_lifetimes
from porous_swim.analysis.summary import summary_lines, summary_page
from porous_swim.reporting import residence, statistics
from porous_swim.reporting.run import Run, runs_of
from porous_swim.reporting.section import Number
from porous_swim.reporting.terminal import print_report
from porous_swim.reporting.trapping import trapping
from porous_swim.reporting.write import Report
from porous_swim.results.results import Results
from tests.analysis.test_summary import summary_of
from tests.support import synthetic
from tests.support.commands import ROOT
from tests.support.pages import Page

FEW = "Few ends were seen (1): the mean and its error are rough (30 or more are wanted)."


def few_ends() -> dict[str, Any]:
    """Three swimmers, of which one leaves and is caught again; none passes the escape pitch."""
    table = synthetic.encounters(
        synthetic.info(n_swimmers=3, last_time=10.0), swimmer=[0, 0, 1, 2], start_time=[0.0, 6.0, 0.0, 0.0],
        end_time=[4.0, 10.0, 10.0, 10.0], end_censored=[False, True, True, True],
    )  # fmt: skip
    return summary_of(table)


def test_estimates_that_are_not_to_be_trusted_say_why_in_the_summary() -> None:
    found = few_ends()
    stay = found["residence"]["mean"]["warning"]
    assert stay.startswith("Few encounters ended (1)")
    assert "The run (10 a/U) is shorter than the mean residence time (28 a/U)" in stay
    assert found["flights"]["mean"]["warning"] == FEW
    assert found["escape_pitch_time"]["mean"]["warning"].startswith("No end was seen (4 under way or cut off)")
    assert found["escape_pitch_time"]["restricted_mean"]["warning"].startswith("No end was seen up to 10 a/U")
    assert found["diffusivity"]["effective"].get("warning") == next(
        (warning for warning in found["warnings"] if "diffus" in warning), None
    )
    assert all("warning" not in found[group][name] for group, name in (("hops", "rate"), ("fractions", "bound")))


def test_lines_and_page_tell_a_warning_below_its_value_and_not_again() -> None:
    found = few_ends()
    lines = summary_lines(found)
    at = next(i for i, line in enumerate(lines) if line.startswith("residence time: "))
    assert lines[at + 1].startswith("  warning: Few encounters ended (1)")
    assert sum("Few encounters ended" in line for line in lines) == 1
    row = next(line for line in summary_page(found).splitlines() if line.startswith("| residence time"))
    assert "**warning**: Few encounters ended (1)" in row


@pytest.fixture(scope="module")
def results() -> Results:
    """A short run with theory of trapping, in memory."""
    scene = ps.load_scene(ROOT / "scenes/single_colloid.yaml")
    return ps.run(scene.replace({"swimmers.count": 60, "run.duration": 60.0, "record.swimmers": 30}))


def marked(results: Results, path: tuple[str, str], *, value: float | None) -> Results:
    """The same with a warning about one of its statistics."""
    group = results.summary[path[0]]
    entry = {**group[path[1]], "value": value, "warning": "It is <wrong>."}
    return replace(results, summary={**results.summary, path[0]: {**group, path[1]: entry}})


@pytest.mark.parametrize("path", [("residence", "mean"), ("diffusivity", "effective"), ("flights", "restricted_mean")])
@pytest.mark.parametrize("value", [1.5, None])
@pytest.mark.parametrize("n_runs", [1, 2])
def test_a_row_of_the_reports_table_tells_the_warning(results, tmp_path, path, value, n_runs) -> None:
    every = [marked(results, path, value=value)] * n_runs
    table = statistics.section(runs_of(every)).tables[0]
    row = next(row for row in table.rows if row[0] == statistics.name_of(path))
    cells = [cell for cell in row if isinstance(cell, Number) and cell.warning]
    assert [cell.warning for cell in cells] == ["It is <wrong>."] * n_runs
    if n_runs == 1:
        assert "warning: It is <wrong>." in Page(ps.report(every, tmp_path)).text


def test_a_restricted_mean_in_the_report_tells_its_horizon(results) -> None:
    end = results.summary["residence"]["horizon"]
    row = next(row for row in statistics.section(runs_of([results])).tables[0].rows
               if row[0] == statistics.name_of(("residence", "restricted_mean")))  # fmt: skip
    assert isinstance(row[1], Number)
    assert row[1].note == f"up to {end:.4g} a/U"


def test_the_terminal_marks_a_value_with_a_warning_and_tells_why_once(results, tmp_path, capsys) -> None:
    runs = runs_of([marked(results, ("winding", "completed"), value=1.5)])
    print_report(Report(tmp_path, runs, ("Also.",)))
    lines = capsys.readouterr().out.splitlines()
    assert any("winding of completed encounters" in line and line.rstrip().endswith("(!)") for line in lines)
    assert sum("It is <wrong>." in line for line in lines) == 1


def changed(results: Results, **changes: Any) -> Run:
    run = runs_of([results])[0]
    assert run.scene is not None
    return replace(run, scene=run.scene.replace(changes))


@pytest.mark.parametrize(("changes", "why"), [
    ({"hydrodynamics.kind": "none"}, "this run has none (hydrodynamics: none)"),
    ({"swimmers.dipole_strength": -0.8}, "for pushers, and here the dipole strength is -0.8 (a puller)"),
    ({"swimmers.dipole_strength": 0.0}, "for pushers, and here the dipole strength is 0 (no dipole)"),
    ({"noise": {"kind": "none"}}, "without noise"),
    ({"swimmers.dipole_strength": 2.0}, "the escape pitch is 0.75 rad"),
])  # fmt: skip
def test_a_theory_that_does_not_apply_is_not_shown_and_the_reason_is_the_runs_own(results, changes, why) -> None:
    run = changed(results, **changes)
    found = trapping(run, escape_pitch_lifetimes(run.encounters))
    assert found.curve is None
    assert found.sentence.startswith("No theory is shown: ")
    assert why in found.sentence
    if "pushers" not in why:
        assert "pushers" not in found.sentence


def test_a_theory_out_of_its_range_is_marked_in_its_curve_its_text_and_at_the_top(results) -> None:
    section = residence.section(runs_of([results]))
    assert section.draw is not None
    labels = [line.get_label() for axis in section.draw().axes for line in axis.get_lines()]
    assert "theory, out of its range" in labels
    assert any("near-wall theory at small pitch does not hold here" in text for text in section.warnings)
    weak = changed(results, **{"swimmers.dipole_strength": 0.2})
    within = trapping(weak, escape_pitch_lifetimes(weak.encounters))
    assert within.curve is not None
    assert within.warnings == ()
