"""Section: how far swimmers wind around colloids."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from porous_swim.analysis import Orbits, orbits
from porous_swim.analysis.columns import column
from porous_swim.analysis.places import own_name
from porous_swim.plots import winding
from porous_swim.plots.style import Shown
from porous_swim.reporting.numbers import value_and_error
from porous_swim.reporting.run import Run
from porous_swim.reporting.section import Section, Table

N_BINS = 40


def section(runs: Sequence[Run]) -> Section:
    """Distributions over completed encounters, in common bins."""
    completed, missing = [], []
    for run in runs:
        if not run.all_round:
            missing.append(run.says(f"Nobody winds around {own_name(run.results.colloids)}."))
        elif _turns(run).size == 0:
            n = len(run.encounters)
            missing.append(run.says(f"No encounter was completed ({n} under way): windings are not known."))
        else:
            completed.append(run)
    largest = max((float(np.max(_turns(run))) for run in completed), default=0.0)
    edges = np.linspace(0.0, largest if largest > 0.0 else 1.0, N_BINS + 1)
    found: list[Shown[Orbits]] = [run.shows(orbits(run.encounters, edges=edges)) for run in completed]
    rows = [[shown.label, *_row(shown.data)] for shown in found]
    header = ["run", "above one turn", "net above one turn", "counterclockwise", "completed", "censored"]
    return Section(
        "Orbits", "winding",
        draw=(lambda: winding.draw(found)) if found else None,
        caption="Winding of completed encounters, which favour short ones; bars are one standard error over swimmers.",
        tables=[Table(header, rows)] if rows else [],
        missing=missing,
    )  # fmt: skip


def _turns(run: Run) -> np.ndarray:
    encounters = run.encounters
    return column(encounters, "winding")[~(column(encounters, "end_censored") | column(encounters, "start_censored"))]


def _row(found: Orbits) -> list[str]:
    shares = (found.above_one_turn, found.net_above_one_turn, found.counterclockwise)
    texts = [value_and_error(share.value, share.standard_error) for share in shares]
    return [*texts, f"{found.above_one_turn.n:,}", f"{found.above_one_turn.n_censored:,}"]
