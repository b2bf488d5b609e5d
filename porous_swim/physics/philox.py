"""Philox4x32-10, a counter-based random number generator.

Source: Salmon, Moraes, Dror, Shaw, Parallel random numbers: as easy as 1, 2, 3 (SC11). The output is a pure
function of a 128-bit counter and a 64-bit key: no state, so no launch, thread or restart can change a result.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
import taichi as ti


@ti.func
def multiply(a, b):
    """High and low word of the product of two 32-bit words."""
    product = ti.cast(a, ti.u64) * ti.cast(b, ti.u64)
    return ti.cast(product >> ti.u64(32), ti.u32), ti.cast(product, ti.u32)


@ti.func
def philox(c0, c1, c2, c3, k0, k1):
    """Four random 32-bit words of the counter (c0, c1, c2, c3) under the key (k0, k1), all u32."""
    for _ in ti.static(range(10)):
        high0, low0 = multiply(ti.u32(0xD2511F53), c0)
        high1, low1 = multiply(ti.u32(0xCD9E8D57), c2)
        c0, c1, c2, c3 = high1 ^ c1 ^ k0, low1, high0 ^ c3 ^ k1, low0
        k0 += ti.u32(0x9E3779B9)
        k1 += ti.u32(0xBB67AE85)
    return c0, c1, c2, c3
