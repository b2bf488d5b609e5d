"""The summary of a run: its map for JSON, its warnings, its lines."""

from __future__ import annotations

import json
import time
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

from porous_swim.analysis.summary import summarize, summary_lines, summary_page
from porous_swim.core.scales import Scales, with_physical
from porous_swim.results.tables import TIMESERIES_SCHEMA, TableInfo, make_table
from tests.support import synthetic

STATISTIC = {"value", "standard_error", "n", "n_censored", "unit"}
THREE = np.arange(9.0).reshape(3, 3)  # centres of colloids


def summary_of(
    encounters: pa.Table, *, persistence_time: float = 1.0, n_swimmers: int = 20, alike: bool = False,
    centers: np.ndarray = THREE, radius: float = 1.0, **options: Any,
) -> dict[str, Any]:  # fmt: skip
    about = TableInfo.of(encounters)
    columns = {field.name: np.zeros(1) for field in TIMESERIES_SCHEMA}
    columns |= {
        "time": np.array([about.last_time]),
        "msd": np.array([7.0]),
        "msd_standard_error": np.array([0.5]),
    }
    clock = np.linspace(0.0, about.last_time, 41)
    position = np.cumsum(np.random.default_rng(0).normal(size=(41, n_swimmers, 3)), axis=0)
    position[:, 1:] = position[:, :1] if alike else position[:, 1:]
    directors = np.ones((len(clock), n_swimmers, 3))  # that never turn: only noise says how long they last
    return summarize(
        encounters,
        synthetic.colloids(about, centers, radius=radius),
        make_table(TIMESERIES_SCHEMA, columns, info=about),
        synthetic.lags(about, clock, position, directors),
        persistence_time=persistence_time,
        **options,
    )


def test_a_summary_has_every_group_and_each_statistic_its_five_entries() -> None:
    rng = np.random.default_rng(1)
    found = summary_of(synthetic.random_moves(rng, n_swimmers=20, n_rows=200, last_time=100.0))
    assert set(found) == {
        "residence", "escape_pitch_time", "winding", "hops", "returns", "flights", "msd", "diffusivity",
        "fractions", "burn_in", "warnings",
    }  # fmt: skip
    statistics = [entry for group in found.values() if isinstance(group, dict) for entry in group.values()]
    statistics = [entry for entry in statistics if isinstance(entry, dict)]
    assert len(statistics) == 24
    assert all(set(entry) - {"warning"} == STATISTIC for entry in statistics)
    marked = [entry for entry in statistics if "warning" in entry]
    # nothing timed an escape pitch: there is no mean, and up to the horizon none ended
    passage = found["escape_pitch_time"]
    assert marked == [passage["mean"], passage["restricted_mean"]]
    assert (passage["restricted_mean"]["value"], passage["mean"]["value"]) == (passage["horizon"], None)
    assert passage["restricted_mean"]["standard_error"] is None
    assert found["residence"]["mean"]["n"] == 200
    assert found["fractions"]["contact_of_encounters"]["value"] == np.float64(0.5)
    assert found["msd"]["final"] == {
        "value": 7.0,
        "standard_error": 0.5,
        "n": 20,
        "n_censored": 0,
        "unit": "a^2",
    }
    json.dumps(found, allow_nan=False)


def test_an_empty_run_summarises_to_null_and_is_json() -> None:
    found = summary_of(synthetic.encounters(synthetic.info(n_swimmers=3), swimmer=np.zeros(0, np.int32)))
    json.dumps(found, allow_nan=False)
    assert found["residence"]["mean"]["value"] is None
    assert found["fractions"]["bound"]["value"] == 0.0
    assert found["warnings"] == []


def test_few_escapes_a_short_run_and_missing_passages_are_warned_of() -> None:
    table = synthetic.encounters(
        synthetic.info(n_swimmers=3, last_time=10.0),
        swimmer=[0, 1, 2],
        start_time=[0.0, 0.0, 0.0],
        end_time=[4.0, 10.0, 10.0],
        end_censored=[False, True, True],
    )
    few, short = summary_of(table)["warnings"]
    assert few.startswith("Few encounters ended (1)")
    assert short.startswith("The run (10 a/U) is shorter than the mean residence time (24 a/U)")

    partly = table.set_column(
        table.schema.get_field_index("escape_pitch_time"),
        table.schema.field("escape_pitch_time"),
        pa.array([None, None, 3.0]),
    )
    assert len(summary_of(partly)["warnings"]) == 2  # the one that ended has no passage: none is timed


def test_escape_pitches_not_passed_are_counted_among_the_ended() -> None:
    n = 40
    table = synthetic.encounters(
        synthetic.info(n_swimmers=n, last_time=10.0),
        swimmer=np.arange(n),
        end_time=np.full(n, 4.0),
        escape_pitch_time=np.where(np.arange(n) < 3, np.nan, 2.0),
    )
    assert summary_of(table)["warnings"] == ["In 3 of the 40 encounters that ended the escape pitch was not passed."]


