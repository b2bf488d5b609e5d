"""Section: the scene in numbers, the medium, and the trajectories of some swimmers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pyarrow as pa

from porous_swim.analysis.columns import column, vectors
from porous_swim.analysis.places import centers_of, own_name, radii_of
from porous_swim.analysis.transport.transport import tracks
from porous_swim.plots import trajectories
from porous_swim.plots.style import Shown
from porous_swim.reporting.numbers import both
from porous_swim.reporting.run import Run, scales_of
from porous_swim.reporting.section import Section, Table

N_WAYS = 5


def section(runs: Sequence[Run]) -> Section:
    """What was run, and how it looks."""
    missing = [run.says(run.no_scene) for run in runs if run.scene is None]
    shown: list[Shown[trajectories.Trajectories]] = []
    for run in runs:
        if len(run.results.trajectory) == 0:
            missing.append(run.says("No swimmer was recorded (record.swimmers), so no way can be drawn."))
        else:
            shown.append(run.shows(_trajectories(run)))
    facts = [_facts(run) for run in runs]
    names = list(dict.fromkeys(name for each in facts for name in each))
    rows = [[name, *(each.get(name, "") for each in facts)] for name in names]
    scales = scales_of(runs)
    return Section(
        "Medium and swimmers", "medium",
        text=[run.says(run.scene.description.strip()) for run in runs if run.scene and run.scene.description.strip()],
        draw=(lambda: trajectories.draw(shown, scales)) if shown else None,
        caption=f"Trajectories of {_some(shown)}, unwrapped across periodic images, coloured by state.",
        tables=[Table(["", *(run.label for run in runs)], rows)],
        missing=missing,
    )  # fmt: skip


def _some(shown: Sequence[Shown[trajectories.Trajectories]]) -> str:
    n = max((run.data.position.shape[1] for run in shown), default=0)
    return "the one recorded swimmer" if n == 1 else f"{n} recorded swimmers that start near each other"


def _trajectories(run: Run) -> trajectories.Trajectories:
    results = run.results
    few = results.trajectory.filter(np.isin(column(results.trajectory, "swimmer"), _neighbours(results.trajectory)))
    recorded = tracks(few)
    order = np.lexsort((column(few, "swimmer"), column(few, "time")))
    state = column(few, "state")[order].reshape(len(recorded.time), len(recorded.swimmer))
    return trajectories.Trajectories(
        centers_of(results.colloids), radii_of(results.colloids), results.info.box, recorded.position, state,
        results.info.dimensions, run.flat_normal,
    )  # fmt: skip


def _neighbours(trajectory: pa.Table) -> np.ndarray:
    """Of the recorded swimmers those that start nearest to the first, so that a picture can show them large."""
    first = trajectory.filter(column(trajectory, "time") == np.min(column(trajectory, "time"))).sort_by("swimmer")
    start = vectors(first, "x", "y", "z")
    nearest = np.argsort(np.linalg.norm(start - start[0], axis=1), kind="stable")
    return column(first, "swimmer")[nearest[:N_WAYS]]


def _facts(run: Run) -> dict[str, str]:
    info, scene, scales = run.results.info, run.scene, run.scales
    radii = radii_of(run.results.colloids)
    facts = {"swimmers": f"{info.n_swimmers:,}", "dimensions": str(info.dimensions)}
    if scene is not None:
        swimmers = scene.swimmers
        facts |= {
            "dipole strength alpha": f"{swimmers.dipole_strength:.4g}",
            "aspect ratio gamma": f"{swimmers.aspect_ratio:g}",
            "translational diffusion D": both(scene.translational_diffusion, "a U", scales),
            "rotational diffusion D_r": both(scene.rotational_diffusion, "U/a", scales),
        }
    facts["colloids"] = own_name(run.results.colloids) or f"{len(radii):,}"
    if len(radii) and run.all_round:
        least, largest = float(radii.min()), float(radii.max())
        several = f" to {both(largest, 'a', scales)}" if largest > least else ""
        facts["radius of colloids"] = both(least, "a", scales) + several
    edges = [both(edge, "a", scales) for edge in info.box[: info.dimensions] if edge > 0.0]
    facts["periodic box"] = " by ".join(edges) if edges else "none: the domain is open"
    facts["time simulated"] = both(info.duration, "a/U", scales)
    facts["time step"] = both(info.time_step, "a/U", scales)
    if scales is not None:
        facts["units"] = f"a = {scales.length:g} µm, a/U = {scales.time:g} s, U = {scales.length / scales.time:g} µm/s"
    return facts
