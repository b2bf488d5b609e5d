"""Closed forms and exact roots against an independent solution of the full equations."""

from __future__ import annotations

import math

import pytest

from porous_swim.analysis.theory import critical_radius, escape_angle

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


def test_rods_have_no_exact_order_and_the_error_says_what_to_use() -> None:
    for refused in (critical_radius, lambda alpha, ratio: escape_angle(alpha, 20.0, ratio)):
        with pytest.raises(ValueError, match='order="leading"'):
            refused(0.8, 0.5)


def test_an_impossible_aspect_ratio_is_refused() -> None:
    with pytest.raises(ValueError, match=r"found 1\.5, allowed are 0 < aspect_ratio <= 1"):
        critical_radius(0.8, 1.5)
