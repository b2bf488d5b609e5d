"""The effective diffusivity of walks whose own is exact, over runs of a few to thousands of persistence times.

Either there is none, with the reason, or its bias is below its error and its intervals of 95 % cover the truth. The
table in docs/statistics.md is what `python -m pytest -m slow -s tests/analysis/test_diffusivity_study.py` prints.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pyarrow as pa
import pytest

import porous_swim as ps
from tests.support import synthetic, walks

an = ps.analysis
N_SWIMMERS = 100
FEW, MANY = 100, 200  # repeats
CELL, BLOCK = 6, 4  # sites along the edge of a periodic cell, and of the block in it that no walker enters


@dataclass(frozen=True)
class Study:
    """A walk that can be drawn as often as needed."""

    name: str
    times: float  # that the run lasts, in persistence times or in times to cross a cell
    truth: float
    draw: Callable[[np.random.Generator], pa.Table]


def free(times: float, *, noise: float) -> Study:
    """Steps of 1 along directors, with `noise` times their diffusivity besides; some 100 frames."""
    time = 40 if times < 10 else 20 if times <= 30 else 8 if times <= 100 else 2  # persistence time in steps
    turning, c = math.sqrt(2.0 / time), math.exp(-1.0 / time)
    active = 0.25 * (1.0 + c) / (1.0 - c)
    n_steps, diffusivity = int(times * time), noise * active
    every = max(1, n_steps // 100)

    def draw(rng: np.random.Generator) -> pa.Table:
        return walks.persistent_lags(
            rng, n_swimmers=N_SWIMMERS, n_frames=n_steps // every, every=every, turning=turning, diffusivity=diffusivity
        )

    return Study(f"free, D/D_active = {noise:g}", times, active + diffusivity, draw)


def among_blocks(times: float) -> Study:
    """Passive walkers on a square grid in which a block of sites repeats; a frame a step, or each fourth."""
    open_sites = np.ones((CELL, CELL), bool)
    open_sites[:BLOCK, :BLOCK] = False
    truth = grid_diffusivity(open_sites)
    n_steps = int(times * CELL**2 / (4.0 * math.pi**2 * truth))
    every = max(1, n_steps // 200)

    def draw(rng: np.random.Generator) -> pa.Table:
        site = np.argwhere(open_sites)[rng.integers(0, open_sites.sum(), N_SWIMMERS)]
        path = [site]
        moves = np.array([[1, 0], [-1, 0], [0, 1], [0, -1]])
        for move in moves[rng.integers(0, 4, (n_steps, N_SWIMMERS))]:
            after = path[-1] + move
            path.append(np.where(open_sites[tuple((after % CELL).T)][:, None], after, path[-1]))
        position = np.pad(np.stack(path)[::every].astype(float), ((0, 0), (0, 0), (0, 1)))
        angle = rng.uniform(0.0, 2.0 * math.pi, position.shape[:2])
        directors = np.stack([np.cos(angle), np.sin(angle), np.zeros(angle.shape)], axis=2)
        clock = np.arange(len(position)) * float(every)
        about = synthetic.info(n_swimmers=N_SWIMMERS, last_time=clock[-1], dimensions=2)
        return synthetic.lags(replace(about, spacing=float(CELL)), clock, position, directors)

    return Study("passive, among blocks", times, truth, draw)


def grid_diffusivity(open_sites: np.ndarray) -> float:
    """Along x, of steps to one of four neighbours, where that is open: from the potential of a unit gradient."""
    n = open_sites.size
    number = np.arange(n).reshape(open_sites.shape)
    laplacian, source, bonds = np.zeros((n, n)), np.zeros(n), []
    for axis in (0, 1):
        joined = open_sites & np.roll(open_sites, -1, axis)
        for a, b in zip(number[joined], np.roll(number, -1, axis)[joined], strict=True):
            gradient = 1.0 if axis == 0 else 0.0
            laplacian[[a, b], [a, b]] += 1.0
            laplacian[[a, b], [b, a]] -= 1.0
            source[a] += gradient
            source[b] -= gradient
            bonds.append((a, b, gradient))
    potential = np.linalg.lstsq(laplacian, source, rcond=None)[0]
    dissipated = sum((gradient + potential[b] - potential[a]) ** 2 for a, b, gradient in bonds)
    return 0.25 * dissipated / open_sites.sum()


@dataclass(frozen=True)
class Outcome:
    """Of many repeats."""

    n: int
    given: float  # share that had a diffusivity
    bias: float  # over the mean stated error
    scatter: float  # standard deviation of the deviation over the stated error
    covered: float
    error: float  # stated, relative
    reasons: tuple[str, ...]


def outcome(study: Study, *, repeats: int) -> Outcome:
    rng = np.random.default_rng(1)
    fits = [an.ensemble_diffusivity(study.draw(rng)) for _ in range(repeats)]
    assert all((fit.reason is None) == fit.linear == math.isfinite(fit.value) for fit in fits)
    found = [fit for fit in fits if fit.linear]
    reasons = tuple(fit.reason for fit in fits if fit.reason is not None)
    if len(found) < 2:
        return Outcome(repeats, len(found) / repeats, 0.0, 1.0, 0.95, 0.0, reasons)
    off = np.array([fit.value for fit in found]) - study.truth
    error = np.array([fit.standard_error for fit in found])
    covered = np.mean([fit.interval[0] <= study.truth <= fit.interval[1] for fit in found])
    return Outcome(
        repeats, len(found) / repeats, float(np.mean(off) / np.mean(error)), float(np.std(off / error)), float(covered),
        float(np.mean(error)) / study.truth, reasons,
    )  # fmt: skip


def check(found: Outcome) -> None:
    n = max(found.given * found.n, 1.0)
    assert abs(found.bias) < 0.3 + 4.0 / math.sqrt(n)
    lowest, highest = (rate + sign * 4.0 * math.sqrt(0.05 * 0.95 / n) for rate, sign in ((0.93, -1), (0.97, 1)))
    assert lowest <= found.covered <= highest


LONG = [free(100.0, noise=0.0), free(30.0, noise=30.0), among_blocks(100.0)]
FREE = {0.0: (3.0, 10.0, 20.0, 30.0, 100.0, 1000.0), 1.0: (10.0, 20.0, 100.0), 30.0: (3.0, 10.0, 100.0)}
ANY = [free(times, noise=noise) for noise, runs in FREE.items() for times in runs]
ANY += [among_blocks(times) for times in (3.0, 10.0, 30.0, 100.0, 1000.0)]


@pytest.mark.parametrize("study", LONG, ids=lambda study: study.name)
def test_a_diffusivity_of_a_long_run_has_no_bias_and_its_intervals_cover_the_truth(study: Study) -> None:
    found = outcome(study, repeats=FEW)
    assert found.given > 0.9
    check(found)


@pytest.mark.parametrize("times", [1.0, 3.0, 10.0])
def test_a_run_of_few_persistence_times_has_no_diffusivity_and_says_why(times: float) -> None:
    found = outcome(free(times, noise=0.0), repeats=20)
    assert found.given == 0.0
    assert all("directors" in reason for reason in found.reasons)


@pytest.mark.slow
@pytest.mark.parametrize("study", ANY, ids=lambda study: f"{study.name}, {study.times:g} times")
def test_a_diffusivity_of_any_run_has_no_bias_and_its_intervals_cover_the_truth(study: Study) -> None:
    found = outcome(study, repeats=MANY)
    if not found.given:
        print(f"\n| {study.name} | {study.times:g} | never | | | | |")
        return
    print(
        f"\n| {study.name} | {study.times:g} | {100 * found.given:.0f} % | {found.bias:+.2f} | {found.scatter:.2f} | "
        f"{100 * found.covered:.1f} % | {100 * found.error:.1f} % |"
    )
    check(found)


def test_the_diffusivity_of_an_open_grid_and_of_channels_is_that_of_a_walk_in_the_plane_and_on_a_line() -> None:
    assert grid_diffusivity(np.ones((5, 4), bool)) == pytest.approx(0.25, rel=1e-12)
    channels = np.ones((6, 4), bool)
    channels[:, :2] = False  # along x, two sites wide
    assert grid_diffusivity(channels) == pytest.approx(0.25, rel=1e-12)
    assert grid_diffusivity(channels.T) == pytest.approx(0.0, abs=1e-12)
