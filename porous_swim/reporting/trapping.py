"""Where the theory of trapping applies to a run, and what it says of times to the escape pitch."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from porous_swim import analysis
from porous_swim.analysis import Lifetimes
from porous_swim.reporting.numbers import value_and_error
from porous_swim.reporting.run import Run

SMALL_PITCH = 0.4  # rad; beyond, the near-wall theory of small pitch is off by more than some per cent
LARGE_COLLOID = 10.0  # contact heights
_N_TIMES = 2000


@dataclass(frozen=True, eq=False)
class Trapping:
    """The theory's survival curve, or none; and a sentence on it."""

    curve: tuple[np.ndarray, np.ndarray] | None
    """Times (n,), a/U, and probabilities (n,)."""
    sentence: str
    warnings: tuple[str, ...] = ()
    """Why the theory is not to be trusted here: what the curve is drawn with, and the top of the page."""


def trapping(run: Run, passages: Lifetimes) -> Trapping:
    """First passage of the escape pitch by `theory.trapping_survival`, or why it does not apply."""
    why, radius = _obstacle(run)
    if why or run.scene is None:
        return Trapping(None, why)
    scene = run.scene
    alpha, gamma, D_r = scene.swimmers.dipole_strength, scene.swimmers.aspect_ratio, scene.rotational_diffusion
    times = np.linspace(0.0, float(np.max(passages.length, initial=1.0)), _N_TIMES)
    probability = analysis.theory.trapping_survival(times, alpha, radius, D_r, gamma)
    logarithm = np.log(np.maximum(probability, 1e-300))
    seen = analysis.one_sample_log_rank(passages, lambda length: np.exp(np.interp(length, times, logarithm))).ratio
    sentence = (
        "Theory is the first passage of the escape pitch from pitch 0 in contact (Spagnolie et al. 2015, near-wall); "
        "swimmers that arrive at another pitch begin elsewhere."
    )
    if np.isfinite(seen.value):
        ratio = value_and_error(seen.value, seen.standard_error)
        sentence += f" Passages seen over those that it expects (log-rank): {ratio}."
    found = analysis.theory.trapping_warnings(alpha, radius, D_r, gamma)
    warnings = tuple(f"Theory of trapping: {each}." for each in found)
    return Trapping((times, probability), " ".join([sentence, *warnings]), warnings)


def _obstacle(run: Run) -> tuple[str, float]:
    """Why the theory does not apply, or nothing; and the radius."""
    scene = run.scene
    if scene is None:
        return "The scene is not known, so no theory is shown.", 0.0
    alpha, gamma = scene.swimmers.dipole_strength, scene.swimmers.aspect_ratio
    if scene.hydrodynamics.kind == "none":
        return (
            "No theory is shown: the theory of trapping is of the flow that turns a swimmer towards a colloid, and "
            "this run has none (hydrodynamics: none)."
        ), 0.0
    if alpha <= 0.0:
        return (
            f"No theory is shown: the theory of trapping is for pushers, and here the dipole strength is {alpha:.3g} "
            f"({'a puller' if alpha < 0.0 else 'no dipole'})."
        ), 0.0
    if scene.rotational_diffusion == 0.0:
        return "No theory is shown: without noise no swimmer leaves by chance, which the theory of trapping is of.", 0.0
    radii = np.unique(analysis.encounter_radii(run.encounters, run.results.colloids))
    if len(radii) > 1:
        return (
            "No theory is shown: the theory of trapping is for colloids of one radius, and swimmers met "
            f"{len(radii):,} of them."
        ), 0.0
    pitch = analysis.theory.escape_angle(alpha, aspect_ratio=gamma, order="leading")
    if pitch > SMALL_PITCH or radii[0] < LARGE_COLLOID * gamma:
        return (
            "No theory is shown: the theory of trapping is for small pitch and large colloids; here the escape pitch "
            f"is {pitch:.2g} rad and the radius {radii[0] / gamma:.3g} contact heights."
        ), 0.0
    return "", float(radii[0])
