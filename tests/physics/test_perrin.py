"""Thermal noise of spheroids, against the integrals behind Perrin's formulas and against their limits."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest
from scipy.integrate import quad

from porous_swim.engine.parameters import Parameters
from porous_swim.physics.perrin import SpheroidDiffusion, spheroid_diffusion
from porous_swim.scene.scene import Scene

RATIOS = [1.0, 0.9999, 0.97, 0.95, 0.9487, 0.9486, 0.9, 0.7, 0.5, 0.25, 0.1, 0.03, 0.01]  # 0.9487: e^2 = 0.1


def by_quadrature(gamma: float) -> SpheroidDiffusion:
    """From the resistance of an ellipsoid with semi-axes a_i: F = 16 pi mu/(chi + a_i^2 alpha_i) along axis i and
    16 pi mu (a_1^2 + a_2^2)/(3 (a_1^2 alpha_1 + a_2^2 alpha_2)) about axis 3, with the integrals from 0 to infinity
    chi of 1/Delta and alpha_i of 1/((a_i^2 + l) Delta), Delta^2 the product of the three a_j^2 + l."""

    def integral(power_long: float, power_short: float) -> float:
        def integrand(u: float) -> float:  # l = exp(u)
            longs, shorts = 1.0 + math.exp(u), gamma**2 + math.exp(u)
            return math.exp(u) * longs**-power_long * shorts**-power_short

        edges = (-60.0, 2.0 * math.log(gamma) - 3.0, 2.0 * math.log(gamma) + 3.0, 3.0, 90.0)
        return sum(quad(integrand, low, high, epsabs=0.0, epsrel=1e-13, limit=200)[0] for low, high in pairwise(edges))

    chi, long, short = integral(0.5, 1.0), integral(1.5, 1.0), integral(0.5, 2.0)
    g = gamma**2
    return SpheroidDiffusion(
        along=6.0 / 16.0 * (chi + long),
        across=6.0 / 16.0 * (chi + g * short),
        turning=8.0 * 3.0 / 16.0 * (long + g * short) / (1.0 + g),
    )


@pytest.mark.parametrize("gamma", RATIOS)
def test_factors_are_the_integrals_of_the_resistance_of_an_ellipsoid(gamma: float) -> None:
    # the quadrature's 1e-13; ends cut off at exp(-60) below and exp(-45) above
    assert spheroid_diffusion(gamma) == pytest.approx(by_quadrature(gamma), rel=1e-12)


def test_a_sphere_has_the_diffusion_of_a_sphere_exactly() -> None:
    factors = spheroid_diffusion(1.0)
    assert factors == (1.0, 1.0, 1.0)
    assert (factors.mean(2), factors.mean(3)) == (1.0, 1.0)


@pytest.mark.parametrize("gamma", [1.0 - 1e-4, 1.0 - 1e-6, 1.0 - 1e-9])
def test_near_a_sphere_factors_grow_in_proportion_to_the_thinning(gamma: float) -> None:
    # slightly deformed sphere (Happel and Brenner, Low Reynolds Number Hydrodynamics): a drag of 1 - 4/5 d along and
    # 1 - 3/5 d across, d = 1 - gamma; in turning the lesser volume gives 2 d, and elongation takes d/5 of it
    d = 1.0 - gamma
    factors = spheroid_diffusion(gamma)
    # what follows is below 3 d^2, and rounding
    assert factors == pytest.approx((1.0 + 0.8 * d, 1.0 + 0.6 * d, 1.0 + 1.8 * d), rel=0, abs=3.0 * d * d + 1e-15)


@pytest.mark.parametrize("gamma", [0.1, 0.03, 0.01, 1e-4])
def test_needles_diffuse_with_the_logarithm_of_their_slenderness(gamma: float) -> None:
    # slender bodies (Kim and Karrila, section 3.3), in kT/(8 pi mu): 2 (ln(2/gamma) - 1/2) along, ln(2/gamma) + 1/2
    # across, 3 (ln(2/gamma) - 1/2) in turning; what follows is of the order gamma^2 ln(2/gamma)
    log = math.log(2.0 / gamma)
    slender = (1.5 * (log - 0.5), 0.75 * (log + 0.5), 3.0 * (log - 0.5))
    assert spheroid_diffusion(gamma) == pytest.approx(slender, rel=0, abs=3.0 * gamma**2 * log + 1e-14)


@pytest.mark.parametrize("gamma", [0.0, -0.5, 1.5, math.nan])
def test_other_shapes_are_refused(gamma: float) -> None:
    with pytest.raises(ValueError, match="aspect_ratio: expected 0 < gamma <= 1, found"):
        spheroid_diffusion(gamma)


def janus(*, dimensions: int = 3, aspect_ratio: float = 0.5, **noise: object) -> Scene:
    return Scene.from_mapping(
        {
            "units": {"length": "1 um", "speed": "5 um/s", "viscosity": "0.89 mPa s", "temperature": "300 K"},
            "swimmers": {
                "count": 1, "dipole_strength": 0.1, "aspect_ratio": aspect_ratio,
                "release": {"kind": "point", "position": [9.0] + [0.0] * (dimensions - 1)},
            },
            "noise": {"kind": "brownian", "translational_diffusion": "thermal", **noise},
            "obstacles": {"layout": "single", "radius": 4.0},
            "domain": {"dimensions": dimensions},
            "run": {"time_step": 0.01, "duration": 1.0},
        }
    )  # fmt: skip


# kT/(6 pi mu a) and kT/(8 pi mu a^3) of the sphere, in a U and U/a, worked out in SI: see test_units
SPHERE = 0.0493791265


@pytest.mark.parametrize("dimensions", [2, 3])
def test_thermal_rods_have_both_diffusivities_of_a_passive_spheroid(dimensions: int) -> None:
    scene = janus(dimensions=dimensions, rotational_diffusion="from_spheroid")
    along, across, turning = by_quadrature(0.5)
    mean = (along + across) / 2.0 if dimensions == 2 else (along + 2.0 * across) / 3.0
    # 1e-9: SPHERE has nine digits
    assert scene.translational_diffusion == pytest.approx(SPHERE * mean, rel=2e-9)
    assert scene.rotational_diffusion == pytest.approx(0.75 * SPHERE * turning, rel=2e-9)
    handed = Parameters.of([scene])  # as the deviations of a step
    for name, D in (("kick", scene.translational_diffusion), ("turn", scene.rotational_diffusion)):
        assert handed[name][0] ** 2 == pytest.approx(2.0 * D * scene.run.time_step, rel=1e-14)  # rounding
    assert Scene.from_mapping({"name": "again"} | scene_data(scene)).rotational_diffusion == scene.rotational_diffusion


def scene_data(scene: Scene) -> dict[str, object]:
    return {key: value for key, value in scene.model_dump(exclude_none=True).items() if key != "name"}


def test_a_given_diffusivity_is_kept_and_turning_follows_from_it() -> None:
    scene = janus(translational_diffusion=0.01, rotational_diffusion="from_spheroid")
    along, across, turning = by_quadrature(0.5)
    assert scene.translational_diffusion == 0.01
    assert scene.rotational_diffusion == pytest.approx(0.0075 * turning / ((along + 2.0 * across) / 3.0), rel=1e-12)
    assert scene.replace({"swimmers.aspect_ratio": 1.0}).rotational_diffusion == 0.0075
    assert scene.replace({"noise.rotational_diffusion": "from_sphere"}).rotational_diffusion == 0.0075


def test_thermal_spheres_are_as_before() -> None:
    sphere = janus(aspect_ratio=1.0)
    assert sphere.translational_diffusion == pytest.approx(SPHERE, rel=2e-9)
    assert sphere.rotational_diffusion == 0.75 * sphere.translational_diffusion
