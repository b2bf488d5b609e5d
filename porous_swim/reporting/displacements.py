"""Section: mean squared displacement, its exponent, and the effective diffusivity."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from porous_swim.analysis import EffectiveDiffusivity, ensemble_diffusivity, ensemble_msd, msd_exponent
from porous_swim.core.errors import ResultsError
from porous_swim.plots import displacements
from porous_swim.plots.style import Shown
from porous_swim.reporting.free_walk import squared_displacement
from porous_swim.reporting.numbers import NONE, both, interval
from porous_swim.reporting.run import Run, scales_of
from porous_swim.reporting.section import Number, Section, Table


def section(runs: Sequence[Run]) -> Section:
    """Displacements of all swimmers against lag."""
    shown: list[Shown[displacements.Displacements]] = []
    missing, warnings, rows = [], [], []
    for run in runs:
        try:
            found = _displacements(run)
        except ResultsError as error:
            missing.append(run.says(f"{error}."))
            continue
        if found is None:
            missing.append(run.says("Too few frames or no motion were recorded: displacements against lag need both."))
            continue
        shown.append(run.shows(found))
        rows.append(_row(run, found.diffusivity))
        if found.diffusivity.reason is not None:
            warnings.append(run.says(found.diffusivity.reason))
    header = ["run", "effective diffusivity", "95 % interval", "lags of the fit", "p: a straight line", "swimmers"]
    return Section(
        "Displacements", "displacements",
        text=["Diffusivity: a line with an offset through four to eight lags, weighted as for Brownian motion."],
        draw=(lambda: displacements.draw(shown, scales_of(runs))) if shown else None,
        caption="Mean squared displacement of all swimmers (left; shaded: the lags of the fit) and its exponent "
        "(right); bars are one standard error over swimmers.",
        tables=[Table(header, rows, caption=" ".join(warnings))] if rows else [],
        missing=missing,
        warnings=warnings,
    )  # fmt: skip


def _displacements(run: Run) -> displacements.Displacements | None:
    """None where nothing moves, or half of the run has room for fewer than two lags: an exponent is of two."""
    lags, info, scene = run.results.lags, run.results.info, run.scene
    squares = ensemble_msd(lags)
    if len(squares.lag) < 2 or not np.all(squares.value > 0.0):
        return None
    free = None
    if scene is not None and len(run.results.colloids) == 0:
        noise = scene.translational_diffusion, scene.rotational_diffusion
        free = squared_displacement(squares.lag, *noise, dimensions=info.dimensions)
    return displacements.Displacements(
        squares, msd_exponent(squares), ensemble_diffusivity(lags), info.dimensions, free
    )


def _row(run: Run, fit: EffectiveDiffusivity) -> list[str | Number]:
    if not np.isfinite(fit.value):
        return [run.label, NONE, NONE, NONE, NONE, f"{fit.n:,}"]
    return [
        run.label,
        Number(both(fit.value, "a U", run.scales, error=fit.standard_error), fit.value),
        interval(*fit.interval, "a U", run.scales),
        interval(*fit.window, "a/U", run.scales), f"{fit.p_value:.2g}", f"{fit.n:,}",
    ]  # fmt: skip
