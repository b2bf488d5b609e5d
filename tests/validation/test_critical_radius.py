"""Capture without noise: the critical radius, and three encounters with one colloid.

The independent values come from an eighth-order integrator with located contact (relative tolerance 1e-11). Forward
Euler is first order here: its critical radius is high by 0.1 x time step (relative, measured at 0.02, 0.01 and
0.005 for all five strengths). At a step of 0.005 that is 0.05 %, a tenth of the 0.5 % by which the radius is
bracketed; half the step must give the same verdicts.
"""

from __future__ import annotations

import math

import pytest

import porous_swim as ps
from tests.validation.scenes import one_swimmer

CRITICAL_RADIUS = {0.2: 182.230, 0.4: 48.768, 0.6: 23.899, 0.8: 15.061, 1.0: 10.866}
DURATION = 400.0
time_steps = pytest.mark.parametrize("time_step", [0.005, 0.0025])


def is_held(radius: float, dipole_strength: float, position: list[float], time_step: float) -> bool:
    """Whether the swimmer's one encounter lasts to the end of the run."""
    scene = one_swimmer(radius, dipole_strength, position, time_step=time_step, duration=DURATION)
    (encounter,) = ps.run(scene).encounters.to_pylist()
    return bool(encounter["end_censored"])


@time_steps
def test_a_head_on_swimmer_escapes_radius_15_and_is_held_by_15_1(time_step):
    assert not is_held(15.0, 0.8, [-40.0, 0.1], time_step)
    assert is_held(15.1, 0.8, [-40.0, 0.1], time_step)


@time_steps
@pytest.mark.parametrize(("dipole_strength", "critical"), CRITICAL_RADIUS.items())
def test_the_critical_radius_is_bracketed_within_half_a_percent(dipole_strength, critical, time_step):
    for factor, held in ((0.995, False), (1.005, True)):
        radius = factor * critical
        assert is_held(radius, dipole_strength, [0.0, radius + 1.0], time_step) is held, factor


@pytest.mark.slow
@pytest.mark.parametrize(("dipole_strength", "critical"), CRITICAL_RADIUS.items())
def test_the_extrapolated_critical_radius_is_the_listed_one(dipole_strength, critical):
    width = 1e-5  # relative, of the last bracket

    def bisected(time_step: float) -> float:
        low, high = 0.99 * critical, 1.01 * critical
        while high - low > width * critical:
            middle = 0.5 * (low + high)
            held = is_held(middle, dipole_strength, [0.0, middle + 1.0], time_step)
            low, high = (low, middle) if held else (middle, high)
        return 0.5 * (low + high)

    coarse, fine = bisected(0.01), bisected(0.005)
    extrapolated = 2.0 * fine - coarse
    print(f"A_c at alpha = {dipole_strength}: {fine:.4f} at 0.005, extrapolated {extrapolated:.4f}, listed {critical}")
    # Half a bracket for each run, tripled at most by 2 fine - coarse; half of the last listed digit; and the second
    # order, (0.1 time_step)^2 = 1e-6, negligible.
    assert extrapolated == pytest.approx(critical, abs=1.5 * width * critical + 0.0005)


def encounter_with(radius: float, time_step: float, duration: float) -> dict[str, float]:
    """Times (a/U) and angles (degrees) of the swimmer from (-40, 0.1) that heads along x."""
    scene = one_swimmer(radius, 0.8, [-40.0, 0.1], time_step=time_step, duration=duration)
    results = ps.run(scene)
    encounter, last = results.encounters.to_pylist()[-1], results.trajectory.to_pylist()[-1]
    return {
        "contact": encounter["start_time"], "release": encounter["release_time"], "pitch": encounter["exit_pitch"],
        "angle": math.degrees(math.atan2(last["ey"], last["ex"])),
    }  # fmt: skip


LISTED = {
    5.0: {"contact": 34.73, "release": 51.19, "angle": 36.05},
    15.0: {"contact": 24.77, "release": 68.55, "angle": -43.24},
    20.0: {"contact": 19.76, "pitch": 0.18107},
}
DIGIT = {"contact": 0.01, "release": 0.01, "angle": 0.01, "pitch": 0.00001}


@pytest.mark.parametrize("radius", LISTED)
def test_contact_release_and_outgoing_angle_extrapolate_to_the_listed_ones(radius):
    """From steps dt and dt/2; the second order that is left is bounded by a quarter of the same from 2 dt and dt."""
    time_step = 0.0005
    runs = [encounter_with(radius, factor * time_step, 120.0) for factor in (4, 2, 1)]
    for what, listed in LISTED[radius].items():
        coarse, middle, fine = (run[what] for run in runs)
        before, extrapolated = 2.0 * middle - coarse, 2.0 * fine - middle
        # An event is booked at the end of its step: each run is off by up to one step, the extrapolate by three.
        grid = 3.0 * 2.0 * time_step if what in ("contact", "release") else 0.0
        second_order = abs(extrapolated - before)
        tolerance = 0.5 * DIGIT[what] + grid + second_order
        print(f"A = {radius}, {what}: {fine:.6g}, extrapolated {extrapolated:.6g} ({tolerance:.2g}), listed {listed}")
        assert second_order < 5.0 * DIGIT[what] + 2.0 * grid  # or the bound above would allow anything
        assert extrapolated == pytest.approx(listed, abs=tolerance)
