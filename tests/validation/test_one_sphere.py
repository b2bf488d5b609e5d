"""Encounters with one colloid at the default step, against the backward equation of height and pitch."""

from __future__ import annotations

import math

import numpy as np
import pytest

import porous_swim as ps
from porous_swim.analysis.columns import column
from porous_swim.analysis.estimates import Swimmers, ratio_of_sums
from tests.support.backward import OneSphere
from tests.validation.agreement import Figure, require_agreement

BAND = 0.05  # a, of encounter.contact_band
# relative, of the solutions on grids of 100 by 300: half of what a grid twice as coarse changes, which is 4 times less
GRID = 3e-4


def first_encounters(hydrodynamics: str, *, alpha: float, radius: float, D: float, count: int, duration: float):
    """Encounter table of swimmers that start in contact with pitch 0, without the encounters that follow."""
    scene = ps.Scene.from_mapping(
        {
            "swimmers": {
                "count": count, "dipole_strength": alpha, "release": {"kind": "parallel", "height": 1.0},
            },
            "hydrodynamics": {"kind": hydrodynamics},
            "noise": {"kind": "brownian", "translational_diffusion": D},
            "obstacles": {"layout": "single", "radius": radius},
            "run": {"time_step": 0.02, "duration": duration, "seed": 5},
            "record": {"every": duration, "swimmers": 0},
        }
    )  # fmt: skip
    table = ps.run(scene).encounters
    first = table.filter(column(table, "start_time") == 0.0)
    assert first.num_rows == count
    assert not np.any(column(first, "end_censored"))
    return first


def mean(values: np.ndarray) -> Figure:
    return Figure(float(np.mean(values)), float(np.std(values)) / math.sqrt(len(values)))


@pytest.fixture(scope="module")
def first():
    """Encounters in which the pitch at release is a third and the contact time a half of what it can be."""
    return first_encounters("image_dipole", alpha=2.0, radius=5.0, D=0.02, count=60_000, duration=60.0)


@pytest.fixture(scope="module")
def exact() -> OneSphere:
    return OneSphere(ps.theory.rates, 5.0, 2.0, 0.02)


def test_the_near_wall_model_holds_swimmers_as_long_as_its_backward_equation_says():
    encounters = first_encounters("near_wall", alpha=0.7, radius=12.0, D=0.006, count=20_000, duration=80.0)
    lengths = column(encounters, "end_time") - column(encounters, "start_time")
    expected = OneSphere(ps.theory.near_wall_rates, 12.0, 0.7, 0.006).mean_sum(np.ones_like)
    assert expected == pytest.approx(6.888, abs=0.002)
    require_agreement({"residence": mean(lengths)}, {"residence": Figure(expected)}, bias=GRID)


def test_every_encounter_of_the_backward_equation_ends(exact):
    assert exact.last_touch(np.ones_like) == pytest.approx(1.0, abs=5e-4)  # the grid again


def test_heights_and_times_in_contact_are_those_of_the_backward_equation(first, exact):
    length = column(first, "end_time") - column(first, "start_time")
    weights = {"residence": np.ones_like, "height": lambda h: h, "contact": in_band}
    sums = {name: exact.mean_sum(weight) for name, weight in weights.items()}
    each = Swimmers.of(column(first, "swimmer"))
    found = {"residence": mean(length)}
    for name, values in (("height", column(first, "mean_height") * length), ("contact", column(first, "contact_time"))):
        found[name] = Figure(*ratio_of_sums(each.sums(values), each.sums(length)))
        sums[name] /= sums["residence"]
    found["height"], sums["height"] = found["height"] - Figure(1.0), sums["height"] - 1.0  # above contact
    require_agreement(found, {name: Figure(value) for name, value in sums.items()}, bias=GRID)


def test_the_pitch_at_release_is_that_of_the_last_touch(first, exact):
    expected = exact.last_touch(lambda pitch: pitch)
    require_agreement({"pitch": mean(column(first, "release_pitch"))}, {"pitch": Figure(expected)}, bias=GRID)


def in_band(height: np.ndarray) -> np.ndarray:
    """Whether a height counts as contact; half where its edge is, which is a height of the grid."""
    return 0.5 * ((height < 1.0 + BAND - 1e-9).astype(float) + (height < 1.0 + BAND + 1e-9))
