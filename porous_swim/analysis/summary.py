"""The statistics of a run in one map, for summary.json, and in a few lines for people."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import column, needs
from porous_swim.analysis.estimates import Estimate, value_and_error
from porous_swim.analysis.hopping.hops import MOVES, HopStatistics, flights, hop_statistics
from porous_swim.analysis.lifetimes.residence import (
    bound_fraction,
    contact_fraction,
    contact_fraction_of_encounters,
    escape_pitch_times,
    residence_times,
)
from porous_swim.analysis.lifetimes.survival import WaitingTimes
from porous_swim.analysis.transport.diffusion import EffectiveDiffusivity
from porous_swim.analysis.transport.ensemble import director_memory, ensemble_diffusivity
from porous_swim.analysis.transport.transport import PERSISTENCE_TIMES_WANTED
from porous_swim.analysis.winding import Winding, winding
from porous_swim.core.scales import pretty
from porous_swim.results.encounter_table import Encounters, parts_of
from porous_swim.results.tables import TableInfo

ENDS_WANTED = 30  # below that a jackknife error is itself off by more than some 15 %
_LAGS = "lag n_swimmers msd director_correlation"
_ENCOUNTERS = f"{MOVES} end_censored contact_time winding signed_winding escape_pitch_time"


@needs(
    encounters=_ENCOUNTERS,
    colloids="colloid x y z radius",
    timeseries="time msd msd_standard_error",
    lags=_LAGS,
)
def summarize(
    encounters: pa.Table | Encounters,
    colloids: pa.Table,
    timeseries: pa.Table,
    lags: pa.Table,
    *,
    persistence_time: float,
    warnings: Iterable[str] = (),
) -> dict[str, Any]:
    """Statistics of a run, ready for JSON: each is `{value, standard_error, n, n_censored, unit}`.

    One that is not to be trusted has a `warning` besides, which says why.
    The tables carry their `TableInfo`. `persistence_time` is 1/((dimensions - 1) D_r) in a/U, that of noise alone,
    infinite without noise. `warnings` come first in the list of warnings; what the numbers themselves give rise to
    follows. Where there is no effective diffusivity `reason` says why.
    """
    residence, passage, away = residence_times(encounters), escape_pitch_times(encounters), flights(encounters)
    late, info = ensemble_diffusivity(lags), TableInfo.of(encounters)
    reason = _why_no_diffusivity(late, info, persistence_time, director_memory(lags))
    duration, reasons = info.duration, [] if reason is None else [reason]
    stays = list(_residence_warnings(residence, duration))
    found = [*_lone_warning(timeseries), *stays, *_passage_warnings(encounters), *(reasons if late.n else [])]
    return {
        "residence": _waiting(residence, stays),
        "escape_pitch_time": _waiting(passage, _mean_warnings(passage, duration)),
        "winding": _winding(winding(encounters, colloids)),
        **_moves(hop_statistics(encounters, colloids)),
        "flights": _waiting(away, _mean_warnings(away, duration)),
        "msd": _final_msd(timeseries, TableInfo.of(timeseries)),
        "diffusivity": {
            "effective": _marked(late.estimate() if reason is None else Estimate.none("a U"), reasons),
            "window": list(late.window) if reason is None else None,
            "reliable": reason is None,
            "reason": reason,
        },
        "fractions": {
            "bound": bound_fraction(encounters).as_dict(),
            "contact": contact_fraction(encounters).as_dict(),
            "contact_of_encounters": contact_fraction_of_encounters(encounters).as_dict(),
        },
        "burn_in": info.burn_in,
        "warnings": [*warnings, *found],
    }


def _marked(estimate: Estimate, warnings: Iterable[str]) -> dict[str, Any]:
    """An estimate with why it is not to be trusted, where there is such."""
    return replace(estimate, warning=" ".join(warnings) or None).as_dict()


def _waiting(times: WaitingTimes, warnings: Iterable[str]) -> dict[str, Any]:
    return {
        "mean": _marked(times.estimate(), warnings),
        "restricted_mean": times.restricted_estimate().as_dict(),
        "horizon": times.horizon if math.isfinite(times.horizon) else None,
        "mean_completed": times.completed_estimate().as_dict(),
    }


def _winding(turns: Winding) -> dict[str, Any]:
    return {name: estimate.as_dict() for name, estimate in vars(turns).items()}


def _moves(moves: HopStatistics) -> dict[str, Any]:
    hops = {
        "rate": moves.hop_rate,
        "time": moves.time,
        "length": moves.length,
        "displacement": moves.displacement,
        "nearest_share": moves.nearest_share,
    }
    return {
        "hops": {name: estimate.as_dict() for name, estimate in hops.items()},
        "returns": {"rate": moves.return_rate.as_dict()},
    }


def _final_msd(timeseries: pa.Table, info: TableInfo) -> dict[str, Any]:
    if len(timeseries) == 0:
        return {"final": Estimate.none("a^2").as_dict(), "time": None}
    value, error = (float(column(timeseries, name)[-1]) for name in ("msd", "msd_standard_error"))
    final = Estimate(value, error, info.n_swimmers, 0, "a^2")
    return {"final": final.as_dict(), "time": float(column(timeseries, "time")[-1])}


def _lone_warning(timeseries: pa.Table) -> Iterable[str]:
    if len(timeseries) and np.all(np.isnan(column(timeseries, "msd_standard_error"))):
        yield "One swimmer tells nothing of how far its numbers are off: they have no standard errors."


def _residence_warnings(residence: WaitingTimes, duration: float) -> Iterable[str]:
    n = residence.n + residence.n_censored
    if n and residence.n == 0:
        yield f"No encounter ended during the run ({n} under way): the mean residence time is not known."
    elif 0 < residence.n < ENDS_WANTED:
        yield (
            f"Few encounters ended ({residence.n}): residence times and their errors are rough "
            f"({ENDS_WANTED} or more are wanted)."
        )
    if residence.n and duration < residence.mean:
        yield (
            f"The run ({duration:g} a/U) is shorter than the mean residence time ({residence.mean:.3g} a/U), "
            "which is then an extrapolation: it holds if swimmers escape at a constant rate."
        )


def _mean_warnings(times: WaitingTimes, duration: float) -> Iterable[str]:
    """Of a mean waiting time, as above of the residence."""
    if times.n == 0 < times.n_censored:
        yield f"No end was seen ({times.n_censored} under way or cut off): the mean is not known."
    elif 0 < times.n < ENDS_WANTED:
        yield f"Few ends were seen ({times.n}): the mean and its error are rough ({ENDS_WANTED} or more are wanted)."
    if times.n and duration < times.mean:
        yield (
            f"The run ({duration:g} a/U) is shorter than this mean, which is then an extrapolation: it holds if ends "
            "come at a constant rate."
        )


def _passage_warnings(encounters: pa.Table | Encounters) -> Iterable[str]:
    n = missing = 0
    for part in parts_of(encounters, "end_censored", "escape_pitch_time"):
        ended = ~column(part, "end_censored")
        n += int(np.count_nonzero(ended))
        missing += int(np.count_nonzero(np.isnan(column(part, "escape_pitch_time"))[ended]))
    if 0 < missing < n:  # all missing: the scene times no such pitch
        yield f"In {missing} of the {n} encounters that ended the escape pitch was not passed."


def _why_no_diffusivity(
    late: EffectiveDiffusivity, info: TableInfo, persistence_time: float, memory: float
) -> str | None:
    """What the displacements say, and what noise says where directors do not turn in time to tell."""
    if late.reason is not None or math.isfinite(memory):
        return late.reason
    if math.isinf(persistence_time):
        return (
            "There is no effective diffusivity: swimmers keep their directors all through the run, and there is no "
            "rotational noise."
        )
    if info.steady_duration < PERSISTENCE_TIMES_WANTED * persistence_time:
        return (
            f"There is no effective diffusivity: the run has {info.steady_duration:g} a/U, shorter than "
            f"{PERSISTENCE_TIMES_WANTED:g} persistence times ({persistence_time:.3g} a/U each), and the motion is not "
            "yet diffusive."
        )
    return None


_LINES = (  # (label, where in the summary)
    ("residence time", ("residence", "mean")),
    ("escape-pitch time", ("escape_pitch_time", "mean")),
    ("winding of completed encounters", ("winding", "completed")),
    ("hop rate per swimmer", ("hops", "rate")),
    ("hop time", ("hops", "time")),
    ("hop length", ("hops", "length")),
    ("return rate per swimmer", ("returns", "rate")),
    ("fraction bound", ("fractions", "bound")),
    ("fraction in contact", ("fractions", "contact")),
    ("mean squared displacement at the end", ("msd", "final")),
    ("effective diffusivity", ("diffusivity", "effective")),
)


def summary_lines(summary: Mapping[str, Any]) -> list[str]:
    """The summary for people: each value ± one standard error, its warning below it, and the other warnings."""
    lines, told = [], ""
    for label, (group, name) in _LINES:
        statistic = summary[group][name]
        if statistic["value"] is not None:
            lines.append(f"{label}: {_in_words(statistic)}")
            if (warning := statistic.get("warning")) is not None:
                lines.append(f"  warning: {warning}")
                told += warning
    lines += [] if (start := _steady_from(summary)) is None else [start]
    return [*lines, *(f"warning: {warning}" for warning in summary["warnings"] if warning not in told)]


def summary_page(summary: Mapping[str, Any]) -> str:
    """The same as a table and a list in Markdown, for the recording; in the laboratory's units where it has them."""
    rows = []
    for label, (group, name) in _LINES:
        if summary[group][name]["value"] is not None:
            statistic = summary[group][name]
            shown = {**statistic, **statistic.get("physical", {}), "physical": None}
            warning = statistic.get("warning")
            mark = "" if warning is None else f"; **warning**: {warning}"
            rows.append(f"| {label} | {_in_words(shown)}{mark} |")
    table = "\n".join(["| statistic | value |", "|---|---|", *rows])
    table += "" if (start := _steady_from(summary)) is None else f"\n\n{start}"
    warnings = "\n".join(f"- {warning}" for warning in summary["warnings"])
    return f"{table}\n\n{warnings}" if warnings else table


def _steady_from(summary: Mapping[str, Any]) -> str | None:
    """What averages over time leave out."""
    burn_in = summary.get("burn_in", 0.0)
    return f"averages over time leave out the first {burn_in:g} a/U (record.burn_in)" if burn_in else None


def _in_words(statistic: Mapping[str, Any]) -> str:
    value, error, unit = statistic["value"], statistic["standard_error"], statistic["unit"]
    counts = f"n = {statistic['n']}"
    if statistic["n_censored"]:
        counts += f", {statistic['n_censored']} censored"
    text = f"{value_and_error(value, error, digits=3)} {pretty(unit)}".rstrip()
    if (found := statistic.get("physical")) is not None:  # in a scene with units
        laboratory = value_and_error(found["value"], found["standard_error"], digits=3)
        text = f"{laboratory} {pretty(found['unit'])} = {text}"
    return f"{text} ({counts})"
