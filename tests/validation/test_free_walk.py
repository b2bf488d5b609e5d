"""Swimmers without colloids, against the exact moments of the persistent random walk that their steps make.

A director that turns at random at every step keeps on average the share c of its direction. With n steps dt, in d
dimensions,

    <e(n dt).e(0)> = c^n,   <|x|^2> = 2 d D n dt + dt^2 sum over j, k = 0..n of w_j w_k c^|j - k|,

where an Euler step goes along the director at its start, w = 1, ..., 1, 0, and a step between reflecting walls along
the mean of the directors at its ends, w = 1/2, 1, ..., 1, 1/2.
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest

import porous_swim as ps
from tests.validation.agreement import Figure, require_agreement
from tests.validation.scenes import make_scene

D, D_r = 0.05, 0.3  # not D_r = 3 D/4, so that neither can stand in for the other
TIME_STEP, DURATION, EVERY = 0.05, 20.0, 2.5
# (dimensions, precision, variates); each is a kernel of its own, whose first compilation takes far longer than the run
REDUCED = [(2, "f64", "gaussian", "euler"), (3, "f32", "gaussian", "euler"), (3, "f32", "uniform", "euler")]
FULL = list(product((2, 3), ("f32", "f64"), ("gaussian", "uniform"), ("euler", "reflected")))
kinds = pytest.mark.parametrize(
    ("count", "dimensions", "precision", "variates", "integrator"),
    [(20_000, *kind) for kind in REDUCED] + [pytest.param(200_000, *kind, marks=pytest.mark.slow) for kind in FULL],
)


def kept_share(dimensions: int, variates: str) -> float:
    """c: the mean cosine of one step's turn, whose variance is v = 2 D_r dt in each direction.

    In the plane exact. In space 1 - <w^2>/2 + <w^4>/24 with w the tangential part of three variates: <w^2> = 2 v, and
    <w^4> = 8 v^2 for Gaussian ones; for uniform ones, of fourth moment 1.8 v^2, 6.08 v^2 on average over directions.
    Terms of v^3 (Gaussian: -v^3/15, 2e-6) change c^400 by less than 1e-3 of itself.
    """
    v = 2.0 * D_r * TIME_STEP
    if dimensions == 3:
        return 1.0 - v + (8.0 if variates == "gaussian" else 6.08) * v**2 / 24.0
    width = math.sqrt(3.0 * v)  # of the uniform distribution with variance v
    return math.exp(-0.5 * v) if variates == "gaussian" else math.sin(width) / width


@kinds
def test_a_free_swimmer_is_the_persistent_random_walk_of_its_steps(count, dimensions, precision, variates, integrator):
    noise = {"kind": "brownian", "translational_diffusion": D, "rotational_diffusion": D_r, "variates": variates}
    scene = make_scene(
        # A force dipole without a colloid to reflect its flow must not matter.
        swimmers={"count": count, "dipole_strength": 4.0, "release": {"kind": "point", "position": [0.0] * dimensions}},
        obstacles={"layout": "none"}, dimensions=dimensions, noise=noise,
        run={"time_step": TIME_STEP, "duration": DURATION, "seed": 11},
        record={"every": EVERY, "swimmers": count},
    ).replace({"run.precision": precision, "run.integrator": integrator})  # fmt: skip
    trajectory = ps.run(scene).trajectory
    squared, turned = ps.analysis.msd(trajectory), ps.analysis.director_correlation(trajectory)

    c, theirs, ours = kept_share(dimensions, variates), {}, {}
    for k in range(1, len(squared.lag)):
        time, n = squared.lag[k], round(squared.lag[k] / TIME_STEP)
        weight = np.array([1.0] * n + [0.0] if integrator == "euler" else [0.5] + [1.0] * (n - 1) + [0.5])
        correlation = c ** np.abs(np.subtract.outer(np.arange(n + 1), np.arange(n + 1)))
        theirs[f"msd at {time:g}"] = Figure(2.0 * dimensions * D * time + TIME_STEP**2 * weight @ correlation @ weight)
        theirs[f"e.e at {time:g}"] = Figure(c**n)
        for name, lagged in (("msd", squared), ("e.e", turned)):
            ours[f"{name} at {time:g}"] = Figure(lagged.value[k], lagged.standard_error[k])
    require_agreement(ours, theirs)
    assert np.isclose(squared.lag[-1], DURATION)
