"""Tables of residence times: laws fitted to them, and means by radius of the colloids."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from porous_swim import analysis
from porous_swim.analysis import LifetimeFit, Lifetimes
from porous_swim.analysis.summary import ENDS_WANTED
from porous_swim.plots.survival import LAW_NAMES
from porous_swim.reporting.numbers import both, interval, value_and_error
from porous_swim.reporting.run import Run
from porous_swim.reporting.section import Cell, Number, Table

FEWEST_ENDS = 10  # to fit laws of two parameters, and again half of them
MOST_TESTED = 5000  # lengths: drawing more and fitting them a hundred times takes too long
N_REPEATS = 99
MOST_RADII = 60  # of a table; where every colloid has a radius of its own, single ones say little
ABOUT_LAWS = (
    "Laws are fitted to the encounters, and to their tail above the median of the completed ones; errors are over "
    "swimmers. Within each of the two, the law of the least AIC is nearest to the data. p is the share of samples "
    f"drawn from the law that lie as far from their fit (of {N_REPEATS} drawn, for up to {MOST_TESTED:,} encounters)."
)


def fits_of(residence: Lifetimes) -> list[LifetimeFit]:
    """Laws of all lengths, and of the tail above the median of the completed ones; none where too few ended."""
    seen = residence.select(residence.start_seen)
    if np.count_nonzero(seen.ended) < FEWEST_ENDS:
        return []
    median = float(np.median(seen.length[seen.ended]))
    fits = [analysis.fit_lifetimes(seen, law) for law in ("exponential", "inverse_gaussian")]
    if median > 0.0 and np.count_nonzero(seen.ended & (seen.length > median)) >= FEWEST_ENDS // 2:
        fits += [analysis.fit_lifetimes(seen, law, cutoff=median) for law in ("exponential", "power_law")]
    return fits


def table_of_fits(found: Sequence[tuple[Run, Lifetimes, Sequence[LifetimeFit]]]) -> list[Table]:
    """A row for each parameter; no table where there is no fit."""
    rows = [row for run, lifetimes, fits in found for fit in fits for row in _rows(run, lifetimes, fit)]
    header = ["law", "above", "parameter", "value", "95 % interval", "AIC", "p", "ends", "censored"]
    several = any(run.n_runs > 1 for run, _, _ in found)
    return [Table(["run", *header] if several else header, rows, "Fits by maximum likelihood")] if rows else []


def _rows(run: Run, lifetimes: Lifetimes, fit: LifetimeFit) -> list[list[Cell]]:
    tested = len(lifetimes) <= MOST_TESTED
    p = analysis.goodness_of_fit(lifetimes, fit, n_repeats=N_REPEATS).p_value if tested else np.nan
    above = both(fit.cutoff, "a/U", run.scales) if fit.cutoff else "0"
    rows: list[list[Cell]] = []
    for name, found in fit.parameters.items():
        value = Number(both(found.value, found.unit, run.scales, error=found.standard_error), found.value)
        rows.append(
            [
                *([run.label] if run.n_runs > 1 else []),
                LAW_NAMES[fit.law], above, name, value, interval(*found.interval, found.unit, run.scales),
                Number(value_and_error(fit.aic, None, digits=6), fit.aic), value_and_error(p, None, digits=2),
                f"{fit.n:,}", f"{fit.n_censored:,}",
            ]
        )  # fmt: skip
    return rows


def table_by_radius(runs: Sequence[Run]) -> list[Table]:
    """Mean residence and winding for each radius that was met; no table where there is one radius, or too many."""
    rows: list[list[Cell]] = []
    for run in runs:
        parts = analysis.by_radius(run.encounters, run.results.colloids)
        for radius, part in parts.items() if 1 < len(parts) <= MOST_RADII else ():
            times, turns = analysis.residence_times(part), analysis.winding(part)
            few = f"few ends were seen ({times.n}; {ENDS_WANTED} are wanted)." if times.n < ENDS_WANTED else ""
            rows.append(
                [
                    run.label, both(radius, "a", run.scales),
                    Number(both(times.mean, "a/U", run.scales, error=times.standard_error), times.mean, warning=few),
                    value_and_error(turns.completed.value, turns.completed.standard_error),
                    f"{times.n:,}", f"{times.n_censored:,}",
                ]
            )  # fmt: skip
    header = ["run", "radius", "mean residence time", "winding of completed encounters", "ends", "censored"]
    return [Table(header, rows, "By radius of the colloid")] if rows else []
