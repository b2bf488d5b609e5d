"""How long noise leaves a swimmer at one colloid, against an independent simulator.

It was run with the scheme and step of the paper, and near the limit of short steps.

T_h is when the height first exceeds 1.5, T_theta when the pitch first exceeds 3 alpha/8, both from the start.
There swimmers start 0.001 above contact, here in contact, so that each has an encounter from t = 0 on (from 0.001
up to 0.6 % of those with alpha = 0.2 leave without touching). Driven by the same noise, the two heights differ by at
most 0.001 until the lower one has been pushed up to the upper one: at speeds of 0.1 and more that is 0.01 in T_h,
less than half of the smallest error below.
"""

from __future__ import annotations

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.analysis.columns import column
from tests.validation.agreement import Figure, figure, require_agreement
from tests.validation.scenes import make_scene

TIME_STEP = 0.001
# (A, alpha, D): (T_theta, T_h, duration); the duration is the mean and 8 to 12 times the standard deviation of T_h
LISTED = {
    (20.0, 0.8, 0.002): (Figure(18.28, 0.13), Figure(21.83, 0.14), 150.0),
    (20.0, 0.8, 0.004): (Figure(12.19, 0.09), Figure(16.26, 0.11), 120.0),
    (20.0, 0.2, 0.002): (Figure(1.617, 0.014), Figure(6.080, 0.023), 40.0),
    (320.0, 0.2, 0.002): (Figure(9.27, 0.14), Figure(32.66, 0.31), 300.0),
}
FIRST = next(iter(LISTED))
full = [pytest.param(at, 10_000, id=f"full-{at}", marks=pytest.mark.slow) for at in LISTED]


# (A, alpha, D): (T_theta, T_h), continuous-path contact and passages at a step of 0.005, by the same simulator
LIMITS = {
    (20.0, 0.8, 0.002): (Figure(18.00, 0.09), Figure(21.55, 0.10)),
    (20.0, 0.8, 0.004): (Figure(12.00, 0.06), Figure(16.05, 0.08)),
    (20.0, 0.2, 0.002): (Figure(1.592, 0.010), Figure(6.092, 0.017)),
    (320.0, 0.2, 0.002): (Figure(8.76, 0.09), Figure(32.03, 0.22)),
}


def passages(at, count: int, *, time_step: float, integrator: str) -> dict[str, Figure]:
    """Mean first passages of the escape pitch and of the escape height, in each swimmer's first encounter.

    A null escape pitch, where a swimmer came back before it had passed, counts as cut off at that time.
    """
    A, alpha, D = at
    _, _, duration = LISTED[at]
    scene = make_scene(
        swimmers={"count": count, "dipole_strength": alpha, "release": {"kind": "parallel", "height": 1.0}},
        obstacles={"layout": "single", "radius": A}, dimensions=3, D=D,
        run={"time_step": time_step, "duration": duration, "seed": 1, "integrator": integrator},
    )  # fmt: skip
    encounters = ps.run(scene).encounters
    first = column(encounters, "start_time") == 0.0
    assert np.array_equal(np.sort(column(encounters, "swimmer")[first]), np.arange(count))
    pitch = ps.analysis.escape_pitch_lifetimes(encounters).select(first).summary()
    height = ps.analysis.residence_lifetimes(encounters).select(first).summary()
    print(f"{at}: {height.n_censored} held to the end, null escape pitch in {pitch.n_censored} of {count}")
    # Cut off at the end, one swimmer in a thousand lowers a mean by 0.001 standard deviations, a tenth of an error.
    assert height.n_censored <= count // 1000
    return {"T_theta": figure(pitch.restricted_estimate()), "T_h": figure(height.restricted_estimate())}


@pytest.mark.parametrize(("at", "count"), [pytest.param(FIRST, 1000, id="reduced"), *full])
def test_trapping_times_are_those_of_an_independent_simulator(at, count):
    pitch_listed, height_listed, _ = LISTED[at]
    ours = passages(at, count, time_step=TIME_STEP, integrator="euler")
    require_agreement(ours, {"T_theta": pitch_listed, "T_h": height_listed})


@pytest.mark.parametrize(("at", "count"), [pytest.param(FIRST, 4000, id="reduced"), *full])
def test_reflecting_walls_give_the_trapping_times_of_short_steps_at_a_step_of_0_02(at, count):
    pitch_listed, height_listed = LIMITS[at]
    ours = passages(at, count, time_step=0.02, integrator="reflected")
    require_agreement(ours, {"T_theta": pitch_listed, "T_h": height_listed}, bias=0.005)
