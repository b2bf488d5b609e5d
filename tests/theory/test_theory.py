"""Closed forms and exact roots against an independent solution of the full equations."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import porous_swim as ps
from porous_swim import theory
from porous_swim.theory import critical_radius, escape_angle
from tests.support.commands import porous_swim

# Independent simulator (event-located contact), digits as known.
PUSHERS = {0.2: 182.230, 0.4: 48.768, 0.6: 23.899, 0.8: 15.061, 1.0: 10.866}
STRONG_PUSHERS = {2.0: 4.757, 3.0: 3.293, 4.0: 2.637}
PULLERS = {-0.4: 8.117, -0.6: 5.860, -0.8: 4.714, -1.2: 3.541}


@pytest.mark.parametrize(("alpha", "radius"), [*PUSHERS.items(), *STRONG_PUSHERS.items(), *PULLERS.items()])
def test_exact_critical_radius_is_that_of_the_full_equations(alpha: float, radius: float) -> None:
    assert critical_radius(alpha) == pytest.approx(radius, abs=5.1e-4)  # the last digit listed, rounded


def test_critical_radius_of_a_weak_pusher_is_that_of_the_full_equations() -> None:
    assert critical_radius(0.1) == pytest.approx(715.60, abs=5.1e-3)


def test_leading_order_is_too_low_by_the_known_shares() -> None:
    low = {alpha: 1.0 - critical_radius(alpha, order="leading") / radius for alpha, radius in PUSHERS.items()}
    expected = {0.2: 0.024, 0.4: 0.089, 0.6: 0.17, 0.8: 0.26, 1.0: 0.35}
    assert low == pytest.approx(expected, abs=6e-3)  # the shares are listed to a per cent, 0.2 and 0.4 better


def test_leading_order_is_the_limit_of_weak_dipoles() -> None:
    for alpha in (0.002, -0.002):
        # The next order is a constant: for pushers 8/(3 alpha s_e) + 3/2 gives 8/3 + 3/2 + O(alpha^2)
        # more than 64/(9 alpha^2), since 1/s_e = 1/beta + 3 beta and beta = 3 alpha/8.
        leading = critical_radius(alpha, order="leading")
        assert critical_radius(alpha) == pytest.approx(leading, abs=5.0)
        assert leading > 1000.0


def test_exact_root_agrees_with_the_improved_closed_form() -> None:
    for alpha in (0.1, 0.4, 0.7, 1.0):
        beta = 3.0 * alpha / 8.0
        sine = (-1.0 + math.sqrt(1.0 + 12.0 * beta**2)) / (6.0 * beta)
        closed = 8.0 / (3.0 * alpha * sine) + 1.5
        assert critical_radius(alpha) == pytest.approx(closed, rel=1.75e-3)  # it is known to 0.17 %


def test_a_swimmer_without_a_dipole_is_never_held() -> None:
    assert critical_radius(0.0) == math.inf
    assert critical_radius(0.0, aspect_ratio=0.5, order="leading") == math.inf


def test_leading_order_of_rods_has_two_plus_gamma() -> None:
    aspect_ratio, bretherton = 0.5, 0.6  # (1 - 1/4)/(1 + 1/4)
    pusher = critical_radius(0.8, aspect_ratio, order="leading")
    assert pusher == pytest.approx(128.0 * 0.5**5 / (9.0 * 0.64 * (2.0 + bretherton)), rel=1e-14)
    puller = critical_radius(-0.8, aspect_ratio, order="leading")
    assert puller == pytest.approx(8.0 / (3.0 * 0.8 * (1.0 + bretherton)), rel=1e-14)


def test_lift_off_pitch_near_the_critical_radius_is_the_known_one() -> None:
    assert escape_angle(0.8, 15.06) == pytest.approx(0.2480, abs=5e-5)
    assert escape_angle(0.8, order="leading") == pytest.approx(0.300, rel=1e-14)


def test_lift_off_pitch_at_a_plane_solves_its_quadratic() -> None:
    sine = math.sin(escape_angle(0.8))
    assert sine + 0.3 * (3.0 * sine**2 - 1.0) == pytest.approx(0.0, abs=1e-15)
    assert escape_angle(0.8, 1e9) == pytest.approx(escape_angle(0.8), rel=1e-8)  # corrections are of order 1/A


def test_improved_closed_form_is_within_its_stated_error() -> None:
    for alpha, share in {0.1: 0.0017, 0.4: 0.0017, 0.8: 0.0017, 1.0: 0.00175, 2.0: 0.0225, 4.0: 0.0995}.items():
        assert critical_radius(alpha, order="improved") == pytest.approx(critical_radius(alpha), rel=share)


@pytest.mark.parametrize("aspect_ratio", [0.3, 0.7, 1.0])
@pytest.mark.parametrize("radius", [3.0, 40.0])
def test_rates_are_those_of_the_drift_of_the_kernel(radius: float, aspect_ratio: float) -> None:
    """The height and the pitch of one kernel velocity and director rate, in their own geometry."""
    for pitch, height in ((0.3, 1.2), (-1.2, 0.8), (1.5, 2.0)):
        n, t = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
        e = np.cos(pitch) * t + np.sin(pitch) * n
        velocity, turning = ps.drift(
            [(radius + height) * n], [e], radius=radius, dipole_strength=0.6, aspect_ratio=aspect_ratio
        )
        turn = turning[0] @ (np.cos(pitch) * n - np.sin(pitch) * t) + velocity[0] @ t / (radius + height)
        expected = [velocity[0] @ n, turn]
        assert theory.rates(pitch, height, radius, 0.6, aspect_ratio) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("aspect_ratio", [0.4, 1.0])
def test_near_wall_rates_are_the_limit_of_large_colloids_at_first_order(aspect_ratio: float) -> None:
    """With the sign of Gamma in Appendix B; with the printed one nothing converges."""

    def errors(radius: float) -> np.ndarray:
        full = np.array(theory.rates(0.4, 1.1, radius, 0.6, aspect_ratio))
        return np.abs(np.array(theory.near_wall_rates(0.4, 1.1, radius, 0.6, aspect_ratio)) - full)

    # the next order of the pitch's rate is h/A, that of the height's rate (h/A)^2
    assert errors(1e4) == pytest.approx(np.array([0.01, 0.1]) * errors(1e3), rel=0.02)
    assert np.all(errors(1e4) < 1e-3)
    plane = np.array(theory.rates(0.4, 1.1, math.inf, 0.6, aspect_ratio))
    assert np.array(theory.rates(0.4, 1.1, 1e7, 0.6, aspect_ratio)) == pytest.approx(plane, abs=3e-7)


def test_contact_height_of_theory_is_that_of_the_kernel() -> None:
    for pitch in (-1.2, 0.0, 0.3):
        for radius in (2.0, 50.0):
            (kernel,) = ps.contact_height([pitch], radius=radius, aspect_ratio=0.3)
            assert theory.contact_height(pitch, radius, 0.3) == pytest.approx(kernel, abs=1e-13)


def test_a_spheroid_at_its_critical_radius_rests_at_lift_off() -> None:
    radius = critical_radius(0.4, 0.7)
    pitch = escape_angle(0.4, radius, 0.7)
    height = theory.contact_height(pitch, radius, 0.7)
    assert theory.rates(pitch, height, radius, 0.4, 0.7) == pytest.approx((0.0, 0.0), abs=1e-12)
    assert theory.equilibrium_pitch(0.4, 1.0001 * radius, 0.7) == pytest.approx(pitch, rel=1e-3)


def test_equilibrium_pitch_is_the_listed_one_and_none_below_the_critical_radius() -> None:
    assert theory.equilibrium_pitch(0.8, 20.0) == pytest.approx(0.18107, abs=5e-6)
    assert theory.equilibrium_pitch(0.8, 15.0) is None
    assert theory.equilibrium_pitch(-0.8, 20.0) == -math.pi / 2
    leading = theory.equilibrium_pitch(0.05, 1e5, order="leading")
    assert leading == pytest.approx(theory.equilibrium_pitch(0.05, 1e5), rel=1e-3)


def test_basin_depth_is_the_printed_closed_form() -> None:
    assert theory.basin_depth(0.8, 200.0) == pytest.approx(0.96 * 128.0**0.2, rel=1e-14)


@pytest.mark.filterwarnings("ignore:mean_trapping_time")
def test_mean_trapping_times_are_the_listed_integrals_and_estimates() -> None:
    noise = [5e-4, 1e-3, 2e-3, 4e-3, 8e-3, 2e-2]
    with pytest.warns(UserWarning, match="near-wall theory at small pitch does not hold"):
        integral = [theory.mean_trapping_time(0.8, 20.0, 0.75 * D) for D in noise]
    assert integral == pytest.approx([2977, 135.6, 33.82, 16.12, 9.718, 5.686], rel=4e-4)  # digits listed
    for (A, D), listed in {(5.0, 0.002): 1.952, (50.0, 0.004): 66.4, (100.0, 0.008): 29.5}.items():
        assert theory.mean_trapping_time(0.8, A, 0.75 * D) == pytest.approx(listed, rel=1.7e-3)
    with pytest.warns(UserWarning, match="the integral is better"):
        estimate = [theory.mean_trapping_time(0.8, 20.0, 0.75 * D, order="estimate") for D in noise]
    assert estimate == pytest.approx([22.1, 18.4, 14.39, 10.87, 8.03, 5.27], abs=0.051)


# (alpha, A, D): E[T_theta] of an independent simulator, with errors of 2 % and less
SIMULATED = {
    (0.8, 20.0, 5e-4): 60.5, (0.8, 20.0, 1e-3): 29.4, (0.8, 20.0, 2e-3): 18.1, (0.8, 20.0, 4e-3): 11.9,
    (0.8, 20.0, 8e-3): 8.30, (0.8, 20.0, 2e-2): 5.68, (0.8, 5.0, 2e-3): 2.14, (0.8, 50.0, 4e-3): 42.3,
    (0.8, 100.0, 8e-3): 24.0, (0.2, 20.0, 2e-3): 1.592, (0.2, 320.0, 2e-3): 8.76,
}  # fmt: skip


@pytest.mark.filterwarnings("ignore:mean_trapping_time")
@pytest.mark.parametrize("at", SIMULATED)
def test_the_integral_is_not_trusted_where_simulations_differ_from_it_by_a_fifth(at) -> None:
    alpha, A, D = at
    off = abs(theory.mean_trapping_time(alpha, A, 0.75 * D) / SIMULATED[at] - 1.0)
    assert bool(theory.trapping_warnings(alpha, A, 0.75 * D)) == (off > 0.2)


def test_the_integral_is_not_trusted_at_large_pitches_and_at_small_colloids() -> None:
    (found,) = theory.trapping_warnings(4.0, 3.5, 0.0045)  # swimmers of the crystal: lift-off at 0.495, not at 1.5
    assert "0.495 rad, not 1.5 rad" in found
    assert theory.trapping_warnings(0.2, 0.8, 0.0015)  # the colloid is smaller than the height of the swimmer
    assert theory.trapping_warnings(0.8, math.inf, 1e-6)  # infinite with the full equations too


@pytest.mark.filterwarnings("ignore:mean_trapping_time")
def test_survival_integrates_to_the_mean_and_falls_from_one_to_zero() -> None:
    times = np.linspace(0.0, 800.0, 40001)
    survival = theory.trapping_survival(times, 0.8, 20.0, 0.0015)
    assert survival[0] == pytest.approx(1.0, abs=1e-10)
    assert np.all(np.diff(survival) < 1e-12)
    # finite volumes 1e-5; the trapezoid on a first step of 0.02 less
    assert np.trapezoid(survival, times) == pytest.approx(theory.mean_trapping_time(0.8, 20.0, 0.0015), rel=3e-5)


def test_inverse_gaussian_has_the_paper_s_lambda() -> None:
    law = theory.inverse_gaussian(38.4, 20.3)
    assert (law.mean(), law.std()) == pytest.approx((38.4, 20.3), rel=1e-12)
    t, shape = 30.0, 137.40  # lambda of the first panel, 137
    density = math.sqrt(shape / (2 * math.pi * t**3)) * math.exp(-shape * (t - 38.4) ** 2 / (2 * 38.4**2 * t))
    assert law.pdf(t) == pytest.approx(density, rel=1e-3)


def test_sliding_is_the_integration_of_the_near_wall_equations() -> None:
    alpha, A, arrival = 0.5, 20.0, -0.8
    leave = 0.375 * alpha

    def rates(_: float, y: np.ndarray) -> list[float]:
        return [theory.near_wall_rates(y[0], 1.0, A, alpha)[1], math.cos(y[0]) / A]

    left = lambda _, y: y[0] - leave  # noqa: E731
    left.terminal = True
    path = solve_ivp(rates, (0.0, 500.0), [arrival, 0.0], events=left, rtol=1e-10, atol=1e-12)
    assert theory.sliding_time(alpha, A, arrival_pitch=arrival) == pytest.approx(path.t[-1], rel=1e-8)
    assert theory.winding(alpha, A, arrival_pitch=arrival) == pytest.approx(path.y[1, -1] / (2 * math.pi), rel=1e-8)


def test_scattering_diverges_where_rest_meets_escape() -> None:
    # 64/(9 alpha^2) passes A = 20 at alpha = 0.5963; with sines, 8/(3 A alpha) = sin(3 alpha/8), at 0.59880
    assert theory.scattering_angle(0.5987, 20.0, 20.0) is not None
    assert theory.scattering_angle(0.5989, 20.0, 20.0) is None
    assert theory.scattering_angle(1e-6, 20.0, 21.0) == pytest.approx(0.0, abs=1e-5)  # grazes, and goes on


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: critical_radius(0.4, 1.2), "aspect_ratio: found 1.2, allowed are 0 < aspect_ratio <= 1"),
        (lambda: critical_radius(0.4, order="best"), "order: found 'best'"),
        (lambda: critical_radius(-0.4, order="improved"), "use 'exact'"),
        (lambda: theory.mean_trapping_time(0.4, -1.0, 0.1), "radius: found -1"),
        (lambda: theory.scattering_angle(0.4, 20.0, 22.0), "allowed are up to radius"),
        (lambda: theory.sliding_time(5.0, 20.0), "near-wall theory needs"),
        (lambda: theory.basin_depth(-0.4, 20.0), "dipole_strength: found -0.4"),
    ],
)
def test_arguments_out_of_range_are_one_sentence(call, sentence: str) -> None:
    with pytest.raises(ValueError, match=sentence.replace("+", "[+]")):
        call()


def test_the_command_prints_a_table_and_json(tmp_path) -> None:
    argv = ["theory", "--dipole-strength", "0.8", "--radius", "20", "--diffusion", "0.002"]
    table = porous_swim(*argv, cwd=tmp_path).stdout
    assert "critical radius (exact)" in table
    assert "15.061 a" in table
    rows = json.loads(porous_swim(*argv, "--json", cwd=tmp_path).stdout)
    values = {(row["quantity"], row["order"]): row["value"] for row in rows}
    assert values["mean trapping time", "integral"] == pytest.approx(33.82, abs=0.005)
    assert values["sliding time from pitch 0", "near wall"] == "infinite"


def test_the_command_says_why_neither_trapping_time_holds_for_the_swimmers_of_the_crystal(tmp_path) -> None:
    argv = ["theory", "--dipole-strength", "4", "--radius", "3.5", "--diffusion", "0.006"]
    done = porous_swim(*argv, cwd=tmp_path)
    integral, estimate = done.stdout.splitlines()[-2:]
    for line in (integral, estimate):
        assert "out of its range: near-wall theory at small pitch does not hold here" in line
    assert "expansion for u below 0.5" in estimate
    assert done.stderr == ""


@pytest.mark.parametrize(
    ("argv", "sentence"),
    [
        (["--dipole-strength", "0.8", "--aspect-ratio", "2"], "theory: aspect_ratio: found 2"),
        *(
            (
                ["--dipole-strength", "0.8", "--radius", radius],
                f"theory: radius: found {radius}, allowed are numbers above 0, or inf for a plane wall",
            )
            for radius in ("-2", "0", "nan")
        ),
        *(
            (
                ["--dipole-strength", "0.8", "--radius", "20", "--diffusion", D],
                f"theory: diffusion: found {D}, allowed are finite numbers above 0",
            )
            for D in ("inf", "0", "-1", "nan")
        ),
        (["--dipole-strength", "1e300"], "theory: found numbers whose powers are beyond double precision"),
        (["--dipole-strength", "nan"], "theory: dipole_strength: found nan, allowed are finite numbers"),
        (["--dipole-strength", "-inf"], "theory: dipole_strength: found -inf, allowed are finite numbers"),
        (["--dipole-strength", "0.8", "--diffusion", "0.1"], "theory: --diffusion needs a --radius"),
    ],
)
def test_the_command_refuses_in_one_sentence(argv, sentence: str, tmp_path) -> None:
    done = porous_swim("theory", *argv, cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith(sentence)
    assert done.stderr.count("\n") == 1


def test_the_command_prints_what_holds_beside_what_does_not(tmp_path) -> None:
    table = porous_swim("theory", "--dipole-strength", "8", "--radius", "3", cwd=tmp_path).stdout
    assert "1.69454 a" in table  # the exact critical radius
    assert table.count("none (dipole_strength: found 8, but near-wall theory needs") == 5
