"""What is read back of a run must be what a run can leave: one look at metadata, summary and tables, once.

Each table in memory is scanned column by column (about a nanosecond a number); a table of encounters that is too long
for memory part by part, as it is read, so that to load it costs nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pyarrow as pa

from porous_swim.core.errors import ResultsError
from porous_swim.results.results import Results
from porous_swim.results.table_check import LARGEST, Limits, check_table
from porous_swim.results.tables import TableInfo

_LATEST = 1e10  # a/U; ten times the longest run
_DEEPEST = 12  # maps and lists within each other in a summary; a run writes five
_STATISTIC = {"value", "standard_error", "n", "unit"}


def checked(results: Results, folder: Path) -> Results:
    """Return `results`, which were read from `folder`; a `ResultsError` names file and column of what no run writes."""
    check_summary(results.summary, folder / "summary.json")
    others = {name: getattr(results, name) for name in ("colloids", "timeseries", "lags", "trajectory")}
    check_info(results.info, folder / "encounters.parquet")
    for name, table in others.items():
        _check_same(results.info, table, folder / f"{name}.parquet")
    limits = Limits.of(results.info, results.colloids, folder / "colloids.parquet")
    for name, table in others.items():
        check_table(table, limits, folder / f"{name}.parquet")
    path = folder / "encounters.parquet"
    stored = results.stored
    if isinstance(stored.source, pa.Table):
        check_table(stored.source, limits, path)
        return results
    return replace(results, stored=replace(stored, check=lambda part: check_table(part, limits, path)))


def check_info(info: TableInfo, path: Path) -> None:
    """Raise a `ResultsError` where what stands in the metadata of the file `path` is not what a run writes."""
    wanted: dict[str, tuple[bool, str]] = {
        "n_swimmers": (_is_whole(info.n_swimmers) and 0 < info.n_swimmers < 2**31, "a count of swimmers"),
        "dimensions": (_is_whole(info.dimensions) and info.dimensions in (2, 3), "2 or 3"),
        "box": (
            len(info.box) == 3 and all(_is_number(edge, _LATEST) and edge >= 0.0 for edge in info.box),
            "three edges",
        ),
        "first_time": (_is_number(info.first_time, _LATEST), "a time"),
        "last_time": (_is_number(info.last_time, _LATEST), "a time"),
        "time_step": (_is_number(info.time_step, _LATEST) and info.time_step > 0.0, "a length of time"),
        "units": (info.units is None or _are_units(info.units), "length_um and time_s above 0"),
        "provenance": (isinstance(info.provenance, dict), "a map"),
    }
    for key, (good, expected) in wanted.items():
        if not good:
            raise _junk(path, f"metadata: {key}", getattr(info, key), expected)
    if info.last_time < info.first_time:
        raise _junk(path, "metadata: last_time", info.last_time, f"at least first_time, {info.first_time:g}")
    _check_depth(info.provenance, path, "metadata: provenance")


def check_summary(summary: Mapping[str, Any], path: Path) -> None:
    """Raise a `ResultsError` where the summary in the file `path` holds what no run writes."""
    _check_depth(summary, path, "")
    if not isinstance(summary.get("status", ""), str):
        raise _junk(path, "status", summary["status"], "a word")
    warnings = summary.get("warnings", [])
    if not isinstance(warnings, list) or not all(isinstance(sentence, str) for sentence in warnings):
        raise _junk(path, "warnings", warnings, "a list of sentences")
    if not isinstance(summary.get("provenance") or {}, dict):
        raise _junk(path, "provenance", summary["provenance"], "a map")
    for key, value in summary.items():
        _check_statistics(value, path, key)


def _check_statistics(entry: Any, path: Path, key: str) -> None:
    if not isinstance(entry, dict):
        return
    if not set(entry) >= _STATISTIC:
        for inner, value in entry.items():
            if inner in _SETTINGS and not (value is None or _SETTINGS[inner][0](value)):
                raise _junk(path, f"{key}.{inner}", value, f"{_SETTINGS[inner][1]}, or null")
            _check_statistics(value, path, f"{key}.{inner}")
        return
    if not isinstance(entry.get("warning", ""), str):
        raise _junk(path, f"{key}.warning", entry["warning"], "a sentence")
    for name, least in (("value", -math.inf), ("standard_error", 0.0)):
        if not (entry[name] is None or (_is_number(entry[name]) and entry[name] >= least)):
            raise _junk(path, f"{key}.{name}", entry[name], "a number, or null")
    for name in ("n", "n_censored"):
        if not (_is_whole(entry.get(name, 0)) and entry.get(name, 0) >= 0):
            raise _junk(path, f"{key}.{name}", entry[name], "a count")
    if not isinstance(entry["unit"], str):
        raise _junk(path, f"{key}.unit", entry["unit"], "a unit")


def _check_depth(value: Any, path: Path, key: str, depth: int = 0) -> None:
    if depth > _DEEPEST:
        raise ResultsError(f"{path}: {key}: found maps or lists {_DEEPEST} deep; no run writes that")
    inner = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    for each in inner:
        _check_depth(each, path, key or "the summary", depth + 1)


def _check_same(info: TableInfo, table: pa.Table, path: Path) -> None:
    """Each table says how many swimmers there are, and of what run."""
    try:
        own = TableInfo.of(table)
    except ResultsError as error:
        raise ResultsError(f"{path}: {error}") from error
    check_info(own, path)
    for key in ("n_swimmers", "dimensions", "box", "time_step"):
        if getattr(own, key) != getattr(info, key):
            raise _junk(path, f"metadata: {key}", getattr(own, key), f"{getattr(info, key)}, as for the encounters")


def _junk(path: Path, key: str, found: Any, expected: str) -> ResultsError:
    text = repr(found)
    return ResultsError(f"{path}: {key}: found {text[:60]}{'...' * (len(text) > 60)}, expected {expected}")


def _is_whole(value: Any) -> bool:
    return isinstance(value, int) and not isinstance(value, bool)


def _is_number(value: Any, largest: float = LARGEST) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) <= largest


def _are_units(units: Any) -> bool:
    return isinstance(units, dict) and all(
        _is_number(units.get(key)) and units[key] >= 1.0 / LARGEST for key in ("length_um", "time_s")
    )


_SETTINGS: dict[str, tuple[Callable[[Any], bool], str]] = {  # what stands beside statistics
    "horizon": (_is_number, "a time"),
    "window": (
        lambda window: isinstance(window, list) and len(window) == 2 and all(map(_is_number, window)),
        "two lags",
    ),
    "reason": (lambda reason: isinstance(reason, str), "a sentence"),
}
