"""Reports: the page against the tables and the summary that it shows, and against nothing from outside."""

from __future__ import annotations

import base64
import json
import math
import re
import sys
import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.analysis.lifetimes.survival import survival_curve
from porous_swim.analysis.summary import summarize
from porous_swim.commands import cli
from porous_swim.core.errors import ResultsError
from porous_swim.plots import survival
from porous_swim.plots.colloids import images_in
from porous_swim.plots.style import MOST_POINTS, Shown, thinned_tail
from porous_swim.reporting import density, network, residence
from porous_swim.reporting import fractions as fractions_section
from porous_swim.reporting.lifetime_tables import table_by_radius
from porous_swim.reporting.numbers import value_and_error
from porous_swim.reporting.run import Run, differences, runs_of
from porous_swim.reporting.write import SECTIONS
from porous_swim.results.encounter_table import Encounters
from porous_swim.results.results import Results
from porous_swim.results.tables import TIMESERIES_SCHEMA, make_table
from porous_swim.scene.identity import portable
from tests.support import synthetic
from tests.support.commands import ROOT, SMALL, small_scene
from tests.support.pages import Page

NAMES = [
    "medium", "fractions", "residence", "winding", "network", "hops", "displacements", "directors", "height_pitch",
    "cell", "statistics", "provenance",
]  # fmt: skip
HOSTILE = "<script>alert('a & b')</script>"
CHANGES: dict[str, dict[str, Any]] = {
    "crystal": {"swimmers.count": 60, "run.duration": 60.0, "run.time_step": 0.004, "record.swimmers": 40,
                "description": HOSTILE},
    "crystal_thermal": {"swimmers.count": 40, "run.duration": "2 s", "run.time_step": "1 ms", "record.swimmers": 40},
    "bullseye": {"run.duration": 60.0},
    "free_space": {"swimmers.count": 40, "run.duration": 60.0, "record.swimmers": 40},
}  # fmt: skip


@pytest.fixture(scope="module")
def runs(tmp_path_factory) -> dict[str, Results]:
    """Short runs of scenes that ship."""
    folder = tmp_path_factory.mktemp("runs")
    scenes = {name: ps.load_scene(ROOT / f"scenes/{name}.yaml").replace(new) for name, new in CHANGES.items()}
    return {name: ps.run(scene, out=folder / name, recording=False) for name, scene in scenes.items()}


@pytest.fixture(scope="module")
def pages(runs, tmp_path_factory) -> dict[str, Page]:
    """Their pages."""
    folder = tmp_path_factory.mktemp("reports")
    return {name: Page(ps.report(results, folder / name)) for name, results in runs.items()}


@pytest.mark.parametrize("name", CHANGES)
def test_a_page_has_every_section_and_takes_nothing_from_outside(pages, name):
    page = pages[name]
    assert [attributes["id"] for attributes in page.attributes("section")] == NAMES
    assert len(SECTIONS) == len(NAMES)
    targets = [attributes["href"] for tag in ("a", "link") for attributes in page.attributes(tag)]
    assert targets == [f"#{section}" for section in NAMES] + ["data:,"]
    assert not re.search(r"https?:|//|url\(|@import", re.sub(r"base64,[^\"]*", "", page.source))
    assert {tag for tag, _ in page.tags} & {"script", "iframe", "object", "embed", "audio", "video"} == set()
    assert page.attributes("img")
    for attributes in page.attributes("img"):
        assert attributes["alt"]
        _check_picture(str(attributes["src"]))


def _check_picture(source: str) -> None:
    """An SVG that refers to nothing but itself, or a PNG."""
    kind, _, data = source.partition(";base64,")
    content = base64.b64decode(data, validate=True)
    if kind == "data:image/png":
        assert content.startswith(b"\x89PNG\r\n\x1a\n")
        return
    assert kind == "data:image/svg+xml"
    for element in ElementTree.fromstring(content).iter():
        for key, value in element.attrib.items():
            if key.rpartition("}")[2] == "href":
                assert value.startswith(("#", "data:image/png;base64,"))


