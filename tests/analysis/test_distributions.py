"""Distributions, binned means, groups, orbits, departures and scattering on tables with known answers."""

from __future__ import annotations

import math
import time
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import porous_swim as ps
from porous_swim.analysis.columns import column
from porous_swim.analysis.estimates import Swimmers, ratio_of_sums
from porous_swim.analysis.groups import by_column, by_radius, encounter_radii
from porous_swim.analysis.histogram import binned_mean, histogram, histogram_2d
from porous_swim.analysis.lifetimes.departures import departures
from porous_swim.analysis.lifetimes.residence import contact_fraction_of_encounters, residence_times
from porous_swim.analysis.orbits import orbits
from porous_swim.analysis.scattering import scattering
from porous_swim.core.errors import ResultsError
from porous_swim.results.tables import COLLOIDS_SCHEMA, make_table
from tests.support import synthetic


def clustered(rng: np.random.Generator, n_swimmers: int, per_swimmer: int) -> tuple[np.ndarray, np.ndarray]:
    """Normal values whose mean differs from swimmer to swimmer, and the swimmers."""
    swimmer = rng.permutation(np.repeat(np.arange(n_swimmers), per_swimmer))
    return rng.normal(size=n_swimmers)[swimmer] + rng.normal(size=len(swimmer)), swimmer


def test_a_histogram_is_that_of_numpy_with_errors_of_leaving_out_each_swimmer() -> None:
    values, swimmer = clustered(np.random.default_rng(1), 300, 7)
    values[5] = np.nan
    edges = np.array([-2.0, -0.5, 0.0, 1.0, 1.5])
    found = histogram(values, edges=edges, swimmer=swimmer)
    known = ~np.isnan(values)
    count, _ = np.histogram(values[known], edges)
    assert found.count.tolist() == count.tolist()
    assert (found.n, found.n_outside) == (2099, 2099 - count.sum())
    assert found.density == pytest.approx(count / 2099 / np.diff(edges), rel=1e-13)
    swimmers = Swimmers.of(swimmer[known])
    for i in range(4):
        inside = (values[known] >= edges[i]) & (values[known] < edges[i + 1])
        _, error = ratio_of_sums(swimmers.sums(inside), swimmers.sums(np.ones(2099)))
        # The two jackknives differ by terms of relative order 1/300.
        assert found.standard_error[i] == pytest.approx(error / (edges[i + 1] - edges[i]), rel=0.01)


def test_errors_of_a_histogram_are_the_spread_over_repeats() -> None:
    rng = np.random.default_rng(2)
    repeats = [
        histogram(values, edges=np.array([-1.0, 0.5, 3.0]), swimmer=swimmer)
        for values, swimmer in (clustered(rng, 100, 10) for _ in range(400))
    ]
    spread = np.std([found.density for found in repeats], axis=0)
    # The spread of 400 repeats is known to 3.5 %: 4 of those.
    assert np.mean([found.standard_error for found in repeats], axis=0) == pytest.approx(spread, rel=0.14)


def test_a_map_is_that_of_numpy_and_its_margin_is_the_histogram() -> None:
    rng = np.random.default_rng(3)
    x, swimmer = clustered(rng, 50, 20)
    y = rng.uniform(size=1000)
    x_edges, y_edges = np.linspace(-2.0, 2.0, 5), np.linspace(0.0, 1.0, 4)
    found = histogram_2d(x, y, x_edges=x_edges, y_edges=y_edges, swimmer=swimmer)
    assert found.count.tolist() == np.histogram2d(x, y, (x_edges, y_edges))[0].tolist()
    margin = histogram(x, edges=x_edges, swimmer=swimmer)
    assert np.sum(found.density, axis=1) / 3.0 == pytest.approx(margin.density, rel=1e-12)
    whole = histogram_2d(x, y, x_edges=x_edges, y_edges=np.array([0.0, 1.0]), swimmer=swimmer)
    assert whole.standard_error[:, 0] == pytest.approx(margin.standard_error, rel=1e-12)


