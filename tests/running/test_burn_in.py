"""What statistics of a steady state leave out at the start of a run (`record.burn_in`), and what they keep."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pytest

import porous_swim as ps
from porous_swim.results.tables import TableInfo
from tests.support import synthetic, walks
from tests.support.commands import SMALL

an = ps.analysis
THREE = np.array([[0.0, 0.0, 0.0], [5.0, 0.0, 0.0], [9.0, 0.0, 0.0]])


def with_burn_in(table: pa.Table, burn_in: float) -> pa.Table:
    return replace(TableInfo.of(table), burn_in=burn_in).attach(table)


def two_swimmers() -> pa.Table:
    """In 20 a/U: one bound from 0 to 2, 4 to 8 and 10 to the end, and one from 1 to 3 alone; contact half of the time.

    The first hops at 4 and returns at 10.
    """
    return synthetic.encounters(
        synthetic.info(n_swimmers=2, last_time=20.0),
        swimmer=[0, 0, 0, 1], colloid=[0, 1, 1, 2], start_time=[0.0, 4.0, 10.0, 1.0], end_time=[2.0, 8.0, 20.0, 3.0],
        end_censored=[False, False, True, False], contact_time=[1.0, 2.0, 5.0, 1.0],
    )  # fmt: skip


def test_fractions_and_rates_are_those_after_the_burn_in() -> None:
    every, late = two_swimmers(), with_burn_in(two_swimmers(), 5.0)
    colloids = synthetic.colloids(TableInfo.of(every), THREE)
    # bound from 5 to 8 and from 10 to 20, of 15 a/U of two swimmers; half of it in contact
    assert an.bound_fraction(every).value == pytest.approx(18.0 / 40.0, rel=1e-14)
    assert an.bound_fraction(late).value == pytest.approx(13.0 / 30.0, rel=1e-14)
    assert an.contact_fraction(late).value == pytest.approx(6.5 / 30.0, rel=1e-14)
    of_encounters = an.contact_fraction_of_encounters(late)
    assert (of_encounters.value, of_encounters.n, of_encounters.n_censored) == (pytest.approx(0.5, rel=1e-14), 2, 1)
    before, after = an.hop_statistics(every, colloids), an.hop_statistics(late, colloids)
    assert (before.hop_rate.value, before.return_rate.value) == (1.0 / 40.0, 1.0 / 40.0)
    assert (after.hop_rate.value, after.return_rate.value) == (0.0, pytest.approx(1.0 / 30.0, rel=1e-14))
    assert after.time == before.time  # of single hops, all of them


def test_statistics_of_single_encounters_keep_all() -> None:
    every, late = two_swimmers(), with_burn_in(two_swimmers(), 5.0)
    colloids = synthetic.colloids(TableInfo.of(every), THREE)
    for statistic in (an.residence_times, an.flights, lambda table: an.winding(table, colloids)):
        assert str(statistic(late)) == str(statistic(every))  # NaN and all


def test_tracks_and_densities_begin_after_the_burn_in() -> None:
    table = walks.brownian(np.random.default_rng(1), n_swimmers=3, n_frames=21, dimensions=2, diffusivity=0.5)
    late = with_burn_in(table, 7.0)
    alone = table.filter(pc.greater_equal(table["time"], 7.0))
    for statistic in (an.time_averaged_msd, an.straightness, an.time_averaged_director_correlation):
        np.testing.assert_array_equal(statistic(late).each, statistic(alone).each)
        assert len(statistic(late).lag) < len(statistic(table).lag)
    assert an.cell_density(late, cell=(1.0, 1.0)).n == 3 * 14
    np.testing.assert_array_equal(an.msd(late).value, an.msd(table).value)  # from the release


def test_the_summary_of_a_run_says_what_averages_leave_out(tmp_path) -> None:
    (tmp_path / "small.yaml").write_text(SMALL)
    scene = ps.load_scene(tmp_path / "small.yaml")
    whole, late = ps.run(scene), ps.run(scene.replace({"record.burn_in": 0.35}), out=tmp_path / "run")
    said = "averages over time leave out the first 0.35 a/U (record.burn_in)"
    assert (whole.summary["burn_in"], late.summary["burn_in"]) == (0.0, 0.35)
    assert said in an.summary_lines(late.summary)
    assert said not in an.summary_lines(whole.summary)
    # nothing else of the run has changed, and a folder remembers
    assert late.encounters.equals(whole.encounters, check_metadata=False)
    loaded = ps.load_results(tmp_path / "run")
    assert an.bound_fraction(loaded.encounters).as_dict() == late.summary["fractions"]["bound"]
    assert loaded.summary["fractions"]["bound"] != whole.summary["fractions"]["bound"]


@pytest.mark.parametrize(
    ("burn_in", "message"),
    [
        (1.0, r"record.burn_in: expected less than run.duration \(1\), found 1"),
        (0.0005, "record.burn_in: 0.0005 is not a whole number of steps of 0.001: the nearest is 0.001"),
        (-1.0, "record.burn_in: "),
    ],
)
def test_a_burn_in_that_leaves_nothing_or_parts_of_steps_is_refused(tmp_path, burn_in: float, message: str) -> None:
    (tmp_path / "small.yaml").write_text(SMALL)
    with pytest.raises(ps.SceneError, match=message):
        ps.load_scene(tmp_path / "small.yaml").replace({"record.burn_in": burn_in})
