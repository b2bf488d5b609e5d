"""The generator against its published vectors, the variates against the moments they should have."""

import numpy as np
import pytest
import taichi as ti

from porous_swim.engine import backend
from porous_swim.physics.model import Model
from porous_swim.physics.noise import counter, make_draw, make_kick, make_turn
from porous_swim.physics.philox import philox
from porous_swim.physics.vectors import vec

ONES = 0xFFFFFFFF
KNOWN_ANSWERS = [  # counter, key, output: Random123 1.09, kat_vectors, "philox4x32 10"
    ([0] * 4, [0] * 2, [0x6627E8D5, 0xE169C58D, 0xBC57AC4C, 0x9B00DBD8]),
    ([ONES] * 4, [ONES] * 2, [0x408F276D, 0x41C83B0E, 0xA20BC7C6, 0x6D5451FD]),
    (
        [0x243F6A88, 0x85A308D3, 0x13198A2E, 0x03707344],
        [0xA4093822, 0x299F31D0],
        [0xD16CFE09, 0x94FDCCEB, 0x5001E420, 0x24126EA1],
    ),
]


@pytest.fixture(params=["cpu", pytest.param("vulkan", marks=pytest.mark.vulkan)])
def device(request):
    return backend.ensure(request.param)


@pytest.mark.parametrize(("counter", "key", "output"), KNOWN_ANSWERS)
def test_philox_gives_the_published_words(device, counter, key, output):
    @ti.kernel
    def draw(c: ti.types.ndarray(ti.u32, 1), words: ti.types.ndarray(ti.u32, 1)):
        for _ in range(1):
            w = philox(c[0], c[1], c[2], c[3], c[4], c[5])
            for k in ti.static(range(4)):
                words[k] = w[k]

    words = np.zeros(4, np.uint32)
    draw(np.array(counter + key, np.uint32), words)
    assert words.tolist() == output


N = 1 << 20


def variates_of(kind: str, *, dimensions=3, seed=5, first=0) -> np.ndarray:
    """(N, 6) variates of N swimmers at one step."""
    backend.ensure("cpu")
    kick = make_kick(Model(ti.f64, dimensions, variates=kind))

    @ti.kernel
    def draw(low: ti.u32, key: ti.u32, out: ti.types.ndarray(ti.f64, 2)):
        for i in range(out.shape[0]):
            n = kick(counter(ti.cast(i, ti.u32), low, ti.u32(0), key, ti.u32(0)))
            for k in ti.static(range(6)):
                out[i, k] = n[k]

    out = np.zeros((N, 6))
    draw(first, seed, out)
    return out


# moments 2, 4, 6 of unit variance: Gaussian 1, 3, 15; uniform 1, 9/5, 27/7
@pytest.mark.parametrize(("kind", "moments"), [("gaussian", (1.0, 3.0, 15.0)), ("uniform", (1.0, 9 / 5, 27 / 7))])
def test_variates_have_the_moments_of_their_distribution(kind, moments):
    n = variates_of(kind)
    for power, expected in zip((1, 2, 3, 4, 5, 6), (0.0, moments[0], 0.0, moments[1], 0.0, moments[2]), strict=True):
        sample = n**power
        # 5 standard errors, twelve comparisons of six columns: one false alarm in 4e4
        error = 5.0 * sample.std(axis=0) / np.sqrt(N)
        assert np.all(np.abs(sample.mean(axis=0) - expected) < error), power


@pytest.mark.parametrize("kind", ["gaussian", "uniform"])
def test_variates_are_not_correlated_across_components_swimmers_steps_and_seeds(kind):
    n = variates_of(kind)
    next_step, next_seed = variates_of(kind, first=1), variates_of(kind, seed=6)
    bound = 5.0 / np.sqrt(N)  # a correlation of independent unit variates has standard error 1/sqrt(N)
    covariance = n.T @ n / N - np.eye(6)
    assert np.all(np.abs(covariance - np.diag(np.diag(covariance))) < bound)
    for other in (next_step, next_seed, np.roll(n, 1, axis=0), np.roll(n, 8, axis=0)):
        assert np.all(np.abs(n.T @ other / N) < bound)
        assert np.all(np.abs((n**2 - 1).T @ (other**2 - 1) / N) < bound * np.var(n[:, 0] ** 2) * 1.1)