def test_names_and_descriptions_are_text_and_never_markup(pages, runs, tmp_path):
    assert HOSTILE in pages["crystal"].text
    assert "<script" not in pages["crystal"].source
    summary = runs["free_space"].summary | {"warnings": [HOSTILE], "provenance": {"scene": HOSTILE}, "status": HOSTILE}
    info = replace(runs["free_space"].info, provenance={"scene": HOSTILE})
    page = Page(ps.report(replace(runs["free_space"], summary=summary, info=info, folder=None), tmp_path))
    assert "<script" not in page.source
    assert page.text.count(HOSTILE) >= 4  # title, heading, warning, provenance


@pytest.mark.parametrize("name", CHANGES)
def test_the_table_has_every_number_of_summary_json(pages, runs, name):
    stored = json.loads((runs[name].folder / "summary.json").read_text())
    expected = [entry for group in stored.values() if isinstance(group, dict) for entry in group.values()]
    expected = [entry for entry in expected if isinstance(entry, dict) and "standard_error" in entry]
    rows = pages[name].rows["statistics"][1:]
    assert len(rows) == len(expected) == 24
    assert len({row[0][0] for row in rows}) == len(rows)
    for row, entry in zip(rows, expected, strict=True):
        text, value = row[1]
        if entry["value"] is None:
            assert (text, value) == ("–", None)
        else:
            assert float(value) == entry["value"]  # repr: to the last bit
            _agree_as_printed(text, entry["value"], entry["standard_error"])
        assert [int(cell[1]) for cell in row[-2:]] == [entry["n"], entry["n_censored"]]


def _agree_as_printed(text: str, value: float, error: float | None) -> None:
    """Half a unit of the last digit that is printed; `%.4g` or `%.6g` where there is no error."""
    if not error:
        assert float(text.split()[0]) == pytest.approx(value, rel=1e-3)
        return
    assert abs(float(text.split()[0]) - value) <= 0.051 * error  # two digits of the error: half a unit is 5 % at most
    assert float(text.split()[-1]) == pytest.approx(error, rel=0.051)


def test_a_scene_with_units_has_them_in_every_table_and_on_every_axis(pages, runs):
    rows = {row[0][0]: row for row in pages["crystal_thermal"].rows["statistics"][1:]}
    a, time = 1.0, 0.2  # um and s, from the scene: 1.0 um at 5.0 um/s
    summary = runs["crystal_thermal"].summary
    for name, group, statistic, factor, unit in (
        ("mean residence time", "residence", "mean", time, "s"),
        ("hop length, between centres", "hops", "length", a, "µm"),
        ("hop rate per swimmer", "hops", "rate", 1.0 / time, "s⁻¹"),
        ("mean squared displacement at the end", "msd", "final", a**2, "µm²"),
    ):
        *value, found = rows[name][3][0].split()
        entry = summary[group][statistic]
        assert found == unit
        _agree_as_printed(" ".join(value), factor * entry["value"], factor * entry["standard_error"])
    assert "a/U = 0.2 s, U = 5 µm/s" in pages["crystal_thermal"].text
    # 10 a/U are too few for an effective diffusivity, and all say so: in its place, and among the warnings
    assert summary["diffusivity"]["effective"]["value"] is None
    assert rows["effective diffusivity"][1][0] == "–"
    assert pages["crystal_thermal"].text.count(summary["diffusivity"]["reason"]) >= 2
    assert "µm" not in pages["crystal"].text
    for make in SECTIONS:
        section = make(runs_of([runs["crystal_thermal"]]))
        if section.draw is None:
            continue
        figure = section.draw()
        figure.draw_without_rendering()
        for axis in figure.axes:
            second = [child for child in axis.child_axes if hasattr(child, "set_functions")]
            dimensional = sum(
                name.endswith(("(a)", "(a/U)", "(a²)")) for name in (axis.get_xlabel(), axis.get_ylabel())
            )
            assert len(second) == dimensional, (section.name, axis.get_xlabel())


