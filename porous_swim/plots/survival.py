"""Survival curves: how likely something lasts longer than a time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from porous_swim.analysis.lifetimes.survival import SurvivalCurve
from porous_swim.analysis.lifetimes.survival_band import survival_band
from porous_swim.plots.scales import Scales, label_x
from porous_swim.plots.style import THEORY, Shown, legend, message, panels, thinned_tail

LAW_NAMES = {"exponential": "exponential", "inverse_gaussian": "inverse Gaussian", "power_law": "power law"}
_LINES = {"exponential": "--", "inverse Gaussian": ":"}  # of laws of all lengths


@dataclass(frozen=True, eq=False)
class Survival:
    """A curve, and laws to compare it with."""

    curve: SurvivalCurve
    laws: Mapping[str, tuple[np.ndarray, np.ndarray]] = field(default_factory=dict)
    """By name: times (n,), a/U, and probabilities (n,)."""
    theory: tuple[np.ndarray, np.ndarray] | None = None
    theory_holds: bool = True
    """False where the theory is out of its range."""


def draw(quantities: Mapping[str, list[Shown[Survival]]], scales: Scales | None) -> Figure:
    """One panel for each quantity: Kaplan-Meier curves with 95 % bands, fits and theory, on a logarithmic axis."""
    picture, axes = panels(len(quantities), width=4.9 if len(quantities) < 3 else 3.9, height=3.5)
    for axis, (name, shown) in zip(axes, quantities.items(), strict=True):
        if not shown:
            message(axis, f"{name}: none ended")
            continue
        least, longest = 0.2, 0.0
        for run in shown:
            _curve(axis, run, name_it=len(shown) > 1)
            probability = run.data.curve.probability
            least = min(least, float(probability[probability > 0.0].min(initial=1.0)))
            longest = max(longest, run.data.curve.longest)
        axis.set(yscale="log", ylim=(max(0.5 * least, 1e-5), 1.3), ylabel="share that lasts longer")
        axis.set_xlim(0.0, 1.05 * longest if longest > 0.0 else 1.0)
        label_x(axis, name, "a/U", scales)
        legend(axis)
    return picture


def _curve(axis: Any, run: Shown[Survival], *, name_it: bool) -> None:
    curve, band = run.data.curve, survival_band(run.data.curve)
    chosen = thinned_tail(curve.probability)
    # the last value holds as far as anything was seen to last, and no further
    time, held = np.append(curve.time[chosen], curve.longest), np.append(chosen, chosen[-1])
    label = run.label if name_it else "Kaplan-Meier, 95 % band"
    axis.step(
        np.append(0.0, time), np.append(1.0, curve.probability[held]),
        where="post", color=run.color, linewidth=1.3, label=label,
    )  # fmt: skip
    axis.fill_between(time, band.lower[held], band.upper[held], step="post", color=run.color, alpha=0.2, linewidth=0)
    for law, (at, value) in run.data.laws.items():
        axis.plot(
            at,
            value,
            _LINES[law],
            color=run.color if name_it else THEORY,
            linewidth=1.0,
            label=None if name_it else law,
        )
    if run.data.theory is not None:
        holds = run.data.theory_holds
        label = "theory" if holds else "theory, out of its range"
        axis.plot(
            *run.data.theory, "-" if holds else "-.", color="#cc79a7", linewidth=1.4, label=None if name_it else label
        )