def test_gaussian_tails_are_served_to_five_and_a_half():
    radius = np.sqrt(np.sum(variates_of("gaussian")[:, :2] ** 2, axis=1))
    # the radius of a pair is at most sqrt(-2 ln 2^-22) = 5.52
    assert 4.5 < radius.max() <= 5.523
    # P(radius > 3) = exp(-4.5), binomial error
    share, p = np.mean(radius > 3.0), np.exp(-4.5)
    assert abs(share - p) < 5.0 * np.sqrt(p * (1 - p) / N)


def draws_of(kind: str, *, seed=5, first=0) -> np.ndarray:
    """(N, 8) variates of N swimmers at one step between reflecting walls: six, and two excursions."""
    backend.ensure("cpu")
    draw_one = make_draw(Model(ti.f64, variates=kind))

    @ti.kernel
    def draw(low: ti.u32, key: ti.u32, out: ti.types.ndarray(ti.f64, 2)):
        for i in range(out.shape[0]):
            n, deep, aside = draw_one(counter(ti.cast(i, ti.u32), low, ti.u32(0), key, ti.u32(0)))
            for k in ti.static(range(6)):
                out[i, k] = n[k]
            out[i, 6], out[i, 7] = deep, aside

    out = np.zeros((N, 8))
    draw(first, seed, out)
    return out


@pytest.mark.parametrize(("kind", "moments"), [("gaussian", (1.0, 3.0, 15.0)), ("uniform", (1.0, 9 / 5, 27 / 7))])
def test_a_step_between_reflecting_walls_draws_six_variates_and_two_excursions_out_of_one_block(kind, moments):
    n = draws_of(kind)
    # -2 ln U is a chi-squared variate of two degrees of freedom: its moments are 2, 8, 48
    expected = np.array(
        [[0.0, moments[0], 0.0, moments[1], 0.0, moments[2]]] * 6 + [[2.0, 8.0, 48.0]] * 2, dtype=object
    )
    for column, listed in zip(n.T, expected, strict=True):
        for power, moment in enumerate(listed, start=1):
            sample = column**power
            assert abs(sample.mean() - moment) < 5.0 * sample.std() / np.sqrt(N), power  # one false alarm in 4e4
    assert n[:, 6:].max() <= 2.0 * 17.0 * np.log(2.0) * (1.0 + 1e-6)
    n = (n - n.mean(axis=0)) / n.std(axis=0)
    others = [draws_of(kind, first=1), draws_of(kind, seed=6), np.roll(n, 1, axis=0)]
    assert np.all(np.abs(n.T @ n / N - np.eye(8)) < 5.0 / np.sqrt(N) + 1e-9)
    for other in others:
        other = (other - other.mean(axis=0)) / other.std(axis=0)
        assert np.all(np.abs(n.T @ other / N) < 5.0 / np.sqrt(N))


@pytest.mark.parametrize("dimensions", [2, 3])
@pytest.mark.parametrize(("real", "tolerance"), [(ti.f32, 2e-7), (ti.f64, 3e-12)])
def test_the_director_turns_by_the_angle_drawn(dimensions, real, tolerance):
    backend.ensure("cpu")
    turn = make_turn(Model(real, dimensions))
    size = 2 * dimensions - 3
    e0 = np.array([0.6, 0.8] if dimensions == 2 else [0.48, 0.6, 0.64])
    w = np.array([0.3]) if dimensions == 2 else np.array([0.1, -0.2, 0.15])

    @ti.kernel
    def apply(out: ti.types.ndarray(real, 1)):
        for _ in range(1):
            e = vec(*[real(c) for c in ti.static(e0.tolist())])
            n = turn(e, vec(*[real(c) for c in ti.static(w.tolist())]))
            for k in ti.static(range(dimensions)):
                out[k] = n[k]

    out = np.zeros(dimensions, np.float32 if real == ti.f32 else np.float64)
    apply(out)
    if dimensions == 2:
        expected = [0.6 * np.cos(0.3) - 0.8 * np.sin(0.3), 0.6 * np.sin(0.3) + 0.8 * np.cos(0.3)]
    else:
        tangential = w - (w @ e0) * e0
        angle = np.linalg.norm(tangential)
        expected = np.cos(angle) * e0 + np.sin(angle) * tangential / angle
    assert size == len(w)
    assert out == pytest.approx(expected, abs=tolerance)