def test_binned_means_have_the_errors_of_a_ratio_over_swimmers() -> None:
    rng = np.random.default_rng(4)
    values, swimmer = clustered(rng, 400, 5)
    against = rng.uniform(-0.2, 1.2, 2000)
    edges = np.linspace(0.0, 1.0, 5)
    found = binned_mean(values, against=against, edges=edges, swimmer=swimmer)
    for i in range(4):
        inside = (against >= edges[i]) & (against < edges[i + 1])
        swimmers = Swimmers.of(swimmer[inside])
        mean, error = ratio_of_sums(swimmers.sums(values[inside]), swimmers.sums(np.ones(inside.sum())))
        assert found.count[i] == inside.sum()
        assert found.mean[i] == pytest.approx(mean, rel=1e-12)
        assert found.standard_error[i] == pytest.approx(error, rel=0.01)
    nothing = binned_mean(values[:1], against=against[:1] * 0.0, edges=edges, swimmer=swimmer[:1])
    assert np.isnan(nothing.standard_error).all()
    assert np.isnan(nothing.mean[1:]).all()


def polydisperse() -> tuple:
    about = synthetic.info(n_swimmers=3, last_time=20.0)
    table = synthetic.encounters(
        about, swimmer=[0, 1, 2, 0], start_time=[0.0, 0.0, 0.0, 10.0], end_time=[4.0, 6.0, 20.0, 12.0],
        end_censored=[False, False, True, False], colloid=[2, 0, 1, 0], contact_time=[1.0, 3.0, 5.0, 1.0],
    )  # fmt: skip
    columns = {"colloid": [1, 0, 2], "x": np.zeros(3), "y": np.zeros(3), "z": np.zeros(3), "radius": [5.0, 5.0, 2.0]}
    return table, make_table(COLLOIDS_SCHEMA, {k: np.asarray(v) for k, v in columns.items()}, info=about)


def test_statistics_by_radius_are_those_of_the_encounters_with_such_colloids() -> None:
    table, colloids = polydisperse()
    assert encounter_radii(table, colloids).tolist() == [2.0, 5.0, 5.0, 5.0]
    parts = by_radius(table, colloids)
    assert list(parts) == [2.0, 5.0]
    assert [len(part) for part in parts.values()] == [1, 3]
    assert residence_times(parts[2.0]).mean == 4.0
    assert residence_times(parts[5.0]).mean == (6.0 + 20.0 + 2.0) / 2.0
    assert contact_fraction_of_encounters(parts[5.0]).value == pytest.approx(9.0 / 28.0, rel=1e-14)
    assert [len(part) for part in by_column(table, "colloid").values()] == [2, 1, 1]


def test_orbits_of_a_wrapped_normal_walk_are_half_left_and_half_right() -> None:
    rng = np.random.default_rng(5)
    n = 5000
    net = rng.normal(0.0, 0.8, n)
    table = synthetic.encounters(
        synthetic.info(n_swimmers=n), swimmer=np.arange(n), end_time=np.ones(n),
        winding=np.abs(net) + 0.1, signed_winding=net,
    )  # fmt: skip
    found = orbits(table)
    exact = math.erfc(1.0 / 0.8 / math.sqrt(2.0))  # P(|normal| > 1)
    assert abs(found.net_above_one_turn.value - exact) < 4.0 * found.net_above_one_turn.standard_error
    assert found.net_above_one_turn.standard_error == pytest.approx(math.sqrt(exact * (1 - exact) / n), rel=0.05)
    assert abs(found.counterclockwise.value - 0.5) < 4.0 * found.counterclockwise.standard_error
    assert found.above_one_turn.value == np.mean(np.abs(net) > 0.9)
    signed = found.signed_winding
    assert signed.n_outside == 0
    assert np.sum(signed.density * np.diff(signed.edges)) == pytest.approx(1.0, rel=1e-12)
    middle = 0.5 * (signed.edges[1:] + signed.edges[:-1])
    # Chi^2 with a mean of one for each bin that has some ten samples.
    filled = signed.count > 10
    law = np.exp(-0.5 * (middle / 0.8) ** 2) / 0.8 / math.sqrt(2.0 * math.pi)
    chi = np.sum(((signed.density - law)[filled] / signed.standard_error[filled]) ** 2)
    assert abs(chi - filled.sum()) < 5.0 * math.sqrt(2.0 * filled.sum())


def test_orbits_in_three_dimensions_have_no_sign() -> None:
    table = synthetic.encounters(synthetic.info(), swimmer=[0], end_time=[1.0], winding=[2.5])
    found = orbits(table)
    assert (found.above_one_turn.value, found.signed_winding.n) == (1.0, 0)
    assert found.counterclockwise.as_dict()["value"] is None
    nothing = orbits(synthetic.encounters(synthetic.info(), swimmer=np.zeros(0, np.int32)))
    assert (nothing.winding.n, nothing.above_one_turn.n) == (0, 0)


