"""Section: how long swimmers remember their direction."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from porous_swim.analysis import Persistence, persistence
from porous_swim.core.errors import ResultsError
from porous_swim.plots import directors
from porous_swim.plots.style import Shown
from porous_swim.reporting.free_walk import director_correlation
from porous_swim.reporting.numbers import both
from porous_swim.reporting.run import Run, scales_of
from porous_swim.reporting.section import Number, Section, Table


def section(runs: Sequence[Run]) -> Section:
    """Correlation of directors of the recorded swimmers, over all starts, and the persistence length."""
    shown: list[Shown[directors.Directors]] = []
    missing, warnings, rows = [], [], []
    for run in runs:
        try:
            found = persistence(run.results.trajectory)
        except ResultsError as error:
            missing.append(run.says(f"{error}."))
            continue
        lag = found.correlation.lag
        if len(lag) == 0:
            missing.append(run.says("Too few frames were recorded to correlate directors."))
            continue
        D_r = None if run.scene is None else run.scene.rotational_diffusion
        free = None if D_r is None else director_correlation(lag, D_r, dimensions=run.results.info.dimensions)
        shown.append(run.shows(directors.Directors(found.correlation, free)))
        rows.append(_row(run, found))
        if found.reason is not None:
            warnings.append(run.says(found.reason))
    return Section(
        "Directions", "directors",
        draw=(lambda: directors.draw(shown, scales_of(runs))) if shown else None,
        caption="Mean scalar product of directors a lag apart; bars are one standard error over swimmers. Dashed: what "
        "rotational noise alone would leave of it.",
        tables=[Table(["run", "persistence length", "read at lag", "swimmers"], rows)] if rows else [],
        missing=missing,
        warnings=warnings,
    )  # fmt: skip


def _row(run: Run, found: Persistence) -> list[str | Number]:
    length = found.length
    error = length.standard_error if np.isfinite(length.standard_error) else None
    return [
        run.label,
        Number(
            both(length.value, "a", run.scales, error=error), length.value,
            note="" if found.reached else "too small: directors are remembered for longer",
        ),
        both(found.lag, "a/U", run.scales), f"{length.n:,}",
    ]  # fmt: skip
