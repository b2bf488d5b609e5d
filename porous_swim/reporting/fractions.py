"""Section: fractions of swimmers bound and in contact over time."""

from __future__ import annotations

from collections.abc import Sequence

import pyarrow as pa

from porous_swim.plots import fractions
from porous_swim.plots.style import Shown
from porous_swim.reporting.run import Run, scales_of
from porous_swim.reporting.section import Section


def section(runs: Sequence[Run]) -> Section:
    """The time series of the run."""
    shown: list[Shown[pa.Table]] = []
    missing = []
    for run in runs:
        if len(run.results.colloids) == 0:
            missing.append(run.says("There are no colloids, so no swimmer is ever bound."))
        elif len(run.results.timeseries) < 2:
            missing.append(run.says("The time series has fewer than two rows."))
        else:
            shown.append(run.shows(run.results.timeseries))
    return Section(
        "Bound and in contact", "fractions",
        draw=(lambda: fractions.draw(shown, scales_of(runs))) if shown else None,
        caption="Fractions of all swimmers in an encounter and in contact; bands are one binomial standard error.",
        missing=missing,
    )  # fmt: skip
