"""Random variates out of one 128-bit block, without library calls.

The block is cut into six integers of 21 bits, or where a step needs more of them into halves of its words or into
parts of 20 and 12 bits. Straight-line code on integers and single precision, so that it vectorises and gives the same
bits at any lane width.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
import taichi as ti

from porous_swim.physics.vectors import bit_cast

BITS = 21
SQRT_12 = 3.4641016151377544
LOG_POLYNOMIAL = (
    -1.1514610310e-1, 1.1676998740e-1, -1.2420140846e-1, 1.4249322787e-1,
    -1.6668057665e-1, 2.0000714765e-1, -2.4999993993e-1, 3.3333331174e-1,
)  # fmt: skip


@ti.func
def split(w0, w1, w2, w3):
    """Six signed integers in [0, 2^21) from four words (vector instructions convert signed ones, unsigned not)."""
    low = ti.u32(0x7FF)
    i4 = ((w0 & low) << ti.u32(10)) | (w1 & ti.u32(0x3FF))
    i5 = ((w2 & low) << ti.u32(10)) | (w3 & ti.u32(0x3FF))
    i0, i1, i2, i3 = w0 >> ti.u32(11), w1 >> ti.u32(11), w2 >> ti.u32(11), w3 >> ti.u32(11)
    return [ti.cast(i, ti.i32) for i in ti.static((i0, i1, i2, i3, i4, i5))]


@ti.func
def cut(w, low_bits: ti.template()):
    """The high and the low part of a word as signed integers; the low one has `low_bits`."""
    low = w & ti.u32((1 << low_bits) - 1)
    return ti.cast(w >> ti.u32(low_bits), ti.i32), ti.cast(low, ti.i32)


@ti.func
def uniform(i, bits: ti.template()):
    """Uniform on [-sqrt 3, sqrt 3] from an integer of `bits` bits, at the middles of 2^bits intervals."""
    return (i * ti.f32(1.0) - ti.f32(2 ** (bits - 1) - 0.5)) * ti.f32(SQRT_12 / 2**bits)


@ti.func
def minus_two_log(i, bits: ti.template()):
    """-2 ln((i + 1/2) / 2^bits) for an integer of `bits` bits; relative error below 2e-7 (polynomial: Cephes logf)."""
    pattern = bit_cast((2 * i + 1) * ti.f32(1.0), ti.i32)
    # the mantissa is brought to [sqrt(1/2), sqrt 2): subtract the bits of sqrt(1/2), keep the exponent
    shifted = pattern - ti.i32(0x3F3504F3)
    exponent = shifted >> 23
    m = bit_cast((shifted & ti.i32(0x007FFFFF)) + ti.i32(0x3F3504F3), ti.f32) - ti.f32(1.0)
    p = m * ti.f32(7.0376836292e-2) + ti.f32(LOG_POLYNOMIAL[0])
    for c in ti.static(LOG_POLYNOMIAL[1:]):
        p = p * m + ti.f32(c)
    square = m * m
    log_m = m - ti.f32(0.5) * square + square * m * p
    return ti.f32(-2.0) * (log_m + (exponent - (bits + 1)) * ti.f32(0.69314718056))


@ti.func
def circle(i, bits: ti.template()):
    """A point of the unit circle, uniform in angle, from an integer of `bits` bits, of which 3 are for symmetry.

    Powers of the coordinates up to 2^bits - 1 have the means of a continuous angle.
    """
    octant = ti.static(1 << (bits - 3))
    t = ((i & (octant - 1)) * ti.f32(1.0) + ti.f32(0.5)) * ti.f32(0.7853981633974483 / octant)
    square = t * t
    s = square * ti.f32(2.718311493989822e-6) + ti.f32(-1.98393348360966317e-4)
    for c in ti.static((8.33332938588946317e-3, -1.66666666416265235e-1, 1.0)):
        s = s * square + ti.f32(c)
    s = s * t
    c = square * ti.f32(2.44331571180948e-5) + ti.f32(-1.38873162549376e-3)
    for k in ti.static((4.16666418707325e-2, -0.5, 1.0)):
        c = c * square + ti.f32(k)
    swap = (i & octant) != 0
    x, y = ti.select(swap, s, c), ti.select(swap, c, s)
    x = ti.select((i & (2 * octant)) != 0, x * ti.f32(-1.0), x)
    return x, ti.select((i & (4 * octant)) != 0, y * ti.f32(-1.0), y)


@ti.func
def gaussian_pair(i, i_bits: ti.template(), j, j_bits: ti.template()):
    """Two independent Gaussian variates (Box and Muller 1958) from two integers.

    Their tails reach to sqrt(2 (i_bits + 1) ln 2): 5.5 from 21 bits, 5.4 from 20.
    """
    r = ti.sqrt(minus_two_log(i, i_bits))
    x, y = circle(j, j_bits)
    return r * x, r * y