def test_departures_are_those_of_completed_encounters_that_touched() -> None:
    table = synthetic.encounters(
        synthetic.info(n_swimmers=4), swimmer=[0, 1, 2, 3], end_time=[1.0, 1.0, 1.0, 1.0],
        end_censored=[False, False, False, True], release_pitch=[0.2, 0.4, np.nan, 9.0],
        exit_pitch=[0.5, 0.6, 0.7, 0.0],
    )  # fmt: skip
    found = departures(table)
    assert found.release.value == pytest.approx(0.3, rel=1e-14)
    assert found.release.standard_error == pytest.approx(0.1, rel=1e-12)  # sd of two over sqrt(2)
    assert found.exit.value == pytest.approx(0.6, rel=1e-14)
    assert (found.release.n, found.exit.n, found.exit.n_censored) == (2, 3, 1)
    assert (found.release_distribution.n, found.exit_distribution.n) == (2, 3)


def test_scattering_of_turned_encounters_has_the_impact_parameter_and_angle_they_were_made_with() -> None:
    rng = np.random.default_rng(6)
    n, radius, box = 200, 4.0, (30.0, 30.0, 30.0)
    parameter, angle = rng.uniform(0.01, 5.0, n), rng.uniform(-3.0, 3.0, n)
    # In a plane: in along +x at height `parameter`, out at `angle`, counterclockwise, which is the side of +y.
    entry = np.stack([-np.sqrt(25.0 - parameter**2), parameter, np.zeros(n)], axis=1)
    before = np.tile([1.0, 0.0, 0.0], (n, 1))
    after = np.stack([np.cos(angle), np.sin(angle), np.zeros(n)], axis=1)
    turn = Rotation.random(n, rng)
    image = rng.integers(-2, 3, (n, 3))
    center = np.array([1.0, 2.0, 3.0])
    position = turn.apply(entry) + center + image * np.array(box)
    about = synthetic.info(n_swimmers=n, box=box)
    columns = dict(zip(("entry_x", "entry_y", "entry_z"), position.T, strict=True))
    columns |= dict(zip(("image_x", "image_y", "image_z"), image.T, strict=True))
    columns |= dict(zip(("entry_ex", "entry_ey", "entry_ez"), turn.apply(before).T, strict=True))
    columns |= dict(zip(("exit_ex", "exit_ey", "exit_ez"), turn.apply(after).T, strict=True))
    winding = rng.uniform(0.0, 1.0, n)
    table = synthetic.encounters(about, swimmer=np.arange(n), end_time=np.ones(n), winding=winding, **columns)
    found = scattering(table, synthetic.colloids(about, center[None], radius=radius))
    free = winding <= 0.5
    assert column(found, "swimmer").tolist() == np.flatnonzero(free).tolist()
    assert column(found, "impact_parameter") == pytest.approx(parameter[free], rel=1e-10)
    assert column(found, "scattering_angle") == pytest.approx(angle[free], rel=1e-10)
    assert set(column(found, "radius")) == {radius}


def test_a_million_samples_are_binned_in_seconds() -> None:
    rng = np.random.default_rng(7)
    values, swimmer = rng.normal(size=1_000_000), rng.integers(0, 100_000, 1_000_000)
    start = time.perf_counter()
    histogram(values, edges=np.linspace(-4.0, 4.0, 200), swimmer=swimmer)
    binned_mean(values, against=values, edges=np.linspace(-4.0, 4.0, 200), swimmer=swimmer)
    assert time.perf_counter() - start < 10.0  # some 1 s on one core


def test_the_page_on_statistics_has_all_of_them():
    page = (Path(__file__).parents[2] / "docs" / "statistics.md").read_text(encoding="utf-8")
    public = {name for name in ps.analysis.__all__ if callable(getattr(ps.analysis, name)) and name[0].islower()}
    helpers = {"summarize", "summary_lines", "tracks", "waiting_times", "survival_curve", "histogram_2d"}
    assert sorted(name for name in public - helpers if f"`{name}`" not in page and f"`{name}(" not in page) == []


def test_a_plane_wall_has_no_impact_parameters() -> None:
    about = synthetic.info()
    wall = synthetic.colloids(about, np.zeros((1, 3)), radius=math.inf)
    with pytest.raises(ResultsError, match="found a plane wall"):
        scattering(synthetic.encounters(about, swimmer=[0], end_time=[1.0]), wall)
