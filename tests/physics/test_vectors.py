"""Vectors of numbers and of lanes: their algebra against NumPy, and what the compiler makes of them."""

import numpy as np
import pytest
import taichi as ti

from porous_swim.engine import backend
from porous_swim.physics.variates import minus_two_log
from porous_swim.physics.vectors import bit_cast, pick, vec

LANES = 16
Wide, WideInt = ti.types.vector(LANES, ti.f32), ti.types.vector(LANES, ti.i32)


def test_vectors_of_lanes_have_the_algebra_of_each_lane():
    backend.ensure("cpu")

    @ti.kernel
    def combine(a: ti.types.ndarray(ti.f32, 2), out: ti.types.ndarray(ti.f32, 2)):
        for _ in range(1):
            f = [Wide(0.0) for _ in ti.static(range(4))]
            for j in range(LANES):
                for row in ti.static(range(4)):
                    f[row][j] = a[row, j]
            x, y = vec(f[0], f[1]), vec(f[2], f[3])
            r = (x - y * 2.0) / f[0] + x * f[3]
            z = pick(f[0] > f[2], r, y)
            for j in range(LANES):
                out[0, j], out[1, j], out[2, j] = z[0][j], z[1][j], x.dot(y)[j]

    a = np.random.default_rng(1).normal(size=(4, LANES)).astype(np.float32)
    out = np.zeros((3, LANES), np.float32)
    with backend.whole_vectors(on=True):
        combine(a, out)
    x, y = a[:2], a[2:]
    z = np.where(a[0] > a[2], (x - y * np.float32(2)) / a[0] + x * a[3], y)
    np.testing.assert_array_equal(out, [*z, x[0] * y[0] + x[1] * y[1]])  # each operation rounds as IEEE 754 says


@pytest.mark.parametrize("whole", [True, False])
def test_bits_of_lanes_are_those_of_memory(whole):
    backend.ensure("cpu")

    @ti.kernel
    def cast(a: ti.types.ndarray(ti.f32, 1), bits: ti.types.ndarray(ti.i32, 1), back: ti.types.ndarray(ti.f32, 1)):
        for _ in range(1):
            x = Wide(0.0)
            for j in range(LANES):
                x[j] = a[j]
            n = bit_cast(x, ti.i32)
            y = bit_cast(n, ti.f32)
            for j in range(LANES):
                bits[j], back[j] = n[j], y[j]

    a = np.random.default_rng(2).normal(size=LANES).astype(np.float32)
    bits, back = np.zeros(LANES, np.int32), np.zeros(LANES, np.float32)
    with backend.whole_vectors(on=whole):
        cast(a, bits, back)
    np.testing.assert_array_equal(bits, a.view(np.int32))
    np.testing.assert_array_equal(back, a)


def test_logarithms_of_lanes_are_those_of_numpy():
    backend.ensure("cpu")

    @ti.kernel
    def logarithm(i: ti.types.ndarray(ti.i32, 1), out: ti.types.ndarray(ti.f32, 1)):
        for _ in range(1):
            n = WideInt(0)
            for j in range(LANES):
                n[j] = i[j]
            value = minus_two_log(n, 16)
            for j in range(LANES):
                out[j] = value[j]

    i = np.array([0, 1, 2, 3, 100, 32767, 32768, 65534, 65535, 5, 17, 4096, 9999, 60000, 46340, 46341], np.int32)
    out = np.zeros(LANES, np.float32)
    with backend.whole_vectors(on=True):
        logarithm(i, out)
    # the stated error of the polynomial, and rounding near 1, where the logarithm vanishes
    np.testing.assert_allclose(out, -2.0 * np.log((i + 0.5) / 65536.0), rtol=2e-7, atol=1e-7)


def test_a_vector_is_bound_once_unless_it_is_made_a_variable():
    backend.ensure("cpu")

    @ti.kernel
    def twice(out: ti.types.ndarray(ti.f32, 1)):
        for _ in range(1):
            x = vec(1.0, 2.0)
            x = x * 3.0
            out[0] = x[0]

    @ti.kernel
    def variable(out: ti.types.ndarray(ti.f32, 1)):
        for _ in range(1):
            x = vec(1.0, 2.0)
            y = x.variable()
            if out[0] == 0.0:
                y = x * 3.0
            y += x
            out[0], out[1], out[2] = y[0], y[1], x[1]

    out = np.zeros(3, np.float32)
    with pytest.raises(Exception, match="bound once"):
        twice(out)
    variable(out)
    assert out.tolist() == [4.0, 8.0, 2.0]