def test_a_run_in_which_all_stay_bound_is_warned_of() -> None:
    table = synthetic.encounters(synthetic.info(), swimmer=[0], end_time=[100.0], end_censored=[True])
    found = summary_of(table)
    assert found["warnings"] == [
        "No encounter ended during the run (1 under way): the mean residence time is not known."
    ]


def test_a_diffusivity_from_a_short_run_is_warned_of_after_the_warnings_given() -> None:
    table = synthetic.encounters(synthetic.info(last_time=100.0), swimmer=np.zeros(0, np.int32))
    found = summary_of(table, persistence_time=20.0, warnings=["first"])
    assert found["warnings"][0] == "first"
    assert "shorter than 10 persistence times (20 a/U each)" in found["warnings"][1]
    assert not found["diffusivity"]["reliable"]
    assert found["diffusivity"]["effective"]["value"] is None
    assert found["diffusivity"]["reason"] == found["warnings"][1]


@pytest.mark.parametrize(("n_swimmers", "alike"), [(1, False), (19, False), (20, True), (20, False)])
def test_a_diffusivity_of_few_swimmers_or_of_swimmers_alike_is_refused_as_by_the_report(n_swimmers, alike) -> None:
    found = summary_of(
        synthetic.encounters(synthetic.info(), swimmer=np.zeros(0, np.int32)), n_swimmers=n_swimmers, alike=alike
    )
    effective = found["diffusivity"]["effective"]
    lines = summary_lines(found)
    if n_swimmers == 20 and not alike:
        assert effective["n"] == 20
        assert lines[-1].startswith("effective diffusivity")
        return
    assert (effective["value"], effective["standard_error"], effective["n"]) == (None, None, 0)
    assert not any(line.startswith("effective diffusivity") for line in lines)
    assert f"needs 20 swimmers whose trajectories differ, of {n_swimmers} here" in lines[-1]


def rates_of(found: dict[str, Any]) -> dict[str, tuple[float | None, int]]:
    """Value and n of what a run at one obstacle may lack."""
    parts = {"hops": found["hops"]["rate"], "returns": found["returns"]["rate"], "winding": found["winding"]["rate"]}
    return {name: (entry["value"], entry["n"]) for name, entry in parts.items()}


