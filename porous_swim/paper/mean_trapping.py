"""Figure ET_Theta: mean trapping time over radius and noise: estimate, integral and simulation."""

from __future__ import annotations

import warnings
from typing import Any, Literal

import numpy as np

from porous_swim import theory
from porous_swim.paper.figure import Reproduction, Row, panels
from porous_swim.paper.noise import Case, mean_of, trapping_times
from porous_swim.paper.scan import paper_scene

NAME = "ET_Theta"
TITLE = "Mean trapping time E[T_theta] (alpha = 0.8) over radius and noise: estimate, integral, simulation to t = 100"
# (A, D): simulated independently with error, and the paper's integral
LISTED = {
    (20.0, 5e-4): (60.5, 1.3, 2977.0), (20.0, 1e-3): (29.4, 0.3, 135.6), (20.0, 2e-3): (18.1, 0.2, 33.82),
    (20.0, 4e-3): (11.9, 0.14, 16.12), (20.0, 8e-3): (8.30, 0.11, 9.718), (20.0, 2e-2): (5.68, 0.09, 5.686),
    (5.0, 2e-3): (2.14, 0.01, 1.952), (50.0, 4e-3): (42.3, 0.6, 66.4), (100.0, 8e-3): (24.0, 0.4, 29.5),
}  # fmt: skip


def reproduce(quick: bool) -> Reproduction:
    """The listed pairs to their ends, and the grid of the figure to t = 100."""
    pairs = [Case(A, 0.8, D) for A, D in LISTED]
    scene = paper_scene("mean_trapping")
    to_end = {"swimmers.count": 150 if quick else 3000, "run.duration": 600.0, "record.every": 600.0}
    rows = []
    for (key, (value, error, integral)), times in zip(
        LISTED.items(), trapping_times(scene.replace(to_end), pairs), strict=True
    ):
        ours, own_error = mean_of(times.pitch)
        text = f"A = {key[0]:g}, D = {key[1]:g}"
        rows.append(Row(f"{text}: E[T_theta]", ours, own_error, independent=value, independent_error=error))
        computed = _closed(Case(key[0], 0.8, key[1]), "integral")
        rows.append(Row(f"{text}: integral", computed, independent=integral, digit=10.0 ** _last_digit(integral)))
    horizon = scene.run.duration
    radii = np.linspace(5.0, 120.0, 8 if quick else 24)
    noises = np.geomspace(5e-4, 2e-2, 10 if quick else 30)
    grid = [Case(float(A), 0.8, float(D)) for A in radii for D in noises]
    results = trapping_times(scene.replace({"swimmers.count": 10, "run.time_step": 0.005} if quick else {}), grid)
    simulated = np.array([times.pitch.mean() for times in results])
    closed = {order: np.array([_closed(case, order) for case in grid]) for order in ("estimate", "integral")}
    columns = {
        "radius": np.array([case.radius for case in grid]), "D": np.array([case.D for case in grid]),
        "simulated": simulated, **closed,
    }  # fmt: skip
    n_runs, n_late = sum(len(times.pitch) for times in results), sum(times.n_no_pitch for times in results)
    notes = [
        f"of the grid, {n_late} of {n_runs} swimmers had not passed the escape pitch by t = {horizon:g}; "
        "they count with that time, as in the paper"
    ]

    def draw() -> Any:
        picture, axes = panels(3)
        shape = (len(radii), len(noises))
        for axis, name in zip(axes, ("estimate", "integral", "simulated"), strict=True):
            values = np.minimum(columns[name], horizon).reshape(shape).T
            mesh = axis.pcolormesh(radii, noises, values, vmin=0.0, vmax=horizon, shading="nearest", rasterized=True)
            axis.set(title=name, xlabel="A/a", ylabel="D", yscale="log")
            picture.colorbar(mesh, ax=axis, label="E[T_theta] U/a, up to 100")
        return picture

    return Reproduction({"grid": columns}, rows, draw, notes)


def _closed(case: Case, order: Literal["integral", "estimate"]) -> float:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the figure shows where these fail
        return theory.mean_trapping_time(case.alpha, case.radius, 0.75 * case.D, order=order)


def _last_digit(value: float) -> int:
    """Power of ten of the fourth digit."""
    return int(np.floor(np.log10(value))) - 3