def test_a_second_axis_shows_the_same_places_in_seconds(runs):
    shown = runs_of([runs["crystal_thermal"]])
    figure = fractions_section.section(shown).draw()
    figure.draw_without_rendering()
    axis = figure.axes[0]
    assert np.allclose(axis.child_axes[0].get_xlim(), 0.2 * np.array(axis.get_xlim()), rtol=1e-12)


def test_comparing_lays_runs_over_each_other(runs, tmp_path):
    both = [runs["crystal"], runs["crystal_thermal"]]
    page = Page(ps.report(both, tmp_path))
    assert [attributes["id"] for attributes in page.attributes("section")] == NAMES
    head, *rows = page.rows["statistics"]
    assert [cell[0] for cell in head[2:4]] == ["crystal", "crystal_thermal"]
    first, second = (results.summary["residence"]["mean"] for results in both)
    assert [float(cell[1]) for cell in rows[0][2:4]] == [first["value"], second["value"]]
    error = math.sqrt(first["standard_error"] ** 2 + second["standard_error"] ** 2)
    assert float(rows[0][4][1]) == pytest.approx((second["value"] - first["value"]) / error, rel=1e-12)
    figure = fractions_section.section(runs_of(both)).draw()
    lines = figure.axes[0].get_lines()
    assert len(lines) == 4
    for line, results in zip(lines[::2], both, strict=True):
        assert np.array_equal(line.get_ydata(), results.timeseries["fraction_bound"].to_numpy())
    assert lines[0].get_color() != lines[2].get_color()
    assert figure.axes[0].child_axes == []  # their units differ: no one axis holds for both


def test_equal_runs_give_equal_pages_and_figures(runs, pages, tmp_path):
    again = ps.report(runs["crystal"], tmp_path)
    files = [sorted(path.parent.rglob("*.*")) for path in (pages["crystal"].path, again)]
    assert {path.suffix for path in files[0]} == {".html", ".svg", ".png", ".json"}
    assert [path.name for path in files[0]] == [path.name for path in files[1]]
    assert all(a.read_bytes() == b.read_bytes() for a, b in zip(*files, strict=True))


def test_the_survival_curve_is_that_of_the_encounters(runs):
    """Kaplan-Meier by its definition, in a loop, at every end."""
    table = runs["crystal"].encounters
    length = table["end_time"].to_numpy() - table["start_time"].to_numpy()
    ended = ~table["end_censored"].to_numpy()
    figure = residence.section(runs_of([runs["crystal"]])).draw()
    drawn = figure.axes[0].get_lines()[0]
    probability, expected = 1.0, [1.0]
    for end in sorted(set(length[ended])):
        probability *= 1.0 - np.sum(length[ended] == end) / np.sum(length >= end)
        expected.append(probability)
    assert drawn.get_xdata()[1:-1] == pytest.approx(sorted(set(length[ended])), rel=1e-12)
    assert drawn.get_ydata()[:-1] == pytest.approx(expected, abs=1e-12)


def test_the_survival_curve_and_its_band_are_drawn_as_far_as_encounters_were_seen_to_last():
    length = np.array([1.0, 2.0, 3.0, 7.0])  # the last is under way
    curve = survival_curve(length, ended=length < 5.0)
    figure = survival.draw({"time": [Shown("run", "black", survival.Survival(curve))]}, None)
    axis = figure.axes[0]
    line, band = axis.get_lines()[0], axis.collections[0].get_paths()[0]
    assert (line.get_xdata()[-1], line.get_ydata()[-1]) == (7.0, 0.25)
    assert band.vertices[:, 0].max() == 7.0
    assert axis.get_xlim()[1] > 7.0


