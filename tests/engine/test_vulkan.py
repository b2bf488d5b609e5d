"""The same source on a Vulkan device, one lane to a thread.

Run with `python -m pytest -m vulkan`; Debian's software driver (mesa-vulkan-drivers) will do.
"""

from __future__ import annotations

import numpy as np
import pytest

from porous_swim.engine import backend
from porous_swim.engine.probe import drift_of
from tests.physics.test_drift import CASES, TOLERANCE, assert_matches, geometry
from tests.physics.test_wall import at_height, directors, wall
from tests.support.engines import fcc, fingerprint, hexagonal, make_engine, released

pytestmark = pytest.mark.vulkan


@pytest.fixture
def vulkan():
    started = backend.ensure("vulkan")
    assert started.device == "vulkan"
    return started


@pytest.mark.parametrize("case", CASES)
def test_drift_is_that_of_the_oracle(vulkan, case):
    offset, director, _, _ = geometry(case)
    velocity, rate = drift_of(
        [offset], [director], case["A"], dipole_strength=case["alpha"], bretherton=case["Gamma"],
        hydrodynamics="image_dipole", precision="f32",
    )  # fmt: skip
    assert_matches(case, velocity[0], rate[0], TOLERANCE["f32"])


@pytest.mark.parametrize("field", [hexagonal(cells=(2, 1)), fcc(cells=1)], ids=["hexagonal", "fcc"])
def test_the_search_and_the_first_contacts_are_those_of_the_cpu_to_the_bit(field):
    position, director = released(field, 48)
    # the first ten touch a colloid: their encounters begin
    colloid, image, height = field.nearest(position[:10])
    center = field.centers[colloid] + image * field.box
    position[:10] = center + (position[:10] - center) * ((field.radii[0] + 1.0) / (field.radii[0] + height))[:, None]
    prints, counts = {}, {}
    for device in ("cpu", "vulkan"):
        engine = make_engine(field, position, director, device=device, alpha=4.0, D=0.006)
        prints[device], counts[device] = fingerprint(engine), engine.counts()
    assert prints["vulkan"] == prints["cpu"]
    assert counts["vulkan"] == counts["cpu"] == (10, 0, 0, 0)


@pytest.mark.parametrize("integrator", ["euler", "reflected"])
def test_swimmers_and_encounters_are_those_of_the_cpu_to_the_bit(integrator):
    field = hexagonal(cells=(2, 1))
    position, director = released(field, 48)
    prints, counts = {}, {}
    for device in ("cpu", "vulkan"):
        # long steps, so that encounters begin, end and hop within the few steps that a software driver affords
        engine = make_engine(
            field, position, director, device=device, time_step=0.04, escape_sine=0.3, alpha=4.0, D=0.05,
            integrator=integrator,
        )  # fmt: skip
        engine.advance(160)
        prints[device], counts[device] = fingerprint(engine), engine.counts()
    assert prints["vulkan"] == prints["cpu"]
    assert counts["vulkan"] == counts["cpu"]
    assert min(counts["cpu"][:3]) > 0


def test_swimmers_at_a_wall_are_those_of_the_cpu_to_the_bit():
    prints = set()
    for device in ("cpu", "vulkan"):
        engine = make_engine(
            wall(3), at_height(1.2, 48, 3), directors(np.linspace(-1.0, 0.1, 48), 3), device=device, time_step=0.04,
            D=0.05,
        )  # fmt: skip
        engine.advance(160)
        assert engine.counts()[1] > 10
        prints.add(fingerprint(engine))
    assert len(prints) == 1


def test_sums_over_all_swimmers_are_those_of_the_cpu():
    field = hexagonal(cells=(2, 1))
    position, director = released(field, 600)  # groups of two
    found = {}
    for device in ("cpu", "vulkan"):
        engine = make_engine(field, position, director, device=device, alpha=4.0, D=0.006, time_step=0.02)
        survey = engine.survey(n_levels=2)
        survey.look([1], renew=[1])
        engine.advance(4)
        found[device] = survey.look([0, 1])
    for one, other in zip(found["cpu"], found["vulkan"], strict=True):
        for name in ("n", "bound", "contact"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
        for name in ("square", "overlap"):  # sums may be fused, not what they are sums of
            np.testing.assert_allclose(getattr(one, name), getattr(other, name), rtol=1e-5, atol=1e-6)
    assert found["cpu"][0].bound.sum() > 0
