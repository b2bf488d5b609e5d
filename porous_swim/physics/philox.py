"""Philox4x32-10, a counter-based random number generator.

Source: Salmon, Moraes, Dror, Shaw, Parallel random numbers: as easy as 1, 2, 3 (SC11). The output is a pure
function of a 128-bit counter and a 64-bit key: no state, so no launch, thread or restart can change a result.
"""

# No `from __future__ import annotations`: Taichi needs live annotations in kernel modules.
import taichi as ti


@ti.func
def product(a, b):
    """Both words of the product of two 32-bit words, of which the lower halves of a and b are taken."""
    return a * (b & ti.u64(0xFFFFFFFF))


@ti.func
def philox(c0, c1, c2, c3, k0, k1):
    """Four random 32-bit words of the counter (c0, c1, c2, c3) under the key (k0, k1), all u32.

    On the way words are the lower halves of 64 bits, whatever the upper ones hold: products of wide values take and
    give such halves, and to pack and unpack them in each round would take longer than all the rest.
    """
    w0, w1, w2, w3 = ti.cast(c0, ti.u64), ti.cast(c1, ti.u64), ti.cast(c2, ti.u64), ti.cast(c3, ti.u64)
    for _ in ti.static(range(10)):
        p0, p1 = product(ti.u64(0xD2511F53), w0), product(ti.u64(0xCD9E8D57), w2)
        w0, w1 = (p1 >> ti.u64(32)) ^ w1 ^ ti.cast(k0, ti.u64), p1
        w2, w3 = (p0 >> ti.u64(32)) ^ w3 ^ ti.cast(k1, ti.u64), p0
        k0 += ti.u32(0x9E3779B9)
        k1 += ti.u32(0xBB67AE85)
    return ti.cast(w0, ti.u32), ti.cast(w1, ti.u32), ti.cast(w2, ti.u32), ti.cast(w3, ti.u32)