def test_half_bonds_of_the_network_carry_the_counts_of_hops(runs):
    shown = runs_of([runs["crystal"]])
    figure = network.section(shown).draw()
    lines = figure.axes[0].collections[1]
    table = runs["crystal"].encounters.sort_by([("swimmer", "ascending"), ("start_time", "ascending")]).to_pylist()
    places = [(row["colloid"], row["image_x"], row["image_y"]) for row in table]
    n_hops = sum(
        one["swimmer"] == two["swimmer"] and a != b
        for one, two, a, b in zip(table, table[1:], places, places[1:], strict=False)
    )
    assert np.sum(lines.get_array()) == n_hops > 20
    # nearest neighbours of the hexagonal crystal are 10 apart: half of that, but for fixed point of the centres
    length = [float(np.linalg.norm(segment[1] - segment[0])) for segment in lines.get_segments()]
    assert np.median(length) == pytest.approx(5.0, abs=1e-6)


def test_free_swimmers_are_compared_with_the_exact_walk(runs):
    """The drawn curve by another way: the double integral of exp(-2 D_r |s - s'|), with 6 D t added."""
    from scipy.integrate import quad

    from porous_swim.reporting.free_walk import director_correlation, squared_displacement

    D, D_r = 0.02, 0.015
    for dimensions, rate in ((2, D_r), (3, 2.0 * D_r)):
        time = np.array([1e-4, 0.01, 0.5, 3.0, 40.0, 600.0])
        straight = [2.0 * quad(lambda s, t, k: (t - s) * math.exp(-k * s), 0.0, t, args=(t, rate))[0] for t in time]
        expected = np.array(straight) + 2.0 * dimensions * D * time
        found = squared_displacement(time, D, D_r, dimensions=dimensions)
        assert found == pytest.approx(expected, rel=1e-9)
        assert director_correlation(time, D_r, dimensions=dimensions) == pytest.approx(np.exp(-rate * time), rel=1e-14)
    assert squared_displacement(np.array([7.0]), 0.0, 0.0, dimensions=3) == pytest.approx([49.0], rel=1e-14)


def in_memory(encounters: Any, *, box: tuple[float, float, float] = (0.0, 0.0, 0.0), **options: Any) -> Results:
    """Results without a folder: `n_colloids`, `n_frames` and `n_recorded` swimmers that go straight at `speed`, 0."""
    n_colloids, n_frames, n_recorded = (options.get(key, 1) for key in ("n_colloids", "n_frames", "n_recorded"))
    about = synthetic.info(n_swimmers=max(n_recorded, 1), last_time=float(n_frames - 1), dimensions=2, box=box)
    clock, directors = np.arange(float(n_frames)), np.zeros((n_frames, n_recorded, 3))
    directors[..., 0] = 1.0
    position = 2.5 + options.get("speed", 0.0) * clock[:, None, None] * directors
    centers = np.column_stack([4.0 * np.arange(n_colloids), np.zeros(n_colloids), np.zeros(n_colloids)])
    tables = {
        "encounters": about.attach(encounters),
        "colloids": synthetic.colloids(about, centers.reshape(-1, 3)),
        "timeseries": make_table(
            TIMESERIES_SCHEMA, {field.name: np.zeros(n_frames) for field in TIMESERIES_SCHEMA} | {"time": clock},
            info=about,
        ),
        "lags": synthetic.lags(about, clock, position, directors),
        "trajectory": synthetic.trajectory(about, clock, position, directors),
    }  # fmt: skip
    if n_colloids == 0:
        lost = np.full(len(tables["trajectory"]), -1, np.int32)
        place = tables["trajectory"].schema.get_field_index("colloid")
        field = tables["trajectory"].schema.field("colloid")
        tables["trajectory"] = tables["trajectory"].set_column(place, field, [lost])
    summary = {"status": "finished", **summarize(*list(tables.values())[:4], persistence_time=math.inf)}
    stored = Encounters.in_memory(tables.pop("encounters"))
    return Results(stored, **tables, summary=summary, folder=None, info=about)


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({"n_colloids": 0}, "There are no colloids"),
        ({"n_recorded": 0}, "No swimmer was recorded"),
        ({"n_frames": 1}, "Too few frames"),
        ({"n_frames": 20, "n_recorded": 1}, "No swimmer met a colloid"),
        ({"n_frames": 20, "n_recorded": 30, "box": (8.0, 8.0, 0.0)}, "no motion were recorded"),
    ],
    ids=["no colloids", "nobody recorded", "one frame", "one swimmer", "all at rest"],
)
def test_a_run_that_lacks_things_has_a_page_that_says_so(options, sentence, tmp_path):
    nobody = synthetic.encounters(synthetic.info(), swimmer=[])
    page = Page(ps.report(in_memory(nobody, **options), tmp_path))
    assert [attributes["id"] for attributes in page.attributes("section")] == NAMES
    assert sentence in page.text
    assert "kept in memory" in page.text
    assert not re.search(r"\bnan\b", page.text)


