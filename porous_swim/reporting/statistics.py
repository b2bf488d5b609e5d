"""Section: every statistic of summary.json with its error and counts."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from porous_swim.core.scales import Scales, pretty
from porous_swim.reporting.numbers import NONE, both, cell, physical, statistics
from porous_swim.reporting.run import Run
from porous_swim.reporting.section import Cell, Number, Section, Table

_NAMES: dict[tuple[str, ...], str] = {  # where the path in summary.json does not say it in words
    ("residence", "mean"): "mean residence time",
    ("residence", "restricted_mean"): "mean residence time up to a horizon",
    ("residence", "mean_completed"): "mean residence time of completed encounters (too short)",
    ("escape_pitch_time", "mean"): "mean time to the escape pitch",
    ("escape_pitch_time", "restricted_mean"): "mean time to the escape pitch, up to a horizon",
    ("escape_pitch_time", "mean_completed"): "mean time to the escape pitch where it came (too short)",
    ("winding", "completed"): "winding of completed encounters",
    ("winding", "net"): "net winding of completed encounters",
    ("winding", "rate"): "winding per time in encounters",
    ("winding", "above_one_turn"): "share of completed encounters above one turn",
    ("hops", "rate"): "hop rate per swimmer",
    ("hops", "time"): "hop time",
    ("hops", "length"): "hop length, between centres",
    ("hops", "displacement"): "hop displacement, from exit to entry",
    ("hops", "nearest_share"): "share of hops to a nearest neighbour",
    ("returns", "rate"): "return rate per swimmer",
    ("flights", "mean"): "mean time between encounters",
    ("flights", "restricted_mean"): "mean time between encounters, up to a horizon",
    ("flights", "mean_completed"): "mean time between encounters, completed ones (too short)",
    ("msd", "final"): "mean squared displacement at the end",
    ("diffusivity", "effective"): "effective diffusivity",
    ("fractions", "bound"): "fraction of time bound",
    ("fractions", "contact"): "fraction of time in contact",
    ("fractions", "contact_of_encounters"): "fraction of the time in encounters in contact",
}


def section(runs: Sequence[Run]) -> Section:
    """One row for each statistic; side by side where there are several runs."""
    found = [statistics(run.results.summary) for run in runs]
    table = _single(found[0], runs[0]) if len(runs) == 1 else _several(runs, found)
    return Section(
        "All statistics", "statistics",
        text=[
            "Each value with one standard error, for which the swimmers are the independent samples. n counts what the "
            "value rests on; censored are those of which the run saw only a part. "
            "What to mind stands below the value.",
            *(run.says(f"Averages over time leave out the first {_burn_in(run)}.") for run in runs if _burn_in(run)),
        ],
        tables=[table],
    )  # fmt: skip


def _burn_in(run: Run) -> str:
    burn_in = run.results.info.burn_in
    return f"{both(burn_in, 'a/U', run.scales)} (record.burn_in)" if burn_in else ""


def name_of(path: tuple[str, ...]) -> str:
    """A statistic's name in words."""
    return _NAMES.get(path, ", ".join(part.replace("_", " ") for part in path))


def _single(found: Mapping[tuple[str, ...], Mapping[str, Any]], run: Run) -> Table:
    scales = run.scales
    header = ["statistic", "value", "unit", *(["in the laboratory"] if scales else []), "n", "censored"]
    rows: list[list[Cell]] = []
    for path, entry in found.items():
        row: list[Cell] = [name_of(path), _value(entry, _horizon(run, path)), pretty(entry["unit"])]
        if scales:
            known = entry["value"] is not None
            row.append(physical(entry["value"], entry["standard_error"], entry["unit"], scales) if known else "")
        rows.append([*row, *_counts(entry)])
    return Table(header, rows)


def _several(runs: Sequence[Run], found: Sequence[Mapping[tuple[str, ...], Mapping[str, Any]]]) -> Table:
    compares = len(runs) == 2
    header = ["statistic", "unit", *(run.label for run in runs), *(["difference/standard error"] if compares else [])]
    rows: list[list[Cell]] = []
    for path in dict.fromkeys(path for each in found for path in each):
        entries = [each.get(path) for each in found]
        unit = next(entry["unit"] for entry in entries if entry is not None)
        row: list[Cell] = [name_of(path), pretty(unit)]
        for run, entry in zip(runs, entries, strict=True):
            row.append(NONE if entry is None else _with_counts(entry, run.scales, _horizon(run, path)))
        rows.append([*row, _difference(*entries)] if compares else row)
    return Table(header, rows)


def _value(entry: Mapping[str, Any], note: str) -> Cell:
    return cell(entry["value"], entry["standard_error"], note=note, warning=entry.get("warning"))


def _horizon(run: Run, path: tuple[str, ...]) -> str:
    """Where a restricted mean ends."""
    end = run.results.summary[path[0]].get("horizon") if path[-1] == "restricted_mean" else None
    return "" if end is None else f"up to {both(end, 'a/U', run.scales)}"


def _counts(entry: Mapping[str, Any]) -> list[Cell]:
    return [Number(f"{count:,}", count) for count in (entry["n"], entry.get("n_censored", 0))]


def _with_counts(entry: Mapping[str, Any], scales: Scales | None, end: str) -> Cell:
    if entry["value"] is None:
        return _value(entry, "")
    second = physical(entry["value"], entry["standard_error"], entry["unit"], scales)
    cut = f", {entry['n_censored']:,} censored" if entry.get("n_censored") else ""
    note = "; ".join(part for part in (second, end, f"n = {entry['n']:,}{cut}") if part)
    return _value(entry, note)


def _difference(first: Mapping[str, Any] | None, second: Mapping[str, Any] | None) -> Cell:
    """The second less the first over the error of that."""
    if first is None or second is None or first["value"] is None or second["value"] is None:
        return NONE
    error = math.hypot(first["standard_error"] or 0.0, second["standard_error"] or 0.0)
    if error == 0.0:
        return NONE
    ratio = (second["value"] - first["value"]) / error
    return Number(f"{ratio:+.1f}", ratio)
