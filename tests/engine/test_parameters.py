"""Numbers by name: who declares them, and how parameter sets are made of them."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest

from porous_swim.core.numbers import Given, numbers_of
from porous_swim.engine.parameters import Parameters
from porous_swim.physics.contact import HardContact
from porous_swim.physics.encounter import Encounter
from porous_swim.physics.hydrodynamics import ImageDipole, NearWall, NoHydrodynamics
from porous_swim.physics.noise import Brownian, NoNoise
from tests.support.motions import Swirl

GIVEN = Given(dipole_strength=0.8, aspect_ratio=0.5, dimensions=3, time_step=0.02)


def scene(*parts, given=GIVEN):
    return SimpleNamespace(movers=parts, given=given)


def test_each_part_hands_over_what_it_declares():
    noise = Brownian(translational_diffusion=0.25, rotational_diffusion=0.16)
    found = numbers_of((ImageDipole(), HardContact(), noise, Encounter(escape_pitch=0.5)), GIVEN)
    assert found == {
        "alpha": 0.8, "bretherton": pytest.approx(0.6), "gamma": 0.5, "kick": pytest.approx(0.1),
        "turn": pytest.approx(0.08), "escape_sine": pytest.approx(math.sin(0.5)),
    }  # fmt: skip


@pytest.mark.parametrize("part", [ImageDipole(), NearWall(), NoHydrodynamics(), HardContact(), NoNoise(), Encounter()])
def test_no_part_of_ours_hands_over_what_it_does_not_declare(part):
    assert set(numbers_of((part,), GIVEN)) == set(part.NUMBERS)


def test_a_part_that_hands_over_other_numbers_than_it_declares_is_named():
    class Forgetful(Swirl):
        NUMBERS = ("strength", "power", "phase")

    with pytest.raises(TypeError, match=r"Forgetful.numbers: expected a value for each of .*phase"):
        numbers_of((Forgetful(strength=1.0, power=2.0),), GIVEN)


def test_two_parts_that_disagree_about_a_number_are_told():
    class Other(Swirl):
        def numbers(self, given):
            return {"strength": 2.0, "power": self.power}

    with pytest.raises(ValueError, match=r"Other.numbers: strength is 2, and another part has 1 for it"):
        numbers_of((Swirl(strength=1.0, power=2.0), Other(strength=1.0, power=2.0)), GIVEN)


def test_sets_of_several_scenes_have_a_row_each_and_come_back_by_name():
    other = Given(dipole_strength=0.8, aspect_ratio=0.25, dimensions=3, time_step=0.02)
    found = Parameters.of([
        scene(Swirl(strength=1.0, power=2.0), HardContact()),
        scene(Swirl(strength=3.0, power=2.5), HardContact(), given=other),
    ])  # fmt: skip
    assert len(found) == 2
    np.testing.assert_array_equal(found["strength"], [1.0, 3.0])
    np.testing.assert_array_equal(found["power"], [2.0, 2.5])
    np.testing.assert_array_equal(found["gamma"], [0.5, 0.25])


def test_scenes_with_other_numbers_do_not_run_together():
    with pytest.raises(ValueError, match="scenes of one run have the same numbers"):
        Parameters.of([scene(ImageDipole()), scene(HardContact())])
