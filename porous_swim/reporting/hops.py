"""Section: lengths, times and turning angles of hops."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from porous_swim.analysis import histogram, hop_shells
from porous_swim.analysis.columns import column
from porous_swim.plots import hops
from porous_swim.plots.style import Shown
from porous_swim.reporting.numbers import value_and_error
from porous_swim.reporting.run import Run, scales_of
from porous_swim.reporting.section import Section, Table

N_BINS = 40


def section(runs: Sequence[Run]) -> Section:
    """Distributions over hops, in common bins, and shares by neighbourhood."""
    hopping = [run for run in runs if len(run.hops)]
    longest, latest = (
        max((float(np.max(column(run.hops, name))) for run in hopping), default=0.0) for name in ("length", "time")
    )
    lengths, times = np.linspace(0.0, 1.02 * longest, N_BINS + 1), np.linspace(0.0, max(latest, 1e-9), N_BINS + 1)
    found: list[Shown[hops.HopDistributions]] = [run.shows(_distributions(run, lengths, times)) for run in hopping]
    rows, text = [], []
    for run in hopping:
        shells = hop_shells(run.hops)
        shares = (shells.nearest, shells.second, shells.farther)
        if all(np.isnan(share.value) for share in shares):
            text.append(
                run.says("Distances between the colloids form no shells: neighbours are not told apart by them.")
            )
            continue
        rows.append([run.label, *(value_and_error(share.value, share.standard_error) for share in shares)])
    return Section(
        "Hops", "hops",
        text=text,
        draw=(lambda: hops.draw(found, scales_of(runs))) if found else None,
        caption="Distance between the centres of the colloids left and entered, time between the encounters, and angle "
        "from the swimmer's hop before; bars are one standard error over swimmers.",
        tables=[Table(["run", "to a nearest neighbour", "to a second-nearest", "farther"], rows)] if rows else [],
        missing=[run.says(no_hops(run)) for run in runs if len(run.hops) == 0],
    )  # fmt: skip


def no_hops(run: Run) -> str:
    """Why a run has no hops."""
    if len(run.results.colloids) == 0:
        return "There are no colloids to hop between."
    n = len(run.encounters)
    seen = "1 encounter was" if n == 1 else f"{n:,} encounters were"
    return f"No swimmer hopped: {seen} seen, none followed by one with another colloid."


def _distributions(run: Run, lengths: np.ndarray, times: np.ndarray) -> hops.HopDistributions:
    swimmer = column(run.hops, "swimmer")
    signed = run.results.info.dimensions == 2
    angle = np.degrees(column(run.hops, "signed_turning_angle" if signed else "turning_angle"))
    # Bins of 10 degrees about whole multiples, where the angles of lattices are: a turn back is one of them.
    first = -175.0 if signed else -5.0
    angle = np.where(angle < first, angle + 360.0, angle)
    return hops.HopDistributions(
        histogram(column(run.hops, "length"), edges=lengths, swimmer=swimmer),
        histogram(column(run.hops, "time"), edges=times, swimmer=swimmer),
        histogram(angle, edges=np.arange(first, 186.0, 10.0), swimmer=swimmer),
    )