@pytest.mark.parametrize("n_frames", [2, 3, 4, 5])
def test_a_run_of_few_frames_has_a_page(n_frames, tmp_path):
    nobody = synthetic.encounters(synthetic.info(), swimmer=[])
    page = Page(ps.report(in_memory(nobody, n_frames=n_frames, n_recorded=3, speed=1.0), tmp_path))
    # lags go up to half of the run, and an exponent is of two: frames 0 to 4
    assert ("Too few frames or no motion were recorded" in page.text) == (n_frames < 5)


def test_one_encounter_that_never_ends_is_said_to_be_stuck(pages):
    for words in ("All swimmers are stuck", "No encounter was completed (1 under way)", "No swimmer hopped"):
        assert words in pages["bullseye"].text


def test_a_fraction_that_still_changes_and_an_interrupted_run_give_warnings(tmp_path):
    results = in_memory(synthetic.encounters(synthetic.info(), swimmer=[]), n_frames=40, n_recorded=30)
    columns = {name: results.timeseries[name].to_numpy() for name in results.timeseries.schema.names}
    columns["fraction_bound"] = np.linspace(0.0, 1.0, 40)  # quarters of 0.62 and 0.88: 5 standard errors of 30 swimmers
    series = make_table(TIMESERIES_SCHEMA, columns, info=results.info)
    summary = results.summary | {"status": "interrupted"}
    text = Page(ps.report(replace(results, timeseries=series, summary=summary), tmp_path)).text
    assert "The run is interrupted: it ends at time 39 a/U" in text
    assert ("The fraction bound still changes" in text) == (4.0 * math.sqrt(2.0 * 0.75 * 0.25 / 30.0) < 0.2564)


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (39.412, 0.1421, "39.41 ± 0.14"),
        (0.022583, 0.00059, "0.02258 ± 0.00059"),
        (39812.0, 1634.0, "39800 ± 1600"),
        (1.23456789, 0.0, "1.23457"),
        (2.5, None, "2.5"),
        (2.5, math.nan, "2.5"),
        (3.21e-9, 4.3e-11, "(3.210 ± 0.043)e-09"),
        (5.4321e8, 1.2e6, "(5.432 ± 0.012)e+08"),
    ],
)
def test_a_value_has_two_digits_of_its_error(value, error, text):
    assert value_and_error(value, error) == text


def test_images_in_a_rectangle_are_those_of_an_enumeration():
    rng = np.random.default_rng(3)
    centers, radii, box = rng.uniform(0.0, 10.0, (7, 2)), rng.uniform(0.2, 1.5, 7), (10.0, 8.0)
    low, high = np.array([-13.0, 2.0]), np.array([4.0, 27.0])
    shift = [(i, j) for i in range(-5, 6) for j in range(-5, 6)]
    every = {(x + i * box[0], y + j * box[1], r) for (x, y), r in zip(centers, radii, strict=True) for i, j in shift}
    inside = {
        (x, y, r) for x, y, r in every if x + r > low[0] and x - r < high[0] and y + r > low[1] and y - r < high[1]
    }
    found, found_radii = images_in(centers, radii, box=box, low=low, high=high)
    assert len(found) == len(inside)
    rows = np.array(sorted(np.round(row, 6).tolist() for row in inside))
    assert np.array_equal(rows, np.column_stack([found, found_radii]))


