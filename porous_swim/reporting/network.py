"""Section: the network of hops over the colloids."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from porous_swim.analysis import hop_degrees, hop_network, hop_symmetry
from porous_swim.analysis.columns import column
from porous_swim.plots import hop_network as picture
from porous_swim.plots.style import Shown
from porous_swim.reporting.hops import no_hops
from porous_swim.reporting.run import Run, scales_of
from porous_swim.reporting.section import Cell, Number, Section, Table


def section(runs: Sequence[Run]) -> Section:
    """Which colloids swimmers hop between, and whether as often there as back."""
    shown: list[Shown[picture.Network]] = []
    rows, missing = [], []
    for run in runs:
        if len(run.hops) == 0:
            missing.append(run.says(no_hops(run)))
            continue
        results = run.results
        network = picture.Network(hop_network(run.hops), results.colloids, results.info.box)
        shown.append(run.shows(network))
        rows.append(_row(run, network))
    header = ["run", "hops", "links used", "colloids left", "links out of a colloid", "opposite pairs",
              "chi²", "p: as often there as back"]  # fmt: skip
    return Section(
        "Hop network", "network",
        text=["Symmetry is Bowker's test of opposite links, which takes hops for independent."] if rows else [],
        draw=(lambda: picture.draw(shown, scales_of(runs))) if shown else None,
        caption="Each half of a bond is as wide as the hops are many that leave the colloid at its end.",
        tables=[Table(header, rows)] if rows else [],
        missing=missing,
    )  # fmt: skip


def _row(run: Run, network: picture.Network) -> list[Cell]:
    degrees, symmetry = hop_degrees(network.links, network.colloids), hop_symmetry(network.links)
    n_out, out = column(degrees, "n_out"), column(degrees, "out_degree")
    left = n_out > 0
    return [
        run.label, Number(f"{len(run.hops):,}", len(run.hops)), f"{len(network.links):,}",
        f"{np.count_nonzero(left):,} of {len(left):,}", f"{np.mean(out[left]):.2f} on average",
        f"{symmetry.degrees_of_freedom:,}", f"{symmetry.chi_squared:.1f}", f"{symmetry.p_value:.2g}",
    ]  # fmt: skip
