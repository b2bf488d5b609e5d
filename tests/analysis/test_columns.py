"""Tables that lack what a statistic reads: our own error, with the function, the column and what is needed."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np
import pyarrow as pa
import pytest

import porous_swim as ps
from porous_swim.core.errors import ResultsError
from porous_swim.results.encounter_table import Encounters
from porous_swim.results.tables import TIMESERIES_SCHEMA, make_table
from tests.support import synthetic

an = ps.analysis
BOX = (20.0, 10.0, 0.0)
N_SWIMMERS, N_FRAMES = 25, 41


def is_table(annotation: str) -> bool:
    return "pa.Table" in annotation


def functions() -> dict[str, Callable]:
    """Every public statistic that takes a table, found by its signature."""
    public = {name: getattr(an, name) for name in an.__all__ if inspect.isfunction(getattr(an, name))}
    return {
        name: function for name, function in public.items()
        if any(is_table(str(each.annotation)) for each in inspect.signature(function).parameters.values())
    }  # fmt: skip


@cache
def tables() -> dict[str, pa.Table]:
    """One of each kind, by the name of the parameter that takes it."""
    rng = np.random.default_rng(1)
    about = synthetic.info(n_swimmers=N_SWIMMERS, last_time=40.0, dimensions=2, box=BOX)
    clock = np.arange(float(N_FRAMES))
    way = np.cumsum(rng.normal(size=(N_FRAMES, N_SWIMMERS, 3)), axis=0)
    to = rng.normal(size=way.shape)
    to /= np.linalg.norm(to, axis=2, keepdims=True)
    swimmer = np.repeat(np.arange(N_SWIMMERS), 4)
    start = np.tile(10.0 * np.arange(4.0), N_SWIMMERS)
    numbers = {
        name: rng.normal(size=len(swimmer)) for name in
        ("entry_x", "entry_y", "exit_x", "exit_y", "entry_ex", "entry_ey", "exit_ex", "exit_ey", "signed_winding",
         "release_pitch", "exit_pitch")
    }  # fmt: skip
    encounters = synthetic.encounters(
        about, swimmer=swimmer, start_time=start, end_time=start + rng.uniform(1.0, 9.0, len(swimmer)),
        escape_pitch_time=start + 0.5, colloid=rng.integers(0, 2, len(swimmer)),
        winding=rng.uniform(0.0, 0.4, len(swimmer)), **numbers,
    )  # fmt: skip
    colloids = synthetic.colloids(about, np.array([[0.0, 0.0, 0.0], [10.0, 0.0, 0.0]]))
    series = {field.name: np.zeros(2) for field in TIMESERIES_SCHEMA} | {"time": np.array([0.0, 40.0])}
    hops = an.hop_table(encounters, colloids)
    return {
        "encounters": encounters, "colloids": colloids, "trajectory": synthetic.trajectory(about, clock, way, to),
        "lags": synthetic.lags(about, clock, way, to),
        "timeseries": make_table(TIMESERIES_SCHEMA, series, info=about),
        "hops": hops, "table": hops, "network": an.hop_network(hops),
    }  # fmt: skip


OTHERS: dict[str, Any] = {  # arguments that are no tables
    "time": np.array([1.0, 2.0]), "name": "swimmer", "persistence_time": 1.0, "lag": 1.0, "distance": 1.0,
    "direction": (1.0, 0.0, 0.0), "heights": np.array([0.0, 50.0]), "box": BOX,
}  # fmt: skip


def arguments(function: Callable) -> dict[str, Any]:
    """A call that works."""
    parameters = inspect.signature(function).parameters.values()
    given: dict[str, Any] = {}
    for each in parameters:
        if is_table(str(each.annotation)):
            given[each.name] = tables()[each.name]
        elif each.name == "hopped":
            given[each.name] = an.hops(tables()["encounters"])
        elif each.default is inspect.Parameter.empty:
            given[each.name] = OTHERS[each.name]
    return given


CASES = [
    (name, parameter)
    for name, function in functions().items()
    for parameter, each in inspect.signature(function).parameters.items()
    if is_table(str(each.annotation))
]


def test_the_statistics_that_take_tables_are_found() -> None:
    assert {"residence_times", "msd", "hop_degrees", "summarize", "winding", "by_column"} <= set(functions())
    assert len(CASES) > 55


@pytest.mark.parametrize("name", functions())
def test_a_whole_table_is_taken(name: str) -> None:
    function = functions()[name]
    function(**arguments(function))


@pytest.mark.parametrize(("name", "parameter"), CASES)
def test_without_a_column_a_function_works_or_names_itself_and_the_column(name: str, parameter: str) -> None:
    function, refused = functions()[name], set()
    given = arguments(function)
    for column in given[parameter].column_names:
        try:
            function(**{**given, parameter: given[parameter].drop_columns([column])})
        except ResultsError as error:
            assert str(error).startswith(f"{name}: {parameter}: the table lacks {column}; needed ")  # noqa: PT017
            refused.add(column)
    assert refused == set(getattr(function, "needs", {"table": ("swimmer",)})[parameter])
    assert refused


@pytest.mark.parametrize("wrong", ["encounters", "colloids", "trajectory", "lags", "hops", "network"])
@pytest.mark.parametrize(("name", "parameter"), CASES)
def test_a_table_of_another_kind_is_refused_unless_it_has_the_columns(name: str, parameter: str, wrong: str) -> None:
    function = functions()[name]
    given, other = arguments(function), tables()[wrong]
    needed = getattr(function, "needs", {"table": ("swimmer",)})[parameter]
    if set(needed) <= set(other.column_names):
        return
    with pytest.raises(ResultsError, match=f"^{name}: {parameter}: the table lacks .*needed "):
        function(**{**given, parameter: other})


@pytest.mark.parametrize("wrong", [{"swimmer": [0]}, np.zeros(3), 5, "runs/crystal"])
@pytest.mark.parametrize(("name", "parameter"), CASES)
def test_what_is_no_table_is_refused(name: str, parameter: str, wrong: object) -> None:
    function = functions()[name]
    with pytest.raises(ResultsError, match=f"^{name}: {parameter}: found {type(wrong).__name__}, which is no pyarrow"):
        function(**{**arguments(function), parameter: wrong})


def test_a_column_of_text_is_refused() -> None:
    table = tables()["trajectory"]
    text = table.set_column(table.column_names.index("x"), "x", pa.array(["1.0"] * len(table)))
    with pytest.raises(ResultsError, match=r"^msd: trajectory: found string in the column x; needed "):
        an.msd(text)


def test_encounters_of_a_file_are_refused_as_a_table_is() -> None:
    part = tables()["encounters"].drop_columns(["end_time"])
    with pytest.raises(ResultsError, match=r"^residence_times: encounters: the table lacks end_time; needed are "):
        an.residence_times(Encounters.in_memory(part))


def test_the_error_says_what_a_function_needs() -> None:
    with pytest.raises(ResultsError) as error:
        an.departures(tables()["trajectory"])
    assert str(error.value) == (
        "departures: encounters: the table lacks end_censored, release_pitch, exit_pitch; needed are the columns "
        "swimmer, end_censored, release_pitch, exit_pitch"
    )
