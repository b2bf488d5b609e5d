"""Section: how long swimmers stay at colloids: survival, fits, theory."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from porous_swim import analysis
from porous_swim.analysis import LifetimeFit, Lifetimes
from porous_swim.plots import survival
from porous_swim.plots.style import Shown
from porous_swim.reporting.numbers import both, counted, interval
from porous_swim.reporting.run import Run, scales_of
from porous_swim.reporting.section import Number, Section, Table

FEWEST_ENDS = 5  # to fit two parameters
SMALL_PITCH = 0.4  # rad; beyond, the near-wall theory of small pitch is off by more than some per cent
_NAMES = {"exponential": "exponential", "inverse_gaussian": "inverse Gaussian", "power_law": "power law"}
LARGE_COLLOID = 10.0  # contact heights


def section(runs: Sequence[Run]) -> Section:
    """Residence times, times to the escape pitch, and times between encounters."""
    panels: dict[str, list[Shown[survival.Survival]]] = {}
    missing, text, rows = [], [], []
    for run in runs:
        encounters = run.results.encounters
        if len(encounters) == 0:
            missing.append(run.says("No swimmer met a colloid: there are no residence times."))
            continue
        residence = analysis.residence_lifetimes(encounters)
        fits = _fits(residence)
        rows += [row for cutoff, fit in fits for row in _rows(run, fit, cutoff)]
        if not fits:
            missing.append(run.says(_too_few(residence)))
        _add(panels, "residence time", run, residence, laws=_laws([fit for cutoff, fit in fits if not cutoff]))
        theory, why = _theory(run)
        text.append(run.says(why))
        passage = analysis.escape_pitch_lifetimes(encounters)
        _add(panels, "time to the escape pitch", run, passage, theory=theory)
        _add(panels, "time between encounters", run, analysis.flight_lifetimes(encounters))
    panels = {name: shown for name, shown in panels.items() if shown}
    header = ["law", "above", "parameter", "value", "95 % interval", "AIC", "ends", "censored"]
    table = Table(header if len(runs) == 1 else ["run", *header], rows, caption="Fits by maximum likelihood.")
    return Section(
        "Residence", "residence",
        text=[*dict.fromkeys(text), *([_LAWS] if rows else [])],
        draw=(lambda: survival.draw(panels, scales_of(runs))) if panels else None,
        caption="Survival: the share that lasts longer than a time (Kaplan-Meier, which takes those that the run cut "
        "off into account). Dashed and dotted: the exponential and the inverse Gaussian that fit best.",
        tables=[table] if rows else [],
        missing=missing,
    )  # fmt: skip


_LAWS = (
    "Laws are fitted to all encounters, and to the tail above the median of the completed ones; errors are over "
    "swimmers. Within each of the two, the law of the least AIC is nearest to the data."
)


def _too_few(residence: Lifetimes) -> str:
    n, cut = int(np.count_nonzero(residence.ended)), int(np.count_nonzero(~residence.ended))
    return f"{counted(n, 'encounter')} ended, {cut} cut off by the run: too few ends to fit a law ({2 * FEWEST_ENDS})."


def _add(
    panels: dict[str, list[Shown[survival.Survival]]], name: str, run: Run, lifetimes: Lifetimes, *,
    laws: dict[str, tuple[np.ndarray, np.ndarray]] | None = None, theory: tuple[np.ndarray, np.ndarray] | None = None,
) -> None:  # fmt: skip
    """Add a curve where anything ended."""
    shown = panels.setdefault(name, [])
    seen = lifetimes.select(lifetimes.start_seen)
    if np.any(seen.ended):
        curve, n_censored = seen.survival(), int(np.count_nonzero(~seen.ended))
        shown.append(run.shows(survival.Survival(curve, n_censored, laws or {}, theory)))


def _fits(residence: Lifetimes) -> list[tuple[float, LifetimeFit]]:
    """Fits of whole lengths and of their tails, with the cutoff of each."""
    seen = residence.select(residence.start_seen)
    if np.count_nonzero(seen.ended) < 2 * FEWEST_ENDS:
        return []
    median = float(np.median(seen.length[seen.ended]))
    fits = [(0.0, analysis.fit_lifetimes(seen, law)) for law in ("exponential", "inverse_gaussian")]
    if median > 0.0 and np.count_nonzero(seen.ended & (seen.length > median)) >= FEWEST_ENDS:
        fits += [(median, analysis.fit_lifetimes(seen, law, cutoff=median)) for law in ("exponential", "power_law")]
    return fits


def _laws(fits: list[LifetimeFit]) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    at = {}
    for fit in fits:
        mean = fit.parameters["mean"].value
        time = np.linspace(0.0, 12.0 * mean, 400)
        value = fit.survival(time)
        at[_NAMES[fit.law]] = (time[value > 1e-5], value[value > 1e-5])
    return at


def _rows(run: Run, fit: LifetimeFit, cutoff: float) -> list[list[str | Number]]:
    rows: list[list[str | Number]] = []
    for name, found in fit.parameters.items():
        rows.append(
            [
                *([run.label] if run.n_runs > 1 else []),
                _NAMES[fit.law], both(cutoff, "a/U", run.scales) if cutoff else "0", name,
                Number(both(found.value, found.unit, run.scales, error=found.standard_error), found.value),
                interval(*found.interval, found.unit, run.scales),
                Number(f"{fit.aic:.1f}", fit.aic), f"{fit.n:,}", f"{fit.n_censored:,}",
            ]
        )  # fmt: skip
    return rows


def _theory(run: Run) -> tuple[tuple[np.ndarray, np.ndarray] | None, str]:
    """First passage of the escape pitch by `theory.trapping_survival`, or why it does not apply."""
    scene = run.scene
    if scene is None:
        return None, "The scene is not known, so no theory is shown."
    alpha, gamma, D_r = scene.swimmers.dipole_strength, scene.swimmers.aspect_ratio, scene.rotational_diffusion
    radii = np.unique(analysis.encounter_radii(run.results.encounters, run.results.colloids))
    if scene.hydrodynamics.kind == "none" or alpha <= 0.0:
        return None, "The theory of trapping is for pushers; none is shown."
    if D_r == 0.0:
        return None, "The theory of trapping needs noise; none is shown."
    if len(radii) > 1:
        return None, "The theory of trapping is for colloids of one radius; none is shown."
    pitch = analysis.theory.escape_angle(alpha, aspect_ratio=gamma, order="leading")
    if pitch > SMALL_PITCH or radii[0] < LARGE_COLLOID * gamma:
        return None, (
            f"The theory of trapping is for small pitch and large colloids; here the escape pitch is {pitch:.2g} rad "
            f"and the radius {radii[0] / gamma:.3g} contact heights, so none is shown."
        )
    longest = float(np.max(analysis.escape_pitch_lifetimes(run.results.encounters).length))
    times = np.linspace(0.0, longest, 200)
    return (times, analysis.theory.trapping_survival(times, alpha, float(radii[0]), D_r, gamma)), (
        "Theory is the first passage of the escape pitch from pitch 0 in contact (Spagnolie et al. 2015, near-wall); "
        "swimmers that arrive at another pitch begin elsewhere."
    )
