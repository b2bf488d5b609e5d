"""Section: how long swimmers stay at colloids: survival, fits, theory."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from porous_swim import analysis
from porous_swim.analysis import LifetimeFit, Lifetimes
from porous_swim.plots import survival
from porous_swim.plots.style import Shown
from porous_swim.reporting.lifetime_tables import ABOUT_LAWS, FEWEST_ENDS, fits_of, table_by_radius, table_of_fits
from porous_swim.reporting.numbers import counted
from porous_swim.reporting.run import Run, scales_of
from porous_swim.reporting.section import Section
from porous_swim.reporting.trapping import trapping

_LONGEST_LAW = 12.0  # means; the axis ends before
_LEAST = 1e-5  # probability that is drawn


def section(runs: Sequence[Run]) -> Section:
    """Residence times, times to the escape pitch, and times between encounters."""
    panels: dict[str, list[Shown[survival.Survival]]] = {}
    missing, text, fitted, warnings = [], [], [], []
    for run in runs:
        encounters = run.encounters
        if len(encounters) == 0:
            missing.append(run.says("No swimmer met a colloid: there are no residence times."))
            continue
        stays, passages = analysis.residence_lifetimes(encounters), analysis.escape_pitch_lifetimes(encounters)
        fits, theory = fits_of(stays), trapping(run, passages)
        fitted.append((run, stays, fits))
        text.append(run.says(theory.sentence))
        warnings += [run.says(each) for each in theory.warnings]
        if not fits:
            missing.append(run.says(_too_few(stays)))
        for name, lifetimes, data in (
            ("residence time", stays, {"laws": _curves(fits)}),
            ("time to the escape pitch", passages, {"theory": theory.curve, "theory_holds": not theory.warnings}),
            ("time between encounters", analysis.flight_lifetimes(encounters), {}),
        ):
            seen = lifetimes.select(lifetimes.start_seen)
            if np.any(seen.ended):
                panels.setdefault(name, []).append(run.shows(survival.Survival(seen.survival(), **data)))
    tables = table_of_fits(fitted)
    return Section(
        "Residence", "residence",
        text=[*text, ABOUT_LAWS] if tables else text,
        draw=(lambda: survival.draw(panels, scales_of(runs))) if panels else None,
        caption="Survival: the share that lasts longer than a time (Kaplan-Meier, which takes those that the run cut "
        "off into account). Dashed and dotted: the exponential and the inverse Gaussian that fit best.",
        tables=[*tables, *table_by_radius(runs)],
        missing=missing,
        warnings=warnings,
    )  # fmt: skip


def _too_few(stays: Lifetimes) -> str:
    n, cut = int(np.count_nonzero(stays.ended)), int(np.count_nonzero(~stays.ended))
    return f"{counted(n, 'encounter')} ended, {cut} cut off by the run: too few ends to fit a law ({FEWEST_ENDS})."


def _curves(fits: Sequence[LifetimeFit]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Those of the laws of all lengths."""
    curves = {}
    for fit in fits:
        if fit.cutoff == 0.0 and np.all(np.isfinite(fit.coordinates)):
            time = np.linspace(0.0, _LONGEST_LAW * fit.parameters["mean"].value, 400)
            value = fit.survival(time)
            curves[survival.LAW_NAMES[fit.law]] = time[value > _LEAST], value[value > _LEAST]
    return curves
