"""Hop tables and networks of random walks on lattices, whose statistics are known."""

from __future__ import annotations

import math
import time

import numpy as np
import pyarrow as pa
import pytest
from scipy import stats

from porous_swim.analysis.columns import column
from porous_swim.analysis.histogram import binned_mean, histogram
from porous_swim.analysis.hopping.hop_network import hop_counts, hop_degrees, hop_network, hop_symmetry
from porous_swim.analysis.hopping.hop_table import hop_shells, hop_table
from porous_swim.analysis.hopping.hops import hop_statistics
from porous_swim.results.tables import TableInfo
from tests.support import synthetic

SPACING = 10.0
SIXTH = math.pi / 3.0
HEXAGONAL_BOX = (4.0 * SPACING, 2.0 * math.sqrt(3.0) * SPACING, 0.0)  # sixteen colloids
SIX = SPACING * np.stack([np.cos(SIXTH * np.arange(6)), np.sin(SIXTH * np.arange(6)), np.zeros(6)], axis=1)


def hexagonal() -> tuple[TableInfo, np.ndarray]:
    row, number = np.divmod(np.arange(16), 4)
    x = (number + 0.5 * (row % 2)) * SPACING
    centers = np.stack([x, row * 0.5 * math.sqrt(3.0) * SPACING, np.zeros(16)], axis=1)
    return synthetic.info(n_swimmers=500, last_time=60.0, dimensions=2, box=HEXAGONAL_BOX), centers


