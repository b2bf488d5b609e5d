"""Statistics of runs against theory, against an independent simulator, and against each other's counts."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.analysis.columns import column
from tests.validation.scenes import crystal, make_scene


def test_escape_pitch_times_in_strong_noise_are_those_of_the_theory():
    # D = 0.02: where noise is strong the Ornstein-Uhlenbeck theory holds (5.68(9) against 5.686 by an independent
    # simulator at a vanishing step). Between reflecting walls a step of 0.02 shows no bias (docs/convergence.md).
    D, alpha, A = 0.02, 0.8, 20.0
    scene = make_scene(
        swimmers={"count": 1000, "dipole_strength": alpha, "release": {"kind": "parallel", "height": 1.0}},
        obstacles={"layout": "single", "radius": A}, dimensions=3, D=D,
        run={"time_step": 0.02, "duration": 60.0, "seed": 1},
    )  # fmt: skip
    encounters = ps.run(scene).encounters
    passages = ps.analysis.escape_pitch_lifetimes(encounters).select(column(encounters, "start_time") == 0.0)
    assert len(passages) == 1000
    found = ps.analysis.one_sample_log_rank(
        passages, lambda time: ps.theory.trapping_survival(time, alpha, A, 0.75 * D)
    )
    print(found)
    assert found.ratio.standard_error < 0.04
    assert abs(found.ratio.value - 1.0) < 4.0 * found.ratio.standard_error


def test_swimmers_without_noise_scatter_by_the_angles_of_an_independent_simulator(tmp_path):
    # alpha = 0.6, A = 20, from x = -40 along x; outgoing angles at infinity, in degrees.
    known = {0.1: 36.27, 5.0: 24.44, 20.0: -20.18}
    rows = [f"-40,{start},0,1,0,0\n" for start in known]
    (tmp_path / "beam.csv").write_text("x,y,z,ex,ey,ez\n" + "".join(rows))
    scene = make_scene(
        swimmers={"count": 3, "dipole_strength": 0.6, "release": {"kind": "file", "path": "beam.csv"}},
        obstacles={"layout": "single", "radius": 20.0}, dimensions=2, folder=tmp_path,
        run={"time_step": 0.01, "duration": 200.0}, encounter={"escape_height": 30.0},
    )  # fmt: skip
    results = ps.run(scene)
    found = ps.analysis.scattering(results.encounters, results.colloids)
    order = np.argsort(column(found, "swimmer"))
    angle, parameter = (column(found, name)[order] for name in ("scattering_angle", "impact_parameter"))
    order = np.argsort(column(results.encounters, "swimmer"))
    before = np.arctan2(*(column(results.encounters, f"entry_e{axis}")[order] for axis in "yx"))  # bent on the way
    assert np.degrees(before + angle) == pytest.approx(list(known.values()), abs=0.006)
    assert np.all(parameter > list(known))  # the flow pushes them aside, by less than a tenth of the colloid
    assert np.all(parameter < np.array(list(known)) + 2.0)


@pytest.fixture(scope="module")
def hexagonal(tmp_path_factory) -> ps.Results:
    scene = crystal("hexagonal_alpha4", 500, time_step=0.005, seed=3)
    scene = scene.replace({"run.duration": 150.0, "record.every": 1.0, "record.swimmers": 500})
    return ps.run(scene, out=tmp_path_factory.mktemp("statistics") / "runs" / "crystal", recording=False)


def test_hops_of_a_crystal_are_as_many_as_the_kernel_counted_and_lead_to_six_neighbours_alike(hexagonal):
    hops = ps.analysis.hop_table(hexagonal.encounters, hexagonal.colloids)
    assert len(hops) == column(hexagonal.timeseries, "n_hops")[-1]
    shells = ps.analysis.hop_shells(hops)
    # 0.9991 of an independent simulator; binomial, as such hops are rare.
    assert abs(shells.nearest.value - 0.9991) < 4.0 * math.sqrt(0.9991 * 0.0009 / len(hops))
    assert shells.nearest.value + shells.second.value + shells.farther.value == pytest.approx(1.0, rel=1e-14)
    # Six directions, one share: what a crystal's symmetry asks for. Between hops a swimmer keeps its sense of rotation,
    # so that the errors are over swimmers.
    sector = (column(hops, "azimuth") + math.pi / 6.0) % (2.0 * math.pi)
    found = ps.analysis.histogram(sector, edges=np.arange(7) * math.pi / 3.0, swimmer=column(hops, "swimmer"))
    assert np.max(np.abs(found.density * math.pi / 3.0 - 1.0 / 6.0) / found.standard_error / (math.pi / 3.0)) < 4.5
    network = ps.analysis.hop_network(hops)
    assert set(column(network, "length")[column(network, "shell") == 1].round(6)) == {10.0}
    assert ps.analysis.hop_symmetry(network).p_value > 1e-4  # detailed balance; one false alarm in 10^4


def test_orbits_of_a_crystal_go_either_way_round_as_often(hexagonal):
    found = ps.analysis.orbits(hexagonal.encounters)
    assert abs(found.counterclockwise.value - 0.5) < 4.0 * found.counterclockwise.standard_error
    assert found.counterclockwise.standard_error < 0.01


def test_the_map_of_heights_and_pitches_has_as_many_in_contact_as_the_kernel_saw(hexagonal):
    trajectory, colloids = hexagonal.trajectory, hexagonal.colloids
    # Contact is a height up to 1.05 during an encounter; nearest and own colloid are the same there.
    found = ps.analysis.height_pitch_density(trajectory, colloids, heights=np.array([1.0 - 1e-5, 1.05, 20.0]))
    n_contact = int(np.count_nonzero(column(trajectory, "state") == 2))
    assert found.n_outside == 0
    assert found.n == len(trajectory)
    # A swimmer within the band that has not touched yet is free: at most one frame of each approach.
    n_near = int(found.count[:, 0].sum())
    assert n_contact <= n_near <= n_contact + len(hexagonal.encounters)


def test_no_swimmer_of_a_crystal_is_inside_a_colloid_in_the_map_of_its_cell(hexagonal):
    cell = (10.0, 10.0 * math.sqrt(3.0))
    found = ps.analysis.cell_density(hexagonal.trajectory, cell=cell, n_bins=50)
    x, y = (0.5 * (edges[1:] + edges[:-1]) for edges in (found.x_edges, found.y_edges))
    centers = np.array([[i * cell[0], j * cell[1]] for i in (0, 1) for j in (0, 1)] + [[0.5 * cell[0], 0.5 * cell[1]]])
    centers = centers + first_center(hexagonal)
    distance = np.min([np.hypot(*np.meshgrid(x - c[0], y - c[1], indexing="ij")) for c in centers], axis=0)
    widest = 0.5 * math.hypot(cell[0] / 50, cell[1] / 50)  # from the middle of a bin to its corner
    assert np.all(found.count[distance < 4.5 - widest - 1e-3] == 0)
    assert np.sum(found.count) == found.n == len(hexagonal.trajectory)


def first_center(results: ps.Results) -> np.ndarray:
    """Where the first colloid is in the cell, (2,)."""
    return np.array([column(results.colloids, axis)[0] for axis in "xy"])


def test_the_example_of_the_page_on_statistics_runs(hexagonal, monkeypatch, capsys):
    page = (Path(__file__).parents[2] / "docs" / "statistics.md").read_text(encoding="utf-8")
    code, sweep, very_many = re.findall(r"```python\n(.*?)```", page, flags=re.DOTALL)
    crystal = ps.load_scene(Path(__file__).parents[2] / "scenes" / "crystal.yaml")
    monkeypatch.chdir(hexagonal.folder.parents[1])
    exec(compile(code, "statistics.md", "exec"), {})
    mean = ps.analysis.residence_times(hexagonal.encounters).mean  # its colloids are all of radius 3.5
    assert capsys.readouterr().out.splitlines()[-1].startswith(f"3.5 {mean} ")
    exec(compile(very_many, "statistics.md", "exec"), {})
    lines = capsys.readouterr().out.splitlines()
    assert lines[0] == str(ps.analysis.hop_statistics(hexagonal.encounters, hexagonal.colloids).hop_rate)
    assert [int(line) for line in lines[1:]] == [len(hexagonal.encounters)]
    (Path("scenes")).mkdir()
    small = crystal.replace({"swimmers.count": 50, "run.duration": 4.0, "record": {"swimmers": 0, "trails": 0}})
    Path("scenes/crystal.yaml").write_text(small.to_yaml())
    exec(compile(sweep, "statistics.md", "exec"), {})
    assert [line.split()[0] for line in capsys.readouterr().out.splitlines()] == ["0.2", "0.8", "4.0"]