def test_the_cell_is_that_of_the_lattice(runs):
    """Hexagonal, spacing 10: 10 by 10 sqrt(3), with a colloid inside and the corners' four."""
    figure = density.cell_section(runs_of([runs["crystal"]])).draw()
    axis = figure.axes[0]
    assert axis.get_xlim() == pytest.approx((0.0, 10.0), abs=1e-6)
    assert axis.get_ylim() == pytest.approx((0.0, 10.0 * math.sqrt(3.0)), abs=1e-6)
    assert len(axis.patches) == 5


def test_heights_and_pitches_at_a_wall_are_those_above_the_wall():
    """A swimmer at height 1.55 with pitch 30 degrees, above the wall z = 0 of the scene that ships."""
    about = synthetic.info(n_swimmers=1, last_time=3.0)
    position = np.zeros((4, 1, 3)) + np.array([7.0, -3.0, 1.55])
    director = np.zeros((4, 1, 3)) + np.array([math.cos(math.pi / 6.0), 0.0, 0.5])
    nobody = in_memory(synthetic.encounters(about, swimmer=[]))
    results = replace(
        nobody, info=about, colloids=synthetic.colloids(about, np.zeros((1, 3)), radius=math.inf),
        trajectory=synthetic.trajectory(about, np.arange(4.0), position, director),
    )  # fmt: skip
    run = Run("wall", "black", results, ps.load_scene(ROOT / "scenes/wall.yaml"), "", 1)
    axis = density.height_pitch_section([run]).draw().axes[0]
    share = np.ma.filled(axis.collections[0].get_array(), 0.0)  # (heights, pitches)
    (at,) = np.argwhere(share > 0.0)
    assert share[tuple(at)] == 1.0
    assert at.tolist() == [int(1.55 / 4.0 * 60), int((30.0 + 90.0) / 3.0)]


def test_means_by_radius_are_time_over_ends_of_each():
    moves = synthetic.random_moves(np.random.default_rng(5), n_swimmers=20, n_rows=200, last_time=100.0)
    results = in_memory(moves, n_colloids=3)
    colloids = results.colloids.set_column(4, results.colloids.schema.field("radius"), [[1.0, 2.0, 2.0]])
    run = Run("run", "black", replace(results, stored=Encounters.in_memory(moves), colloids=colloids), None, "", 1)
    (table,) = table_by_radius([run])
    for row, group in zip(table.rows, ({0}, {1, 2}), strict=True):
        length = [row["end_time"] - row["start_time"] for row in moves.to_pylist() if row["colloid"] in group]
        assert row[2].value == pytest.approx(sum(length) / len(length), rel=1e-12)  # none of them is cut off
        assert row[4] == f"{len(length)}"


def test_pictures_of_very_many_encounters_show_some_swimmers_and_say_so(runs, monkeypatch, tmp_path):
    monkeypatch.setattr("porous_swim.reporting.run.MANY", 25)
    results = runs["crystal"]
    n, wanted = len(results.encounters), -(-len(results.encounters) // 25)
    assert wanted > 2
    (run,) = runs_of([results])
    assert run.one_in == 1  # 60 swimmers: too few to leave any out
    monkeypatch.setattr("porous_swim.reporting.run._FEWEST_SWIMMERS", 5)
    assert run.one_in == wanted
    assert 0 < len(run.encounters) < n / 2
    assert run.encounters.equals(results.stored.of_one_in(wanted))
    page = Page(ps.report(results, tmp_path))
    assert f"of {n} encounters distributions, fits, means by radius and hops show those of one swimmer in {wanted}" in (
        page.source
    )


@pytest.fixture
def called(monkeypatch, capsys):
    """Call the command line here: its exit status, stdout and stderr."""

    def call(*arguments: object) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["porous-swim", "report", *map(str, arguments)])
        with pytest.raises(SystemExit) as left:
            cli.main()
        printed = capsys.readouterr()
        return int(left.value.code or 0), printed.out, printed.err

    return call