def one_return(box: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> pa.Table:
    """One swimmer, twice at the same colloid in 10 a/U, half a turn in each of 2 a/U."""
    about = synthetic.info(last_time=10.0, box=box)
    return synthetic.encounters(
        about, swimmer=[0, 0], start_time=[0.0, 5.0], end_time=[2.0, 7.0], winding=[0.5, 0.5]
    )  # fmt: skip


def test_at_a_wall_nobody_hops_or_winds_but_swimmers_return() -> None:
    found = summary_of(one_return(), centers=THREE[:1], radius=np.inf)
    assert rates_of(found) == {"hops": (None, 0), "returns": (0.1, 1), "winding": (None, 0)}
    assert all(entry["value"] is None and entry["n"] == 0 for entry in found["winding"].values())
    lines = summary_lines(found)
    assert not any(line.startswith(("hop rate", "winding")) for line in lines)
    assert any(line.startswith("return rate per swimmer: 0.1 U/a (n = 1)") for line in lines)


def test_around_one_colloid_alone_swimmers_wind_and_have_nowhere_to_hop() -> None:
    found = rates_of(summary_of(one_return(), centers=THREE[:1]))
    assert found == {"hops": (None, 0), "returns": (0.1, 1), "winding": (0.25, 2)}
    repeated = rates_of(summary_of(one_return((10.0, 0.0, 0.0)), centers=THREE[:1]))
    assert repeated["hops"] == (0.0, 0)  # its images are there, and were not reached


def test_in_free_space_there_are_no_rates_of_hops_and_returns() -> None:
    nothing = synthetic.encounters(synthetic.info(), swimmer=np.zeros(0, np.int32))
    found = rates_of(summary_of(nothing, centers=np.zeros((0, 3))))
    assert found == {"hops": (None, 0), "returns": (None, 0), "winding": (None, 0)}


def test_lines_round_to_two_digits_of_the_error_and_leave_out_what_is_unknown() -> None:
    found = summary_of(synthetic.encounters(synthetic.info(), swimmer=np.zeros(0, np.int32)), warnings=["beware"])
    found["residence"]["mean"] = {
        "value": 39.41472, "standard_error": 0.14119, "n": 54973, "n_censored": 7293, "unit": "a/U"
    }  # fmt: skip
    found["hops"]["rate"] = {
        "value": 55410.2, "standard_error": 140.3, "n": 12, "n_censored": 0, "unit": "U/a"
    }  # fmt: skip
    lines = summary_lines(found)
    assert lines[0] == "residence time: 39.41 ± 0.14 a/U (n = 54973, 7293 censored)"
    assert "hop rate per swimmer: 55410 ± 140 U/a (n = 12)" in lines
    assert not any(line.startswith("hop time") for line in lines)
    assert lines[-1] == "warning: beware"


def test_a_scene_with_units_tells_each_statistic_in_them_too() -> None:
    # a = 2 um, U = 4 um/s: a/U = 0.5 s, a^2 = 4 um^2, a U = 8 um^2/s, U/a = 2 1/s
    found = with_physical(summary_of(synthetic.random_moves(np.random.default_rng(1), n_swimmers=20, n_rows=200,
                                                            last_time=100.0)), Scales(2.0, 0.5))  # fmt: skip
    factors = {
        ("residence", "mean"): (0.5, "s"), ("hops", "length"): (2.0, "um"), ("hops", "rate"): (2.0, "1/s"),
        ("msd", "final"): (4.0, "um^2"), ("diffusivity", "effective"): (8.0, "um^2/s"),
        ("winding", "rate"): (2.0, "turns/s"),
    }  # fmt: skip
    for (group, name), (factor, unit) in factors.items():
        entry = found[group][name]
        assert set(entry) == STATISTIC | {"physical"}
        numbers = [entry["physical"][key] for key in ("value", "standard_error")]
        assert numbers == pytest.approx([entry[key] * factor for key in ("value", "standard_error")], rel=1e-14)
        assert entry["physical"]["unit"] == unit
    assert "physical" not in found["fractions"]["bound"]
    assert "physical" not in found["winding"]["completed"]
    json.dumps(found, allow_nan=False)


def test_lines_of_a_scene_with_units_begin_with_them() -> None:
    found = summary_of(synthetic.encounters(synthetic.info(), swimmer=np.zeros(0, np.int32)))
    found["residence"]["mean"] = {
        "value": 39.41472, "standard_error": 0.14119, "n": 54973, "n_censored": 7293, "unit": "a/U"
    }  # fmt: skip
    lines = summary_lines(with_physical(found, Scales(1.0, 0.2)))
    assert lines[0] == "residence time: 7.883 ± 0.028 s = 39.41 ± 0.14 a/U (n = 54973, 7293 censored)"
    assert any(line.startswith("mean squared displacement at the end: 7.00 ± 0.50 µm² = ") for line in lines)


def test_the_page_of_a_scene_with_units_is_in_them_alone() -> None:
    found = summary_of(synthetic.encounters(synthetic.info(), swimmer=np.zeros(0, np.int32)))
    assert "| mean squared displacement at the end | 7.00 ± 0.50 a² (n = 1) |" in summary_page(found)
    page = summary_page(with_physical(found, Scales(2.0, 0.5)))
    assert "| mean squared displacement at the end | 28.0 ± 2.0 µm² (n = 1) |" in page
    assert "a²" not in page


def test_a_summary_of_a_million_encounters_takes_seconds() -> None:
    rng = np.random.default_rng(2)
    table = synthetic.random_moves(rng, n_swimmers=100_000, n_rows=1_000_000, last_time=100.0)
    start = time.perf_counter()
    summary_of(table)
    assert time.perf_counter() - start < 20.0  # some 5 s on one core; a loop over swimmers takes minutes


def test_an_error_above_ten_is_no_power_of_ten() -> None:
    found = summary_of(synthetic.encounters(synthetic.info(), swimmer=np.zeros(0, np.int32)))
    found["residence"]["mean"] = {
        "value": 147.3, "standard_error": 183.2, "n": 2, "n_censored": 18, "unit": "a/U"
    }  # fmt: skip
    assert summary_lines(found)[0] == "residence time: 150 ± 180 a/U (n = 2, 18 censored)"


def test_a_slope_below_zero_of_swimmers_that_come_back_is_no_diffusivity() -> None:
    rng = np.random.default_rng(3)
    clock = np.linspace(0.0, 40.0, 41)
    about = synthetic.info(n_swimmers=30, last_time=40.0)
    angle = 2.0 * np.pi * clock / 39.0 + rng.uniform(0.0, 6.0, 30)[:, None]
    circle = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1).swapaxes(0, 1)
    position = circle * (1.0 + 0.1 * rng.random(30))[:, None] + 1e-3 * rng.normal(size=circle.shape)
    columns = {field.name: np.zeros(1) for field in TIMESERIES_SCHEMA}
    found = summarize(
        synthetic.encounters(about, swimmer=np.zeros(0, np.int32)), synthetic.colloids(about, THREE),
        make_table(TIMESERIES_SCHEMA, columns, info=about), synthetic.lags(about, clock, position, position),
        persistence_time=10.0,
    )  # fmt: skip
    assert found["diffusivity"]["effective"]["value"] is None
    assert "There is no effective diffusivity" in found["warnings"][-1]
