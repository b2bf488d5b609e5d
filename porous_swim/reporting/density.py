"""Sections: where swimmers are, in height and pitch at a colloid and in the cell of the lattice."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from porous_swim.analysis import Map, cell_density, height_pitch_density, histogram_2d
from porous_swim.analysis.columns import column, vectors
from porous_swim.analysis.places import centers_of, own_name, radii_of
from porous_swim.plots import cell, height_pitch
from porous_swim.plots.colloids import images_in
from porous_swim.plots.style import Shown
from porous_swim.reporting.numbers import both
from porous_swim.reporting.run import Run, scales_of
from porous_swim.reporting.section import Section
from porous_swim.results.tables import steady_frames

HEIGHTS = 4.0  # a; escape heights, where they are larger, are doubled
N_HEIGHTS = 60
_NOBODY = "No swimmer was recorded (record.swimmers), or none after the burn-in."


def height_pitch_section(runs: Sequence[Run]) -> Section:
    """Density in height and pitch, over all frames of the recorded swimmers."""
    shown: list[Shown[height_pitch.HeightPitch]] = []
    missing, text = [], []
    for run in runs:
        results = run.results
        if len(results.colloids) == 0:
            missing.append(run.says("There are no colloids to be high above."))
            continue
        if len(steady_frames(results.trajectory)) == 0:
            missing.append(run.says(_NOBODY))
            continue
        escape = None if run.scene is None else run.scene.encounter.escape_height
        top = HEIGHTS if escape is None else max(HEIGHTS, 2.0 * escape)
        heights = np.linspace(0.0, top, N_HEIGHTS + 1)
        if not run.all_round and run.flat_normal is None:
            name = own_name(results.colloids)
            missing.append(run.says(f"How {name} stands is not known, so neither are heights above it."))
            continue
        found = _height_pitch(run, heights)
        shown.append(run.shows(height_pitch.HeightPitch(found, escape)))
        share, height = 100.0 * found.n_outside / found.n, both(top, "a", run.scales)
        text.append(run.says(f"{share:.3g} % of {found.n:,} positions are higher than {height}."))
    return Section(
        "Height and pitch", "height_pitch",
        text=text,
        draw=(lambda: height_pitch.draw(shown, scales_of(runs))) if shown else None,
        caption="Height of the swimmer's centre above the nearest colloid, and pitch of its director above the tangent "
        "plane there (above 0: outwards).",
        missing=missing,
    )  # fmt: skip


def _height_pitch(run: Run, heights: np.ndarray) -> Map:
    """The density above the nearest colloid, or above the one that is flat."""
    results, normal = run.results, run.flat_normal
    if normal is None:
        return height_pitch_density(results.trajectory, results.colloids, heights=heights)
    seen = steady_frames(results.trajectory)
    offset = vectors(seen, "x", "y", "z") - centers_of(results.colloids)[0]
    sine = vectors(seen, "ex", "ey", "ez") @ normal
    return histogram_2d(
        np.arcsin(np.clip(sine, -1.0, 1.0)), offset @ normal,
        x_edges=np.linspace(-0.5 * np.pi, 0.5 * np.pi, N_HEIGHTS + 1), y_edges=heights,
        swimmer=column(seen, "swimmer"),
    )  # fmt: skip


def cell_section(runs: Sequence[Run]) -> Section:
    """Density in the cell of the lattice, or in the whole box where there is no lattice."""
    shown: list[Shown[cell.Cell]] = []
    missing, text = [], []
    for run in runs:
        if not (run.results.info.box[0] > 0.0 and run.results.info.box[1] > 0.0):
            missing.append(run.says("The domain is open: there is no cell to fold positions into."))
            continue
        if len(steady_frames(run.results.trajectory)) == 0:
            missing.append(run.says(_NOBODY))
            continue
        if run.results.info.dimensions == 3 and _cells(run) is None:
            missing.append(run.says("The field is no lattice: all of it seen along z would show nothing."))
            continue
        found, what = _cell(run)
        shown.append(run.shows(found))
        text.append(run.says(f"{found.density.n:,} positions folded into {what}."))
    return Section(
        "In the periodic cell", "cell",
        text=text,
        draw=(lambda: cell.draw(shown, scales_of(runs))) if shown else None,
        caption="Density of swimmers over its mean in the cell; in three dimensions seen along z.",
        missing=missing,
    )  # fmt: skip


def _cells(run: Run) -> Sequence[int] | None:
    """How many cells of a lattice the box has along each axis; None where there is no lattice, or no scene."""
    return getattr(run.scene.obstacles, "cells", None) if run.scene is not None else None


def _cell(run: Run) -> tuple[cell.Cell, str]:
    results, box = run.results, run.results.info.box
    cells = _cells(run)
    edges = (box[0] / cells[0], box[1] / cells[1]) if cells else (box[0], box[1])
    low, high = np.zeros(2), np.asarray(edges)
    centers, radii = images_in(
        centers_of(results.colloids)[:, :2], radii_of(results.colloids), box=(box[0], box[1]), low=low, high=high
    )
    density = cell_density(results.trajectory, cell=edges)
    what = f"one of {cells[0]} by {cells[1]} cells" if cells else "the whole periodic box"
    return cell.Cell(density, centers, radii), what