def walk(about: TableInfo, centers: np.ndarray, bonds: np.ndarray, chosen: np.ndarray) -> pa.Table:
    """Encounters of swimmers that hop along `bonds` (n_bonds, 3) in the order `chosen` (n_swimmers, n_hops)."""
    n_swimmers, n_hops = chosen.shape
    way = np.cumsum(np.concatenate([np.zeros((n_swimmers, 1, 3)), bonds[chosen]], axis=1), axis=1).reshape(-1, 3)
    place = way + np.repeat(centers[np.arange(n_swimmers) % len(centers)], n_hops + 1, axis=0)
    edges = np.array([edge or np.inf for edge in about.box])
    image = np.floor(place / edges + 1e-9).astype(int)
    wrapped = place - image * np.array(about.box)
    colloid = np.argmin(np.linalg.norm(wrapped[:, None] - centers, axis=2), axis=1)
    assert wrapped == pytest.approx(centers[colloid], abs=1e-9)
    start = np.tile(np.arange(n_hops + 1.0), n_swimmers)
    columns = {f"image_{axis}": image[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"entry_{axis}": place[:, i] for i, axis in enumerate("xyz")}
    columns |= {f"exit_{axis}": place[:, i] for i, axis in enumerate("xyz")}
    return synthetic.encounters(
        about, swimmer=np.repeat(np.arange(n_swimmers), n_hops + 1), start_time=start, end_time=start + 0.75,
        colloid=colloid, **columns,
    )  # fmt: skip


def test_a_hexagonal_walk_has_six_equal_neighbours() -> None:
    about, centers = hexagonal()
    colloids = synthetic.colloids(about, centers)
    chosen = np.random.default_rng(1).integers(0, 6, (500, 50))
    hops = hop_table(walk(about, centers, SIX, chosen), colloids)
    assert len(hops) == 25_000
    assert column(hops, "length") == pytest.approx(np.full(25_000, SPACING), rel=1e-12)
    assert column(hops, "displacement") == pytest.approx(np.full(25_000, SPACING), rel=1e-12)
    assert set(column(hops, "shell")) == {1}
    assert set(column(hops, "time")) == {0.25}
    assert column(hops, "azimuth") == pytest.approx(np.angle(np.exp(1j * SIXTH * chosen.ravel())), abs=1e-9)
    network = hop_network(hops)
    assert len(network) == 16 * 6
    deviation = (column(network, "probability") - 1.0 / 6.0) / column(network, "standard_error")
    # Six shares of one sum: 5/6 of a unit variance each. 4.5 standard errors: 1 false alarm in 1500 for 96.
    assert np.max(np.abs(deviation)) < 4.5
    assert np.mean(deviation**2) == pytest.approx(1.0, abs=0.6)
    # Hops are independent here, so that the errors over swimmers are binomial, up to sampling.
    binomial = np.sqrt(5.0 / 36.0 / 25_000 * 16)
    assert column(network, "standard_error") == pytest.approx(np.full(96, binomial), rel=0.3)
    degrees = hop_degrees(network, colloids)
    assert set(column(degrees, "out_degree")) == set(column(degrees, "in_degree")) == {6}
    assert np.sum(column(degrees, "n_out")) == np.sum(column(degrees, "n_in")) == 25_000
    shells = hop_shells(hops)
    assert (shells.nearest.value, shells.second.value, shells.farther.value) == (1.0, 0.0, 0.0)


def test_turning_angles_of_a_hexagonal_walk_are_uniform_over_six() -> None:
    about, centers = hexagonal()
    chosen = np.random.default_rng(2).integers(0, 6, (500, 50))
    hops = hop_table(walk(about, centers, SIX, chosen), synthetic.colloids(about, centers))
    signed, unsigned = column(hops, "signed_turning_angle"), column(hops, "turning_angle")
    assert np.isnan(unsigned).sum() == np.isnan(signed).sum() == 500  # each swimmer's first
    turn = np.angle(np.exp(1j * SIXTH * np.diff(chosen, axis=1))).ravel()
    assert np.cos(signed[~np.isnan(signed)]) == pytest.approx(np.cos(turn), abs=1e-9)
    assert np.sin(signed[~np.isnan(signed)]) == pytest.approx(np.sin(turn), abs=1e-9)
    assert np.abs(signed[~np.isnan(signed)]) == pytest.approx(unsigned[~np.isnan(unsigned)], abs=1e-9)
    edges = (np.arange(5) - 0.5) * SIXTH  # about 0, 60, 120 and 180 degrees
    found = histogram(unsigned, edges=edges, swimmer=column(hops, "swimmer"))
    exact = np.array([1, 2, 2, 1]) / 6.0
    assert np.all(np.abs(found.density * SIXTH - exact) < 4.0 * found.standard_error * SIXTH)
    assert np.all(found.standard_error * SIXTH < 0.005)


def test_one_colloid_in_a_box_has_hops_over_images() -> None:
    about = synthetic.info(n_swimmers=200, last_time=40.0, dimensions=2, box=(SPACING, SPACING, 0.0))
    centers = np.array([[1.0, 2.0, 0.0]])
    colloids = synthetic.colloids(about, centers)
    s = SPACING
    bonds = np.array([[s, 0, 0], [0, s, 0], [-s, 0, 0], [0, -s, 0], [s, s, 0], [2 * s, 0, 0]])
    chosen = np.random.default_rng(3).choice(6, (200, 30), p=[0.2, 0.2, 0.2, 0.2, 0.1, 0.1])
    table = walk(about, centers, bonds, chosen)
    hops = hop_table(table, colloids)
    network = hop_network(hops)
    assert len(hops) == 6000
    assert len(network) == 6
    images = np.stack([column(network, f"image_{axis}") for axis in "xy"], axis=1)
    for i, bond in enumerate(bonds):
        row = np.flatnonzero(np.all(images == bond[:2] / s, axis=1))
        assert column(network, "n_hops")[row] == np.count_nonzero(chosen == i)
        assert column(network, "shell")[row] == [1, 1, 1, 1, 2, 3][i]
    matrix = hop_counts(hops)
    assert (column(matrix, "n_hops").tolist(), column(matrix, "probability").tolist()) == ([6000], [1.0])
    degrees = hop_degrees(network, colloids)
    assert (column(degrees, "out_degree").tolist(), column(degrees, "n_in").tolist()) == ([6], [6000])
    shells, known = hop_shells(hops), hop_statistics(table, colloids)
    assert shells.nearest == known.nearest_share
    assert shells.nearest.value + shells.second.value + shells.farther.value == pytest.approx(1.0, rel=1e-14)
    assert hop_symmetry(network).p_value < 1e-10  # nothing goes back along the diagonal


def network_of(counts: np.ndarray) -> pa.Table:
    start, end = np.nonzero(counts)
    zeros = np.zeros(len(start), np.int32)
    columns = {"from_colloid": start, "to_colloid": end, "n_hops": counts[start, end]}
    return pa.table({**columns, **{f"image_{axis}": zeros for axis in "xyz"}})


def test_bowkers_statistic_of_a_table_is_that_worked_by_hand() -> None:
    counts = np.array([[0, 20, 10, 5], [10, 0, 30, 15], [5, 10, 0, 20], [0, 5, 10, 0]])
    found = hop_symmetry(network_of(counts))
    # 10^2/30 + 5^2/15 + 5^2/5 + 20^2/40 + 10^2/20 + 10^2/30
    assert found.chi_squared == pytest.approx(10 / 3 + 5 / 3 + 5 + 10 + 5 + 10 / 3, rel=1e-14)
    assert found.degrees_of_freedom == 6
    assert found.p_value == pytest.approx(stats.chi2.sf(85 / 3, 6), rel=1e-10)


def test_symmetric_hops_have_uniform_p_values_and_biased_ones_vanishing_ones() -> None:
    rng = np.random.default_rng(5)
    rate = 100.0 * (1.0 - np.eye(6))
    found = [hop_symmetry(network_of(rng.poisson(rate))).p_value for _ in range(300)]
    assert stats.kstest(found, "uniform").pvalue > 1e-4  # one false alarm in 10^4
    rate[0, 1] *= 2.0
    assert hop_symmetry(network_of(rng.poisson(rate))).p_value < 1e-3


def test_errors_of_a_network_are_the_spread_over_repeats_where_swimmers_keep_their_way() -> None:
    about, centers = hexagonal()
    colloids = synthetic.colloids(about, centers)
    rng = np.random.default_rng(6)
    shares, errors = [], []
    for _ in range(100):
        own = rng.dirichlet(np.ones(6), 100)  # each swimmer has its own preferences
        chosen = np.array([rng.choice(6, 10, p=p) for p in own])
        matrix = hop_network(hop_table(walk(about, centers, SIX, chosen), colloids))
        shares.append(column(matrix, "probability")[:2])
        errors.append(column(matrix, "standard_error")[:2])
    # The spread of 100 repeats is known to 7 %: 4 of those.
    assert np.mean(errors, axis=0) == pytest.approx(np.std(shares, axis=0), rel=0.28)


def test_residence_before_a_hop_is_that_of_the_colloid_left_in_the_direction_of_the_hop() -> None:
    about, centers = hexagonal()
    chosen = np.random.default_rng(7).integers(0, 6, (500, 20))
    table = walk(about, centers, SIX, chosen)
    stay = np.concatenate([0.1 + 0.1 * chosen, np.full((500, 1), 0.9)], axis=1).ravel()  # longer before turning left
    end = table.schema.get_field_index("end_time")
    about_time = column(table, "start_time") + stay
    table = table.set_column(end, table.schema.field(end), pa.array(about_time))
    hops = hop_table(table, synthetic.colloids(about, centers))
    found = binned_mean(
        column(hops, "residence"), against=(column(hops, "azimuth") + 0.5 * SIXTH) % (2.0 * math.pi),
        edges=np.arange(7) * SIXTH, swimmer=column(hops, "swimmer"),
    )  # fmt: skip
    assert found.mean == pytest.approx(0.1 + 0.1 * np.arange(6), rel=1e-9)


def test_hops_in_three_dimensions_have_no_signed_angle_and_an_empty_table_no_hops() -> None:
    about = synthetic.info(box=(SPACING,) * 3)
    centers = np.zeros((1, 3))
    colloids = synthetic.colloids(about, centers)
    hops = hop_table(walk(about, centers, SPACING * np.eye(3), np.array([[0, 2, 2, 1]])), colloids)
    assert hops.column("signed_turning_angle").null_count == 4
    assert column(hops, "turning_angle")[1:] == pytest.approx([math.pi / 2, 0.0, math.pi / 2], abs=1e-12)
    assert column(hops, "polar_angle") == pytest.approx([math.pi / 2, 0.0, 0.0, math.pi / 2], abs=1e-12)
    assert hop_network(hops).column("standard_error").null_count == 3  # a single swimmer
    nothing = hop_table(synthetic.encounters(about, swimmer=np.zeros(0, np.int32)), colloids)
    network = hop_network(nothing)
    assert (len(nothing), len(network), len(hop_counts(nothing))) == (0, 0, 0)
    assert hop_symmetry(network).degrees_of_freedom == 0
    assert column(hop_degrees(network, colloids), "out_degree").tolist() == [0]


def test_a_million_hops_take_seconds() -> None:
    about, centers = hexagonal()
    table = synthetic.random_moves(np.random.default_rng(8), n_swimmers=20_000, n_rows=1_000_000, last_time=100.0)
    start = time.perf_counter()
    hops = hop_table(table, synthetic.colloids(about, centers))
    hop_symmetry(hop_network(hops))
    hop_shells(hops)
    assert time.perf_counter() - start < 20.0  # some 4 s on one core
