"""One swimmer at one colloid without noise, with located events: the listed numbers to their last digit.

The independent values come from an eighth-order integrator with event-located contact (relative tolerance 1e-11).
"""

from __future__ import annotations

import math

import numpy as np
import pytest

import porous_swim as ps
from tests.support.engines import fingerprint, hexagonal, make_engine, released
from tests.validation.scenes import one_swimmer
from tests.validation.test_critical_radius import CRITICAL_RADIUS, DIGIT, LISTED


def located(radius: float, dipole_strength: float, position, *, time_step=0.1, duration=120.0) -> ps.Results:
    scene = one_swimmer(
        radius, dipole_strength, position, time_step=time_step, duration=duration, integrator="located"
    )  # fmt: skip
    return ps.run(scene)


@pytest.mark.parametrize(("dipole_strength", "critical"), CRITICAL_RADIUS.items())
def test_a_swimmer_escapes_two_thousandths_below_the_critical_radius_and_is_held_as_much_above(
    dipole_strength, critical
):
    for factor, held in ((0.998, False), (1.002, True)):
        radius = factor * critical
        (encounter,) = located(radius, dipole_strength, [0.0, radius + 1.0], duration=600.0).encounters.to_pylist()
        assert encounter["end_censored"] is held, factor


def test_an_elongated_swimmer_escapes_below_its_critical_radius_and_is_bound_above():
    gamma, alpha = 0.7, 0.4
    critical = ps.theory.critical_radius(alpha, gamma)
    for factor, held in ((0.98, False), (1.02, True)):
        radius = factor * critical
        height = ps.contact_height([0.0], radius=radius, aspect_ratio=gamma)[0]
        scene = one_swimmer(
            radius, alpha, [0.0, radius + height], time_step=0.1, duration=400.0, integrator="located"
        ).replace({"swimmers.aspect_ratio": gamma})  # fmt: skip
        (encounter,) = ps.run(scene).encounters.to_pylist()
        assert encounter["end_censored"] is held, factor


def test_the_near_wall_model_holds_a_swimmer_from_its_own_critical_radius_on():
    # at lift-off s = (3 alpha/8)(1 - 3 s^2) and at rest 1/A = (3 alpha/8) s: 3/2 below the improved closed form
    critical = ps.theory.critical_radius(0.8, order="improved") - 1.5
    for factor, held in ((0.998, False), (1.002, True)):
        radius = factor * critical
        scene = one_swimmer(
            radius, 0.8, [0.0, radius + 1.0], time_step=0.1, duration=600.0, integrator="located"
        ).replace({"hydrodynamics": {"kind": "near_wall"}})  # fmt: skip
        (encounter,) = ps.run(scene).encounters.to_pylist()
        assert encounter["end_censored"] is held, factor


@pytest.mark.parametrize("radius", LISTED)
def test_contact_release_and_outgoing_angle_are_the_listed_ones(radius):
    results = located(radius, 0.8, [-40.0, 0.1])
    encounter, last = results.encounters.to_pylist()[-1], results.trajectory.to_pylist()[-1]
    ours = {
        "contact": encounter["start_time"], "release": encounter["release_time"], "pitch": encounter["exit_pitch"],
        "angle": math.degrees(math.atan2(last["ey"], last["ex"])),
    }  # fmt: skip
    for what, listed in LISTED[radius].items():
        assert ours[what] == pytest.approx(listed, abs=0.51 * DIGIT[what]), what  # half a unit of the last digit


def test_every_column_of_the_encounter_table_is_independent_of_the_time_step():
    """To ten digits; least and largest height only where they are at an event, as here."""
    coarse, fine = (
        located(15.0, 0.8, [-40.0, 0.1], time_step=time_step).encounters.to_pylist()[0] for time_step in (0.2, 0.03)
    )
    for name, value in fine.items():
        assert coarse[name] == pytest.approx(value, rel=1e-8, abs=1e-8, nan_ok=True), name


def test_winding_is_the_angle_between_the_points_of_contact_and_lift_off():
    results = located(15.0, 0.8, [-40.0, 0.1])
    (encounter,) = results.encounters.to_pylist()
    # below pi here; polar angles from the entry and, since the last contact is not listed, from the exit
    swept = math.atan2(encounter["exit_y"], encounter["exit_x"]) - math.atan2(
        encounter["entry_y"], encounter["entry_x"]
    )
    turns = abs((swept + math.pi) % (2.0 * math.pi) - math.pi) / (2.0 * math.pi)
    assert encounter["winding"] == pytest.approx(turns, abs=1e-12)
    assert abs(encounter["signed_winding"]) == pytest.approx(turns, abs=1e-9)
    assert 0.0 < encounter["release_winding"] < encounter["winding"]


def test_a_fast_graze_of_the_wall_is_not_missed():
    """A swimmer without flow passes a sphere in a straight line, a hair within or beyond contact."""
    for depth, n_encounters in ((1e-7, 1), (-1e-7, 0)):
        scene = one_swimmer(
            20.0, 0.0, [-30.0, 21.0 - depth], time_step=0.5, duration=60.0, integrator="located"
        )  # fmt: skip
        assert ps.run(scene).encounters.num_rows == n_encounters, depth


def test_located_runs_are_the_same_to_the_bit_however_they_are_cut():
    field = hexagonal()
    position, director = released(field, 48, seed=3)
    prints = set()
    for cuts in ((40,), (1, 6, 33), (20, 20)):
        engine = make_engine(
            field, position, director, alpha=4.0, D=0.0, precision="f64", time_step=0.1, integrator="located"
        )  # fmt: skip
        for steps in cuts:
            engine.advance(steps)
        prints.add(fingerprint(engine))
    assert len(prints) == 1


def test_no_located_swimmer_of_a_crystal_is_ever_inside_a_colloid():
    field = hexagonal()
    position, director = released(field, 200, seed=4)
    engine = make_engine(
        field, position, director, alpha=4.0, D=0.0, precision="f64", time_step=0.25, integrator="located"
    )  # fmt: skip
    for _ in range(40):
        engine.advance(1)
        now = engine.snapshot()
        # contact is followed to 1e-12 of the distance from the centre
        assert np.min(field.nearest(now.position)[2]) > 1.0 - 1e-10
        assert np.allclose(np.linalg.norm(now.director, axis=1), 1.0, rtol=0, atol=1e-14)