def test_the_last_line_is_the_page_and_the_first_ones_are_the_summary(called, runs, tmp_path):
    status, out, err = called(runs["bullseye"].folder, "--out", tmp_path / "mine")
    assert (status, err) == (0, "")
    assert Path(out.splitlines()[-1]) == tmp_path / "mine/report.html"
    assert {path.name for path in (tmp_path / "mine").iterdir()} == {"report.html", "figures", "files.json"}
    value = f"{runs['bullseye'].summary['fractions']['bound']['value']:.3f}"
    (line,) = [line for line in out.splitlines() if line.startswith("fraction of time bound")]
    assert value[:4] in line
    status, out, _ = called(runs["bullseye"].folder, "--compare", runs["free_space"].folder)
    assert Path(out.splitlines()[-1]) == runs["bullseye"].folder / "comparison/report.html"
    assert "free_space" in out


def test_what_is_no_run_folder_is_one_sentence_with_status_2(called, runs, tmp_path):
    small_scene(tmp_path, SMALL)
    folder = runs["crystal"].folder
    for arguments, words in (
        ((tmp_path / "none",), "there is no such run folder"),
        ((tmp_path,), "no summary.json"),
        ((folder, "--compare", tmp_path / "none"), "there is no such run folder"),
        ((folder, "--out", tmp_path / "small.yaml"), "the report cannot be written"),
    ):
        status, out, err = called(*arguments)
        assert (status, out) == (2, "")
        assert words in err
        assert len(err.splitlines()) == 1


def test_no_results_are_refused(tmp_path):
    with pytest.raises(ResultsError, match="found no results"):
        ps.report([], tmp_path)


def test_pictures_need_no_display_and_no_pyplot(runs, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "matplotlib.pyplot", None)  # to import it is an error now
    monkeypatch.delenv("DISPLAY", raising=False)
    ps.report(runs["bullseye"], tmp_path)
    assert {path.suffix for path in (tmp_path / "figures").iterdir()} == {".png", ".svg"}


def test_a_thinned_survival_curve_keeps_every_step_of_its_tail():
    # exponential: of 20 000 ends some 20 lie below 1e-3, which even picks by number would all but skip
    probability = np.append(1.0 - np.arange(1, 20_000) / 20_000, 0.0)
    chosen = thinned_tail(probability)
    assert len(chosen) <= MOST_POINTS
    assert set(range(19_979, 20_000)) <= set(chosen.tolist())
    gaps = np.diff(np.log(probability[chosen[chosen < 19_999]]))
    assert gaps.min() > -1.0  # elsewhere no step is longer than those of the tail


def test_scenes_differ_by_what_is_in_their_files_and_not_by_where_these_are(tmp_path):
    scene = ps.load_scene(ROOT / "scenes/beads.yaml")
    for name in ("same", "other"):
        (tmp_path / name).mkdir()
        scene.save(tmp_path / name)
    table = tmp_path / "other" / "beads.csv"
    table.write_text("\n".join(table.read_text().splitlines()[:-1]))
    same, other = (ps.load_scene(tmp_path / name / "scene.yaml") for name in ("same", "other"))
    kept_in_memory = ps.Scene.from_mapping(portable(scene))
    assert differences([scene, same, kept_in_memory]) == {}
    (found,) = differences([scene, None, other]).items()
    assert found[0] == "obstacles.path"
    assert [text[:10] for text in found[1]] == ["beads.csv ", "", "beads.csv "]
