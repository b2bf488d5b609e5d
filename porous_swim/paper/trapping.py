"""Figure TrappingTimes: how long noise leaves a swimmer at a colloid, four sets; and the finding on the noise."""

from __future__ import annotations

from typing import Any

import numpy as np

from porous_swim import theory
from porous_swim.paper.figure import Reproduction, Row, panels
from porous_swim.paper.noise import Case, mean_of, trapping_times
from porous_swim.paper.scan import paper_scene

NAME = "TrappingTimes"
TITLE = "Trapping times from T_h with inverse-Gaussian densities of the same mean and deviation"
# the paper's mean and deviation (its lambda is mean^3/deviation^2); T_theta and T_h of the independent simulator with
# the same scheme and step (value, error)
SETS = {
    Case(20.0, 0.8, 0.002): (("38.4", "20.3"), (18.28, 0.13), (21.83, 0.14)),
    Case(20.0, 0.8, 0.004): (("25.1", "13.2"), (12.19, 0.09), (16.26, 0.11)),
    Case(20.0, 0.2, 0.002): (("6.33", "1.61"), (1.617, 0.014), (6.080, 0.023)),
    Case(320.0, 0.2, 0.002): (("43.7", "35.9"), (9.27, 0.14), (32.66, 0.31)),
}
FITTED = (39.1, 25.2, 6.19, 44.2)  # T_h with a quarter of the translational and half of the rotational variance


def reproduce(quick: bool) -> Reproduction:
    """The four sets with standard noise, and with the amplitudes that fit the paper's means."""
    standard = list(SETS)
    fitted = [Case(case.radius, case.alpha, 0.25 * case.D, 0.375 * case.D) for case in standard]
    scene = paper_scene("trapping").replace({"swimmers.count": 200} if quick else {})
    results = trapping_times(scene, [*standard, *fitted])
    rows = []
    for case, times in zip(standard, results, strict=False):
        paper, pitch, height = SETS[case]
        ours, error = mean_of(times.pitch)
        rows.append(Row(f"{case.text}: E[T_theta]", ours, error, independent=pitch[0], independent_error=pitch[1]))
        ours, error = mean_of(times.height)
        rows.append(
            Row(f"{case.text}: E[T_h]", ours, error, paper=paper[0], independent=height[0], independent_error=height[1])
        )
        rows.append(Row(f"{case.text}: deviation of T_h", *_deviation(times.height), paper=paper[1]))
    for case, listed, times in zip(standard, FITTED, results[len(standard) :], strict=True):
        ours, error = mean_of(times.height)
        # listed without an error: three digits
        rows.append(Row(f"{case.text}: E[T_h] with D/4, D_r/2 (a fit)", ours, error, paper=SETS[case][0][0],
                        independent=listed, independent_error=0.01 * listed))  # fmt: skip
    tables = {
        f"A{case.radius:g}-alpha{case.alpha:g}-D{case.D:g}": {"T_theta": times.pitch, "T_h": times.height}
        for case, times in zip(standard, results, strict=False)
    }
    held = sum(times.n_held for times in results)
    n_runs = sum(len(times.height) for times in results)
    notes = [f"{held} of {n_runs} swimmers were still held at t = {scene.run.duration:g}"]

    def draw() -> Any:
        picture, axes = panels(4, in_line=2)
        for axis, case, times in zip(axes, standard, results, strict=False):
            axis.hist(times.height, bins=50, density=True, color="0.8", label="T_h")
            t = np.linspace(0.05, float(times.height.max()), 400)
            law = theory.inverse_gaussian(float(times.height.mean()), float(times.height.std(ddof=1)))
            axis.plot(t, law.pdf(t), "C3", label="inverse Gaussian")
            axis.set(title=case.text, xlabel="T U/a", ylabel="density", xlim=(0, np.quantile(times.height, 0.995)))
            axis.legend()
        return picture

    return Reproduction(tables, rows, draw, notes)


def _deviation(times: np.ndarray) -> tuple[float, float]:
    """Standard deviation of `times`, and its standard error for the law that the figure shows.

    The kurtosis of an inverse Gaussian is 3 + 15 (deviation/mean)^2.
    """
    mean, deviation = float(times.mean()), float(times.std(ddof=1))
    return deviation, 0.5 * deviation * float(np.sqrt((2.0 + 15.0 * (deviation / mean) ** 2) / len(times)))
