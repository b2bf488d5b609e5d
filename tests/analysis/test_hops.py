"""Hops, returns and flights on tables with known answers."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pyarrow as pa
import pytest

from porous_swim.analysis.columns import column
from porous_swim.analysis.hopping.hops import flights, hop_lengths, hop_statistics, hops, moves, returns
from tests.support import synthetic

BOX = (10.0, 0.0, 0.0)
CENTERS = np.array([[0.5, 0.0, 0.0], [4.5, 0.0, 0.0], [9.0, 3.0, 0.0]])


def five_encounters() -> pa.Table:
    """Swimmer 0: colloid 0, 1, back in 1, image 1 of colloid 1, under way; swimmer 2: one encounter."""
    about = synthetic.info(n_swimmers=4, last_time=50.0, box=BOX)
    return synthetic.encounters(
        about,
        swimmer=[2, 0, 0, 0, 0],
        start_time=[3.0, 10.0, 0.0, 40.0, 20.0],
        end_time=[7.0, 16.0, 10.0, 50.0, 30.0],
        end_censored=[False, False, False, True, False],
        colloid=[0, 1, 0, 1, 1],
        image_x=[0, 0, 0, 1, 0],
        entry_x=[0.0, 5.0, 0.0, 13.0, 0.0],
        exit_x=[0.0, 0.0, 2.0, 0.0, 6.0],
    )


def test_moves_are_hops_and_returns_in_order_of_time() -> None:
    every = moves(five_encounters())
    assert every.swimmer.tolist() == [0, 0, 0]
    assert every.from_colloid.tolist() == [0, 1, 1]
    assert every.to_colloid.tolist() == [1, 1, 1]
    assert every.time.tolist() == [0.0, 4.0, 10.0]  # the first is a direct hop
    assert every.displacement[:, 0].tolist() == [3.0, 0.0, 7.0]
    assert returns(five_encounters()).start_time.tolist() == [20.0]


def test_a_move_to_another_image_of_the_same_colloid_is_a_hop() -> None:
    hopped = hops(five_encounters())
    assert hopped.to_image[:, 0].tolist() == [0, 1]
    table = synthetic.colloids(synthetic.info(box=BOX), CENTERS)
    assert hop_lengths(hopped, table, box=BOX).tolist() == [4.0, 10.0]


def test_hop_statistics_of_five_encounters_are_those_worked_by_hand() -> None:
    found = hop_statistics(five_encounters(), synthetic.colloids(synthetic.info(box=BOX), CENTERS))
    assert found.hop_rate.value == pytest.approx(2.0 / (4 * 50.0), rel=1e-14)
    # One swimmer of four made both hops: standard error of the mean of (2, 0, 0, 0)/50.
    assert found.hop_rate.standard_error == pytest.approx(np.std([2, 0, 0, 0], ddof=1) / 100.0, rel=1e-12)
    assert found.return_rate.value == pytest.approx(1.0 / 200.0, rel=1e-14)
    assert found.time.value == 5.0
    assert found.length.value == 7.0
    assert found.displacement.value == 5.0
    # Distances are 3.35 (0 to 2's image), 4 (0 to 1), 5.4, 6.3, 9, ...: the gap after 4 is wider than half of 4 - 3.35,
    # and all have a neighbour by then. One hop is to colloid 1, the other one box edge long.
    assert found.nearest_share.as_dict()["value"] == 0.5


def test_a_hop_across_the_border_to_the_neighbour_counts_as_nearest() -> None:
    about = synthetic.info(last_time=9.0, box=BOX)
    table = synthetic.encounters(
        about, swimmer=[0, 0], start_time=[0.0, 5.0], end_time=[2.0, 9.0], colloid=[0, 2], image_x=[0, -1]
    )
    found = hop_statistics(table, synthetic.colloids(about, CENTERS))
    assert found.length.value == pytest.approx(np.hypot(1.5, 3.0), rel=1e-14)
    assert found.nearest_share.value == 1.0


def test_the_only_colloid_of_a_box_has_its_own_image_as_nearest() -> None:
    about = synthetic.info(last_time=9.0, box=BOX)
    table = synthetic.encounters(about, swimmer=[0, 0], start_time=[0.0, 5.0], end_time=[2.0, 9.0], image_x=[0, 1])
    assert hop_statistics(table, synthetic.colloids(about, CENTERS[:1])).nearest_share.value == 1.0


@pytest.mark.parametrize("seed", range(20))
def test_encounters_are_hops_returns_and_first_ones(seed: int) -> None:
    rng = np.random.default_rng(seed)
    n_swimmers, n_rows = int(rng.integers(1, 40)), int(rng.integers(1, 300))
    table = synthetic.random_moves(rng, n_swimmers=n_swimmers, n_rows=n_rows, last_time=100.0)
    swimmer = column(table, "swimmer")
    hopped, returned = hops(table), returns(table)
    assert len(table) == len(hopped) + len(returned) + len(np.unique(swimmer))
    assert np.all(moves(table).time > 0.0)  # the table has gaps between all encounters of a swimmer
    # By brute force: each swimmer's places one after another.
    n_hops = 0
    for number in np.unique(swimmer):
        rows = np.flatnonzero(swimmer == number)
        rows = rows[np.argsort(column(table, "start_time")[rows])]
        places = [(column(table, "colloid")[row], column(table, "image_x")[row]) for row in rows]
        n_hops += sum(a != b for a, b in pairwise(places))
    assert len(hopped) == n_hops


def test_flights_end_at_the_next_encounter_or_are_cut_by_the_end_of_the_run() -> None:
    found = flights(five_encounters())
    # Swimmer 0: 0, 4 and 10; swimmer 2 leaves at 7 and is free until 50.
    assert (found.n, found.n_censored) == (3, 1)
    assert found.mean == pytest.approx((0.0 + 4.0 + 10.0 + 43.0) / 3.0, rel=1e-14)
    assert found.mean_completed == pytest.approx(14.0 / 3.0, rel=1e-14)


def test_exponential_flights_cut_by_a_short_run_are_recovered() -> None:
    rng = np.random.default_rng(11)
    n, mean, last_time = 5000, 8.0, 10.0
    flight = rng.exponential(mean, n)
    back = flight < last_time - 1.0
    about = synthetic.info(n_swimmers=n, last_time=last_time)
    number = np.arange(n)
    table = synthetic.encounters(
        about,
        swimmer=np.concatenate([number, number[back]]),
        start_time=np.concatenate([np.zeros(n), 1.0 + flight[back]]),
        end_time=np.concatenate([np.ones(n), np.full(back.sum(), last_time)]),
        end_censored=np.concatenate([np.zeros(n, bool), np.ones(back.sum(), bool)]),
    )
    found = flights(table)
    assert abs(found.mean - mean) < 4.0 * found.standard_error
    assert found.standard_error < 0.03 * mean
    assert found.mean_completed < 0.6 * mean


def test_a_table_without_moves_has_no_values() -> None:
    about = synthetic.info(n_swimmers=2)
    found = hop_statistics(
        synthetic.encounters(about, swimmer=np.zeros(0, np.int32)),
        synthetic.colloids(about, np.zeros((0, 3))),
    )
    assert found.time.as_dict()["value"] is None
    assert (found.hop_rate.as_dict()["value"], found.hop_rate.n) == (None, 0)  # nowhere to hop
